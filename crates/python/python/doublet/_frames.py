"""Frames of pandas, polars, xarray and pyarrow, and times of any kind."""

from __future__ import annotations

import datetime
from typing import Any, Callable, NamedTuple, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._doublet import DoubletError

#: Units of time, s.
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}


def column(values: ArrayLike, name: str) -> NDArray[np.float64]:
    """Values as float64 in one piece: the same memory where they are so already."""
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise DoubletError(f"{name} must be numbers: {error}") from None
    if array.ndim != 1:
        raise DoubletError(f"{name} has {array.ndim} dimensions: give one column")
    return array


def seconds(values: Any, unit: str = "", name: str = "time") -> NDArray[np.float64]:
    """Time in seconds. Instants count from the first one; durations and numbers are kept, numbers in ``unit``."""
    dtype = getattr(values, "dtype", None)
    if getattr(dtype, "tz", None) is not None:
        values = values.dt.tz_convert(None) if hasattr(values, "dt") else values.tz_convert(None)
    array = values if isinstance(values, np.ndarray) else np.asarray(values)
    if array.dtype == object:
        array = _of_objects(array, name)
    if array.dtype.kind not in "mM":
        return _of_numbers(array, unit, name)
    if unit:
        raise DoubletError(f"{name} holds {'instants' if array.dtype.kind == 'M' else 'durations'}: leave its unit out")
    if np.isnat(array).any():
        raise DoubletError(f"{name} has no value at sample {int(np.argmax(np.isnat(array)))}: leave that row out")
    durations = array - array[0] if array.dtype.kind == "M" and len(array) else array.astype(_duration(array))
    whole = durations // np.timedelta64(1, "s")
    return np.ascontiguousarray(whole.astype(np.float64) + (durations - whole * np.timedelta64(1, "s")) / np.timedelta64(1, "s"))


def _duration(array: NDArray[Any]) -> str:
    return f"timedelta64[{np.datetime_data(array.dtype)[0]}]"


def _of_objects(array: NDArray[Any], name: str) -> NDArray[Any]:
    """An array of Python's dates, durations and times of day as one of NumPy; others as they are."""
    first = array.flat[0] if array.size else None
    if isinstance(first, datetime.datetime):
        zone = first.tzinfo
        plain = [one.astimezone(datetime.timezone.utc).replace(tzinfo=None) if zone else one for one in array]
        return np.array(plain, dtype="datetime64[us]")
    if isinstance(first, datetime.timedelta):
        return np.array(array, dtype="timedelta64[us]")
    if isinstance(first, datetime.time):
        of_day = [3600 * one.hour + 60 * one.minute + one.second + 1e-6 * one.microsecond for one in array]
        return np.array(of_day)
    return array


def _of_numbers(array: NDArray[Any], unit: str, name: str) -> NDArray[np.float64]:
    if array.dtype.kind in "USO" and array.size and isinstance(array.flat[0], str):
        raise DoubletError(f"{name} is text: convert it by pandas.to_datetime or pandas.to_timedelta")
    factor = TIME_UNITS.get(unit or "s")
    if factor is None:
        raise DoubletError(f"'{unit}' is not a unit of time: use one of {', '.join(TIME_UNITS)}")
    numbers = column(array, name)
    return numbers if factor == 1.0 else numbers * factor


class Columns(NamedTuple):
    """A frame: names of its columns, a column by name, the stamps of its index where it has one, and the units it states."""

    names: list[str]
    get: Callable[[str], Any]
    stamps: Optional[Any]
    units: dict[str, str]


def columns_of(frame: Any) -> Columns:
    """The columns of a frame of pandas or polars, of an ``xarray.Dataset``, of a table of pyarrow or of a mapping of arrays."""
    if hasattr(frame, "data_vars"):
        return _of_dataset(frame)
    if hasattr(frame, "column_names"):
        names = [str(name) for name in frame.column_names]
        return Columns(names, lambda name: frame.column(name).to_numpy(), None, {})
    if hasattr(frame, "columns"):
        attributes = getattr(frame, "attrs", {}).get("units", {})
        units = dict(attributes) if isinstance(attributes, dict) else {}
        by_name = {str(name): name for name in frame.columns}
        return Columns(list(by_name), lambda name: frame[by_name[name]], getattr(frame, "index", None), units)
    if hasattr(frame, "__arrow_c_stream__"):
        import pyarrow

        return columns_of(pyarrow.table(frame))
    if hasattr(frame, "keys"):
        names = [str(name) for name in frame.keys()]
        return Columns(names, lambda name: frame[name], None, {})
    raise DoubletError(f"a {type(frame).__name__} is not a frame: give one of pandas, polars, xarray or pyarrow")


def _of_dataset(dataset: Any) -> Columns:
    variables = {str(name): one for name, one in dataset.data_vars.items()}
    dimensions = {one.dims for one in variables.values()}
    if len(dimensions) != 1 or len(next(iter(dimensions))) != 1:
        shown = ", ".join(f"{name} {one.dims}" for name, one in variables.items())
        raise DoubletError(f"the variables of the dataset do not share one dimension: {shown or 'there are none'}")
    dimension = next(iter(dimensions))[0]
    time = dataset[dimension] if dimension in dataset.coords else None
    several = {**variables, **({} if time is None else {"time": time})}
    units = {name: str(one.attrs["units"]) for name, one in several.items() if "units" in one.attrs}
    return Columns(list(variables), lambda name: variables[name].to_numpy(), None if time is None else time.to_numpy(), units)


def numeric(values: Any) -> bool:
    """Whether a column holds numbers."""
    return bool(np.issubdtype(np.asarray(values).dtype, np.number))


def formula(text: str) -> list[str]:
    """Terms of ``"1 + alpha + delta_e"``. The constant is the term ``1``."""
    terms = [term.strip().replace("**", "^") for term in text.split("+")]
    if not all(terms):
        raise DoubletError(f"'{text}' has an empty term: write it as '1 + alpha + delta_e'")
    return terms


def terms_of(given: Any) -> list[str]:
    """Terms of a formula or of a sequence of terms."""
    return formula(given) if isinstance(given, str) else [str(term) for term in given]
