"""A steering assist as a plain Python function: python assist.py RearLoadBicycle.fmu"""

import sys
from fmpy import read_model_description, simulate_fmu

fmu = sys.argv[1]
number = {v.name: v.valueReference for v in read_model_description(fmu).modelVariables}


def assist(roll, roll_rate, steer_rate):
    """The motor's torque on the steering [N m], left positive, from rad and rad/s."""
    return max(-10.0, min(10.0, -10.0 * roll - 30.0 * roll_rate - 1.0 * steer_rate))


def control(time, recorder):
    """After each step: what was measured goes to the assist, its torque acts in the next step."""
    measured = recorder.fmu.getReal([number["roll"], number["roll_rate"], number["steer_rate"]])
    recorder.fmu.setReal([number["assist_torque"]], [assist(*measured)])
    return True  # go on


ride = simulate_fmu(fmu, stop_time=20, output_interval=0.005, step_finished=control,
                    start_values={"roll_start": 0.05, "rear_load": 20.0},
                    output=["roll", "roll_rate", "steer_rate", "assist_torque"])
torque = abs(ride["assist_torque"]).max()
print(f"after 20 s: roll {ride['roll'][-1]:.5f} rad, torque at most {torque:.2f} N m")
