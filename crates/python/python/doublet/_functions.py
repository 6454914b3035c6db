"""Functions of arrays: no session, no aircraft."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Mapping, Optional, Sequence, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _doublet
from ._doublet import DoubletError
from ._constraints import column_constraints
from ._errors import unknown
from ._fit import information_criterion
from ._formulas import formula, halves_of, term_columns
from ._frames import column as _column, columns_of, is_frame, matrix_of, numbers as _numbers, seconds
from ._quality import lag_one, verdict_of
from ._table import Table, Value, normal_quantile
from ._verdict import Verdict


@dataclass(frozen=True)
class Regression:
    """A least-squares fit of n samples by p parameters.

    Attributes:
        names: Names, p.
        params: Estimates, shape (p,).
        stderr: Standard errors by ``errors``, shape (p,).
        stderr_white: As if the residuals were white, shape (p,).
        cov: Covariance by ``errors``, shape (p, p).
        cov_white: ``s² (X'X)⁻¹``, shape (p, p).
        residuals, fitted: Shape (n,).
        r2: Coefficient of determination.
        residual_std: ``s``, the standard deviation of the residual with n - p degrees of freedom.
        condition: Condition number of the scaled regressors.
        correlation: Lag-one correlation of the residuals inside records.
        errors, method: As :func:`lstsq` was called.
    """

    names: tuple[str, ...]
    params: NDArray[np.float64]
    cov: NDArray[np.float64]
    cov_white: NDArray[np.float64]
    residuals: NDArray[np.float64]
    fitted: NDArray[np.float64]
    held: tuple[Optional[str], ...]
    r2: float
    residual_std: float
    condition: float
    correlation: float = 0.0
    errors: str = "coloured"
    method: str = "ols"

    @property
    def verdict(self) -> Verdict:
        """The quality check: collinear columns, poorly determined parameters, few samples, correlated residuals, outliers."""
        return verdict_of(self)

    @property
    def stderr(self) -> NDArray[np.float64]:
        """Standard errors by ``errors``, shape (p,)."""
        return np.sqrt(np.diag(self.cov))

    @property
    def stderr_white(self) -> NDArray[np.float64]:
        """Standard errors as if the residuals were white, shape (p,)."""
        return np.sqrt(np.diag(self.cov_white))

    def __getitem__(self, name: str) -> Value:
        if name not in self.names:
            raise unknown("parameter", name, self.names)
        at = self.names.index(name)
        return Value(float(self.params[at]), float(self.stderr[at]))

    @property
    def nobs(self) -> int:
        """Samples, n."""
        return len(self.residuals)

    @property
    def df_resid(self) -> int:
        """Degrees of freedom of the residuals: samples less estimated parameters."""
        return self.nobs - sum(one in (None, "prior") for one in self.held)

    @property
    def aic(self) -> float:
        """Akaike's criterion of white normal residuals; compare regressions of the same samples only."""
        return information_criterion(float(self.residuals @ self.residuals), self.nobs, len(self.names))

    def conf_int(self, level: float = 0.95) -> NDArray[np.float64]:
        """Ends of the intervals of ``level``, shape (p, 2)."""
        half = normal_quantile(level) * self.stderr
        return np.column_stack([self.params - half, self.params + half])

    def predict(self, X: Any) -> NDArray[np.float64]:
        """Values at other regressors, shape (m,).

        Args:
            X: Array with a column per parameter, or frame with the columns of their names or of the variables in them.

        Raises:
            DoubletError: Another number of columns; of a frame a missing column, with the nearest one.
        """
        matrix = term_columns(columns_of(X), self.names) if is_frame(X) else matrix_of(X)[1]
        if matrix.shape[1] != len(self.names):
            raise DoubletError(f"X has {matrix.shape[1]} columns: give one for each of {', '.join(self.names)}")
        return np.asarray(matrix @ self.params)

    @property
    def table(self) -> Table:
        """A row per parameter."""
        pairs = zip(self.names, self.params, self.stderr, self.stderr_white, self.held)
        return Table(
            [
                dict(parameter=n, estimate=float(v), stderr=float(e), stderr_white=float(w),
                     t=float(v / e) if e else float("nan"), note=h)
                for n, v, e, w, h in pairs
            ],
            f"R2 {self.r2:.6g}, s {self.residual_std:.6g}, {len(self.residuals)} samples",
        )

    def plot(self, *, axes: Any = None) -> Any:
        """Draws what was measured and what was fitted over the samples; returns the axes."""
        from ._plots import one

        axis = one(axes)
        axis.plot(self.fitted + self.residuals, linewidth=1, label="measured")
        axis.plot(self.fitted, linewidth=1, label="fitted")
        axis.set_xlabel("sample")
        axis.set_title(f"R2 {self.r2:.4f}, verdict {self.verdict.level}")
        axis.grid(True, linewidth=0.3)
        axis.legend()
        return axis

    def summary(self) -> str:
        """The parameters and the quality check as text."""
        return f"{self.table.summary()}\n{self.verdict.line()}"

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return self.table._repr_html_() + self.verdict._repr_html_()


def lstsq(
    X: Any,
    y: Any,
    *,
    names: Optional[Sequence[str]] = None,
    groups: Optional[ArrayLike] = None,
    std: Optional[ArrayLike] = None,
    method: Literal["ols", "gls", "stepwise", "orthogonal"] = "ols",
    order: int = 2,
    weights: Literal["equal", "huber"] = "equal",
    errors: Literal["coloured", "white"] = "coloured",
    constraints: Optional[Mapping[str, Any]] = None,
) -> Regression:
    """Least squares with honest errors: arrays or a frame in, no session.

    Args:
        X: Regressors, shape (n, p), rows in order of time and evenly sampled; or a frame, whose columns give the names; or a formula
            ``"Cm ~ 1 + alpha + alpha*delta_e"`` of the columns of the frame ``y``, whose terms are the names.
        y: Measurement, shape (n,); or the frame of a formula.
        names: Names of the columns.
        groups: Number of the record each row belongs to, shape (n,), rows of a record together: residuals are correlated
            inside a record only.
        std: Standard deviation of each row, shape (n,): weighted least squares.
        method: ``"ols"``; ``"gls"``, generalised least squares with an autoregression of the residuals; ``"stepwise"`` or
            ``"orthogonal"``: columns are chosen, constant ones always stay.
        order: Order of the autoregression of ``"gls"``, 1 or more and below the rows of the shortest record.
        weights: ``"equal"``, or ``"huber"``: residuals beyond 1.345 standard deviations weigh less (Huber 1964). Neither ``std`` nor
            ``"gls"`` can be combined with it.
        errors: ``"coloured"`` (corrected for the correlation of the residuals, Morelli and Klein 1997, with a Parzen taper) or
            ``"white"``.
        constraints: By column: a number (fixed), ``(lower, upper)`` or ``{"mean": .., "std": ..}``.

    Raises:
        DoubletError: Sizes that differ, values that are not finite, columns that depend on each other (named), settings that exclude
            each other.
    """
    if errors not in ("coloured", "white"):
        raise DoubletError(f"'{errors}' are not errors: use coloured or white")
    if weights not in ("equal", "huber"):
        raise DoubletError(f"'{weights}' are not weights: use equal or huber")
    if order < 1:
        raise DoubletError(f"order is {order}: give 1 or more")
    columns, matrix, measured = _regressors(X, y, names)
    given = column_constraints(constraints)
    records = None if groups is None else np.unique(np.asarray(groups), return_inverse=True)[1]
    numbers = None if records is None else [int(k) for k in records]
    deviations = None if std is None else _column(std, "std")
    for name, values in (("y", measured), ("std", deviations)):
        if values is not None and len(values) != len(matrix):
            raise DoubletError(f"X has {len(matrix)} rows and {name} {len(values)}: give one value per row")
    row = _doublet.lstsq(matrix, measured, columns, numbers, deviations, method, order, weights == "huber", given)
    chosen = row["coloured"] if errors == "coloured" else row["white"]
    return Regression(
        tuple(row["names"]), row["estimates"], chosen, row["white"], row["residuals"], row["fitted"], tuple(row["held"]),
        row["r2"], row["residual_std"], row["condition"], lag_one(row["residuals"], records), errors, method,
    )


def _regressors(X: Any, y: Any, names: Optional[Sequence[str]]) -> tuple[list[str], NDArray[np.float64], NDArray[np.float64]]:
    """Names and values of the regressors, and the measurement."""
    if isinstance(X, str):
        if names is not None:
            raise DoubletError("names and a formula exclude each other: the terms of the formula are the names")
        if not is_frame(y):
            raise DoubletError(f"y is a {type(y).__name__}: give the frame of the formula as the second argument")
        found = columns_of(y)
        left, right = halves_of(X)
        terms = formula(right, found.names)
        return terms, term_columns(found, terms), term_columns(found, [left])[:, 0]
    index, index_of_y = getattr(X, "index", None), getattr(y, "index", None)
    if index is not None and hasattr(index, "equals") and hasattr(index_of_y, "equals") and not index.equals(index_of_y):
        raise DoubletError("X and y have different indices: align them, or give y.to_numpy()")
    own, matrix = matrix_of(X)
    columns = list(names) if names is not None else own or [f"x{k}" for k in range(matrix.shape[1])]
    return columns, matrix, _column(y, "y")


def coloured_covariance(X: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
    """Covariance of the estimates of ordinary least squares of ``y`` (n,) on ``X`` (n, p) for residuals that are correlated in
    time, shape (p, p).

    Raises:
        DoubletError: As for :func:`lstsq`.
    """
    return _doublet.coloured_covariance(matrix_of(X)[1], _column(y, "y"))


def smooth(
    time: ArrayLike, values: ArrayLike, *, method: str = "polynomial", width: int = 11, degree: int = 2
) -> NDArray[np.float64]:
    """Smoothed values without a shift in time, shape (n,). Arrays of float64 are read where they lie; nothing is copied.

    Args:
        time: s, instants or durations, shape (n,), strictly increasing.
        values: Shape (n,).
        method: ``"polynomial"`` (Savitzky-Golay of ``degree`` over ``width`` samples), ``"moving-average"`` over ``width``, or
            ``"spencer"`` (15 samples).
        width: Samples, odd.
        degree: Of the polynomial.

    Raises:
        DoubletError: Lengths that differ, time that does not increase, fewer samples than the method needs.
    """
    return _doublet.smooth(seconds(time), _column(values, "values"), method, width, degree)


def differentiate(
    time: ArrayLike, values: ArrayLike, *, method: str = "central", width: int = 11, degree: int = 2
) -> NDArray[np.float64]:
    """Slope over time, unit of the values per second, shape (n,).

    Args:
        time: As for :func:`smooth`.
        values: Shape (n,).
        method: ``"central"`` difference of order four, or the slope of a local ``"polynomial"``.
        width: Samples of the polynomial, odd.
        degree: Of the polynomial.

    Raises:
        DoubletError: As for :func:`smooth`.
    """
    return _doublet.differentiate(seconds(time), _column(values, "values"), method, width, degree)


#: Coherence from which on a response counts.
COHERENCE = 0.6


@dataclass(frozen=True, repr=False)
class FrequencyResponse:
    """Output over input against frequency.

    Attributes:
        freq: Angular frequency, rad/s, shape (m,).
        response: Complex, shape (m,); not finite where the inputs are collinear.
        coherence: Partial coherence, shape (m,).
        std: Standard deviation of the gain relative to itself and of the phase in rad, shape (m,).
        phase: Phase without jumps, rad, shape (m,).
    """

    freq: NDArray[np.float64]
    response: NDArray[np.complex128]
    coherence: NDArray[np.float64]
    std: NDArray[np.float64]
    phase: NDArray[np.float64]
    averages: NDArray[np.float64]

    @property
    def gain_db(self) -> NDArray[np.float64]:
        """Gain, dB."""
        return 20.0 * np.log10(np.abs(self.response))

    @property
    def table(self) -> Table:
        """A row per frequency."""
        columns = dict(frequency_rad_s=self.freq, gain_db=self.gain_db, phase_deg=np.degrees(self.phase), coherence=self.coherence, std=self.std)
        return Table([dict(zip(columns, map(float, row))) for row in zip(*columns.values())], repr(self)[1:-1])

    def __repr__(self) -> str:
        if not len(self.freq):
            return "<doublet.FrequencyResponse: no frequencies>"
        good = int(np.sum(self.coherence > COHERENCE))
        span = f"{self.freq[0]:.4g} to {self.freq[-1]:.4g} rad/s"
        return f"<doublet.FrequencyResponse: {len(self.freq)} frequencies, {span}, {good} of coherence above {COHERENCE:g}>"

    def _repr_html_(self) -> str:
        return self.table._repr_html_()

    def to_control(self) -> Any:
        """The response as ``control.frd`` of python-control."""
        import control

        good = np.isfinite(self.response)
        return control.frd(self.response[good], self.freq[good])

    def plot(self, axes: Any = None) -> Any:
        """Bode plot with two standard deviations; returns three axes: gain, phase, coherence."""
        import matplotlib.pyplot as plt

        if axes is None:
            _, axes = plt.subplots(3, 1, sharex=True, figsize=(7, 7))
        error = 2 * 20 / np.log(10.0) * self.std
        for axis, values, width, label in (
            (axes[0], self.gain_db, error, "gain [dB]"),
            (axes[1], np.degrees(self.phase), np.degrees(2 * self.std), "phase [deg]"),
            (axes[2], self.coherence, None, "coherence"),
        ):
            axis.errorbar(self.freq, values, yerr=None if width is None else np.where(np.isfinite(width), width, 0.0))
            axis.set_xscale("log")
            axis.set_ylabel(label)
            axis.grid(True, linewidth=0.3)
        axes[2].set_xlabel("frequency [rad/s]")
        return axes


@overload
def frequency_response(
    u: Union[np.ndarray[tuple[int, int], Any], Sequence[NDArray[Any]]],
    y: ArrayLike,
    *,
    dt: float,
    method: Literal["composite", "single"] = ...,
    band: Optional[tuple[float, float]] = ...,
    points: int = ...,
    window: Optional[float] = ...,
    overlap: float = ...,
) -> list[FrequencyResponse]: ...
@overload
def frequency_response(
    u: Union[NDArray[Any], Sequence[float]],
    y: ArrayLike,
    *,
    dt: float,
    method: Literal["composite", "single"] = ...,
    band: Optional[tuple[float, float]] = ...,
    points: int = ...,
    window: Optional[float] = ...,
    overlap: float = ...,
) -> FrequencyResponse: ...
def frequency_response(
    u: Any,
    y: ArrayLike,
    *,
    dt: float,
    method: Literal["composite", "single"] = "composite",
    band: Optional[tuple[float, float]] = None,
    points: int = 40,
    window: Optional[float] = None,
    overlap: float = 0.5,
) -> Union[FrequencyResponse, list[FrequencyResponse]]:
    """Frequency response of ``y`` (n,) to ``u`` (n,), or to each row of ``u`` (k, n) with the others held.

    Args:
        dt: Time step, s.
        method: ``"composite"`` of four window lengths, or ``"single"``.
        band: Lowest and highest frequency, rad/s; by default what the record resolves.
        points: Frequencies, evenly on a logarithmic scale.
        window: Longest window, s; by default a third of the record.
        overlap: Part of a window that the next overlaps.

    Raises:
        DoubletError: Fewer than 8 samples, lengths that differ, a step, number of points or method that cannot be.
    """
    inputs = np.atleast_2d(_numbers(np.asarray(u), "u"))
    output = _column(y, "y")
    if not (np.isfinite(dt) and dt > 0):
        raise DoubletError(f"dt is {dt}: give a time step above 0 s")
    if not 1 <= points <= 10_000:
        raise DoubletError(f"points is {points}: give 1 to 10000 frequencies")
    if len(output) < 8:
        raise DoubletError(f"y has {len(output)} samples: give at least 8")
    longest = window if window is not None else len(output) * dt / 3.0
    if method == "composite":
        lengths = [longest, longest / 2, longest / 4, longest / 8]
    elif method == "single":
        lengths = [longest]
    else:
        raise DoubletError(f"'{method}' is not a method: use composite or single")
    low, high = band if band is not None else (2 * 2 * np.pi / longest, 0.25 * np.pi / dt)
    omega = np.geomspace(low, high, points).tolist()
    rows = _doublet.frequency_response([(dt, [np.ascontiguousarray(row) for row in inputs], output)], omega, lengths, overlap)
    found = [
        FrequencyResponse(r["omega"], r["response"], r["coherence"], r["relative_std"], r["phase"], r["averages"]) for r in rows
    ]
    return found[0] if np.ndim(u) == 1 else found


def modes(A: ArrayLike, states: Sequence[str]) -> Table:
    """Natural modes of ``x' = A x``, named by the states that take part in them.

    Args:
        A: Shape (n, n).
        states: Names among ``u v w p q r phi theta psi north east h V alpha beta``.

    Raises:
        DoubletError: A matrix that is not square or finite, another number of names, an unknown name.
    """
    rows = _doublet.natural_modes(np.asarray(A, dtype=np.float64), list(states))
    return Table(
        [
            dict(name=r["name"], frequency_rad_s=r["frequency"], damping=r["damping"], real_1_s=r["eigenvalue"].real,
                 imaginary_rad_s=r["eigenvalue"].imag, participation=dict(zip(states, map(float, r["participation"]))))
            for r in rows
        ],
        "modes",
    )
