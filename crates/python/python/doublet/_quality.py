"""The quality check of a regression, by the limits of the engine where it has them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ._verdict import Verdict

if TYPE_CHECKING:
    from ._functions import Regression

#: Condition number of the scaled regressors.
CONDITION = 100.0
#: Standard error as a part of the estimate.
RELATIVE_ERROR = 0.5
#: Samples for each parameter.
SAMPLES = 10
#: Lag-one correlation of residuals from which on standard errors for white residuals are wrong.
WHITE = 0.2
#: Lag-one correlation of residuals from which on corrected standard errors are too small: intervals of 95 % hold less than 90 %.
CORRELATION = 0.97
#: Residual, in robust standard deviations, of an outlier, and part of the samples that may be such.
OUTLIER, OUTLIERS = 6.0, 0.001


def verdict_of(regression: "Regression") -> Verdict:
    """Findings about a regression, each with its fix."""
    found: list[tuple[str, str, str, str, str]] = []

    def add(code: str, where: str, text: str, fix: str) -> None:
        found.append(("caution", code, where, text, fix))

    if regression.condition > CONDITION:
        text = f"Regressors are nearly collinear: condition number {regression.condition:.4g} (limit {CONDITION:g})."
        add("condition", "regressors", text, "Remove a column, or add records that separate the columns.")
    estimated = [(n, v, e) for n, v, e, h in zip(regression.names, regression.params, regression.stderr, regression.held) if h is None]
    weak = [name for name, value, error in estimated if not error <= RELATIVE_ERROR * abs(value)]
    if weak:
        text = f"Poorly determined: {', '.join(weak)}: standard error over {100 * RELATIVE_ERROR:g} % of the estimate."
        add("relative-error", ", ".join(weak), text, "Treat the parameter as unknown: remove the column, or fix it.")
    if regression.nobs < SAMPLES * len(regression.names):
        text = f"{regression.nobs} samples for {len(regression.names)} parameters (limit {SAMPLES} for each)."
        add("samples", "samples", text, "Add samples.")
    lag = f"lag-one correlation {regression.correlation:.3f}"
    if regression.errors == "white" and regression.correlation > WHITE:
        add("white", "residuals", f"Standard errors assume white residuals: {lag} (limit {WHITE:g}).", "Set errors='coloured'.")
    elif regression.method != "gls" and regression.correlation > CORRELATION:
        text = f"Residuals are strongly correlated, standard errors may be too small: {lag} (limit {CORRELATION:g})."
        add("correlation", "residuals", text, "Set method='gls'.")
    sizes = np.abs(regression.residuals - np.median(regression.residuals))
    scale = float(np.median(sizes)) / 0.6745
    outliers = int(np.sum(sizes > OUTLIER * scale)) if scale > 0 else 0
    if outliers > OUTLIERS * regression.nobs:
        text = f"{outliers} residuals are outliers: over {OUTLIER:g} standard deviations."
        add("outliers", "residuals", text, "Check the samples, or set weights='huber'.")
    return Verdict._found(found)


def lag_one(residuals: "np.ndarray[tuple[int], np.dtype[np.float64]]", groups: "np.ndarray[tuple[int], np.dtype[np.int64]] | None") -> float:
    """Lag-one correlation of residuals inside their records."""
    pairs = residuals[1:] * residuals[:-1]
    inside = pairs if groups is None else pairs[groups[1:] == groups[:-1]]
    square = float(residuals @ residuals)
    return float(inside.sum()) / square if square > 0 else 0.0
