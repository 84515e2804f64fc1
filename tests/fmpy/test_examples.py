"""The examples of fmi-export, packed from their golden descriptions.

EXAMPLES names the folder with an FMU of each.
"""

import math
import os
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import fmi2OK
from fmpy.validation import validate_fmu
from lxml import etree
from slave import Slave

NAMES = ["Dahlquist", "VanDerPol", "DisturbanceObserver", "RollAssist"]


@pytest.fixture(scope="module")
def examples() -> Path:
    folder = os.environ.get("EXAMPLES")
    if not folder or not Path(folder).is_dir():
        pytest.exit("expected the environment variable EXAMPLES to name a folder", 2)
    return Path(folder)


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_finds_no_problem(examples, name):
    assert validate_fmu(str(examples / f"{name}.fmu")) == []


@pytest.mark.parametrize("name", NAMES)
def test_description_is_valid_by_the_schema(examples, name):
    schema = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
    with zipfile.ZipFile(examples / f"{name}.fmu") as archive:
        xml = etree.fromstring(archive.read("modelDescription.xml"))
    etree.XMLSchema(etree.parse(schema)).assertValid(xml)


@pytest.mark.parametrize("step", [0.1, 1 / 60, 0.5])
@pytest.mark.parametrize("k", [1.0, 2.5])
def test_dahlquist_is_its_exact_solution(examples, k, step):
    result = fmpy.simulate_fmu(
        str(examples / "Dahlquist.fmu"),
        stop_time=5.0,
        output_interval=step,
        start_values={"k": k},
        output=["x"],
    )
    exact = np.exp(-k * result["time"])
    # each step multiplies by a rounded exp: n steps err by some n·2⁻⁵³ relative
    assert result["time"][-1] == pytest.approx(5.0, abs=1e-9)
    assert np.allclose(result["x"], exact, rtol=len(exact) * 2**-51, atol=0.0)


def test_dahlquist_takes_another_rate_between_steps(examples, tmp_path):
    fmu = examples / "Dahlquist.fmu"
    folder = fmpy.extract(str(fmu), unzipdir=str(tmp_path))
    description = fmpy.read_model_description(folder)
    references = {v.name: v.valueReference for v in description.modelVariables}
    slave = Slave(description, folder, references)
    assert slave.instantiate()
    slave.start()
    slave.go_on(1.0)
    assert slave.set("k", 3.0) == fmi2OK
    slave.go_on(1.0)
    assert slave.get("x") == pytest.approx(math.exp(-1.0) * math.exp(-3.0), rel=2**-50)
    slave.free()
    slave.fmu.freeLibrary()


def van_der_pol(mu, stop, steps):
    """Classical Runge–Kutta, fine steps."""

    def f(x):
        return np.array([x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]])

    x, h = np.array([2.0, 0.0]), stop / steps
    for _ in range(steps):
        k1 = f(x)
        k2 = f(x + h / 2 * k1)
        k3 = f(x + h / 2 * k2)
        k4 = f(x + h * k3)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x


@pytest.mark.parametrize("mu", [1.0, 3.0])
def test_van_der_pol_is_a_fine_reference(examples, mu):
    result = fmpy.simulate_fmu(
        str(examples / "VanDerPol.fmu"),
        stop_time=4.0,
        output_interval=0.1,
        start_values={"mu": mu},
        output=["x0", "x1", "der_x0", "der_x1"],
    )
    last = result[-1]
    reference = van_der_pol(mu, 4.0, 8000)
    # Internal steps of 0.01 s: 0.01⁴ times derivatives of a few hundred at μ = 3.
    assert last["x0"] == pytest.approx(reference[0], abs=1e-6)
    assert last["x1"] == pytest.approx(reference[1], abs=1e-5)
    assert last["der_x0"] == last["x1"]
    x0, x1 = last["x0"], last["x1"]
    assert last["der_x1"] == pytest.approx(mu * (1 - x0**2) * x1 - x0, rel=1e-14, abs=1e-14)
