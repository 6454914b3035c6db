"""Step 2: coefficients of forces and moments along flight paths."""

from __future__ import annotations

import inspect
import json
from typing import TYPE_CHECKING, Any, Iterator, Literal, Mapping, NoReturn, Optional, Sequence, Union, overload

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._doublet import DoubletError
from ._errors import unknown
from ._formulas import terms_of
from ._path import Path, stated_only
from ._recording import Aircraft, PathLike
from ._table import Columnar, Table, stacked
from ._verdict import Verdict
from ._views import View, refuse_others

if TYPE_CHECKING:
    from ._session import Session

_UNITS = {"V": "m/s", **{name: "rad" for name in ("alpha", "beta", "delta_a", "delta_e", "delta_r")}}


class WindowCoefficients(Columnar):
    """Coefficients of one window and the variables they depend on, smoothed as the angular acceleration is: arrays of shape (n,)
    over ``time`` (s)."""

    def __init__(self, coefs: "Coefficients", index: int, name: str) -> None:
        self.name = name
        self._coefs, self._index = coefs, index
        inner = coefs._inner
        self.time, self._coefficients, self.variables = inner.columns(index)
        self.warnings = inner.warnings(index)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        found = self._coefficients.get(name, self.variables.get(name))
        if found is None:
            raise unknown("coefficient or variable", name, self)
        return np.asarray(found)

    def __iter__(self) -> Iterator[str]:
        return iter([*self._coefficients, *self.variables])

    def regressors(self, terms: Union[str, Sequence[str]]) -> NDArray[np.float64]:
        """Columns of terms as :func:`fit` has them, smoothed as the angular acceleration is, shape (n, p); also of a formula
        ``"1 + alpha + delta_e"``."""
        return np.asarray(self._coefs._inner.regressors(self._index, terms_of(terms)))

    def to_pandas(self) -> Any:
        """Coefficients and variables as a ``pandas.DataFrame`` over time, for SysIdentPy or scikit-learn."""
        import pandas

        return pandas.DataFrame({name: self[name] for name in self}, index=pandas.Index(self.time, name="time"))

    def _columns(self) -> dict[str, Any]:
        return {"time": self.time, **{name: self[name] for name in self}}

    def __repr__(self) -> str:
        return f"<doublet.WindowCoefficients '{self.name}': {len(self.time)} samples of {', '.join(self)}>"

    def _repr_html_(self) -> str:
        rows = [dict(name=name, mean=float(np.mean(self[name])), low=float(np.min(self[name])), high=float(np.max(self[name]))) for name in self]
        level = self._coefs.verdict["windows"][self.name]
        return Table(rows, f"{self.name}: {len(self.time)} samples, verdict {level}")._repr_html_()


class Coefficients(Columnar, View[_doublet.Coefficients], Sequence[WindowCoefficients]):
    """``CX CY CZ Cl Cm Cn CD CL`` of every window; ``coefs["window"]["Cm"]`` is an array."""

    def __init__(self, inner: _doublet.Coefficients, call: Any, path: Path) -> None:
        super().__init__(inner, call)
        self.windows = inner.windows()
        self.path, self.aircraft = path, path.aircraft
        self._verdict: Optional[Verdict] = None

    @property
    def verdict(self) -> Verdict:
        """How far paths and coefficients may be trusted: the verdict of a session of the same windows."""
        if self._verdict is None:
            self._verdict = Verdict._of(self._inner.verdict())
        return self._verdict

    def to_session(self, *, name: str = "arrays", folder: Optional[PathLike] = None) -> Session:
        """The session of the same recording, manoeuvres and settings, ``name`` and ``folder`` as for :meth:`Fit.to_session`; its model is
        that of a new session."""
        from ._bridge import session_of

        return session_of([self.path], self._inner.session(), False, name, folder)

    def __len__(self) -> int:
        return len(self.windows)

    @overload
    def __getitem__(self, key: Union[str, int]) -> WindowCoefficients: ...
    @overload
    def __getitem__(self, key: slice) -> list[WindowCoefficients]: ...
    def __getitem__(self, key: Union[str, int, slice]) -> Union[WindowCoefficients, list[WindowCoefficients]]:
        if isinstance(key, slice):
            return [self[index] for index in range(len(self))[key]]
        if isinstance(key, str):
            if key not in self.windows:
                raise unknown("manoeuvre", key, self.windows)
            key = self.windows.index(key)
        index = range(len(self))[key]
        return WindowCoefficients(self, index, self.windows[index])

    def to_pandas(self) -> Any:
        """All windows below each other, with a column ``window``."""
        import pandas

        return pandas.concat([one.to_pandas().assign(window=one.name) for one in self])

    def _columns(self) -> dict[str, Any]:
        return stacked([one._columns() for one in self], self.windows)

    def plot(self, name: str, *, windows: Optional[Sequence[str]] = None, axes: Any = None, ax: Any = None) -> Any:
        """Draws a coefficient or variable over the time since the start of each window; returns the axes.

        Args:
            name: Coefficient or variable.
            windows: Names of windows; all by default.
            axes: Axes to draw on.
            ax: Earlier name of ``axes``.
        """
        from ._plots import by_either_name, one as axis_of

        chosen = [self[window] for window in (self.windows if windows is None else windows)]
        curves = [(one.name, one.time - one.time[0], one[name]) for one in chosen]
        axis = axis_of(by_either_name(axes, ax))
        for label, time, values in curves:
            axis.plot(time, values, linewidth=1, label=label)
        axis.set_xlabel("time since start [s]")
        axis.set_ylabel(f"{name} [{_UNITS.get(name, '-')}]")
        axis.set_title(f"verdict {self.verdict.level}")
        axis.grid(True, linewidth=0.3)
        if len(curves) <= 8:
            axis.legend()
        return axis

    def __repr__(self) -> str:
        return f"<doublet.Coefficients of {', '.join(self.windows)}: {self.verdict.line()}>"

    def _repr_html_(self) -> str:
        return self.verdict._repr_html_()


def coefficients(
    path: Path,
    aircraft: Optional[Aircraft] = None,
    *,
    axes: Literal["body", "stability"] = "body",
    thrust: Literal["included", "removed", "force_removed"] = "included",
    moment_reference: Union[Literal["aircraft", "centre_of_gravity"], Sequence[float]] = "aircraft",
    angular_acceleration: Literal["differentiated", "smoother", "recorded"] = "differentiated",
    matched_smoothing: Optional[bool] = None,
    gyroscopic: Optional[Literal["signed", "summed", "ignored"]] = None,
    settle_s: Optional[float] = None,
    actuator_lag_s: Optional[float] = None,
    control_lag: Optional[Mapping[str, Mapping[str, float]]] = None,
    **others: NoReturn,
) -> Coefficients:
    """Force and moment coefficients along a path, ``C = F / (q S)``, ``M / (q S l)``, about the aircraft's moment reference.

    Args:
        path: Path of :func:`reconstruct`, which must have been given an aircraft.
        aircraft: That of the path; another one is refused.
        axes: ``"body"`` or ``"stability"`` (moments and roll and yaw rate turned by the angle of attack).
        thrust: ``"included"``, or ``"removed"`` where it is recorded or follows from the engines; ``"force_removed"`` leaves its moment in.
        moment_reference: Point the moments are about: of the ``"aircraft"``, the ``"centre_of_gravity"``, or ``(x, y, z)`` in datum axes
            (aft, right, up), m.
        angular_acceleration: ``"differentiated"`` rates, by a ``"smoother"``, or as ``"recorded"``.
        matched_smoothing: All other signals get the same smoothing as the differentiated rates.
        gyroscopic: Moment of the propellers: ``"signed"``, ``"summed"`` or ``"ignored"``.
        settle_s: Time left out at the start of every window, s.
        actuator_lag_s: First-order lag of all controls, s.
        control_lag: Lag and delay of one control: ``{"elevator": {"lag_s": 0.05, "delay_s": 0.02}}``.

    The differentiation, the origin's altitude and the places of the sensors are arguments of :func:`reconstruct`.

    Raises:
        DoubletError: A path without an aircraft, a setting that does not exist or cannot be.

    Warns:
        DoubletWarning: The verdict on the coefficients is bad.
    """
    if aircraft is not None and path.aircraft is not None and not aircraft._is(path.aircraft):
        raise DoubletError(f"the path is of {path.aircraft!r}: reconstruct it with {aircraft!r}, or leave the aircraft out")
    arguments = list(inspect.signature(coefficients).parameters)[:-1]
    earlier = next((name for name in others if name in path._preparation or name in _OF_THE_PATH), None)
    if earlier is not None:
        raise DoubletError(f"{earlier} is an argument of reconstruct: give it there")
    refuse_others("coefficients", others, arguments)
    if thrust not in _THRUST:
        raise unknown("treatment of thrust", thrust, _THRUST)
    for surface in control_lag or {}:
        if surface not in ("aileron", "elevator", "rudder"):
            raise unknown("control", surface, ["aileron", "elevator", "rudder"])
    point = moment_reference if isinstance(moment_reference, str) else [float(value) for value in moment_reference]
    preparation = stated_only(dict(
        path._preparation, axes=axes, remove_thrust=_THRUST[thrust], moment_reference=None if point == "aircraft" else point,
        angular_acceleration=angular_acceleration, matched_smoothing=matched_smoothing, gyroscopic=gyroscopic, settle_s=settle_s,
        actuator_lag_s=actuator_lag_s, control_lag=None if control_lag is None else {k: dict(v) for k, v in control_lag.items()},
    ))
    call = (path, preparation)
    formed = Coefficients(_formed(*call), (_formed, call), path)
    if path.verdict.level != "bad":
        formed.verdict.warn("coefficients")
    return formed


#: Values of ``preparation.remove_thrust``.
_THRUST: dict[str, Any] = {"included": False, "removed": True, "force_removed": "force"}
#: Settings of the preparation that the path is made with.
_OF_THE_PATH = (
    "differentiation", "differentiation_half_width_s", "origin_altitude_m", "correct_accelerometer", "correct_vanes", "correct_antenna",
)


def _formed(path: Path, preparation: Mapping[str, Any]) -> _doublet.Coefficients:
    return _doublet.Coefficients.form(path._inner, json.dumps(preparation))
