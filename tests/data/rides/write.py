"""Writes the small ride files of other programs' making that the tests read.

    pip install numpy scipy h5py pyarrow
    python write.py            # into the folder of this script

The same ride in each: 40 samples at 200 Hz, time = i / 200 s, steer = sin(i / 5) / 10 rad,
roll_rate = cos(i / 7) / 4 rad/s, speed = 2.5 m/s.
"""

from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.io import savemat

HERE = Path(__file__).parent
N = 40
i = np.arange(N)
time, steer, roll_rate = i / 200, np.sin(i / 5) / 10, np.cos(i / 7) / 4
speed = np.full(N, 2.5)
columns = {"time": time, "steer": steer, "roll_rate": roll_rate, "speed": speed}


def mat(name, content, **options):
    savemat(HERE / f"{name}.mat", content, **options)


# as MATLAB's save -v7: compressed, standing; beside what is no column
mat(
    "vectors",
    columns | {"rider": "second", "fs": 200.0, "law_in_loop": np.array([[0]], dtype=np.uint8)},
    do_compression=True,
    oned_as="column",
)
# as save -v6: as it is; lying; singles and integers: time in ms, steer in units of 1e-4 rad
mat(
    "integers",
    {
        "t": (5 * i).astype(np.int32),
        "steer_counts": np.round(steer * 1e4).astype(np.int16),
        "w": roll_rate.astype(np.float32),
        "v": (2.5 * np.ones(N)).astype(np.float64),
        "calibration": np.eye(3),
    },
    oned_as="row",
)
# a struct alone, and beside another variable
mat("struct", {"ride": columns}, do_compression=True, oned_as="column")
mat("structs", {"ride": columns, "t2": time, "z": time + 1j}, oned_as="column")


def mat73(path, group):
    """As MATLAB writes them: a dataset a variable, transposed, chunked and deflated."""
    with h5py.File(path, "w", userblock_size=512, libver="earliest") as file:
        for name, values in group.items():
            if isinstance(values, dict):
                inner = file.create_group(name)
                inner.attrs["MATLAB_class"] = np.bytes_("struct")
            else:
                inner, values = file, {name: values}
            for field, x in values.items():
                # (two of them: an index of chunks takes 2 kB)
                how = dict(chunks=(1, 16), compression="gzip", shuffle=True)
                how = how if field in ("time", "steer") else {}
                data = inner.create_dataset(field, data=x.reshape(1, -1), **how)
                kind = {"float64": "double", "float32": "single"}.get(x.dtype.name, x.dtype.name)
                data.attrs["MATLAB_class"] = np.bytes_(kind)
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: - HDF5 schema 1.00 ."
    with open(path, "r+b") as file:
        file.write(head.ljust(116) + bytes(8) + b"\x00\x02IM")


mat73(HERE / "vectors73.mat", columns | {"roll_rate": roll_rate.astype(np.float32)})
mat73(HERE / "struct73.mat", {"ride": columns})

table = pa.table(
    {
        "time": pa.array((time * 1e6).round().astype("int64") + 1_700_000_000_000_000, pa.timestamp("us")),
        "steer[deg]": np.degrees(steer),
        "roll_rate": pa.array(roll_rate.astype(np.float32)),
        "speed": pa.array(speed),
        "rider": pa.array(["second"] * N),
    }
)
pq.write_table(table, HERE / "ride.parquet", compression="zstd", row_group_size=16)
empty = table.set_column(3, "speed", pa.array([2.5] * 30 + [None] + [2.5] * 9))
pq.write_table(empty, HERE / "gap.parquet", compression="snappy", row_group_size=16)
