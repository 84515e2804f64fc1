"""An importer in miniature: the C functions through ctypes, statuses instead of exceptions."""

from ctypes import byref, c_char, c_double, c_int, c_size_t, c_uint, c_void_p
from math import nan

from fmpy import fmi2
from fmpy.fmi2 import fmi2Discard, fmi2OK

COSIMULATION = 1
NONE, ONE = c_size_t(0), c_size_t(1)

STATES = ["instantiated", "initialization", "step complete", "step failed", "terminated"]


class Slave:
    """An instance whose functions return their status instead of raising."""

    def __init__(self, description, unzipped, references):
        self.lines = []
        self.references = references
        self.guid = description.guid.encode()
        self.fmu = fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(unzipped),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="slave",
        )
        self.library = self.fmu.dll
        self.callbacks = fmi2.fmi2CallbackFunctions()
        # The logger is variadic; fixed arguments travel the same way.
        self.callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self.log)
        self.callbacks.allocateMemory = fmi2.defaultCallbacks.allocateMemory
        self.callbacks.freeMemory = fmi2.defaultCallbacks.freeMemory
        self.callbacks.componentEnvironment = c_void_p(42)
        self.component = None
        self.time = 0.0

    def log(self, environment, name, status, category, message):
        self.lines.append((environment, name, status, category, message))

    def taken(self):
        lines, self.lines = self.lines, []
        return lines

    def instantiate(self, name=b"slave", kind=COSIMULATION, guid=None, logging=1):
        guid = self.guid if guid is None else guid
        self.library.fmi2Instantiate.restype = c_void_p
        self.component = self.library.fmi2Instantiate(
            name, kind, guid, None, byref(self.callbacks), 0, logging
        )
        return self.component

    def call(self, function, *arguments):
        return self.library[function](c_void_p(self.component), *arguments)

    def setup(self, start=0.0, stop=None):
        defined = int(stop is not None)
        return self.call(
            "fmi2SetupExperiment", 0, c_double(0), c_double(start), defined, c_double(stop or 0)
        )

    def start(self):
        statuses = [
            self.setup(),
            self.call("fmi2EnterInitializationMode"),
            self.call("fmi2ExitInitializationMode"),
        ]
        assert statuses == [fmi2OK] * 3

    def set(self, name, value):
        reference = c_uint(self.references[name])
        return self.call("fmi2SetReal", byref(reference), ONE, byref(c_double(value)))

    def get(self, name):
        reference, value = c_uint(self.references[name]), c_double(nan)
        assert self.call("fmi2GetReal", byref(reference), ONE, byref(value)) == fmi2OK
        return value.value

    def step(self, time, h):
        return self.call("fmi2DoStep", c_double(time), c_double(h), 1)

    def ok(self, function, *arguments):
        status = self.call(function, *arguments)
        assert status == fmi2OK, (function, self.lines)

    def reach(self, state):
        """A new instance, brought into a state, leaning and turning."""
        assert self.instantiate()
        self.time = 0.0
        for name, value in [("roll_start", 0.05), ("steer_start", -0.02)]:
            assert self.set(name, value) == fmi2OK
        if state == "step failed":
            # a rider who pushes the bicycle over
            assert self.set("rider_roll_gain", -2000.0) == fmi2OK
        assert self.setup() == fmi2OK
        if state == "instantiated":
            return
        self.ok("fmi2EnterInitializationMode")
        if state == "initialization":
            return
        self.ok("fmi2ExitInitializationMode")
        if state == "step failed":
            assert self.step(0.0, 10.0) == fmi2Discard
        else:
            # off the internal grid
            self.go_on(1 / 60)
        if state == "terminated":
            self.ok("fmi2Terminate")
        self.taken()

    def go_on(self, h):
        assert self.step(self.time, h) == fmi2OK, self.lines
        self.time += h

    def free(self):
        if self.component:
            self.library.fmi2FreeInstance(c_void_p(self.component))
        self.component = None

    def ramp(self, name, slope, order=1):
        reference = c_uint(self.references[name])
        return self.call(
            "fmi2SetRealInputDerivatives", byref(reference), ONE, byref(c_int(order)), byref(c_double(slope))
        )

    def rate(self, name):
        reference, value = c_uint(self.references[name]), c_double(nan)
        self.ok("fmi2GetRealOutputDerivatives", byref(reference), ONE, byref(c_int(1)), byref(value))
        return value.value

    def derivative(self, unknown, known):
        unknown, known = c_uint(self.references[unknown]), c_uint(self.references[known])
        value = c_double(nan)
        self.ok(
            "fmi2GetDirectionalDerivative", byref(unknown), ONE, byref(known), ONE, byref(c_double(1)), byref(value)
        )
        return value.value

    def save(self):
        state = c_void_p()
        self.ok("fmi2GetFMUstate", byref(state))
        assert state.value
        return state

    def restore(self, state):
        self.ok("fmi2SetFMUstate", state)

    def forget(self, state):
        self.ok("fmi2FreeFMUstate", byref(state))
        assert not state.value

    def bytes_of(self, state):
        size = c_size_t()
        self.ok("fmi2SerializedFMUstateSize", state, byref(size))
        room = (c_char * size.value)()
        self.ok("fmi2SerializeFMUstate", state, room, size)
        return bytes(room)

    def read(self, data):
        state = c_void_p()
        status = self.call("fmi2DeSerializeFMUstate", data, c_size_t(len(data)), byref(state))
        return status, state

    def bytes(self):
        """The present state, to the last bit."""
        state = self.save()
        data = self.bytes_of(state)
        self.forget(state)
        return data
