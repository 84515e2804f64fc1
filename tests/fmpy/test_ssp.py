"""A system that wobble wrote as an SSP, judged by the schemas and simulated by fmpy.

SSP         the archive, made by `wobble cosim … --ssp FILE`; without it these tests are skipped
SSP_RESULT  the CSV that the same call wrote with `--algorithm jacobi`, at equal steps; without it
            only the comparison with it is skipped
"""

import csv
import os
import shutil
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, read_ssv
from lxml import etree

SSD = "SystemStructure.ssd"
SSV = "resources/parameters.ssv"
NAMESPACES = {"ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription"}


def from_environment(name: str) -> Path:
    path = os.environ.get(name)
    if not path:
        pytest.skip(f"the environment variable {name} names no file, see test_ssp.py")
    if not Path(path).is_file():
        pytest.exit(f"{name}: expected a file, found none at {path}", 2)
    return Path(path).resolve()


@pytest.fixture(scope="module")
def ssp() -> Path:
    return from_environment("SSP")


@pytest.fixture(scope="module")
def ssd(ssp):
    return etree.fromstring(zipfile.ZipFile(ssp).read(SSD))


@pytest.fixture(scope="module")
def components(ssp, tmp_path_factory):
    """Unzipped folder and description of each component's FMU, by name."""
    folder = tmp_path_factory.mktemp("ssp")
    zipfile.ZipFile(ssp).extractall(folder)
    found = {}
    for component in read_ssd(str(ssp)).system.elements:
        unzipped = fmpy.extract(str(folder / component.source))
        found[component.name] = (unzipped, fmpy.read_model_description(unzipped))
    yield found
    for unzipped, _ in found.values():
        shutil.rmtree(unzipped)


@pytest.fixture(scope="module")
def start(ssp, components):
    """The parameter set as simulate_ssp wants it: choices and truths as numbers, not as texts."""
    if SSV not in zipfile.ZipFile(ssp).namelist():
        return None
    parameters = read_ssv(str(ssp), resource=SSV)
    for parameter in parameters.parameters:
        if parameter.type == "Boolean":
            parameter.value = parameter.value == "true"
        elif parameter.type == "Enumeration":
            component, name = parameter.name.split(".", 1)
            _, description = components[component]
            variable = next(v for v in description.modelVariables if v.name == name)
            items = variable.declaredType.items
            parameter.value = int(next(i.value for i in items if i.name == parameter.value))
    return parameters


def connections(ssd):
    ends = ["startElement", "startConnector", "endElement", "endConnector"]
    found = ssd.iterfind("ssd:System/ssd:Connections/ssd:Connection", NAMESPACES)
    return [tuple(connection.get(end) for end in ends) for connection in found]


def test_its_files_are_valid_by_the_schemas(ssp):
    archive = zipfile.ZipFile(ssp)
    folder = Path(fmpy.__file__).parent / "ssp" / "schema"
    names = {"ssd": "SystemStructureDescription.xsd", "ssv": "SystemStructureParameterValues.xsd"}
    judged = 0
    for name in archive.namelist():
        suffix = name.rsplit(".", 1)[-1]
        if suffix in names:
            schema = etree.XMLSchema(etree.parse(folder / names[suffix]))
            schema.assertValid(etree.fromstring(archive.read(name)))
            judged += 1
    assert judged == (2 if SSV in archive.namelist() else 1)


def test_what_is_a_connector_is_connected(ssd):
    # fmpy sets every input that is a connector at every step, to 0 where nothing leads to it
    listed = set()
    for component in ssd.iterfind("ssd:System/ssd:Elements/ssd:Component", NAMESPACES):
        for connector in component.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES):
            listed.add((component.get("name"), connector.get("name"), connector.get("kind")))
    used = set()
    for source, output, target, name in connections(ssd):
        used |= {(source, output, "output"), (target, name, "input")}
    assert listed == used
    assert used


def jacobi(ssd, components, start, stop, step):
    """Each output after each step, by component and name: all step from the inputs they have, then
    all inputs follow. As fmpy has it, inputs are 0 during the first step."""
    slaves, references = {}, {}
    for name, (unzipped, description) in components.items():
        slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=unzipped,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slaves[name] = slave
        references[name] = {v.name: v.valueReference for v in description.modelVariables}
    for parameter in start.parameters if start else []:
        name, variable = parameter.name.split(".", 1)
        slave, reference = slaves[name], [references[name][variable]]
        if parameter.type == "Real":
            slave.setReal(reference, [float(parameter.value)])
        elif parameter.type == "Boolean":
            slave.setBoolean(reference, [parameter.value])
        else:
            slave.setInteger(reference, [int(parameter.value)])
    for slave in slaves.values():
        slave.enterInitializationMode()
        slave.exitInitializationMode()
    wires = connections(ssd)
    values = {(source, output): 0.0 for source, output, _, _ in wires}
    columns = {wire: [] for wire in values}
    time = 0.0
    while time < stop:
        for source, output, target, name in wires:
            slaves[target].setReal([references[target][name]], [values[source, output]])
        for slave in slaves.values():
            slave.doStep(currentCommunicationPoint=time, communicationStepSize=step)
        for source, output in values:
            values[source, output] = slaves[source].getReal([references[source][output]])[0]
            columns[source, output].append(values[source, output])
        time += step
    for slave in slaves.values():
        slave.terminate()
        slave.freeInstance()
    return columns


@pytest.mark.parametrize("step", [0.005, 0.01])
def test_fmpy_simulates_it_as_jacobi_does(ssp, ssd, components, start, step):
    result = simulate_ssp(str(ssp), stop_time=5.0, step_size=step, parameter_set=start)
    expected = jacobi(ssd, components, start, 5.0, step)
    moving = 0
    for (component, name), column in expected.items():
        found = result[f"{component}.{name}"]
        # the same calls in the same order
        assert np.allclose(found, column, rtol=0.0, atol=1e-12), f"{component}.{name}"
        moving += np.ptp(column) > 0.0
    assert moving, "at rest all agree"


def test_wobble_simulates_it_as_fmpy_does(ssp, ssd, start):
    path = from_environment("SSP_RESULT")
    with path.open() as file:
        header, *rows = csv.reader(file)
    names = [column.split("[")[0] for column in header]
    columns = dict(zip(names, np.array(rows, dtype=float).T, strict=True))
    time = columns["time"]
    step = time[1] - time[0]
    result = simulate_ssp(str(ssp), stop_time=time[-1], step_size=step, parameter_set=start)
    compared = 0
    for source, output, _, _ in connections(ssd):
        found = result[f"{source}.{output}"]
        # the plant's columns have plain names
        column = columns.get(f"{source}.{output}", columns.get(output))
        # fmpy records what a step gave under the time the step began
        steps = len(time) - 1
        scale = max(1.0, np.abs(column).max())
        assert np.allclose(found[:steps], column[1:], rtol=0.0, atol=1e-9 * scale), output
        compared += 1
    assert compared
