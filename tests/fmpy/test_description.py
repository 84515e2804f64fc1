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
    assert re.sub(r' generationDateAndTime="[^"]*"', "", packed) == golden


def test_archive_holds_what_it_should(fmu):
    with zipfile.ZipFile(fmu) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
    assert names[0] == "modelDescription.xml"
    binaries = [name for name in names if name.startswith("binaries/")]
    assert set(names) == {
        "modelDescription.xml",
        "documentation/index.html",
        "documentation/licenses/license.txt",
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


def test_capabilities_that_are_absent_are_not_declared(description):
    slave = description.coSimulation
    assert slave.canHandleVariableCommunicationStepSize
    assert not slave.canGetAndSetFMUstate
    assert not slave.canSerializeFMUstate
    assert not slave.canInterpolateInputs
    assert not slave.providesDirectionalDerivative
    assert not slave.canRunAsynchronuously
