"""Recordings, the channels they hold, their manoeuvres; aircraft."""

from __future__ import annotations

import json
import numbers
import os
from dataclasses import dataclass
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import ArrayLike, NDArray

from . import _doublet
from ._doublet import DoubletError
from ._errors import existing, nearest, unknown, warn
from ._frames import Origin, Times, column, columns_of, common_origin, is_dated, is_missing, numeric, times
from ._replayed import Replayed
from ._table import Columnar, Table
from ._window import Window

PathLike = Union[str, "os.PathLike[str]"]
Progress = Optional[Callable[[float], object]]


def roles() -> Table:
    """Every role a channel may play: name, SI unit and description."""
    return Table([dict(role=name, unit=unit, description=text) for name, unit, text in _doublet.roles()], "roles")


def guess_roles(*paths: PathLike) -> Table:
    """Guessed roles of the channels of the files of one flight, as ``doublet map --json``: role, channel, unit, sign, confidence (0 to 1), evidence,
    and the channel that would play the role otherwise with the reason against it.

    Args:
        paths: Files or folders.

    Raises:
        DoubletError: A file that cannot be read.
    """
    names = ("role", "channel", "unit", "sign", "confidence", "evidence", "runner_up", "reason")
    found = _doublet.guess_roles([os.fspath(path) for path in paths])
    return Table([dict(zip(names, row)) for row in found], "guessed roles")


def units() -> Table:
    """Every unit that is understood, with the SI unit it becomes."""
    return Table([dict(unit=unit, si=si) for unit, si in _doublet.units()], "units")


@dataclass(frozen=True, eq=False, repr=False)
class Signal(NDArrayOperatorsMixin):
    """Samples of one channel. NumPy takes it for its values: ``np.mean(signal)``, ``np.degrees(signal)`` and ``signal - 1.0`` give
    plain arrays.

    Attributes:
        name: Name as recorded.
        time: Time, s, shape (n,), strictly increasing; a read-only view, no copy.
        values: Values in ``unit``, shape (n,); likewise.
        unit: Unit: SI where the channel plays a role.
        role: Role it plays, or ``None``.
    """

    name: str
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    unit: str
    role: Optional[str]

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, key: Any) -> Any:
        return self.values[key]

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]:
        if copy:
            return np.array(self.values, dtype=dtype)
        return np.asarray(self.values, dtype=dtype)

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> Any:
        plain = [one.values if isinstance(one, Signal) else one for one in inputs]
        return getattr(function, method)(*plain, **options)

    def __repr__(self) -> str:
        role = f" ({self.role})" if self.role and self.role != self.name else ""
        if not len(self):
            return f"<doublet.Signal {self.name}{role}: no samples>"
        span = f"{self.time[0]:.5g} to {self.time[-1]:.5g} s, {np.nanmin(self.values):.5g} to {np.nanmax(self.values):.5g} {self.unit}"
        return f"<doublet.Signal {self.name}{role}: {len(self)} samples, {span.rstrip()}>"

    def _repr_html_(self) -> str:
        row: dict[str, Any] = dict(name=self.name, role=self.role, unit=self.unit, samples=len(self))
        if len(self):
            row.update(start_s=float(self.time[0]), end_s=float(self.time[-1]), low=float(np.nanmin(self.values)),
                       mean=float(np.nanmean(self.values)), high=float(np.nanmax(self.values)))
        return Table([row])._repr_html_()

    def to_pandas(self) -> Any:
        """A ``pandas.Series`` over time."""
        import pandas

        return pandas.Series(self.values, index=pandas.Index(self.time, name="time"), name=self.name)


#: A window: pair of start and end, s, with the surface as a third, slice, or interval of pandas. Ends may be durations, and instants where the
#: time of the recording was given as instants.
WindowGiven = Union[Window, tuple[float, float], tuple[float, float, str], slice, Any]


class Recording(Columnar, Replayed[_doublet.Recording]):
    """Recorded channels of one flight. Channels with a role are in SI and radians."""

    def __init__(self, inner: _doublet.Recording, call: Any = None, origin: Optional[Origin] = None) -> None:
        super().__init__(inner, call)
        self._channels = inner.channels()
        self._origin = origin

    def __getstate__(self) -> dict[str, Any]:
        call = self._call or (_restored, (_kept(self._inner, self._channels), self.warnings, self.channel_map))
        return {**super().__getstate__(), "_call": call}

    @classmethod
    def from_arrays(
        cls, time: Optional[ArrayLike], channels: Mapping[str, Any], *, source: str = "arrays", check: bool = True
    ) -> "Recording":
        """A recording of arrays.

        Args:
            time: Time of all channels, s, shape (n,), strictly increasing; ``None`` where each channel gives its own. Durations
                (``timedelta64``) become seconds; instants (``datetime64``) become seconds since the first one of all channels, which
                is :attr:`origin`.
            channels: By name: ``values``, ``(values, unit)`` or ``(time, values, unit)``. A name of :func:`roles` plays that
                role and its values are converted from ``unit`` to SI (without a unit they are taken for SI); any other name
                stays as it is.
            source: Name of the recorder.
            check: Compare the channels: a time in another unit is refused, other contradictions give a :class:`DoubletWarning`.

        Raises:
            DoubletError: Lengths that differ, time that does not increase or is not in seconds, a unit that does not fit its role.
        """
        return cls._of_clocks(None if time is None else times(time), channels, source, check)

    @classmethod
    def _of_clocks(cls, shared: Optional[Times], channels: Mapping[str, Any], source: str, check: bool) -> "Recording":
        """A recording of channels with a time of their own or the shared one."""
        clocks = {} if shared is None else {"time": shared}
        rows = []
        for name, given in channels.items():
            clock, values, unit = "time", given, ""
            if isinstance(given, tuple) and len(given) == 2:
                values, unit = given
            elif isinstance(given, tuple) and len(given) == 3:
                clock, values, unit = f"time of '{name}'", given[1], given[2]
                clocks[clock] = times(given[0], name=clock)
            if clock not in clocks:
                raise DoubletError(f"'{name}' has no time: give it as (time, values, unit), or give time for all")
            rows.append((str(name), clock, column(values, f"'{name}'"), str(unit)))
        origin = common_origin(clocks)
        seconds = {name: clock.since(None if origin is None else origin.instant) for name, clock in clocks.items()}
        inner = _doublet.Recording.from_arrays([(name, seconds[clock], values, unit) for name, clock, values, unit in rows], source)
        made = cls(inner, origin=origin)
        if check:
            made._refuse_or_warn()
        return made

    def _refuse_or_warn(self) -> None:
        """Refuses a time in another unit and warns of channels that contradict each other."""
        wrong = [row for row in self.check() if row["level"] == "bad"]
        said = [f"{row['channel']}: {row['hypothesis']}. {row['evidence']}. {row.get('fix', '')}".strip() for row in wrong]
        for row, line in zip(wrong, said):
            if row["channel"] == "time":
                raise DoubletError(f"{line} check=False takes it as it is.")
        if said:
            more = f" ({len(said) - 1} more in recording.check())" if len(said) > 1 else ""
            warn(f"contradictory channels: {said[0]}{more}")

    @classmethod
    def from_frame(
        cls,
        frame: Any,
        *,
        time: Optional[str] = None,
        units: Optional[Mapping[str, str]] = None,
        names: Optional[Mapping[str, str]] = None,
        source: str = "frame",
        check: bool = True,
    ) -> "Recording":
        """A recording of the columns of a frame of pandas or polars, of an ``xarray.Dataset`` or of a table of pyarrow. Columns that are not
        numbers are left out, except those with a role, a unit or a name of ``names``, which must be numbers.

        Args:
            frame: Frame with one row per instant. Units in ``frame.attrs["units"]`` of pandas and in ``attrs["units"]`` of the
                variables of xarray are used.
            time: Column of time; by default ``time`` or ``t``, or else the index. Numbers are s unless ``units`` states
                another unit of time under the name of the column or ``"time"``; durations become seconds, instants become
                seconds since the first one.
            units: Unit of each column that is not SI, by the name it has here.
            names: Role of a column that is called otherwise: ``{"AoA": "alpha"}``.
            source: Name of the recorder.
            check: As in :meth:`from_arrays`.
        """
        found = columns_of(frame)
        names = dict(names or {})
        known = [*found.names, *names.values(), "time"]
        wrong = next((name for name in [*(units or {}), *names] if name not in known), None)
        if wrong is not None:
            raise unknown("column", wrong, found.names)
        _check_names(found.names, names)
        if time is not None and time not in found.names:
            raise unknown("column", time, found.names)
        time = time or next((name for name in ("time", "t") if name in found.names), None)
        if time is None and found.stamps is None:
            raise DoubletError("the frame has no column time or t: name it by time=")
        stamps, own = found.stamps if time is None else found.get(time), units or {}
        stated = {**found.units, **own}
        # Instants and durations have no unit: one that the frame states is that of earlier numbers.
        of_time = own if is_dated(stamps) else stated
        clock = times(stamps, of_time.get(time or "time", of_time.get("time", "")))
        channels_known = {*_role_names(), *stated, *names} - {"time"}
        channels = {}
        for name in found.names:
            role = names.get(name, name)
            values = None if name == time else _channel(found.get(name), name, not channels_known.isdisjoint((name, role)))
            if values is not None:
                channels[role] = (values, stated.get(name, stated.get(role, "")))
        return cls._of_clocks(clock, channels, source, check)

    @property
    def origin(self) -> Optional[np.datetime64]:
        """The instant at 0 s, where time was given as instants; UTC where these have a time zone."""
        return None if self._origin is None else self._origin.instant

    @property
    def channels(self) -> Table:
        """Every channel: source, name, unit, role, samples."""
        keys = ("source", "name", "unit", "role", "samples")
        return Table([dict(zip(keys, row)) for row in self._channels], "channels")

    @property
    def roles(self) -> list[str]:
        """Roles that are recorded."""
        return [row[3] for row in self._channels if row[3] is not None]

    @property
    def channel_map(self) -> Optional[str]:
        """The channel map the files were read by; ``None`` for arrays."""
        return self._inner.channel_map

    @property
    def warnings(self) -> list[str]:
        """Findings about the quality of the data, one line each."""
        return self._inner.warnings()

    def __getitem__(self, name: str) -> Signal:
        """The channel by its role, its name, or ``source/name``."""
        for at in (3, 1):
            for index, row in enumerate(self._channels):
                if row[at] == name or (at == 1 and f"{row[0]}/{row[1]}" == name):
                    time, values = self._inner.signal(index)
                    return Signal(row[1], time, values, row[2], row[3])
        raise unknown("channel or role", name, list(self))

    def get(self, name: str, default: Any = None) -> Any:
        """The channel or role called ``name``, or ``default`` where there is none."""
        return self[name] if name in self else default

    def __contains__(self, name: object) -> bool:
        return any(name in (row[3], row[1], f"{row[0]}/{row[1]}") for row in self._channels)

    def __iter__(self) -> Iterator[str]:
        return (row[3] or f"{row[0]}/{row[1]}" for row in self._channels)

    def __len__(self) -> int:
        return len(self._channels)

    def check(self) -> Table:
        """Channels against each other by kinematics and air data, as ``doublet check`` says it: level ``bad`` where a mistake
        of sign, unit or channel explains what does not fit."""
        return Table(json.loads(self._inner.physics()), "channels against each other")

    def to_pandas(self, step: Optional[float] = None) -> Any:
        """The channels with a role as a ``pandas.DataFrame``, by straight lines on one time: that of the roll rate, or every
        ``step`` seconds. ``attrs["units"]`` has the units."""
        import pandas

        frame = pandas.DataFrame(self._columns(step)).set_index("time")
        frame.attrs["units"] = {"time": "s", **{role: self[role].unit for role in self.roles}}
        return frame

    def _columns(self, step: Optional[float] = None) -> dict[str, Any]:
        base = self["p"] if "p" in self else self[next(iter(self))]
        time = base.time if step is None else np.arange(base.time[0], base.time[-1] + 0.5 * step, step)
        return {"time": time, **{role: np.interp(time, self[role].time, self[role].values) for role in self.roles}}

    def to_xarray(self) -> Any:
        """The same as an ``xarray.Dataset``, each variable with its unit."""
        import xarray

        frame = self.to_pandas()
        data = {role: ("time", frame[role].to_numpy(), {"units": self[role].unit}) for role in self.roles}
        return xarray.Dataset(data, coords={"time": ("time", frame.index.to_numpy(), {"units": "s"})})

    def plot(self, *names: str, axes: Any = None) -> Any:
        """Draws the channels or roles ``names`` over time, one below the other, on ``axes``; returns the axes."""
        from ._plots import stack

        signals = [self[name] for name in names or self.roles[:6]]
        return stack([(s.role or s.name, s.unit, [(s.time, s.values, None)]) for s in signals], axes)

    def __repr__(self) -> str:
        return f"<doublet.Recording of {len(self)} channels, roles {', '.join(self.roles) or 'none'}>"

    def _repr_html_(self) -> str:
        return self.channels._repr_html_()


def _role_names() -> list[str]:
    return [name for name, _, _ in _doublet.roles()]


def _channel(values: Any, name: str, is_known: bool) -> Optional[NDArray[np.float64]]:
    """A column of a frame; ``None`` where it is not numbers and nothing says that it is a channel."""
    array = np.asarray(values)
    if array.dtype.kind == "b" and is_known:
        raise DoubletError(f"column '{name}' is True or False and must be numbers: convert it by astype(float), or leave it out")
    if not is_known and not numeric(array) and (array.dtype.kind != "O" or not _are_numbers(array)):
        return None
    return column(array, f"column '{name}'")


def _are_numbers(array: NDArray[Any]) -> bool:
    """Whether objects are numbers as far as there are values."""
    present = [one for one in array.flat if not is_missing(one)]
    return bool(present) and all(isinstance(one, numbers.Number) and not isinstance(one, bool) for one in present)


def _check_names(columns: Sequence[str], names: Mapping[str, str]) -> None:
    """Every name must be a role, and no two columns may play the same one."""
    known = _role_names()
    played: dict[str, str] = {}
    for one in columns:
        role = names.get(one, one)
        if one in names and role not in known:
            near = nearest(role, known) or ": doublet.roles() lists them"
            raise DoubletError(f"names: '{role}' of column '{one}' is not a role{near}")
        if role in played:
            raise DoubletError(f"columns '{played[role]}' and '{one}' are both '{role}': rename or leave out one of them")
        played[role] = one


def _kept(inner: _doublet.Recording, channels: Sequence[Any]) -> list[tuple[Any, ...]]:
    """Channels as they are pickled; those of one clock share its array."""
    rows: list[tuple[Any, ...]] = []
    for index, (source, name, unit, role, _) in enumerate(channels):
        time, values = inner.signal(index)
        if rows and np.array_equal(rows[-1][4], time):
            time = rows[-1][4]
        rows.append((source, name, unit, role, time, values))
    return rows


def _restored(rows: list[tuple[Any, ...]], warnings: list[str], channel_map: Optional[str]) -> _doublet.Recording:
    return _doublet.Recording.restore(rows, warnings, channel_map)


def read(
    paths: Union[PathLike, Sequence[PathLike]], *, channel_map: Optional[str] = None, progress: Progress = None
) -> Recording:
    """Reads the files of one flight: MAT, HDF5, text, ULog, ArduPilot logs, TDMS, MDF 4, MCAP, Parquet, folders of CSV.

    Args:
        paths: File or folder, or several on one time line.
        channel_map: File of a channel map, or the name of one that comes with doublet; by default the one that fits best,
            or else a guess from names, units and values (then read ``recording.check()``).
        progress: Called with the part done, 0 to 1. Ctrl-C stops.

    Raises:
        DoubletFileNotFoundError: A file that does not exist.
        DoubletError: A file or channel map that cannot be read.
    """
    several = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    if not several:
        raise DoubletError("paths is empty: give a file")
    return Recording(_doublet.Recording.read([existing(path) for path in several], channel_map, progress))


def find_manoeuvres(recording: Recording) -> list[Window]:
    """The manoeuvres that the control deflections of ``recording`` show, in order of time. An empty list where there is none;
    ``recording.check()`` and ``doublet propose manoeuvres`` have the reasons."""
    rows, _ = recording._inner.manoeuvres()
    return [Window(name, start, end, surface, kind, confidence=sure) for name, start, end, surface, kind, sure in rows]


class Aircraft(Replayed[_doublet.Aircraft]):
    """Reference lengths, mass and inertia.

    Args:
        area: Reference area, m².
        span: Span, m.
        chord: Mean chord, m.
        mass: Mass, kg, constant; everything lies at the centre of gravity.
        inertia: ``(Ixx, Iyy, Izz)`` or ``(Ixx, Iyy, Izz, Ixz)``, kg m²; Ixz with its positive sign.
        name: Name in results.
    """

    def __init__(
        self,
        *,
        area: float,
        span: float,
        chord: float,
        mass: float,
        inertia: Sequence[float],
        name: str = "aircraft",
    ) -> None:
        if len(inertia) not in (3, 4):
            raise DoubletError("inertia is (Ixx, Iyy, Izz) or (Ixx, Iyy, Izz, Ixz), kg m²")
        moments, xz = [float(value) for value in inertia[:3]], float(inertia[3]) if len(inertia) == 4 else 0.0
        numbers = (name, area, span, chord, mass, moments, xz)
        super().__init__(_plain(*numbers), (_plain, numbers))

    @classmethod
    def _named(cls, name: str) -> "Aircraft":
        made = cls.__new__(cls)
        place = os.path.abspath(name) if os.path.exists(name) else name
        Replayed.__init__(made, _doublet.Aircraft.named(place), (_named, (place,)))
        return made

    def _is(self, other: "Aircraft") -> bool:
        """Whether the other one has the same name, lengths and masses."""
        return bool(self._inner.figures() == other._inner.figures())

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        figures = self._inner.figures()
        if name in figures:
            return figures[name]
        raise AttributeError(f"an aircraft has {', '.join(figures)}")

    @property
    def text(self) -> Optional[str]:
        """The aircraft file of one that was described by its numbers, for a session to name."""
        return self._inner.text

    def __repr__(self) -> str:
        figures = self._inner.figures()
        return (
            f"<doublet.Aircraft {figures['name']}: {figures['area']:.4g} m², span {figures['span']:.4g} m, "
            f"chord {figures['chord']:.4g} m, {figures['mass']:.5g} kg>"
        )

    def _repr_html_(self) -> str:
        figures = self._inner.figures()
        units = dict(area="m²", span="m", chord="m", mass="kg", centre_of_gravity="m", inertia="kg m²")
        rows = [dict(quantity=name, value=figures[name], unit=unit) for name, unit in units.items()]
        return Table(rows, figures["name"])._repr_html_()


def aircraft(name: PathLike) -> Aircraft:
    """An aircraft that comes with doublet, by its ``name`` (``"c337f"``), or that of an aircraft file, with its standard loading.

    Raises:
        DoubletError: No aircraft has this name, or its file is wrong.
    """
    return Aircraft._named(os.fspath(name))


def _named(name: str) -> _doublet.Aircraft:
    return _doublet.Aircraft.named(name)


def _plain(
    name: str, area: float, span: float, chord: float, mass: float, moments: Sequence[float], xz: float
) -> _doublet.Aircraft:
    return _doublet.Aircraft.plain(name, area, span, chord, mass, moments, xz)
