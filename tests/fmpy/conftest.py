"""fmpy as the judge from outside.

Environment variables name what is judged:
FMU      the file RearLoadBicycle.fmu
FOREIGN  the folder with RollAssist.fmu and RollAssistStateless.fmu, the controller in C
WOBBLE   the program, which simulates the same bicycle without FMI
"""

import csv
import json
import os
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest
from slave import Slave


def from_environment(name: str) -> Path:
    path = os.environ.get(name)
    if not path:
        pytest.exit(f"expected the environment variable {name}, see conftest.py", 2)
    if not Path(path).is_file():
        pytest.exit(f"{name}: expected a file, found none at {path}", 2)
    return Path(path).resolve()


@pytest.fixture(scope="session")
def fmu() -> Path:
    return from_environment("FMU")


@pytest.fixture(scope="session")
def description(fmu):
    return fmpy.read_model_description(str(fmu))


@pytest.fixture(scope="session")
def references(description):
    """Value references by name."""
    return {v.name: v.valueReference for v in description.modelVariables}


@pytest.fixture(scope="session")
def unzipped(fmu, tmp_path_factory) -> Path:
    return Path(fmpy.extract(str(fmu), unzipdir=str(tmp_path_factory.mktemp("fmu"))))


@pytest.fixture(scope="session")
def foreign() -> Path:
    folder = os.environ.get("FOREIGN")
    if not folder or not Path(folder).is_dir():
        pytest.exit("expected the environment variable FOREIGN to name a folder", 2)
    return Path(folder).resolve()


@pytest.fixture(scope="session")
def unzipped_assist(foreign, tmp_path_factory) -> Path:
    """The controller in C."""
    fmu = str(foreign / "RollAssist.fmu")
    return Path(fmpy.extract(fmu, unzipdir=str(tmp_path_factory.mktemp("assist"))))


@pytest.fixture(scope="session")
def wobble() -> Path:
    return from_environment("WOBBLE")


@pytest.fixture
def slave(description, unzipped, references):
    slave = Slave(description, unzipped, references)
    yield slave
    slave.free()
    slave.fmu.freeLibrary()


def columns_of(text: str) -> dict:
    """The columns of a CSV file, by name."""
    header, *rows = csv.reader(text.splitlines())
    names = [column.split("[")[0] for column in header]
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


@pytest.fixture(scope="session")
def native(wobble):
    """Runs the bicycle without FMI; returns its columns by name."""

    def run(step: float, stop: float, start_values: dict, *changes: str) -> dict:
        command = [wobble, "simulate", "--step", repr(step), "--duration", repr(stop)]
        for name, value in start_values.items():
            command += ["--set", f"{name}={value}"]
        for change in changes:
            command += ["--at", change]
        output = subprocess.run(command, check=True, capture_output=True, text=True)
        return columns_of(output.stdout)

    return run


@pytest.fixture(scope="session")
def falling(wobble):
    """Start values of a fall: the calibrated set with the paper's start and its negative trail."""
    start = ["trail=-0.035", "roll_start=-5deg", "steer_start=1deg", "yaw_rate_start=2"]
    command = [wobble, "parameters", "--bicycle", "section3", "--json"]
    for setting in start:
        command += ["--set", setting]
    output = subprocess.run(command, check=True, capture_output=True, text=True)
    rows = json.loads(output.stdout)
    # the formulation travels as a name there and as a number in the FMU; it keeps its start
    numbers = [row for row in rows if row["kind"].endswith("parameter") and "unit" in row]
    return {row["name"]: row["value"] for row in numbers}
