"""Reference masters: FMUs coupled by equal names, as plainly as it can be said.

An output goes to every input of the same name. Inputs are held while a member steps. A member of a
longer step takes part at its own communication points only.
"""

from dataclasses import dataclass, field
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

# Passes of the initial exchange; without an algebraic loop values settle within one a member.
MOST_PASSES = 50


@dataclass
class Member:
    """An FMU that takes part, from its start values."""

    name: str
    unzipped: Path
    start_values: dict = field(default_factory=dict)
    # how many base steps one of its own takes
    every: int = 1

    def __post_init__(self):
        description = fmpy.read_model_description(str(self.unzipped))
        variables = description.modelVariables
        self.variables = {v.name: v for v in variables}
        self.inputs = [v.name for v in variables if v.causality == "input"]
        self.outputs = [v.name for v in variables if v.causality == "output"]
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(self.unzipped),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=self.name,
        )

    def set(self, values: dict):
        for name, value in values.items():
            variable = self.variables[name]
            setter = self.fmu.setReal if variable.type == "Real" else self.fmu.setInteger
            setter([variable.valueReference], [value])

    def get(self) -> dict:
        """The outputs."""
        references = [self.variables[name].valueReference for name in self.outputs]
        return dict(zip(self.outputs, self.fmu.getReal(references), strict=True))

    def take(self, board: dict):
        """Sets the inputs that somebody publishes."""
        self.set({name: board[name] for name in self.inputs if name in board})

    def step(self, now: float, then: float):
        self.fmu.doStep(currentCommunicationPoint=now, communicationStepSize=then - now)


def initialize(members) -> dict:
    """Initial values travel until they settle; what is published then."""
    for member in members:
        member.fmu.instantiate()
        member.fmu.setupExperiment(startTime=0.0)
        member.set(member.start_values)
        member.fmu.enterInitializationMode()
    before, board = None, published(members)
    for _ in range(MOST_PASSES):
        if board == before:
            break
        for member in members:
            member.take(board)
        before, board = board, published(members)
    assert board == before, "the initial values do not settle"
    for member in members:
        member.fmu.exitInitializationMode()
    return published(members)


def published(members) -> dict:
    board = {}
    for member in members:
        board |= member.get()
    return board


def jacobi(members, n, board, time):
    """All step from the values at the communication point, then publish where they have come to."""
    due = [member for member in members if n % member.every == 0]
    for member in due:
        member.take(board)
    for member in due:
        member.step(time(n), time(n + member.every))
    for member in members:
        if (n + 1) % member.every == 0:
            board |= member.get()


def gauss_seidel(members, n, board, time):
    """One after the other, each from the newest values; each publishes at once."""
    for member in members:
        if n % member.every == 0:
            member.take(board)
            member.step(time(n), time(n + member.every))
            board |= member.get()


def couple(members, sweep, step: float, count: int) -> dict:
    """Makes `count` steps by `sweep`; by name what each member was at each communication point, of one
    of a longer step what it was when it last arrived."""

    def time(n):
        return n * step

    try:
        board = initialize(members)
        shown = dict(board)
        rows = [{"time": 0.0} | shown]
        for n in range(count):
            sweep(members, n, board, time)
            for member in members:
                if (n + 1) % member.every == 0:
                    shown |= {name: board[name] for name in member.outputs}
            rows.append({"time": time(n + 1)} | shown)
        for member in members:
            member.fmu.terminate()
    finally:
        for member in members:
            member.fmu.freeInstance()
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
