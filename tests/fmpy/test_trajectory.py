"""simulate_fmu against the bicycle without FMI: equal to the last bit."""

import math
import runpy
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest

# From somewhere that is not upright and straight.
ASLANT = {"roll_start": 0.05, "steer_start": -0.02, "yaw_rate_start": 0.1, "rear_load": 12.5}


def outputs(description):
    return [v.name for v in description.modelVariables if v.causality == "output"]


def simulate(fmu, description, step, stop, start_values, **options):
    return fmpy.simulate_fmu(
        str(fmu),
        stop_time=stop,
        output_interval=step,
        start_values=start_values,
        output=outputs(description),
        **options,
    )


def assert_equal(result, native, names):
    assert len(result["time"]) == len(native["time"])
    for name in ["time", *names]:
        # NaN would not equal itself; there must be none
        assert np.array_equal(result[name], native[name]), name


@pytest.mark.parametrize("step", [0.005, 0.001])
def test_equal_steps(fmu, description, native, step):
    result = simulate(fmu, description, step, 24.0, ASLANT)
    assert_equal(result, native(step, 24.0, ASLANT), outputs(description))


FORMULATIONS = ["printed", "minimal", "repaired", "whipple", "whipple_slip"]


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_formulations_by_number(fmu, description, native, formulation):
    number = FORMULATIONS.index(formulation) + 1
    result = simulate(fmu, description, 0.005, 0.1, ASLANT | {"formulation": number})
    expected = native(0.005, 0.1, ASLANT | {"formulation": formulation})
    assert_equal(result, expected, outputs(description))


@pytest.mark.parametrize("formulation", ["repaired", "whipple_slip"])
def test_jumps_that_are_not_smoothed(fmu, description, native, formulation):
    # more friction than the start can break: the fork is held until the lean does
    values = ASLANT | {"steer_smoothing": 0.0, "steer_rate_smoothing": 0.0}
    values |= {"coulomb_friction": 3.0, "rider_roll_gain": 100.0}
    number = FORMULATIONS.index(formulation) + 1
    result = simulate(fmu, description, 0.005, 5.0, values | {"formulation": number})
    expected = native(0.005, 5.0, values | {"formulation": formulation})
    assert_equal(result, expected, outputs(description))
    # at the start the fork is at rest and breaks away
    assert result["steer_acceleration"][0] != 0.0
    held = result["steer_rate"][1:] == 0.0
    assert held.any() and not held.all()
    assert not result["steer_acceleration"][1:][held].any()


def test_speed_changes_midway(fmu, description, native):
    # fmpy interpolates between samples; between equal powers of two that is exact.
    speed = np.array(
        [(0.0, 2.0), (5.0, 2.0), (5.0, 4.0), (10.0, 4.0)],
        dtype=[("time", float), ("speed", float)],
    )
    result = simulate(fmu, description, 0.005, 10.0, ASLANT, input=speed)
    expected = native(0.005, 10.0, ASLANT | {"speed": 2.0}, "5:speed=4")
    assert_equal(result, expected, outputs(description))
    # and it matters
    unchanged = native(0.005, 10.0, ASLANT | {"speed": 2.0})
    assert result["x"][-1] > unchanged["x"][-1] + 5.0


def test_parameters_through_start_values(fmu, description, native, falling):
    upright = falling | {"trail": 0.13}
    result = simulate(fmu, description, 0.005, 5.0, upright)
    assert_equal(result, native(0.005, 5.0, upright), outputs(description))
    assert result["time"][-1] == 5.0


def test_steer_limit_ends_the_simulation(fmu, description, native, falling):
    result = simulate(fmu, description, 0.005, 5.0, falling)
    expected = native(0.005, 5.0, falling)
    assert_equal(result, expected, outputs(description))
    assert result["time"][-1] < 1.0
    # The event is located to the last bit of the step, where steer passes 85°.
    assert abs(result["steer"][-1]) == pytest.approx(math.radians(85), abs=1e-9)


def test_a_value_out_of_range_stops_the_simulation(fmu, description):
    with pytest.raises(Exception, match="fmi2SetReal"):
        simulate(fmu, description, 0.005, 1.0, {"wheelbase": 9.0})


DOCUMENTATION = Path(__file__).parents[2] / "fmu" / "documentation"


def test_the_script_that_couples_runs(fmu):
    command = [sys.executable, DOCUMENTATION / "couple.py", fmu]
    ran = subprocess.run(command, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout


def test_the_assist_of_the_documentation_steers(fmu, monkeypatch, capsys):
    script = DOCUMENTATION / "assist.py"
    monkeypatch.setattr(sys, "argv", [str(script), str(fmu)])
    after = runpy.run_path(str(script))
    ride, assist = after["ride"], after["assist"]
    assert capsys.readouterr().out
    # what is measured at one point acts until the next; the first step is made without
    demand = [assist(*row) for row in ride[["roll", "roll_rate", "steer_rate"]].tolist()]
    assert ride["assist_torque"][0] == ride["assist_torque"][1] == 0.0
    assert np.array_equal(ride["assist_torque"][2:], demand[1:-1])
    assert abs(ride["roll"][-1]) < 0.01 < ride["roll"][0]
