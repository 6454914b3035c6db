"""Step 2: derivatives fitted to coefficients."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterator, Literal, Mapping, Optional, Sequence, Union, overload

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._coefficients import Coefficients
from ._doublet import DoubletError
from ._constraints import coefficient_constraints
from ._errors import unknown
from ._formulas import terms_of
from ._linear import Linear
from ._predicted import predicted
from ._recording import PathLike, Progress
from ._table import Table, Value, normal_quantile
from ._verdict import Verdict
from ._views import View

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._linear import Trim
    from ._session import Session


@dataclass(frozen=True, repr=False)
class CoefficientFit:
    """Derivatives of one coefficient.

    Attributes:
        coefficient: ``"Cm"`` and so on.
        names: Names of the p parameters.
        estimates: Estimates, shape (p,).
        stderr_white: Standard errors as if the residuals were white, shape (p,).
        stderr: Standard errors corrected for correlated residuals (Morelli and Klein 1997), shape (p,).
        cov: Covariance of the estimates: correlation for white residuals with ``stderr``, shape (p, p); :attr:`Fit.cov` has that for correlated ones.
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
    def df_resid(self) -> int:
        """Degrees of freedom of the residuals: samples less estimated parameters."""
        return self.nobs - sum(one in (None, "prior") for one in self.held)

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
        """Covariance of all parameters in the order of ``params``, shape (p, p). Residuals of several coefficients in the same samples are
        correlated; coloured errors include the covariance that follows, white ones have none between coefficients."""
        if self.errors == "coloured":
            return self._inner.covariance()
        names = list(self.params)
        joint = np.zeros((len(names), len(names)))
        for row in self.coefficients.values():
            at = [names.index(name) for name in row.names]
            if at:
                joint[np.ix_(at, at)] = row.cov
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

    def simulate(self, manoeuvre: str) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Flies a manoeuvre by the pooled estimates from its recorded controls and reconstructed start, as the proof of match does.

        Args:
            manoeuvre: Name, also of one for validation. Constants are its own, or those that leave no mean residual in it.

        Returns:
            By signal, ``airspeed``, ``altitude``, ``alpha``, ``q`` and so on: ``time`` (s), ``measured`` (as reconstructed) and
            ``simulated``, SI.

        Raises:
            DoubletKeyError: No manoeuvre has this name.
            DoubletError: The path was not smoothed, the model lacks a coefficient, or the motion diverges.
        """
        if manoeuvre not in self.windows:
            raise unknown("manoeuvre", manoeuvre, self.windows)
        return self._inner.simulated(manoeuvre)

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
        """The derivative called ``name``, or ``default`` where there is none."""
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
            progress: Called with the part done, 0 to 1. Ctrl-C stops.
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
    predict_with: Literal["pooled", "manoeuvre_means"] = "pooled",
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
        predict_with: What predicts the windows: the ``"pooled"`` estimates, or ``"manoeuvre_means"``, means of the estimates of single
            windows.

    Raises:
        DoubletError: A coefficient, term, window or setting that does not exist, settings that exclude each other, flights with different
            aircraft or settings. A coefficient that cannot be fitted has an ``error`` instead.

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
    if predict_with not in ("pooled", "manoeuvre_means"):
        raise DoubletError(f"'{predict_with}' does not predict: use pooled or manoeuvre_means")
    several = [coefs] if isinstance(coefs, Coefficients) else list(coefs)
    planes = [one.aircraft for one in several if one.aircraft is not None]
    if any(not plane._is(planes[0]) for plane in planes):
        raise DoubletError("the flights are of different aircraft: fit each aircraft alone")
    given = coefficient_constraints(constraints)
    chosen = None if windows is None else list(windows)
    call = (
        several, _models(structure), chosen, given, by_surface, constants == "common", weights == "huber", order if method == "gls" else None,
        predict_with == "manoeuvre_means",
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
    by_means: bool,
) -> _doublet.Fit:
    return _doublet.Fit.fit([one._inner for one in several], models, windows, given, by_surface, common, huber, order, by_means)


def information_criterion(square: float, count: int, parameters: int) -> float:
    """Akaike's criterion of ``count`` white normal residuals with a sum of squares."""
    likelihood = -0.5 * count * (np.log(2 * np.pi * square / count) + 1.0)
    return float(2 * parameters - 2 * likelihood)
