"""Step 2: coefficients and derivatives."""

from __future__ import annotations

import inspect
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterator, Literal, Mapping, NoReturn, Optional, Sequence, Union, overload

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._doublet import DoubletError
from ._constraints import coefficient_constraints
from ._errors import unknown
from ._formulas import terms_of
from ._linear import Linear
from ._path import Path, stated_only
from ._predicted import predicted
from ._recording import Aircraft, PathLike, Progress
from ._table import Columnar, Table, Value, normal_quantile, stacked
from ._verdict import Verdict
from ._views import View, refuse_others

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._linear import Trim
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
        """The session of the same recording, manoeuvres and settings, as :meth:`Fit.to_session`; its model is that of a new
        session."""
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


@dataclass(frozen=True, repr=False)
class CoefficientFit:
    """Derivatives of one coefficient.

    Attributes:
        coefficient: ``"Cm"`` and so on.
        names: Names of the p parameters.
        estimates: Estimates, shape (p,).
        stderr_white: Standard errors as if the residuals were white, shape (p,).
        stderr: Standard errors corrected for correlated residuals (Morelli and Klein 1997), shape (p,).
        cov: Covariance of the estimates: correlation of the fit with the corrected errors, shape (p, p).
        residuals, fitted: Shape (n,), windows below each other.
        r2: Coefficient of determination.
        condition: Condition number of the scaled regressors.
        held: ``"fixed"``, ``"at bound"``, ``"prior"`` or ``None`` for each parameter.
        windows: Windows whose samples it used.
        dropped: Terms left out, with the reason.
        error: Reason of a failure, or ``None``.
    """

    coefficient: str
    windows: list[str]
    dropped: list[tuple[str, str]]
    error: Optional[str] = None
    names: tuple[str, ...] = ()
    estimates: Any = None
    stderr_white: Any = None
    stderr: Any = None
    cov: Any = None
    residuals: Any = None
    fitted: Any = None
    r2: float = float("nan")
    condition: float = float("nan")
    held: tuple[Optional[str], ...] = ()

    @classmethod
    def _of(cls, row: Mapping[str, Any], errors: str) -> "CoefficientFit":
        head = dict(coefficient=row["coefficient"], windows=list(row["windows"]), dropped=list(row["dropped"]))
        if "error" in row:
            return cls(**head, error=row["error"])
        stderr = row["coloured"] if errors == "coloured" else row["white"]
        return cls(
            **head, names=tuple(row["names"]), estimates=row["estimates"], stderr_white=row["white"], stderr=stderr,
            cov=row["correlation"] * np.outer(stderr, stderr), residuals=row["residuals"], fitted=row["fitted"],
            r2=row["r2"], condition=row["condition"], held=tuple(row["held"]),
        )

    @property
    def nobs(self) -> int:
        """Samples it used."""
        return 0 if self.residuals is None else len(self.residuals)

    @property
    def aic(self) -> float:
        """Akaike's criterion of white normal residuals; compare structures over the same windows only."""
        return information_criterion(float(self.residuals @ self.residuals), self.nobs, len(self.names)) if self.names else float("nan")

    def __getitem__(self, name: str) -> Value:
        if name not in self.names:
            raise unknown(f"parameter of {self.coefficient}", name, self.names)
        at = self.names.index(name)
        return Value(float(self.estimates[at]), float(self.stderr[at]))

    @property
    def table(self) -> Table:
        """A row per parameter."""
        rows = [] if self.error is not None else [
            dict(derivative=name, estimate=float(value), stderr=float(error), stderr_white=float(white), note=held)
            for name, value, error, white, held in zip(self.names, self.estimates, self.stderr, self.stderr_white, self.held)
        ]
        return Table(rows, f"{self.coefficient}: {self.error or f'R2 {self.r2:.4f}, {self.nobs} samples'}")

    def __repr__(self) -> str:
        if self.error is not None:
            return f"<doublet.CoefficientFit {self.coefficient}: {self.error}>"
        shown = ", ".join(f"{name} {self[name]}" for name in self.names if not name.endswith("]"))
        return f"<doublet.CoefficientFit {self.coefficient}: R2 {self.r2:.4f}, {self.nobs} samples; {shown}>"

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


class Fit(View[_doublet.Fit]):
    """Derivatives over windows: ``fit["Cm_alpha"]`` is a value with its error, ``fit.coefficients["Cm"]`` everything about one
    coefficient."""

    def __init__(self, inner: _doublet.Fit, call: Any, errors: str) -> None:
        super().__init__(inner, call)
        rows = [CoefficientFit._of(row, errors) for row in inner.rows()]
        self.coefficients: dict[str, CoefficientFit] = {row.coefficient: row for row in rows}
        self.errors = errors
        self.windows: list[str] = inner.windows()
        self._verdict: Optional[Verdict] = None

    @property
    def verdict(self) -> Verdict:
        """How far the derivatives may be trusted: the verdict of a session of the same windows and structure. Its keys
        ``windows``, ``coefficients`` and ``derivatives`` have the level of each."""
        if self._verdict is None:
            self._verdict = Verdict._of(self._inner.verdict())
        return self._verdict

    def to_session(self, *, name: str = "arrays", folder: Optional[PathLike] = None) -> Session:
        """The session of the same recordings, manoeuvres, filter, preparation, structure and estimation: for studies, reports, proof of
        match and exports. Its run gives the same derivatives: gusts and delays are as :func:`reconstruct` had them, and every sample counts.
        Its standard errors are the same: both contain the errors of the flight path. Of several flights a session estimates
        gusts and delays together, arrays those of each flight; where these differ the standard errors lack the errors of the path.

        Args:
            name: Title.
            folder: As for :meth:`Session.from_recordings`.
        """
        from ._bridge import session_of

        several: Sequence[Coefficients] = self._call[1][0] if self._call else []
        return session_of([one.path for one in several], self._inner.session(), True, name, folder)

    @property
    def params(self) -> dict[str, float]:
        """Estimates by name."""
        return {n: float(v) for row in self.coefficients.values() for n, v in zip(row.names, row.estimates if row.names else ())}

    @property
    def stderr(self) -> dict[str, float]:
        """Standard errors by name."""
        return {n: float(v) for row in self.coefficients.values() for n, v in zip(row.names, row.stderr if row.names else ())}

    @property
    def cov(self) -> NDArray[np.float64]:
        """Covariance of all parameters in the order of ``params``, shape (p, p). Coloured errors include the covariance between
        coefficients where the engine states it."""
        names = list(self.params)
        joint = np.zeros((len(names), len(names)))
        for row in self.coefficients.values():
            at = [names.index(name) for name in row.names]
            if at:
                joint[np.ix_(at, at)] = row.cov
        if self.errors == "coloured":
            known, _, covariance, _ = self._inner.draws(1, 0)
            pairs = [(names.index(name), index) for index, name in enumerate(known) if name in names]
            at, of = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
            joint[np.ix_(at, at)] = covariance[np.ix_(of, of)]
        return joint

    @property
    def nobs(self) -> dict[str, int]:
        """Samples by coefficient."""
        return {name: one.nobs for name, one in self.coefficients.items()}

    @property
    def aic(self) -> dict[str, float]:
        """Akaike's criterion by coefficient."""
        return {name: one.aic for name, one in self.coefficients.items()}

    def conf_int(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Ends of the intervals of ``level`` by name."""
        times, errors = normal_quantile(level), self.stderr
        return {name: (value - times * errors[name], value + times * errors[name]) for name, value in self.params.items()}

    @overload
    def predict(
        self, coefficient: str, X: None = None, *, constants: Literal["identified", "own"] = ...
    ) -> dict[str, dict[str, NDArray[np.float64]]]: ...
    @overload
    def predict(self, coefficient: str, X: object, *, manoeuvre: Optional[str] = ...) -> NDArray[np.float64]: ...
    def predict(
        self,
        coefficient: str,
        X: Any = None,
        *,
        constants: Literal["identified", "own"] = "identified",
        manoeuvre: Optional[str] = None,
    ) -> Union[dict[str, dict[str, NDArray[np.float64]]], NDArray[np.float64]]:
        """Values of a coefficient at new regressors, shape (m,); without them its predictions by window, those of validation
        included: ``time`` (s), ``observed`` and ``predicted``.

        Args:
            coefficient: Coefficient.
            X: As for :meth:`Results.predict`.
            constants: Of the predictions by window, ``"identified"``: constants of the identification; ``"own"``: the constant of each
                window.
            manoeuvre: As for :meth:`Results.predict`.
        """
        if constants not in ("identified", "own"):
            raise DoubletError(f"'{constants}' are not constants: use identified or own")
        if coefficient not in self.coefficients:
            raise unknown("coefficient of the fit", coefficient, self.coefficients)
        if X is not None:
            error = self.coefficients[coefficient].error
            if error is not None:
                raise DoubletError(f"{coefficient}: {error}")
            return predicted(coefficient, self._terms()[coefficient], self.params, X, manoeuvre)
        rows = self._inner.predicted(coefficient)
        return {
            window: {"time": time, "observed": observed, "predicted": identified if constants == "identified" else own}
            for window, (time, observed, identified, own) in rows
        }

    def _terms(self) -> dict[str, list[str]]:
        """Terms of the structure by coefficient."""
        model: dict[str, list[str]] = json.loads(self._inner.session())["model"]
        return model

    def __getitem__(self, name: str) -> Value:
        for row in self.coefficients.values():
            if name in row.names:
                return row[name]
        raise unknown("derivative", name, self.params)

    def get(self, name: str, default: Any = None) -> Any:
        """The derivative, or ``default`` where there is none."""
        return self[name] if name in self.params else default

    def __contains__(self, name: object) -> bool:
        return name in self.params

    def __iter__(self) -> Iterator[str]:
        return iter(self.params)

    @property
    def table(self) -> Table:
        """A row per derivative: estimate, both standard errors, relative error, t, verdict."""
        rows: list[dict[str, Any]] = []
        levels = self.verdict["derivatives"]
        for one in self.coefficients.values():
            if one.error is not None:
                rows.append(dict(derivative=one.coefficient, note=one.error))
            for k, name in enumerate(one.names):
                value, error = float(one.estimates[k]), float(one.stderr[k])
                rows.append(
                    dict(derivative=name, estimate=value, stderr=error, stderr_white=float(one.stderr_white[k]),
                         relative_percent=100 * abs(error / value) if value else float("nan"),
                         t=value / error if error else float("nan"), verdict=levels.get(name), note=one.held[k])
                )
        return Table(rows, "derivatives")

    @property
    def predictions(self) -> Table:
        """How well the estimate predicts each window: R² with the constants of the identification and with its own constant."""
        keys = ("window", "role", "coefficient", "r2_identified_constants", "r2_own_constant")
        return Table([dict(zip(keys, row)) for row in self._inner.predictions()], "predictions")

    def summary(self) -> str:
        """The derivatives as text, with R² of each coefficient and the verdict."""
        quality = ", ".join(f"{c} {one.r2:.4f}" for c, one in self.coefficients.items() if one.error is None)
        return f"{self.table.summary()}\nR2: {quality}\n{self.verdict.line()}"

    def linearise(self, *, samples: int = 500, seed: int = 1, progress: Progress = None, **trim: Unpack[Trim]) -> "Linear":
        """Linear models, modes and flying-qualities levels about a trim. Values not given are medians over the windows.

        Args:
            samples: Draws of the derivatives for sampled intervals.
            seed: Their seed.
            trim: ``airspeed`` (m/s), ``altitude`` (m), ``gamma`` (rad), ``load_factor``, ``pull_up``, ``mass`` (kg),
                ``fuel`` (kg on board in all), ``stick_delay`` (s), ``aileron`` (rad available from trim), ``window`` (name).
        """
        return Linear(json.loads(self._inner.dynamics(dict(trim), samples, seed, progress)), self.verdict)

    def modes(self, **trim: Unpack[Trim]) -> Table:
        """Natural modes about a trim, as :meth:`linearise`."""
        return self.linearise(**trim).modes

    def plot(self, coefficient: str, *, axes: Any = None) -> Any:
        """Draws what was observed of a coefficient, what was fitted, over the time of its windows end to end; returns the axes."""
        from ._plots import one as axis_of

        if coefficient not in self.coefficients:
            raise unknown("coefficient of the fit", coefficient, self.coefficients)
        row = self.coefficients[coefficient]
        if row.error is not None:
            raise DoubletError(f"{coefficient}: {row.error}")
        axis = axis_of(axes)
        time, breaks = self._end_to_end(row)
        axis.plot(time, row.fitted + row.residuals, linewidth=1, label="observed")
        axis.plot(time, row.fitted, linewidth=1, label="fitted")
        for instant in breaks:
            axis.axvline(instant, linewidth=0.3, color="grey")
        axis.set_xlabel("time in the windows, end to end [s]")
        axis.set_ylabel(f"{coefficient} [-]")
        axis.legend()
        return axis

    def _end_to_end(self, row: CoefficientFit) -> tuple[NDArray[np.float64], list[float]]:
        """Time of the samples of a coefficient, its windows end to end, and where each begins."""
        parts, breaks, end = [], [], 0.0
        for window in row.windows:
            time = self._inner.time(window)
            parts.append(time - time[0] + end)
            breaks.append(end)
            end = float(parts[-1][-1])
        return np.concatenate(parts), breaks[1:]

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return self.table._repr_html_() + self.verdict._repr_html_()


def fit(
    coefs: Union[Coefficients, Sequence[Coefficients]],
    structure: Union[str, Sequence[str], Mapping[str, Union[str, Sequence[str]]]],
    *,
    windows: Optional[Sequence[str]] = None,
    method: Literal["ols", "gls"] = "ols",
    order: int = 2,
    weights: Literal["equal", "huber"] = "equal",
    errors: Literal["coloured", "white"] = "coloured",
    constraints: Optional[Mapping[tuple[str, str], Any]] = None,
    constants: Literal["per_manoeuvre", "common"] = "per_manoeuvre",
    by_surface: bool = True,
) -> Fit:
    """Derivatives by least squares over windows.

    Args:
        coefs: Coefficients of :func:`coefficients`, or a list of those of several flights, which are pooled; a window of flight 2
            whose name is taken is called ``"NAME (flight 2)"``.
        structure: Terms of each coefficient, products of powers of variables: ``{"Cm": ["1", "alpha", "qc/V", "delta_e"]}``, or
            formulas: ``{"Cm": "1 + alpha + qc/V + delta_e"}``, ``"Cm ~ 1 + alpha"``.
        windows: Names of the windows to identify with, the others being predicted; by default those with the role identification.
        method: ``"ols"``, or ``"gls"``: generalised least squares with an autoregression of the residuals of each coefficient, which shortens
            the intervals where residuals are strongly correlated. Constraints make either constrained or mixed estimation.
        order: Order of the autoregression of ``"gls"``, 1 to 50 and below the samples of the shortest window.
        weights: ``"equal"``, or ``"huber"``: residuals beyond 1.345 standard deviations weigh less (Huber 1964).
        errors: ``"coloured"`` or ``"white"``: what ``stderr`` and ``cov`` are.
        constraints: By coefficient and term: a number (fixed), ``(lower, upper)`` with ``None`` for an open end, or
            ``{"mean": .., "std": ..}``.
        constants: ``"per_manoeuvre"``, or ``"common"``.
        by_surface: Symmetric coefficients from windows of the elevator, asymmetric ones from those of aileron and rudder.

    Warns:
        DoubletWarning: The verdict on the fit is bad.
    """
    if method not in ("ols", "gls"):
        raise DoubletError(f"'{method}' is not a method of fit: use ols or gls; lstsq has stepwise and orthogonal too")
    if not 1 <= order <= 50:
        raise DoubletError(f"order is {order}: give 1 to 50")
    if weights not in ("equal", "huber"):
        raise DoubletError(f"'{weights}' are not weights: use equal or huber")
    if errors not in ("coloured", "white"):
        raise DoubletError(f"'{errors}' are not errors: use coloured or white")
    if constants not in ("per_manoeuvre", "common"):
        raise DoubletError(f"'{constants}' are not constants: use per_manoeuvre or common")
    several = [coefs] if isinstance(coefs, Coefficients) else list(coefs)
    planes = [one.aircraft for one in several if one.aircraft is not None]
    if any(not plane._is(planes[0]) for plane in planes):
        raise DoubletError("the flights are of different aircraft: fit each aircraft alone")
    given = coefficient_constraints(constraints)
    chosen = None if windows is None else list(windows)
    call = (
        several, _models(structure), chosen, given, by_surface, constants == "common", weights == "huber", order if method == "gls" else None
    )
    found = Fit(_fitted(*call), (_fitted, call), errors)
    found.verdict.warn("fit")
    return found


def _models(structure: Any) -> list[tuple[str, list[str]]]:
    """Coefficients with their terms."""
    if isinstance(structure, Mapping):
        return [(str(name), terms_of(terms)) for name, terms in structure.items()]
    formulas = [structure] if isinstance(structure, str) else list(structure)
    halves = [str(text).partition("~") for text in formulas]
    if any(not tilde for _, tilde, _ in halves):
        raise DoubletError("a formula names its coefficient: write 'Cm ~ 1 + alpha', or give a mapping")
    return [(name.strip(), terms_of(terms)) for name, _, terms in halves]


def _fitted(
    several: Sequence[Coefficients],
    models: Any,
    windows: Optional[list[str]],
    given: Any,
    by_surface: bool,
    common: bool,
    huber: bool,
    order: Optional[int],
) -> _doublet.Fit:
    return _doublet.Fit.fit([one._inner for one in several], models, windows, given, by_surface, common, huber, order)


def information_criterion(square: float, count: int, parameters: int) -> float:
    """Akaike's criterion of ``count`` white normal residuals with a sum of squares."""
    likelihood = -0.5 * count * (np.log(2 * np.pi * square / count) + 1.0)
    return float(2 * parameters - 2 * likelihood)
