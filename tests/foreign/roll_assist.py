"""The roll assist of roll_assist.c, its law written once more, for PythonFMU:

    pythonfmu build -f roll_assist.py
"""

import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class PythonRollAssist(Fmi2Slave):
    description = "Steering assist against rolling"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.roll = self.roll_rate = self.steer_rate = 0.0
        self.speed = 8.0 / 3.6
        self.roll_gain = 10.0
        self.roll_rate_gain = 40.0
        self.roll_rate_gain_slope = -5.0
        self.steer_rate_gain = 1.0
        self.torque_limit = 10.0
        self.motor_time = 0.02
        self.motor_torque = 0.0

        for name in ["roll", "roll_rate", "steer_rate", "speed"]:
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        self.register_variable(Real("assist_torque", causality=Fmi2Causality.output))
        for name in [
            "roll_gain",
            "roll_rate_gain",
            "roll_rate_gain_slope",
            "steer_rate_gain",
            "torque_limit",
            "motor_time",
        ]:
            tunable = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}
            self.register_variable(Real(name, **tunable))

    def demand(self):
        roll_rate_gain = self.roll_rate_gain + self.roll_rate_gain_slope * self.speed
        torque = (
            -self.roll_gain * self.roll
            - roll_rate_gain * self.roll_rate
            - self.steer_rate_gain * self.steer_rate
        )
        return max(-self.torque_limit, min(self.torque_limit, torque))

    @property
    def assist_torque(self):
        return self.motor_torque if self.motor_time > 0.0 else self.demand()

    def do_step(self, current_time, step_size):
        if self.motor_time > 0.0:
            missing = self.demand() - self.motor_torque
            self.motor_torque -= missing * math.expm1(-step_size / self.motor_time)
        return True
