#!/usr/bin/env python3
"""Writes an hour of the shipped simulated flight at 1 kHz with 48 channels, to measure time and memory of a long recording.

    scripts/make_long_recording.py FILE [--seconds 3600] [--rate 1000] [--channels 48] [--single]

The ending of FILE is the format: tdms, mat (version 5), mf4, parquet, h5, csv. Needs numpy, scipy and h5py; asammdf for MDF 4, pyarrow for
Parquet. The flight is the truth of assets/flights/demo by cubic splines, with sensor noise; angles are in degrees. The channels beyond those of
the flight are strain gauges of noise, as a structural recorder has them. Delete the file afterwards: an hour has 1.4 GB.
"""

import argparse
import pathlib
import struct

import h5py
import numpy
from scipy.interpolate import CubicSpline
from scipy.io import savemat

TRUTH = pathlib.Path(__file__).resolve().parent.parent / "assets/flights/demo/truth.h5"
# Name in the file, unit, name in the truth, factor, standard deviation of the noise.
DEG = 57.29577951308232
FLIGHT = [
    ("ax", "m/s^2", "ax", 1.0, 0.02), ("ay", "m/s^2", "ay", 1.0, 0.02), ("az", "m/s^2", "az", 1.0, 0.02),
    ("p", "deg/s", "p", DEG, 0.05), ("q", "deg/s", "q", DEG, 0.05), ("r", "deg/s", "r", DEG, 0.05),
    ("phi", "deg", "phi", DEG, 0.02), ("theta", "deg", "theta", DEG, 0.02), ("psi", "deg", "psi", DEG, 0.05),
    ("airspeed", "m/s", "airspeed", 1.0, 0.1), ("alpha", "deg", "alpha", DEG, 0.05), ("beta", "deg", "beta", DEG, 0.05),
    ("v_north", "m/s", "v_north", 1.0, 0.03), ("v_east", "m/s", "v_east", 1.0, 0.03), ("v_down", "m/s", "v_down", 1.0, 0.03),
    ("x", "m", "x", 1.0, 0.1), ("y", "m", "y", 1.0, 0.1), ("z", "m", "z", 1.0, 0.1),
    ("delta_e", "deg", "delta_e", DEG, 0.02), ("delta_a", "deg", "delta_a", DEG, 0.02), ("delta_r", "deg", "delta_r", DEG, 0.02),
    ("thrust_1", "N", "thrust_1", 1.0, 0.0), ("thrust_2", "N", "thrust_2", 1.0, 0.0),
]
TDMS_BLOCK = 100_000


def columns(seconds, rate, channels, kind):
    """Yields name, unit and samples, the time first."""
    noise = numpy.random.default_rng(1)
    count = int(seconds * rate)
    with h5py.File(TRUTH) as file:
        own = file["motion/time"][:]
        time = own[0] + numpy.arange(count) / rate
        yield "time", "s", time
        for name, unit, source, factor, deviation in FLIGHT[: channels - 1]:
            values = file["motion/" + source][:].astype(float)
            if source == "psi":
                values = numpy.unwrap(values)
            values = factor * CubicSpline(own, values)(numpy.minimum(time, own[-1]))
            yield name, unit, (values + deviation * noise.standard_normal(count)).astype(kind)
    for index in range(channels - 1 - len(FLIGHT)):
        yield f"strain_{index + 1:02}", "um/m", (10.0 * index + noise.standard_normal(count)).astype(kind)


def text(word):
    raw = word.encode()
    return struct.pack("<I", len(raw)) + raw


def write_tdms(path, columns):
    """Segments of 100 s, as LabVIEW writes them: the first describes the channels, each holds blocks of all channels."""
    columns = list(columns)
    code = {"float64": 10, "float32": 9}
    count = len(columns[0][2])
    with open(path, "wb") as out:
        for start in range(0, count, TDMS_BLOCK):
            length = min(TDMS_BLOCK, count - start)
            is_new = start == 0 or length != TDMS_BLOCK
            described = b""
            if is_new:
                described = struct.pack("<I", len(columns) + 1) + text("/'recorder'") + struct.pack("<II", 0xFFFFFFFF, 0)
                for name, unit, values in columns:
                    layout = struct.pack("<IIIQ", 20, code[values.dtype.name], 1, length)
                    described += text(f"/'recorder'/'{name}'") + layout + struct.pack("<I", 1)
                    described += text("unit_string") + struct.pack("<I", 0x20) + text(unit)
            raw = sum(length * values.itemsize for _, _, values in columns)
            contains = 1 << 3 | (1 << 1 | 1 << 2 if is_new else 0)
            out.write(b"TDSm" + struct.pack("<IIQQ", contains, 4713, len(described) + raw, len(described)) + described)
            for _, _, values in columns:
                out.write(values[start : start + length].tobytes())


def write_mdf(path, columns):
    from asammdf import MDF, Signal

    columns = list(columns)
    time = columns[0][2]
    with MDF(version="4.10") as file:
        file.append([Signal(values, time, unit=unit, name=name) for name, unit, values in columns[1:]])
        file.save(path, overwrite=True)


def write_parquet(path, columns):
    import pyarrow
    from pyarrow import parquet

    columns = list(columns)
    fields = [pyarrow.field(f"{name} [{unit}]", pyarrow.from_numpy_dtype(values.dtype)) for name, unit, values in columns]
    table = pyarrow.Table.from_arrays([pyarrow.array(values) for _, _, values in columns], schema=pyarrow.schema(fields))
    parquet.write_table(table, path, compression="zstd", use_dictionary=False)


def write_hdf5(path, columns):
    with h5py.File(path, "w") as file:
        for name, unit, values in columns:
            file.create_dataset(f"recorder/{name}", data=values).attrs["unit"] = unit


def write_csv(path, columns):
    columns = list(columns)
    with open(path, "w") as out:
        out.write(",".join(f"{name} [{unit}]" for name, unit, _ in columns) + "\n")
        table = [values for _, _, values in columns]
        for start in range(0, len(table[0]), TDMS_BLOCK):
            block = numpy.column_stack([values[start : start + TDMS_BLOCK] for values in table])
            numpy.savetxt(out, block, fmt="%.7g", delimiter=",")


def write_mat(path, columns):
    savemat(path, {name if unit == "s" else f"{name}_{unit.replace('/', '_').replace('^', '')}": values for name, unit, values in columns})


WRITERS = {"tdms": write_tdms, "mat": write_mat, "mf4": write_mdf, "parquet": write_parquet, "h5": write_hdf5, "csv": write_csv}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--channels", type=int, default=48)
    parser.add_argument("--single", action="store_true", help="write single precision")
    options = parser.parse_args()
    kind = numpy.float32 if options.single else numpy.float64
    given = columns(options.seconds, options.rate, options.channels, kind)
    WRITERS[options.file.suffix[1:].lower()](options.file, given)


if __name__ == "__main__":
    main()
