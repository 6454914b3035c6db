"""Manoeuvres, and their excluded parts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Optional, Sequence

import numpy as np

from ._doublet import DoubletError
from ._frames import Origin, moment
from ._table import Table


@dataclass(frozen=True, repr=False)
class Window:
    """A manoeuvre.

    Attributes:
        name: Name, unique among the windows used together.
        start: First instant, s.
        end: Last instant, s.
        surface: ``"elevator"``, ``"aileron"`` or ``"rudder"``; ``None`` where several move or it is not known.
        kind: Kind of input in words, for example ``"3-2-1-1"``.
        role: ``"identification"`` or ``"validation"``.
        confidence: How near its shape is to the ideal, 0 to 1, where it was found.
        flight: Name of its flight, where a session names it.
        exclude: Excluded parts: pairs of start and end, s.
    """

    name: str
    start: float
    end: float
    surface: Optional[str] = None
    kind: str = ""
    role: str = "identification"
    confidence: Optional[float] = None
    flight: Optional[str] = None
    exclude: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        try:
            is_forward = bool(self.start < self.end)
            pairs = tuple((start, end) for start, end in self.exclude)
        except (TypeError, ValueError):
            raise DoubletError(f"manoeuvre '{self.name}': give start and end, and exclude as pairs of them") from None
        if not is_forward:
            raise DoubletError(f"manoeuvre '{self.name}': its end {self.end} s is not after its start {self.start} s")
        wrong = next((pair for pair in pairs if not pair[0] < pair[1]), None)
        if wrong is not None:
            raise DoubletError(f"manoeuvre '{self.name}': the excluded part {wrong[0]} to {wrong[1]} s is empty")
        object.__setattr__(self, "exclude", pairs)

    def split(self) -> list["Window"]:
        """The parts between the excluded parts, each a window; the window where nothing is excluded."""
        if not self.exclude:
            return [self]
        parts, start = [], self.start
        for first, last in sorted(self.exclude):
            parts.append((start, min(first, self.end)))
            start = max(start, last)
        kept = [pair for pair in [*parts, (start, self.end)] if pair[0] < pair[1]]
        return [
            replace(self, name=f"{self.name} (part {number})", start=first, end=last, exclude=())
            for number, (first, last) in enumerate(kept, start=1)
        ]

    def _row(self) -> tuple[str, float, float, Optional[str], str, str, list[tuple[float, float]]]:
        excluded = [(float(start), float(end)) for start, end in self.exclude]
        return self.name, float(self.start), float(self.end), self.surface, self.kind, self.role, excluded

    @classmethod
    def _of_row(cls, row: tuple[str, float, float, Optional[str], str, str, list[tuple[float, float]]]) -> "Window":
        name, start, end, surface, kind, role, excluded = row
        return cls(name, start, end, surface, kind, role, exclude=tuple(excluded))

    @classmethod
    def _of(cls, given: Any, index: int, origin: Optional[Origin] = None) -> "Window":
        """A window from what users give: a window, ``(start, end)``, ``(start, end, surface)``, a slice, or an interval of pandas, whose
        ends are seconds, durations, or instants of a recording with an origin."""
        if isinstance(given, Window):
            start, end = _ends((given.start, given.end), given, origin)
            return replace(given, start=start, end=end, exclude=tuple(_ends(pair, given, origin) for pair in given.exclude))
        surface = None
        if isinstance(given, slice):
            ends: Sequence[Any] = (given.start, given.stop)
        elif hasattr(given, "left") and hasattr(given, "right"):
            ends = (given.left, given.right)
        else:
            is_row = isinstance(given, (tuple, list)) or (isinstance(given, np.ndarray) and given.ndim == 1)
            ends = tuple(given) if is_row else ()
            surface = ends[2] if len(ends) == 3 else None
        if len(ends) not in (2, 3) or not (surface is None or isinstance(surface, str)):
            raise _not_a_window(given)
        start, end = _ends(ends, given, origin)
        return cls(f"window {index + 1}", start, end, surface)

    def __repr__(self) -> str:
        words = [word for word in (self.flight, self.surface, self.kind, self.role) if word]
        if self.exclude:
            words.append(f"without {', '.join(f'{_shown(start)} to {_shown(end)} s' for start, end in self.exclude)}")
        return f"<doublet.Window '{self.name}': {_shown(self.start)} to {_shown(self.end)} s, {', '.join(words)}>"

    def _repr_html_(self) -> str:
        row = dict(name=self.name, start_s=self.start, end_s=self.end, surface=self.surface, kind=self.kind, role=self.role,
                   flight=self.flight, exclude_s=[f"{_shown(start)} to {_shown(end)}" for start, end in self.exclude] or None,
                   confidence=self.confidence)
        return Table([{key: value for key, value in row.items() if value is not None}])._repr_html_()


def of_one_flight(given: Sequence[Any], origin: Optional[Origin]) -> list[Window]:
    """Windows of one recording."""
    windows = [Window._of(window, index, origin) for index, window in enumerate(given)]
    flights = list(dict.fromkeys(one.flight for one in windows if one.flight is not None))
    if len(flights) > 1:
        raise DoubletError(f"windows are of the flights {', '.join(flights)}: give those of one, [w for w in windows if w.flight == '{flights[0]}']")
    return windows


def _shown(time: Any) -> str:
    return f"{time:.6g}" if isinstance(time, (int, float)) else str(time)


def _ends(pair: Sequence[Any], given: Any, origin: Optional[Origin]) -> tuple[float, float]:
    """Start and end in seconds."""
    try:
        return moment(pair[0], origin), moment(pair[1], origin)
    except DoubletError as error:
        raise DoubletError(f"windows: {error}") from None
    except (TypeError, ValueError):
        raise _not_a_window(given) from None


def _not_a_window(given: Any) -> DoubletError:
    return DoubletError(f"windows: {given!r} is not a manoeuvre: give (start, end) in s, (start, end, surface) or a doublet.Window")
