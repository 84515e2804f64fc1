"""Controllers of others: one in C, one built with PythonFMU; and the C one's ways to fail.
"""

import math
import subprocess
import sys
import zipfile
from ctypes import byref, c_double, c_int, c_uint, c_void_p
from pathlib import Path

import fmpy
import numpy as np
import pytest
from coupling import Member, couple, gauss_seidel, jacobi
from fmpy.fmi2 import (
    fmi2Discard,
    fmi2Error,
    fmi2Fatal,
    fmi2LastSuccessfulTime,
    fmi2OK,
    fmi2Terminated,
)
from fmpy.validation import validate_fmu
from lxml import etree
from pythonfmu.builder import FmuBuilder
from slave import ONE, Slave

SOURCES = Path(__file__).parents[1] / "foreign"
NONE, ERROR, DISCARD, FATAL, HANG, EARLY, NAN = range(7)
STEP = 0.005


@pytest.fixture
def controller(unzipped_assist):
    """An instance of the C controller, leaning, not yet instantiated."""
    description = fmpy.read_model_description(str(unzipped_assist))
    references = {v.name: v.valueReference for v in description.modelVariables}
    slave = Slave(description, unzipped_assist, references)
    yield slave
    slave.free()
    slave.fmu.freeLibrary()


def set_integer(slave, name, value):
    reference = c_uint(slave.references[name])
    assert slave.call("fmi2SetInteger", byref(reference), ONE, byref(c_int(value))) == fmi2OK


def ready(slave, fault=NONE, at=0.1, **values):
    """Stepping, its inputs set."""
    assert slave.instantiate()
    slave.time = 0.0
    set_integer(slave, "fault", fault)
    for name, value in {"fault_time": at, "roll": 0.1, "roll_rate": 0.05, **values}.items():
        assert slave.set(name, value) == fmi2OK
    slave.start()


def go_until(slave, stop):
    """Steps to `stop`; all is well until then."""
    while slave.time < stop - STEP / 2:
        slave.go_on(STEP)


def last_successful_time(slave):
    time = c_double(math.nan)
    slave.ok("fmi2GetRealStatus", fmi2LastSuccessfulTime, byref(time))
    return time.value


def is_terminated(slave):
    terminated = c_int(-1)
    slave.ok("fmi2GetBooleanStatus", fmi2Terminated, byref(terminated))
    return terminated.value


# −10·0.1 − (40 − 5·8/3.6)·0.05
DEMAND = -1.0 - (40.0 - 5.0 * 8.0 / 3.6) * 0.05


@pytest.mark.parametrize("name", ["RollAssist", "RollAssistStateless"])
def test_fmpy_finds_no_problem(foreign, name):
    fmu = foreign / f"{name}.fmu"
    assert validate_fmu(str(fmu)) == []
    schema = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
    with zipfile.ZipFile(fmu) as archive:
        xml = etree.fromstring(archive.read("modelDescription.xml"))
    etree.XMLSchema(etree.parse(schema)).assertValid(xml)


@pytest.mark.parametrize("h", [0.005, 1 / 60, 0.1])
def test_the_motor_lags_exactly(controller, h):
    ready(controller)
    for n in range(1, 7):
        controller.go_on(h)
        exact = DEMAND * (1.0 - math.exp(-n * h / 0.02))
        # each step rounds a few times
        assert controller.get("assist_torque") == pytest.approx(exact, rel=n * 2**-50)


def test_without_lag_the_torque_is_there_at_once(controller):
    ready(controller, motor_time=0.0)
    assert controller.get("assist_torque") == pytest.approx(DEMAND, rel=2**-50)
    assert controller.set("roll", 2.0) == fmi2OK
    assert controller.get("assist_torque") == -10.0
    assert controller.set("roll", math.nan) == fmi2OK
    assert math.isnan(controller.get("assist_torque"))


@pytest.mark.parametrize(
    ("fault", "status"),
    [(ERROR, fmi2Error), (DISCARD, fmi2Discard), (FATAL, fmi2Fatal), (EARLY, fmi2Discard)],
)
def test_a_fault_strikes_in_the_step_that_passes_its_time(controller, fault, status):
    ready(controller, fault, at=0.1)
    go_until(controller, 0.1)
    assert controller.step(controller.time, STEP) == status
    [(_, name, said, _, _)] = controller.taken()
    assert (name, said) == (b"slave", status)
    # after a failed step there is no other
    assert controller.step(controller.time, STEP) == fmi2Error


@pytest.mark.parametrize("fault", [DISCARD, EARLY])
def test_a_discarded_step_tells_how_far_it_came(controller, fault):
    ready(controller, fault, at=0.012)
    go_until(controller, 0.01)
    assert controller.step(controller.time, STEP) == fmi2Discard
    assert last_successful_time(controller) == 0.012
    assert is_terminated(controller) == int(fault == EARLY)
    exact = DEMAND * (1.0 - math.exp(-0.012 / 0.02))
    assert controller.get("assist_torque") == pytest.approx(exact, rel=1e-14)


def test_a_discarded_step_can_be_taken_back_and_made_shorter(controller):
    ready(controller, DISCARD, at=0.012)
    go_until(controller, 0.01)
    before, torque = controller.save(), controller.get("assist_torque")
    assert controller.step(controller.time, STEP) == fmi2Discard
    controller.restore(before)
    assert controller.get("assist_torque") == torque
    controller.go_on(0.002)
    assert controller.get("assist_torque") != torque
    controller.forget(before)


def test_nan_comes_after_its_time(controller):
    ready(controller, NAN, at=0.1)
    go_until(controller, 0.1)
    assert math.isfinite(controller.get("assist_torque"))
    controller.go_on(STEP)
    assert math.isnan(controller.get("assist_torque"))
    controller.go_on(STEP)
    assert math.isnan(controller.get("assist_torque"))


RIDE = f"""
import sys, fmpy

def tell(time, recorder):
    print(time, flush=True)
    return True

fmpy.simulate_fmu(sys.argv[1], stop_time=0.02, output_interval={STEP}, step_finished=tell,
                  start_values={{"fault": int(sys.argv[2]), "fault_time": 0.01}})
"""


def test_the_one_that_hangs_hangs(foreign):
    def ride(fault):
        command = [sys.executable, "-c", RIDE, foreign / "RollAssist.fmu", str(fault)]
        return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)

    with ride(NONE) as well:
        assert len(well.stdout.readlines()) == 4
    with ride(HANG) as hanging:
        assert [float(hanging.stdout.readline()) for _ in range(2)] == [0.005, 0.01]
        # at work for a minute; a second tells it from going on
        with pytest.raises(subprocess.TimeoutExpired):
            hanging.wait(timeout=1.0)
        hanging.kill()
        assert hanging.stdout.read() == ""


def test_calls_out_of_turn_are_refused(controller):
    assert controller.instantiate()
    assert controller.step(0.0, STEP) == fmi2Error
    assert controller.call("fmi2ExitInitializationMode") == fmi2Error
    controller.start()
    controller.go_on(STEP)
    assert controller.step(0.0, STEP) == fmi2Error
    assert controller.step(controller.time, 0.0) == fmi2Error
    assert controller.set("assist_torque", 1.0) == fmi2Error
    controller.ok("fmi2Reset")
    assert controller.step(0.0, STEP) == fmi2Error
    controller.start()
    assert controller.step(0.0, STEP) == fmi2OK


def test_one_of_the_two_cannot_save_states(foreign, tmp_path):
    unzipped = fmpy.extract(str(foreign / "RollAssistStateless.fmu"), unzipdir=str(tmp_path))
    description = fmpy.read_model_description(unzipped)
    assert not description.coSimulation.canGetAndSetFMUstate
    references = {v.name: v.valueReference for v in description.modelVariables}
    slave = Slave(description, unzipped, references)
    ready(slave)
    assert slave.call("fmi2GetFMUstate", byref(c_void_p())) == fmi2Error
    slave.free()
    slave.fmu.freeLibrary()


@pytest.fixture(scope="module")
def in_python(tmp_path_factory):
    """The controller of PythonFMU, unzipped."""
    if not FmuBuilder.has_binary():
        pytest.skip("PythonFMU has no binary for this platform")
    fmu = FmuBuilder.build_FMU(SOURCES / "roll_assist.py", dest=tmp_path_factory.mktemp("built"))
    return Path(fmpy.extract(str(fmu), unzipdir=str(tmp_path_factory.mktemp("python"))))


LEANING = {"roll_start": 0.05, "rear_load": 20.0}


@pytest.mark.parametrize("sweep", [jacobi, gauss_seidel])
@pytest.mark.parametrize("motor_time", [0.02, 0.0])
def test_two_foreign_controllers_of_one_law_steer_alike(
    unzipped, unzipped_assist, in_python, sweep, motor_time
):
    def ride(assist):
        bicycle = Member("plant", unzipped, LEANING)
        members = [bicycle, Member("controller", assist, {"motor_time": motor_time})]
        return couple(members, sweep, STEP, 2000)

    in_c, in_python = ride(unzipped_assist), ride(in_python)
    for name in in_c:
        # one law, sums and functions of two libraries: round-off in a loop that forgets it
        assert np.allclose(in_c[name], in_python[name], rtol=0.0, atol=1e-9), name
    # and it did steer
    assert np.abs(in_c["assist_torque"]).max() > 0.1
    assert abs(in_c["roll"][-1]) < 0.01


def test_the_law_is_the_same_where_the_motor_meets_its_limit(unzipped_assist, in_python):
    rolls = np.array(
        [(0.0, 0.0, 0.0), (1.0, 2.0, 1.0), (2.0, -3.0, -1.0)],
        dtype=[("time", float), ("roll", float), ("roll_rate", float)],
    )

    def torque(fmu):
        result = fmpy.simulate_fmu(str(fmu), stop_time=2.0, output_interval=STEP, input=rolls)
        return result["assist_torque"]

    in_c, in_python = torque(unzipped_assist), torque(in_python)
    assert np.allclose(in_c, in_python, rtol=0.0, atol=1e-12)
    assert in_c.min() < -9.9 and in_c.max() > 9.9
