"""Columns as a MAT-file of level 5 (MathWorks, "MAT-File Format", R2023b, chapter 1): exact to the bit, and read without parsing."""

from __future__ import annotations

import struct
from typing import BinaryIO, Mapping, Union

import numpy as np
from numpy.typing import NDArray

from ._doublet import DoubletError

_Column = NDArray[np.float64]
_Value = Union[_Column, Mapping[str, _Column]]

#: Types of elements.
_INT8, _INT32, _UINT32, _DOUBLE, _MATRIX = 1, 5, 6, 9, 14
#: Classes of variables.
_STRUCT, _NUMBERS = 2, 6


def write_mat(path: str, variables: Mapping[str, _Value]) -> None:
    """Writes variables: columns, or structs of columns."""
    with open(path, "wb") as file:
        file.write(b"MATLAB 5.0 MAT-file, doublet".ljust(116) + bytes(8) + struct.pack("<H", 0x0100) + b"IM")
        for name, value in variables.items():
            _write(file, name, value)


def _write(file: BinaryIO, name: str, value: _Value) -> None:
    head, size = _head(name, value)
    if size >= 2**32:
        raise DoubletError(f"'{name}' has {size / 1e9:.1f} GB: a recording of several clocks may have 4 GB")
    file.write(struct.pack("<II", _MATRIX, size) + head)
    if isinstance(value, Mapping):
        for column in value.values():
            _write(file, "", column)
    else:
        file.write(struct.pack("<II", _DOUBLE, 8 * len(value)) + np.ascontiguousarray(value, "<f8").tobytes())


def _head(name: str, value: _Value) -> tuple[bytes, int]:
    """Header of a variable, and the size of header and values."""
    is_struct = isinstance(value, Mapping)
    rows = 1 if is_struct else len(value)
    flags = struct.pack("<II", _STRUCT if is_struct else _NUMBERS, 0)
    head = _element(_UINT32, flags) + _element(_INT32, struct.pack("<ii", rows, 1)) + _element(_INT8, _encoded(name))
    if not isinstance(value, Mapping):
        return head, len(head) + 8 + 8 * rows
    names = [_encoded(column) for column in value]
    width = max(map(len, names)) + 1
    head += _element(_INT32, struct.pack("<i", width)) + _element(_INT8, b"".join(one.ljust(width, b"\0") for one in names))
    return head, len(head) + sum(8 + _head("", column)[1] for column in value.values())


def _element(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def _encoded(name: str) -> bytes:
    """A name in ASCII, other letters by their numbers."""
    return name.encode("ascii", "backslashreplace")
