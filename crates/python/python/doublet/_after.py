"""Results of a fit: functions of the derivatives with their intervals, output error."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Callable, Literal, Mapping, Optional, Union

import numpy as np
from numpy.typing import NDArray

from ._doublet import DoubletError
from ._fit import Fit
from ._recording import Progress
from ._table import Table, Value, normal_quantile
from ._verdict import Verdict

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._linear import Trim

_UNITS = {"V": "m/s", "alpha": "rad", "beta": "rad", "p": "rad/s", "q": "rad/s", "r": "rad/s", "phi": "rad", "theta": "rad",
          "ax": "m/s²", "ay": "m/s²", "az": "m/s²"}


@dataclass(frozen=True)
class Distribution:
    """A function of the derivatives.

    Attributes:
        value: At the estimates.
        verdict: That of the fit.
        samples: At each draw, shape (n, ...), of a function; ``None`` of an expression.
        std: Standard deviation of the draws.
        interval: Ends of the 95 % interval by quantiles of the draws.
    """

    value: Any
    verdict: Verdict
    samples: Optional[NDArray[np.float64]] = None
    _stderr: Optional[float] = None
    _interval: Optional[tuple[float, float]] = None

    @property
    def std(self) -> Any:
        """Standard deviation of the draws, unit and shape of ``value``."""
        return self._stderr if self.samples is None else np.nanstd(self.samples, axis=0, ddof=1)

    @property
    def interval(self) -> tuple[Any, Any]:
        """Ends of the 95 % interval by quantiles of the draws, unit and shape of ``value``."""
        if self.samples is None:
            return self._interval or (float("nan"), float("nan"))
        low, high = np.nanquantile(self.samples, [0.025, 0.975], axis=0)
        return low, high

    def plot(self, *, axes: Any = None) -> Any:
        """Draws the draws of a number as a histogram, or values with their 95 % intervals over their index; returns the axes."""
        from ._plots import one

        axis, (low, high) = one(axes), self.interval
        if np.ndim(self.value) == 0:
            if self.samples is not None:
                axis.hist(self.samples[np.isfinite(self.samples)], bins=40, alpha=0.5)
            axis.axvline(self.value, linewidth=1, label="estimate")
            axis.axvspan(low, high, alpha=0.15, label="95 % interval")
            axis.set_xlabel("value")
        else:
            value, low, high = (np.ravel(one_of) for one_of in (self.value, low, high))
            axis.plot(value, linewidth=1, label="estimate")
            axis.fill_between(np.arange(len(value)), low, high, alpha=0.25, linewidth=0, label="95 % interval")
            axis.set_xlabel("index")
            axis.set_ylabel("value")
        axis.set_title(f"verdict {self.verdict.level}")
        axis.legend()
        return axis

    def __repr__(self) -> str:
        low, high = self.interval
        if np.ndim(self.value) == 0:
            return f"<{self.value:.5g} ± {self.std:.2g}, 95 %: {low:.5g} to {high:.5g}; verdict {self.verdict.level}>"
        return f"<{np.shape(self.value)} values ± {self.std}, 95 %: {low} to {high}; verdict {self.verdict.level}>"

    def _repr_html_(self) -> str:
        low, high = self.interval
        columns = [np.ravel(one) for one in (self.value, self.std, low, high)]
        rows = [dict(zip(("value", "std", "low_95", "high_95"), map(float, row))) for row in zip(*columns)]
        return Table(rows, self.verdict.line())._repr_html_()


def propagate(
    fit: Fit,
    function: Union[str, Callable[[Mapping[str, float]], Any]],
    *,
    n: int = 2000,
    seed: int = 0,
    **trim: Unpack[Trim],
) -> Distribution:
    """Any function of the derivatives with its interval, by draws of all of them together with their covariance within and
    across coefficients.

    Args:
        fit: Fit of :func:`fit`.
        function: Of a mapping of derivatives to a number or an array; or an expression such as ``"-Cm_alpha/CZ_alpha"``, which
            may name S, b, c, V, rho, qbar, mass, Ixx, Iyy, Izz, Ixz of the trim too and needs a model that can be trimmed.
        n: Draws.
        seed: Their seed: the same seed gives the same numbers.
        trim: As :meth:`Fit.linearise`, for an expression.

    Raises:
        DoubletError: The expression has an unknown name, or no bounded interval.
    """
    if isinstance(function, str):
        value, _, sampled = fit._inner.propagate(function, dict(trim), n, seed)
        if sampled is None:
            raise DoubletError(f"'{function}' has no bounded interval: some draws have no value")
        return Distribution(value, fit.verdict, _stderr=sampled[0], _interval=(sampled[1], sampled[2]))
    names, estimates, _, draws = fit._inner.draws(n, seed)

    def at(row: NDArray[np.float64]) -> Any:
        return function(dict(zip(names, map(float, row))))

    return Distribution(at(estimates), fit.verdict, np.asarray([at(row) for row in draws], dtype=np.float64))


@dataclass(frozen=True)
class OutputError:
    """Output error of one window.

    Attributes:
        window: Window.
        axis: ``"longitudinal"``, ``"lateral"`` or ``"both"``.
        derivatives: Estimates with errors corrected for correlated residuals and for forces and moments that the model lacks; per rad,
            rates without dimension.
        cov: Their covariance by the same errors, in the order of ``derivatives``, shape (p, p).
        outputs: By name: time (s), measured and flown (SI), R².
        verdict: Level of the manoeuvre: ``"good"``, ``"caution"`` or ``"bad"``; ``fit.verdict`` has the findings.
        error: Reason of a failure, or ``None``.
        iterations: Steps of the search.
        filter_error: Estimates by filter error, empty by default.
        filter_error_cov: Their covariance in the order of ``filter_error``, shape (p, p); empty by default.
        filter_trouble: Reason why filter error failed, or ``None``.
    """

    window: str
    axis: str
    verdict: str
    derivatives: dict[str, Value]
    outputs: dict[str, tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]]
    iterations: int = 0
    error: Optional[str] = None
    filter_error: dict[str, Value] = field(default_factory=dict)
    filter_trouble: Optional[str] = None
    cov: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    filter_error_cov: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def nobs(self) -> int:
        """Samples of each output."""
        return max((len(time) for time, *_ in self.outputs.values()), default=0)

    @property
    def table(self) -> Table:
        """A row per derivative."""
        rows = [dict(derivative=name, estimate=value.value, stderr=value.stderr) for name, value in self.derivatives.items()]
        return Table(rows, f"output error of '{self.window}', {self.axis}")

    def summary(self) -> str:
        """The derivatives, R² of each output and the verdict of the window as text."""
        if self.error is not None:
            return f"output error of '{self.window}', {self.axis}: {self.error}"
        quality = ", ".join(f"{name} {output[3]:.4f}" for name, output in self.outputs.items())
        return f"{self.table.summary()}\nR2: {quality}\nverdict {self.verdict}"

    def conf_int(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Ends of the intervals of ``level`` by name."""
        times = normal_quantile(level)
        return {name: (value - times * value.stderr, value + times * value.stderr) for name, value in self.derivatives.items()}

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        title = f"output error of '{self.window}', {self.axis}: {self.error or f'verdict {self.verdict}'}"
        outputs = Table([dict(output=name, r2=output[3]) for name, output in self.outputs.items()])
        return Table(list(self.table), title)._repr_html_() + (outputs._repr_html_() if self.outputs else "")

    def plot(self, axes: Any = None) -> Any:
        """Draws measured and flown outputs; returns the axes."""
        from ._plots import stack

        if self.error is not None:
            raise DoubletError(f"window '{self.window}': {self.error}")
        rows = self.outputs.items()
        return stack([(n, _UNITS.get(n, "SI"), [(t, m, None), (t, f, None)]) for n, (t, m, f, _) in rows], axes)


def output_error(fit: Fit, *, axis: Optional[Literal["longitudinal", "lateral", "both"]] = None, filter_error: bool = False, progress: Progress = None) -> list[OutputError]:
    """Output error of every window with the equations of motion: the moved axis flies the recorded controls until its outputs
    follow the reconstructed ones; the other axis moves as reconstructed.

    Args:
        fit: Fit whose derivatives are the start and whose terms are free.
        axis: ``"longitudinal"``, ``"lateral"`` or ``"both"``; by default that of the surface of each window.
        filter_error: Estimates with process noise as well, for gusts; several times the work.
        progress: Called with the part done, 0 to 1. Ctrl-C stops.

    Raises:
        DoubletError: No window has a result. A window that fails beside others has an ``error``.
    """
    found, levels = [], fit.verdict["windows"]
    for row in fit._inner.output_error(axis, filter_error, progress):
        derivatives, filtered = ({name: Value(*rest) for name, *rest in row.get(key, [])} for key in ("derivatives", "filter_error"))
        covariances = {name: row[key] for name, key in (("cov", "covariance"), ("filter_error_cov", "filter_covariance")) if key in row}
        found.append(
            OutputError(
                row["window"], row["axis"], levels[row["window"]], derivatives, row.get("outputs", {}), row.get("iterations", 0),
                row.get("error"), filtered, row.get("filter_trouble"), **covariances,
            )
        )
    if found and all(one.error is not None for one in found):
        raise DoubletError(f"window '{found[0].window}': {found[0].error}")
    return found
