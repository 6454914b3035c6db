"""Frames of pandas, polars, xarray and pyarrow, and times of any kind."""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping
from typing import Any, Callable, NamedTuple, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._doublet import DoubletError
from ._table import Columnar

#: Units of time, s.
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}


def column(values: ArrayLike, name: str) -> NDArray[np.float64]:
    """Values as float64 in one piece: the same memory where they are so already."""
    array = numbers(values, name)
    if array.ndim != 1:
        raise DoubletError(f"{name} has {array.ndim} dimensions: give one column")
    return np.ascontiguousarray(array)


def numbers(values: ArrayLike, name: str) -> NDArray[np.float64]:
    """Values as an array of float64. Objects that are numbers are converted, ``None`` is not a number; anything else is refused."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise DoubletError(f"{name} must be numbers: {error}") from None
    kind = array.dtype.kind
    if kind == "O":
        return np.array([_number(one, name) for one in array.flat], dtype=np.float64).reshape(array.shape)
    if kind in "biuf":
        return np.asarray(array, dtype=np.float64)
    if kind == "c":
        raise DoubletError(f"Complex data not supported: {name} is complex, give its real and imaginary part as two columns")
    if kind in "mM":
        raise DoubletError(f"{name} holds {_kind_of_time(array)}, not numbers: convert it to seconds")
    if kind in "UST":
        raise DoubletError(f"{name} is text and must be numbers: convert it, for example by pandas.to_numeric")
    raise DoubletError(f"{name} must be numbers, not {array.dtype}: convert it")


def _number(value: Any, name: str) -> float:
    """A number among objects."""
    if is_missing(value):
        return math.nan
    if not isinstance(value, (str, bytes)):
        try:
            return float(value)
        except (TypeError, ValueError):
            pass
    raise DoubletError(f"{name} must be numbers, {value!r} is {'text' if isinstance(value, str) else f'a {type(value).__name__}'}: convert it")


def is_missing(value: Any) -> bool:
    """Whether an object stands for no value."""
    return value is None or type(value).__name__ == "NAType"


class Times(NamedTuple):
    """Times in seconds, or instants, which are seconds from an origin on.

    Attributes:
        values: Seconds, or instants of ``datetime64``; those with a time zone in UTC.
        has_zone: Whether the instants have a time zone.
    """

    values: NDArray[Any]
    has_zone: bool = False

    @property
    def are_instants(self) -> bool:
        return bool(self.values.dtype.kind == "M")

    def since(self, origin: Optional[np.datetime64]) -> NDArray[np.float64]:
        """Seconds; of instants those since the origin, which only an empty column lacks."""
        if not self.are_instants:
            return self.values
        return np.zeros(0) if origin is None else _seconds_of(self.values - origin)


def times(values: Any, unit: str = "", name: str = "time") -> Times:
    """Instants as they are; durations and numbers in seconds, numbers being in ``unit``."""
    has_zone = _has_zone(values)
    if hasattr(getattr(values, "dtype", None), "tz"):
        values = values.dt.tz_convert(None) if hasattr(values, "dt") else values.tz_convert(None)
    array = values if isinstance(values, np.ndarray) else np.asarray(values)
    if array.dtype == object:
        array, is_zoned = _of_objects(array)
        has_zone = has_zone or is_zoned
    if array.dtype.kind not in "mM":
        return Times(_of_numbers(array, unit, name))
    if unit:
        raise DoubletError(f"{name} holds {_kind_of_time(array)}: leave its unit out")
    if np.isnat(array).any():
        raise DoubletError(f"{name} has no value at sample {int(np.argmax(np.isnat(array)))}: leave that row out")
    return Times(array, has_zone) if array.dtype.kind == "M" else Times(_seconds_of(array))


def _has_zone(values: Any) -> bool:
    """Whether instants of pandas, polars or pyarrow have a time zone."""
    dtype, kind = getattr(values, "dtype", None), getattr(values, "type", None)
    return any(zone is not None for zone in (getattr(dtype, "tz", None), getattr(dtype, "time_zone", None), getattr(kind, "tz", None)))


def seconds(values: Any, unit: str = "", name: str = "time") -> NDArray[np.float64]:
    """Time in seconds. Instants count from the first one; durations and numbers are kept, numbers in ``unit``."""
    found = times(values, unit, name)
    return found.since(found.values[0] if found.are_instants and len(found.values) else None)


class Origin(NamedTuple):
    """The instant that seconds are counted from.

    Attributes:
        instant: Instant; UTC where it has a time zone.
        has_zone: Whether it has a time zone.
    """

    instant: np.datetime64
    has_zone: bool


def common_origin(clocks: Mapping[str, Times]) -> Optional[Origin]:
    """The first instant of all clocks; ``None`` where they count seconds."""
    filled = {name: clock for name, clock in clocks.items() if len(clock.values)}
    if not any(clock.are_instants for clock in filled.values()):
        return None
    (first, one), *others = filled.items()
    for name, other in others:
        if other.are_instants != one.are_instants:
            dated, plain = (first, name) if one.are_instants else (name, first)
            raise DoubletError(f"{dated} holds instants and {plain} does not: give both as instants, or both in seconds")
        if other.has_zone != one.has_zone:
            raise DoubletError(f"only one of {first} and {name} has a time zone: give both one, or none")
    return Origin(min(clock.values[0] for clock in filled.values()), one.has_zone)


def moment(value: Any, origin: Optional[Origin]) -> float:
    """A number, a duration, or an instant of a recording with an origin, in seconds."""
    if isinstance(value, np.timedelta64):
        return float(value / np.timedelta64(1, "s"))
    if hasattr(value, "total_seconds"):
        return float(value.total_seconds())
    if isinstance(value, (np.datetime64, datetime.datetime)):
        return _since(value, origin)
    if isinstance(value, str):
        raise DoubletError(f"{value!r} is text: give seconds, a duration or an instant")
    return float(value)


def _since(value: Any, origin: Optional[Origin]) -> float:
    """An instant in seconds since the origin."""
    if origin is None:
        raise DoubletError(f"{value} is an instant, but the time counts seconds: give seconds")
    found = times(np.array([value]) if isinstance(value, np.datetime64) else np.array([value], dtype=object))
    if found.has_zone != origin.has_zone:
        raise DoubletError(f"{value} has {'a' if found.has_zone else 'no'} time zone, the recording has {'one' if origin.has_zone else 'none'}: give both alike")
    return float(found.since(origin.instant)[0])


def stated_seconds(values: Any, unit: str, name: str = "time") -> NDArray[np.float64]:
    """Time in seconds with the unit that a frame states, which instants and durations do not have."""
    return seconds(values, "" if is_dated(values) else unit, name)


def is_dated(values: Any) -> bool:
    """Whether times are instants or durations, which have no unit of their own."""
    kind = np.asarray(values).dtype.kind
    return kind in "mM" or (kind == "O" and isinstance(next(iter(values), None), (datetime.datetime, datetime.timedelta)))


def _kind_of_time(array: NDArray[Any]) -> str:
    return "instants" if array.dtype.kind == "M" else "durations"


def _seconds_of(durations: NDArray[Any]) -> NDArray[np.float64]:
    """Durations in seconds: whole ones exactly, then the rest."""
    second = np.timedelta64(1, "s")
    whole = durations // second
    return np.ascontiguousarray(whole.astype(np.float64) + (durations - whole * second) / second)


def _of_objects(array: NDArray[Any]) -> tuple[NDArray[Any], bool]:
    """An array of Python's dates, durations and times of day as one of NumPy, and whether it has a time zone; others as they are."""
    first = array.flat[0] if array.size else None
    if isinstance(first, datetime.datetime):
        zone = first.tzinfo
        plain = [one.astimezone(datetime.timezone.utc).replace(tzinfo=None) if zone else one for one in array]
        return np.array(plain, dtype="datetime64[us]"), zone is not None
    if isinstance(first, datetime.timedelta):
        return np.array(array, dtype="timedelta64[us]"), False
    if isinstance(first, datetime.time):
        return np.array([3600 * one.hour + 60 * one.minute + one.second + 1e-6 * one.microsecond for one in array]), False
    return array, False


def _of_numbers(array: NDArray[Any], unit: str, name: str) -> NDArray[np.float64]:
    if array.dtype.kind in "USTO" and array.size and isinstance(array.flat[0], str):
        raise DoubletError(f"{name} is text: convert it by pandas.to_datetime or pandas.to_timedelta")
    factor = TIME_UNITS.get(unit or "s")
    if factor is None:
        raise DoubletError(f"'{unit}' is not a unit of time: use one of {', '.join(TIME_UNITS)}")
    plain = column(array, name)
    return plain if factor == 1.0 else plain * factor


class Columns(NamedTuple):
    """A frame: names of its columns, a column by name, the stamps of its index where it has one, and the units it states."""

    names: list[str]
    get: Callable[[str], Any]
    stamps: Optional[Any]
    units: dict[str, str]


def is_frame(given: Any) -> bool:
    """Whether it has columns with names; a lone column has none."""
    if isinstance(given, (Mapping, Columnar)) or any(hasattr(given, mark) for mark in ("data_vars", "column_names", "columns")):
        return True
    return hasattr(given, "__arrow_c_stream__") and not hasattr(given, "__array__")


def columns_of(frame: Any) -> Columns:
    """The columns of a frame of pandas or polars, of an ``xarray.Dataset``, of a table of pyarrow or of a mapping of arrays."""
    if isinstance(frame, Columnar):
        return columns_of(frame._columns())
    if hasattr(frame, "data_vars"):
        return _of_dataset(frame)
    if hasattr(frame, "column_names"):
        names = [str(name) for name in frame.column_names]
        return Columns(names, frame.column, None, {})
    if hasattr(frame, "columns"):
        attributes = getattr(frame, "attrs", {}).get("units", {})
        units = dict(attributes) if isinstance(attributes, dict) else {}
        by_name = {str(name): name for name in frame.columns}
        return Columns(list(by_name), lambda name: frame[by_name[name]], getattr(frame, "index", None), units)
    if hasattr(frame, "keys"):
        names = [str(name) for name in frame.keys()]
        return Columns(names, lambda name: frame[name], None, {})
    if hasattr(frame, "__arrow_c_stream__"):
        import pyarrow

        return columns_of(pyarrow.table(frame))
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


def matrix_of(given: Any, name: str = "X") -> tuple[Optional[list[str]], NDArray[np.float64]]:
    """Names of the columns where they have some, and their values, shape (n, p)."""
    if hasattr(given, "toarray"):
        raise DoubletError(f"{name} is sparse, which is not supported: give {name}.toarray()")
    if is_frame(given):
        found = columns_of(given)
        if not found.names:
            raise DoubletError(f"{name} has no columns: give one for each parameter")
        return found.names, chosen_columns(found, found.names, name)
    array = numbers(given, name)
    if array.ndim != 2:
        raise DoubletError(f"{name} has {array.ndim} dimensions. Reshape your data: give samples by columns")
    return None, array


def chosen_columns(found: Columns, names: list[str], name: str = "X") -> NDArray[np.float64]:
    """Columns of a frame by name, shape (n, p)."""
    columns = [column(found.get(one), f"column '{one}' of {name}") for one in names]
    other = next((one for one, values in zip(names, columns) if len(values) != len(columns[0])), None)
    if other is not None:
        raise DoubletError(f"columns '{names[0]}' and '{other}' of {name} have different lengths: give one value per row")
    return np.column_stack(columns)


def numeric(values: Any) -> bool:
    """Whether a column holds numbers."""
    return bool(np.issubdtype(np.asarray(values).dtype, np.number))
