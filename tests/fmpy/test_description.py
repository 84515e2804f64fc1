"""What the FMU says of itself."""

import re
import zipfile
from pathlib import Path

import fmpy
from fmpy.validation import validate_fmu
from lxml import etree

ROOT = Path(__file__).parents[2]


def test_fmpy_finds_no_problem(fmu):
    assert validate_fmu(str(fmu)) == []


def test_description_is_valid_by_the_schema(fmu):
    schema = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
    xsd = etree.XMLSchema(etree.parse(schema))
    with zipfile.ZipFile(fmu) as archive:
        xml = etree.fromstring(archive.read("modelDescription.xml"))
    xsd.assertValid(xml)


def test_description_is_the_golden_file(fmu):
    golden = (ROOT / "fmu" / "modelDescription.xml").read_text(encoding="utf-8")
    with zipfile.ZipFile(fmu) as archive:
        packed = archive.read("modelDescription.xml").decode("utf-8")
    undated = [re.sub(r' generationDateAndTime="[^"]*"', "", xml) for xml in (packed, golden)]
    assert undated[0] == undated[1]


def test_archive_holds_what_it_should(fmu):
    with zipfile.ZipFile(fmu) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
    assert names[0] == "modelDescription.xml"
    binaries = [name for name in names if name.startswith("binaries/")]
    assert set(names) == {
        "modelDescription.xml",
        "documentation/assist.py",
        "documentation/couple.py",
        "documentation/index.html",
        "documentation/licenses/apache-2.0.txt",
        "documentation/licenses/crates.txt",
        "documentation/licenses/license.txt",
        "documentation/licenses/third-party.txt",
        "model.png",
        "resources/start.json",
        *binaries,
    }
    assert binaries
    assert all(re.match(r"binaries/\w+/RearLoadBicycle\.\w+$", name) for name in binaries)


def test_every_parameter_has_bounds_and_a_description(description):
    for variable in description.modelVariables:
        assert variable.description, variable.name
        if variable.causality == "parameter" and variable.type == "Real":
            assert variable.min is not None and variable.max is not None, variable.name
            assert float(variable.min) <= float(variable.start) <= float(variable.max)


def test_capabilities_are_what_the_torture_takes_for_granted(description):
    slave = description.coSimulation
    assert slave.canHandleVariableCommunicationStepSize
    assert slave.canGetAndSetFMUstate
    assert slave.canSerializeFMUstate
    assert slave.canInterpolateInputs
    assert slave.providesDirectionalDerivative
    assert slave.maxOutputDerivativeOrder == 1
    assert not slave.canRunAsynchronuously


def test_every_continuous_state_has_its_derivative(description):
    derivatives = [unknown.variable for unknown in description.derivatives]
    states = {variable.derivative.name for variable in derivatives}
    tyres = {"lateral_velocity", "front_lateral_force", "rear_lateral_force"}
    path = {"heading", "x", "y"}
    assert states == {"roll", "steer", "roll_rate", "steer_rate", "yaw_rate"} | tyres | path
    assert len(derivatives) == len(states)
