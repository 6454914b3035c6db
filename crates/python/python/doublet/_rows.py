"""Rows of ``results.json``, as a session's results give them."""

from typing import Any, Optional, TypedDict


class StateRow(TypedDict, total=False):
    """The last filtered estimate of a state, SI, with its standard deviation; with a recorded truth also that."""

    state: str
    unit: str
    estimate: float
    deviation: float
    last_second_mean: float
    truth: float
    mean_squared_normalised_error: float


class InnovationRow(TypedDict, total=False):
    """Consistency of the innovations of a measurement; ``mean`` and ``ratio`` in predicted standard deviations."""

    measurement: str
    samples: int
    outliers: int
    mean: float
    ratio: float
    is_white: bool
    advice: str


class DerivativeRow(TypedDict, total=False):
    """A derivative with its standard errors: of white residuals, and corrected for their correlation; none if it is held."""

    name: str
    verdict: dict[str, Any]
    consequence: dict[str, Any]
    depends_on: list[dict[str, Any]]
    estimate: float
    held: str
    standard_error: Optional[float]
    corrected_standard_error: Optional[float]
    interval_95: list[float]
    relative_error_percent: Optional[float]
    t: Optional[float]


class FitRow(TypedDict, total=False):
    """The fit of a coefficient, to one manoeuvre or to several; ``error`` where it failed."""

    coefficient: str
    windows: list[str]
    verdict: dict[str, Any]
    error: str
    samples: int
    r_squared: float
    rms_relative_percent: float
    residual_deviation: float
    condition_number: float
    derivatives: list[DerivativeRow]
    parameter_correlation: list[list[float]]
    dropped: list[dict[str, Any]]
    follows: dict[str, Any]


class WindowRow(TypedDict, total=False):
    """A manoeuvre with its path, its consistency and its own fits; ``error`` where the path or its coefficients failed."""

    name: str
    flight: str
    start_s: float
    end_s: float
    role: str
    surface: str
    kind: str
    note: str
    excluded: list[dict[str, float]]
    verdict: dict[str, Any]
    error: str
    mass_properties: dict[str, Any]
    samples: int
    air_density: str
    before_input: dict[str, float]
    mean_nis: float
    expected_nis: float
    nis_band: list[float]
    nis_band_correlated: list[float]
    missing_measurements: list[str]
    states: list[StateRow]
    innovations: list[InnovationRow]
    fits: list[FitRow]
    warnings: list[str]
