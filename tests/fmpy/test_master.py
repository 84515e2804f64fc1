"""The bicycle with the controller in C: masters in Python against laws, `wobble cosim` against them."""

import subprocess
from math import expm1

import numpy as np
import pytest
from conftest import columns_of
from coupling import Member, couple, gauss_seidel, jacobi

SWEEPS = {"jacobi": jacobi, "gauss-seidel": gauss_seidel}
LEANING = {"roll_start": 0.05, "rear_load": 20.0}
STATES = ["roll", "steer", "roll_rate", "steer_rate", "yaw_rate", "heading", "x", "y"]


@pytest.fixture
def members(unzipped, unzipped_assist):
    """Bicycle and controller, in this order."""

    def make(every=1, **controller):
        return [
            Member("plant", unzipped, LEANING),
            Member("controller", unzipped_assist, controller, every=every),
        ]

    return make


@pytest.mark.parametrize("sweep", SWEEPS.values())
def test_a_controller_without_gains_leaves_the_bicycle_to_itself(members, native, sweep):
    gains = ["roll_gain", "roll_rate_gain", "roll_rate_gain_slope", "steer_rate_gain"]
    coupled = couple(members(**dict.fromkeys(gains, 0.0)), sweep, 0.005, 1000)
    alone = native(0.005, 5.0, LEANING)
    for name in STATES:
        assert np.array_equal(coupled[name], alone[name]), name


@pytest.mark.parametrize("algorithm", SWEEPS)
@pytest.mark.parametrize("motor_time", [0.02, 0.0])
def test_the_coupling_is_the_loop_written_out(members, unzipped, algorithm, motor_time):
    step, count = 0.005, 1000
    coupled = couple(members(motor_time=motor_time), SWEEPS[algorithm], step, count)

    def demand(roll, roll_rate, steer_rate):
        gain = 40.0 - 5.0 * (8.0 / 3.6)
        return max(-10.0, min(10.0, -10.0 * roll - gain * roll_rate - steer_rate))

    bicycle = Member("alone", unzipped, LEANING)
    bicycle.fmu.instantiate()
    bicycle.fmu.setupExperiment(startTime=0.0)
    bicycle.set(LEANING)
    bicycle.fmu.enterInitializationMode()
    bicycle.fmu.exitInitializationMode()
    measured = ["roll", "roll_rate", "steer_rate"]
    torque = 0.0 if motor_time else demand(0.05, 0.0, 0.0)
    for n in range(count):
        before = [bicycle.get()[name] for name in measured]
        bicycle.set({"assist_torque": torque})
        bicycle.step(n * step, (n + 1) * step)
        after = [bicycle.get()[name] for name in measured]
        wanted = demand(*(before if algorithm == "jacobi" else after))
        torque += (wanted - torque) * (-expm1(-step / motor_time) if motor_time else 1.0)
        assert torque == pytest.approx(coupled["assist_torque"][n + 1], abs=1e-12)
        # sums in another order, in a loop that forgets them
        assert after == pytest.approx([coupled[name][n + 1] for name in measured], abs=1e-12)
    bicycle.fmu.freeInstance()
    # and the assist is felt
    assert np.abs(coupled["assist_torque"]).max() > 0.1


def test_in_what_order_members_are_named_is_nothing_to_jacobi(members):
    forward = couple(members(), jacobi, 0.005, 1000)
    backward = couple(members()[::-1], jacobi, 0.005, 1000)
    for name in forward:
        assert np.array_equal(forward[name], backward[name]), name


@pytest.mark.parametrize("sweep", SWEEPS.values())
def test_the_error_falls_with_the_step(members, sweep):
    def end(substeps):
        coupled = couple(members(), sweep, 0.004 / substeps, 500 * substeps)
        return np.array([coupled[name][-1] for name in STATES])

    fine = end(16)
    coarse, halved = (np.abs(end(substeps) - fine).max() for substeps in [1, 2])
    # of first order, measured against a sixteenth: (1 − 1/16)/(1/2 − 1/16) = 2.14
    assert 1.8 < coarse / halved < 2.5


def test_a_slow_controller_is_seen_at_its_own_points(members):
    coupled = couple(members(every=5), jacobi, 0.001, 1000)
    torque = coupled["assist_torque"]
    assert np.array_equal(torque[:-1].reshape(-1, 5), np.tile(torque[:-1:5, None], 5))
    assert (np.diff(torque[::5]) != 0.0).all()


@pytest.fixture(scope="module")
def cosim(wobble, fmu, foreign, tmp_path_factory):
    """Runs `wobble cosim` with the controller in C; its columns, the bicycle's by plain names."""
    out = tmp_path_factory.mktemp("cosim") / "ride.csv"

    def run(algorithm: str, step: str, controller_step: str) -> dict:
        command = [wobble, "cosim", "--plant", fmu, "--controller", foreign / "RollAssist.fmu"]
        command += ["--set", "roll_start=0.05", "--load", "20", "--algorithm", algorithm]
        command += ["--step", step, "--controller-step", controller_step, "--stop", "5s", "-o", out]
        subprocess.run(command, check=True)
        return columns_of(out.read_text(encoding="utf-8"))

    return run


@pytest.mark.parametrize("algorithm", SWEEPS)
@pytest.mark.parametrize(("step", "every"), [(5, 1), (1, 1), (1, 5)])
def test_wobble_couples_as_the_reference_does(members, cosim, algorithm, step, every):
    ours = cosim(algorithm, f"{step}ms", f"{step * every}ms")
    # the command has the controller step before the bicycle
    controller_first = members(every=every)[::-1]
    theirs = couple(controller_first, SWEEPS[algorithm], step * 1e-3, 5000 // step)
    assert len(ours["time"]) == len(theirs["time"])
    for name in ["time", *STATES]:
        # the same calls in the same order; points in time may differ in the last bit
        assert np.allclose(ours[name], theirs[name], rtol=0.0, atol=1e-9), name
    torque = ours["controller.assist_torque"]
    assert np.allclose(torque, theirs["assist_torque"], rtol=0.0, atol=1e-9)
