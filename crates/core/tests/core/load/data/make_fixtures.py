"""Writes the small recordings of this folder: python3 make_fixtures.py (numpy, scipy 1.17, h5py 3.16).

Every channel follows from the sample number i and the time t, so that the tests compute what they expect.
"""

import struct
import zlib

import h5py
import numpy as np
import scipy.io

N = 50
i = np.arange(N)
t = 0.02 * i


def mat_v5():
    contents = {
        "t": t,
        "alpha": np.sin(t)[:, None],
        "flaps": (i % 3).astype(np.uint8)[:, None],
        "logical": (i % 2 == 0)[:, None],
        "counts": (-i).astype(np.int16)[None, :],
        "wide": np.vstack([i, 2.0 * i, 3.0 * i]),
        "tall": np.column_stack([i, 2.0 * i]).astype(np.float32),
        "note": "steady flight, alpha in rad",
        "imu": {"time": 10.0 + 0.01 * i, "q": np.cos(t), "calibration": {"scale": 2.0, "by": "hand"}},
        "cells": np.array([np.arange(4.0), "text"], dtype=object),
        "scalar": 9.81,
    }
    scipy.io.savemat("v5_compressed.mat", contents, do_compression=True, oned_as="column")
    scipy.io.savemat("v5_plain.mat", contents, do_compression=False, oned_as="column")
    sparse = {"t": t, "kept": np.sin(t), "s": scipy.sparse.eye(5, format="csc"), "z": t + 1j * t}
    scipy.io.savemat("v5_sparse.mat", sparse, do_compression=True)


def mat_v5_big_endian():
    """Big endian, with tags of the short form for name and dimensions' neighbours, partly compressed."""

    def element(kind, data):
        if 0 < len(data) <= 4:
            return struct.pack(">HH", len(data), kind) + data.ljust(4, b"\0")
        return struct.pack(">II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    def matrix(name, cls, kind, rows, columns, data):
        body = element(6, struct.pack(">II", cls, 0)) + element(5, struct.pack(">ii", rows, columns))
        body += element(1, name.encode()) + element(kind, data)
        return struct.pack(">II", 14, len(body)) + body

    header = b"MATLAB 5.0 MAT-file, big endian".ljust(116) + b"\0" * 8 + b"\x01\x00MI"
    time = matrix("t", 6, 9, N, 1, t.astype(">f8").tobytes())
    squares = matrix("sq", 6, 5, N, 1, (i * i).astype(">i4").tobytes())
    tiny = matrix("k", 8, 1, 1, 3, bytes([1, 2, 253]))
    packed = zlib.compress(squares)
    with open("v5_big_endian.mat", "wb") as file:
        file.write(header + time + struct.pack(">II", 15, len(packed)) + packed + tiny)


def hdf5_layouts():
    with h5py.File("layouts.h5", "w") as file:
        file.attrs["aircraft"] = "test"
        imu = file.create_group("imu")
        imu["time"] = t
        q = imu.create_dataset("q", data=np.cos(t), chunks=(16,), compression="gzip", shuffle=True)
        q.attrs["units"] = "deg/s"
        q32 = imu.create_dataset("q32", data=np.cos(t).astype(">f4"))
        q32.attrs["unit"] = "rad/s"
        imu.create_dataset("valid", data=(i % 2 == 0))
        imu.create_dataset("acc", data=np.column_stack([i, 2.0 * i, 3.0 * i]))
        gps = file.create_group("gps")
        gps.attrs["start_time"] = 5.0
        gps.attrs["sample_rate"] = 4.0
        gps.create_dataset("alt", data=(100 + i[:20]).astype(np.int32)).attrs["units"] = "ft"
        own = gps.create_dataset("fix", data=i[:10].astype(np.uint8))
        own.attrs["start_time"] = 6.0
        own.attrs["sample_rate"] = 2.0
        kind = np.dtype([("time", "<f8"), ("n1", "<f4"), ("n2", ">i2"), ("label", "S4")])
        table = np.zeros(N, kind)
        table["time"], table["n1"], table["n2"] = t, i / 4, -i
        file.create_dataset("engine", data=table)
        below = file.create_group("imu/below")
        below["r"] = np.sin(t)
        file["remark"] = "written by hand"


def hdf5_claim():
    with h5py.File("claims.h5", "w") as file:
        file["time"] = t
        file.create_dataset("huge", shape=(2**60,), dtype="f8", chunks=(1024,))


def hdf5_claim_together():
    with h5py.File("claims_together.h5", "w", libver="latest") as file:
        for k in range(8):
            file.create_dataset(f"q{k}", shape=(100_000,), dtype="f8")


def hdf5_odd():
    with h5py.File("odd.h5", "w", libver="latest") as file:
        file["time"] = t
        file["q"] = i
        file.create_dataset("lzf", data=t, compression="lzf", chunks=(len(t),))
        file["nothing"] = h5py.Empty("f8")
        file.create_dataset("unwritten", shape=(1000, 5000), dtype="f8")
        file.create_dataset("unwritten_chunks", shape=(10**9,), dtype="f8", chunks=(1024,))


def hdf5_virtual():
    with h5py.File("virtual.h5", "w", libver="latest") as file:
        file["time"] = t
        file["q"] = i
        file["below/r"] = 2.0 * i
        whole = h5py.VirtualLayout(shape=(len(t),), dtype="f8")
        whole[:] = h5py.VirtualSource("elsewhere.h5", "q", shape=(len(t),))
        file.create_virtual_dataset("whole", whole)
        part = h5py.VirtualLayout(shape=(len(t),), dtype="f8")
        part[10:20] = h5py.VirtualSource(".", "q", shape=(len(t),))[:10]
        file.create_virtual_dataset("below/part", part, fillvalue=0.0)


def hdf5_expands():
    with h5py.File("expands.h5", "w") as file:
        file["time"] = t
        file.create_dataset("zeros", shape=(4_000_000,), dtype="f8", chunks=(4_000_000,), compression=9)[:] = 0.0


def mat_v73():
    with h5py.File("v73.mat", "w", userblock_size=512) as file:

        def put(group, name, data, kind, **attributes):
            item = group.create_dataset(name, data=data)
            item.attrs["MATLAB_class"] = np.bytes_(kind)
            for key, value in attributes.items():
                item.attrs[key] = value
            return item

        put(file, "t", t[None, :], "double")
        put(file, "u_IMU", np.vstack([i, 2.0 * i]), "double")
        put(file, "flag", (i % 2).astype(np.uint8)[None, :], "logical", MATLAB_int_decode=np.int32(1))
        put(file, "note", np.array([[ord(c)] for c in "steady"], np.uint16), "char", MATLAB_int_decode=np.int32(2))
        run = file.create_group("run")
        run.attrs["MATLAB_class"] = np.bytes_("struct")
        put(run, "time", t[None, :], "double")
        put(run, "alpha", np.sin(t)[None, :], "double")
        refs = file.create_group("#refs#")
        first = put(refs, "a", np.arange(4.0)[None, :], "double")
        second = put(refs, "b", np.array([[ord(c)] for c in "two"], np.uint16), "char")
        cells = file.create_dataset("cells", data=np.array([[first.ref], [second.ref]], h5py.ref_dtype), dtype=h5py.ref_dtype)
        cells.attrs["MATLAB_class"] = np.bytes_("cell")
    with open("v73.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, test".ljust(116) + b"\0" * 8 + b"\x00\x02IM")


mat_v5()
mat_v5_big_endian()
hdf5_layouts()
hdf5_claim()
hdf5_claim_together()
hdf5_odd()
hdf5_virtual()
hdf5_expands()
mat_v73()
