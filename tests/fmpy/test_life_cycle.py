"""The C interface misused through ctypes."""

from ctypes import byref, c_double, c_int, c_uint, c_void_p
from math import inf, nan

import pytest
from fmpy.fmi2 import fmi2Discard, fmi2Error, fmi2OK
from slave import COSIMULATION, NONE, ONE


@pytest.mark.parametrize(
    "wrong, word",
    [
        ({"guid": b"{0}"}, b"fmuGUID"),
        ({"name": None}, b"instanceName"),
        ({"name": b""}, b"instanceName"),
        ({"kind": 0}, b"fmuType"),
    ],
)
def test_a_wrong_instantiation_gives_null_and_one_line(slave, wrong, word):
    assert slave.instantiate(**wrong) is None
    [(environment, _, status, category, message)] = slave.taken()
    assert (environment, status, category) == (42, fmi2Error, b"logStatusError")
    assert word in message


def test_without_callbacks_there_is_no_instance(slave):
    function = slave.library.fmi2Instantiate
    function.restype = c_void_p
    assert function(b"slave", COSIMULATION, slave.guid, None, None, 0, 1) is None


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_not_a_number_is_refused_and_the_instance_lives(slave, value):
    slave.instantiate()
    slave.start()
    before = slave.get("speed")
    assert slave.set("speed", value) == fmi2Error
    [(_, name, status, _, message)] = slave.taken()
    assert (name, status) == (b"slave", fmi2Error)
    assert b"speed" in message
    assert slave.get("speed") == before
    assert slave.step(0.0, 0.01) == fmi2OK


def test_null_arrays(slave):
    slave.instantiate()
    slave.start()
    for function in ["Real", "Integer", "Boolean", "String"]:
        for verb in ["Get", "Set"]:
            assert slave.call(f"fmi2{verb}{function}", None, NONE, None) == fmi2OK
            assert slave.call(f"fmi2{verb}{function}", None, ONE, None) == fmi2Error
    assert len(slave.taken()) == 8
    reference = c_uint(slave.references["roll"])
    assert slave.call("fmi2GetReal", byref(reference), ONE, None) == fmi2Error
    assert slave.call("fmi2GetRealStatus", 2, None) == fmi2Error


def test_a_null_instance_is_an_error(slave):
    none = c_void_p(None)
    for function in ["EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset"]:
        assert slave.library[f"fmi2{function}"](none) == fmi2Error
    assert slave.library.fmi2DoStep(none, c_double(0), c_double(1), 1) == fmi2Error
    assert slave.library.fmi2GetReal(none, None, NONE, None) == fmi2Error
    slave.library.fmi2FreeInstance(none)


def test_steps_out_of_order_are_refused_and_can_be_corrected(slave):
    slave.instantiate()
    assert slave.step(0.0, 0.01) == fmi2Error
    slave.start()
    for time, h in [(0.0, 0.0), (0.0, -1.0), (0.0, nan), (0.0, inf), (0.0, 1e15), (1.0, 0.01)]:
        assert slave.step(time, h) == fmi2Error, (time, h)
    assert len(slave.taken()) == 7
    assert slave.step(0.0, 0.01) == fmi2OK
    assert slave.get("time") == 0.01


def test_no_step_beyond_the_stop_time(slave):
    slave.instantiate()
    assert slave.setup(stop=0.3) == fmi2OK
    assert slave.call("fmi2EnterInitializationMode") == fmi2OK
    assert slave.call("fmi2ExitInitializationMode") == fmi2OK
    time = 0.0
    for _ in range(3):
        # 0.1 + 0.1 + 0.1 > 0.3 in floating point
        assert slave.step(time, 0.1) == fmi2OK
        time += 0.1
    assert slave.step(time, 0.1) == fmi2Error


def test_an_early_end_can_be_asked_about(slave):
    slave.instantiate()
    assert slave.set("roll_start", 1.4) == fmi2OK
    assert slave.set("rider_roll_gain", -2000.0) == fmi2OK
    slave.start()
    assert slave.step(0.0, 10.0) == fmi2Discard
    time, terminated = c_double(), c_int()
    assert slave.call("fmi2GetRealStatus", 2, byref(time)) == fmi2OK
    assert slave.call("fmi2GetBooleanStatus", 3, byref(terminated)) == fmi2OK
    assert terminated.value == 1
    assert 0.0 <= time.value < 10.0
    assert slave.get("time") == time.value
    assert slave.step(time.value, 0.01) == fmi2Error
    assert slave.call("fmi2Terminate") == fmi2OK
    assert slave.call("fmi2Reset") == fmi2OK
    slave.start()
    assert slave.step(0.0, 0.01) == fmi2OK


def test_instances_come_and_go(slave):
    # fresh instances behave alike however many came before
    values = set()
    for _ in range(200):
        slave.instantiate()
        slave.start()
        assert slave.step(0.0, 0.01) == fmi2OK
        values.add(slave.get("steer"))
        slave.library.fmi2FreeInstance(c_void_p(slave.component))
    slave.component = None
    assert len(values) == 1
