"""A steering assist in the loop with the bicycle.

    python couple.py RearLoadBicycle.fmu
"""

import shutil
import sys

from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave

STEP = 0.005  # s: the controller's sample time


def assist(roll, roll_rate, steer, steer_rate, speed):
    """The motor's torque on the steering [N m], left positive. Angles in rad, rates in rad/s."""
    torque = -30.0 * roll_rate - 1.0 * steer_rate
    return max(-10.0, min(10.0, torque))


class Bicycle:
    """The FMU, its variables by name, in SI units."""

    def __init__(self, path, **start):
        description = read_model_description(path)
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        self.folder = extract(path)
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="bicycle",
        )
        self.fmu.instantiate()
        self.set(**start)
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time = 0.0

    def set(self, **values):
        self.fmu.setReal([self.reference[name] for name in values], list(values.values()))

    def get(self, *names):
        return self.fmu.getReal([self.reference[name] for name in names])

    def step(self):
        """Goes on by STEP; false where the bicycle fell or the steering met its limit."""
        try:
            self.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=STEP)
        except FMICallException as error:
            if error.status != 2:  # fmi2Discard: the end came within the step
                raise
            return False
        self.time += STEP
        return True

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)


def ride(bicycle, controller, until):
    """Rides on with the controller; the largest roll angle [rad] on the way."""
    largest = 0.0
    while bicycle.time < until - STEP / 2:
        signals = bicycle.get("roll", "roll_rate", "steer", "steer_rate", "speed")
        if controller is not None:
            bicycle.set(assist_torque=controller(*signals))
        if not bicycle.step():
            print(f"the bicycle came to its end after {bicycle.time:.3f} s")
            break
        largest = max(largest, abs(bicycle.get("roll")[0]))
    return largest


def main(path):
    bicycle = Bicycle(path, speed=8 / 3.6, roll_start=0.05, rear_load=20.0)
    ride(bicycle, None, 5.0)

    # The same second twice from one saved state, without and with the assist.
    bicycle.set(roll_moment=100.0)
    state, time = bicycle.fmu.getFMUstate(), bicycle.time
    without = ride(bicycle, None, time + 1.0)
    bicycle.fmu.setFMUstate(state)
    bicycle.time = time
    with_assist = ride(bicycle, assist, time + 1.0)
    bicycle.fmu.freeFMUstate(state)
    print(f"largest roll angle in a gust: {without:.4f} rad, with the assist {with_assist:.4f} rad")

    # Tunable parameters act from where they are set: the load falls off.
    bicycle.set(roll_moment=0.0, rear_load=0.0)
    ride(bicycle, assist, time + 6.0)
    print(f"roll angle 5 s after the load was lost: {bicycle.get('roll')[0]:.5f} rad")
    bicycle.close()


if __name__ == "__main__":
    main(sys.argv[1])
