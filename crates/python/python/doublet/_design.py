"""The next flight: inputs designed from a fit, their predicted errors and excursions."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Literal, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._doublet import DoubletError
from ._fit import Fit
from ._recording import Progress
from ._session import Results
from ._table import Table
from ._verdict import Verdict

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._linear import Trim

_SURFACES = ("aileron", "elevator", "rudder")


class Design:
    """A designed input with its predicted errors and excursions."""

    def __init__(self, row: dict[str, Any], csv: str, verdict: Verdict) -> None:
        self._row, self._csv, self._verdict = row, csv, verdict

    @property
    def verdict(self) -> Verdict:
        """How far the derivatives may be trusted that the input was designed with."""
        return self._verdict

    @property
    def predicted(self) -> Table:
        """A row per derivative: estimate, errors that a fit of the designed windows will have (``standard_error`` as if residuals were
        white, ``corrected`` in the noise that the fit left), and the corrected error now (``present``)."""
        return Table(self._row["predicted"], "errors to expect")

    @property
    def excursions(self) -> Table:
        """Excursion of each quantity, SI: nominal, expected with gusts and uncertain derivatives, limits, and the margin to them,
        which is negative where a limit may be exceeded."""
        return Table(self._row["excursions"], "excursions")

    @property
    def manoeuvres(self) -> Table:
        """A row per window: name, surfaces, duration (s), peaks (rad) and rates (rad/s)."""
        return Table(self._row["manoeuvres"], "windows")

    @property
    def trim(self) -> dict[str, float]:
        """The trim, SI and radians."""
        return dict(self._row["trim"])

    @property
    def costs(self) -> dict[str, float]:
        """Cost by each criterion; smaller is better."""
        return dict(self._row["costs"])

    def nodes(self, manoeuvre: int = 1) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
        """Nodes of a manoeuvre, straight lines between them: time since its start (s), and each surface's deflection about the trim (rad),
        arrays of shape (n,); with a throttle also the change of thrust ``thrust_n`` (N).

        Args:
            manoeuvre: Number of the manoeuvre, from 1.

        Raises:
            DoubletError: The design does not have this manoeuvre.
        """
        rows = [row for row in self._row["signal"] if row["manoeuvre"] == manoeuvre]
        if not rows:
            raise DoubletError(f"the design has no manoeuvre {manoeuvre}: give 1 to {len(self.manoeuvres)}")
        names = ("time_s", *_SURFACES, *(["thrust_n"] if "throttle" in self._row["surfaces"] else []))
        columns = {name: np.array([row[name] for row in rows]) for name in names}
        return columns.pop("time_s"), columns

    def at(self, time: Any, manoeuvre: int = 1) -> dict[str, NDArray[np.float64]]:
        """Deflections about the trim (rad) at any ``time`` (s, shape (n,)) since the start of ``manoeuvre``, by surface as in :meth:`nodes`."""
        nodes, deflections = self.nodes(manoeuvre)
        return {name: np.interp(time, nodes, values) for name, values in deflections.items()}

    def save(self, path: "str | os.PathLike[str]") -> None:
        """Writes the nodes of all manoeuvres as CSV to ``path``, as ``doublet design --out`` does."""
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(self._csv)

    def to_dict(self) -> dict[str, Any]:
        """What ``doublet design --json`` prints."""
        return self._row

    def plot(self, manoeuvre: int = 1, axes: Any = None) -> Any:
        """Draws the deflections of ``manoeuvre`` in degrees on ``axes``; returns the axes."""
        from ._plots import one as axis_of

        axis = axis_of(axes)
        time, deflections = self.nodes(manoeuvre)
        for name in (name for name in self._row["surfaces"] if name in deflections):
            axis.plot(time, np.degrees(deflections[name]), linewidth=1, label=name)
        axis.set_xlabel("time [s]")
        axis.set_ylabel("deflection about the trim [deg]")
        axis.legend()
        return axis

    def summary(self) -> str:
        """Expected errors and excursions as text."""
        row = self._row
        head = f"{row['kind']} on {', '.join(row['surfaces'])}, {row['time_s']:.4g} s in {len(row['manoeuvres'])} windows"
        return "\n".join([head, self.predicted.summary(), self.excursions.summary(), self.verdict.line()])

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return self.predicted._repr_html_() + self.excursions._repr_html_() + self.verdict._repr_html_()


def design_input(
    identified: Union[Fit, Results],
    *,
    surfaces: Sequence[str] = _SURFACES,
    duration: float = 60.0,
    kind: str = "multisine",
    criterion: Literal["d", "a", "max-relative"] = "a",
    peak: Optional[float] = None,
    rate: float = float(np.radians(60.0)),
    peak_thrust: Optional[float] = None,
    envelope: Optional[Mapping[str, tuple[float, float]]] = None,
    usage: float = 0.9,
    gusts: Optional[float] = None,
    rounds: int = 3,
    samples: int = 40,
    with_flown: bool = False,
    seed: int = 1,
    progress: Progress = None,
    **trim: Unpack[Trim],
) -> Design:
    """Inputs of the next flight that minimise the errors of the derivatives within limits, as ``doublet design``.

    Args:
        identified: Fit of :func:`fit`, or results of :func:`run` with ``studies=["dynamics"]``: those give the numbers of the
            command line.
        surfaces: Controls to move: ``"aileron"``, ``"elevator"``, ``"rudder"``, ``"throttle"``.
        duration: Time of all windows together, s.
        kind: ``"multisine"``, ``"doublet"``, ``"3-2-1-1"`` and others that a wrong name lists.
        criterion: Criterion to minimise: ``"d"``, determinant of the covariance; ``"a"``, sum of squared relative errors;
            ``"max-relative"``, the largest of them.
        peak: Largest deflection from the trim, rad; that of the windows unless given.
        rate: Fastest deflection, rad/s.
        peak_thrust: Largest change of thrust by an input of the throttle, N; a fifth of the trim's unless given.
        envelope: Limits that replace those of the windows: ``alpha``, ``beta``, ``phi`` (rad), ``n_z``, ``p`` (rad/s), ``V``
            (m/s), ``h`` (m), each ``(low, high)``.
        usage: Fraction of the margin to the limits that the nominal response may use.
        gusts: Standard deviation of the gusts, m/s; that of the filter's random walk of the wind unless given.
        rounds: Rounds of the search; 0 for shapes as published.
        samples: Draws of the derivatives, each with gusts and a start of its own.
        with_flown: Whether the windows flown so far count.
        seed: Seed of all draws.
        progress: Called with the part done, 0 to 1. Ctrl-C stops.
        trim: As :meth:`Fit.linearise`, for a fit.

    Raises:
        DoubletError: A surface, kind, criterion or limit that does not exist, or a model that cannot be trimmed.
    """
    limits = [(name, float(low), float(high)) for name, (low, high) in (envelope or {}).items()]
    row, csv = _doublet.design_input(
        identified._inner, dict(trim), list(surfaces), kind, criterion, duration, usage, peak, rate, peak_thrust, gusts, limits, rounds, samples, seed,
        with_flown, progress,
    )
    return Design(json.loads(row), csv, identified.verdict)
