"""Step 2: coefficients, derivatives, and what follows from them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._doublet import DoubletError
from ._path import Path
from ._recording import Aircraft, Progress
from ._table import Table, Value

Constraint = tuple[str, str, str, float, float]


class WindowCoefficients:
    """Coefficients of one window and the variables they depend on, smoothed as the angular acceleration is: arrays of shape (n,)
    over ``time`` (s)."""

    def __init__(self, inner: _doublet.Coefficients, index: int, name: str) -> None:
        self.name = name
        self._inner, self._index = inner, index
        self.time, self._coefficients, self.variables = inner.columns(index)
        self.warnings = inner.warnings(index)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        found = self._coefficients.get(name, self.variables.get(name))
        if found is None:
            raise DoubletError(f"'{name}' is neither a coefficient nor a variable: use {', '.join(self)}")
        return found

    def __iter__(self) -> Iterator[str]:
        return iter([*self._coefficients, *self.variables])

    def regressors(self, terms: Sequence[str]) -> NDArray[np.float64]:
        """Columns of terms as :func:`fit` has them, smoothed as the angular acceleration is, shape (n, p)."""
        return self._inner.regressors(self._index, list(terms))

    def to_pandas(self) -> Any:
        """Coefficients and variables as a ``pandas.DataFrame`` over time: what SysIdentPy or scikit-learn take."""
        import pandas

        return pandas.DataFrame({name: self[name] for name in self}, index=pandas.Index(self.time, name="time"))


class Coefficients(Sequence[WindowCoefficients]):
    """``CX CY CZ Cl Cm Cn CD CL`` of every window; ``coefs["window"]["Cm"]`` is an array."""

    def __init__(self, inner: _doublet.Coefficients) -> None:
        self._inner = inner
        self.windows = inner.windows()

    def __len__(self) -> int:
        return len(self.windows)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            if key not in self.windows:
                raise DoubletError(f"no window is called '{key}': there are {', '.join(self.windows)}")
            key = self.windows.index(key)
        index = range(len(self))[key]
        return WindowCoefficients(self._inner, index, self.windows[index])

    def to_pandas(self) -> Any:
        """All windows below each other, with a column ``window``."""
        import pandas

        return pandas.concat([one.to_pandas().assign(window=one.name) for one in self])

    def __repr__(self) -> str:
        return f"<doublet.Coefficients of {', '.join(self.windows)}>"


def coefficients(
    path: Path, aircraft: Optional[Aircraft] = None, *, axes: str = "body", thrust: str = "included"
) -> Coefficients:
    """Force and moment coefficients along a path, ``C = F / (q S)``, ``M / (q S l)``, about the aircraft's moment reference.

    Args:
        path: Path of :func:`reconstruct`, which must have been given an aircraft.
        aircraft: The same one; only there to be named.
        axes: ``"body"`` or ``"stability"`` (moments and roll and yaw rate turned by the angle of attack).
        thrust: ``"included"``, or ``"removed"`` where it is recorded or follows from the engines.
    """
    del aircraft
    if thrust not in ("included", "removed"):
        raise DoubletError(f"'{thrust}' is no treatment of thrust: use included or removed")
    return Coefficients(_doublet.Coefficients.form(path._inner, axes, thrust == "removed"))


@dataclass(frozen=True)
class CoefficientFit:
    """Derivatives of one coefficient.

    Attributes:
        coefficient: ``"Cm"`` and so on.
        names: Names of the p parameters.
        estimates: Estimates, shape (p,).
        stderr_white: Standard errors as if the residuals were white, shape (p,).
        stderr: Standard errors corrected for coloured residuals (Morelli and Klein 1997), shape (p,).
        cov: Covariance of the estimates: correlation of the fit with the corrected errors, shape (p, p).
        residuals, fitted: Shape (n,), windows below each other.
        r2: Coefficient of determination.
        condition: Condition number of the scaled regressors.
        held: ``"fixed"``, ``"at bound"``, ``"prior"`` or ``None`` for each parameter.
        windows: Windows whose samples it used.
        dropped: Terms left out, with the reason.
        error: Why there is no estimate, or ``None``.
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

    def __getitem__(self, name: str) -> Value:
        if name not in self.names:
            raise DoubletError(f"{self.coefficient} has no parameter '{name}': there are {', '.join(self.names)}")
        at = self.names.index(name)
        return Value(float(self.estimates[at]), float(self.stderr[at]))


class Fit:
    """Derivatives over windows: ``fit["Cm_alpha"]`` is a value with its error, ``fit.coefficients["Cm"]`` everything about one
    coefficient."""

    def __init__(self, inner: _doublet.Fit, errors: str) -> None:
        self._inner = inner
        rows = [CoefficientFit._of(row, errors) for row in inner.rows()]
        self.coefficients: dict[str, CoefficientFit] = {row.coefficient: row for row in rows}

    @property
    def params(self) -> dict[str, float]:
        """Estimates by name."""
        return {n: float(v) for row in self.coefficients.values() for n, v in zip(row.names, row.estimates if row.names else ())}

    @property
    def stderr(self) -> dict[str, float]:
        """Standard errors by name."""
        return {n: float(v) for row in self.coefficients.values() for n, v in zip(row.names, row.stderr if row.names else ())}

    def __getitem__(self, name: str) -> Value:
        for row in self.coefficients.values():
            if name in row.names:
                return row[name]
        raise DoubletError(f"no derivative is called '{name}': there are {', '.join(self.params)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self.params)

    @property
    def table(self) -> Table:
        """A row per derivative: estimate, both standard errors, relative error, t."""
        rows: list[dict[str, Any]] = []
        for one in self.coefficients.values():
            if one.error is not None:
                rows.append(dict(derivative=one.coefficient, note=one.error))
            for k, name in enumerate(one.names):
                value, error = float(one.estimates[k]), float(one.stderr[k])
                rows.append(
                    dict(derivative=name, estimate=value, stderr=error, stderr_white=float(one.stderr_white[k]),
                         relative_percent=100 * abs(error / value) if value else float("nan"),
                         t=value / error if error else float("nan"), note=one.held[k])
                )
        return Table(rows, "derivatives")

    @property
    def predictions(self) -> Table:
        """How well the estimate predicts each window: R² with the constants of the identification and with its own constant."""
        keys = ("window", "role", "coefficient", "r2_identified_constants", "r2_own_constant")
        return Table([dict(zip(keys, row)) for row in self._inner.predictions()], "predictions")

    def summary(self) -> str:
        """The derivatives as text, with R² of each coefficient."""
        quality = ", ".join(f"{c} {one.r2:.4f}" for c, one in self.coefficients.items() if one.error is None)
        return f"{self.table.summary()}\nR2: {quality}"

    def linearise(self, *, samples: int = 500, seed: int = 1, progress: Progress = None, **trim: Any) -> "Linear":
        """Linear models, modes and flying-qualities levels about a trim. What is left open is the median over the windows.

        Args:
            samples: Draws of the derivatives for sampled intervals.
            seed: Their seed.
            trim: ``airspeed`` (m/s), ``altitude`` (m), ``gamma`` (rad), ``load_factor``, ``pull_up``, ``mass`` (kg),
                ``fuel`` (kg on board in all), ``window`` (name).
        """
        return Linear(json.loads(self._inner.dynamics(trim, samples, seed, progress)))

    def modes(self, **trim: Any) -> Table:
        """Natural modes about a trim, as :meth:`linearise`."""
        return self.linearise(**trim).modes

    def plot(self, coefficient: str, *, axes: Any = None) -> Any:
        """Draws what was observed of a coefficient, what was fitted and the residual; returns the axes."""
        from ._plots import one as axis_of

        row = self.coefficients[coefficient]
        axis = axis_of(axes)
        axis.plot(row.fitted + row.residuals, linewidth=1, label="observed")
        axis.plot(row.fitted, linewidth=1, label="fitted")
        axis.set_xlabel("sample")
        axis.set_ylabel(coefficient)
        axis.legend()
        return axis

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def fit(
    coefs: Coefficients,
    structure: Mapping[str, Sequence[str]],
    *,
    windows: Optional[Sequence[str]] = None,
    method: str = "ols",
    errors: str = "coloured",
    constraints: Mapping[tuple[str, str], Any] = {},
    constants: str = "per_window",
    by_surface: bool = True,
) -> Fit:
    """Derivatives by least squares over windows.

    Args:
        coefs: Coefficients of :func:`coefficients`.
        structure: Terms of each coefficient, products of powers of variables: ``{"Cm": ["1", "alpha", "qc/V", "delta_e"]}``.
        windows: Names of the windows to identify with, the others being predicted; without it those whose role says so.
        method: ``"ols"``; constraints make it constrained or mixed estimation.
        errors: ``"coloured"`` or ``"white"``: what ``stderr`` and ``cov`` are.
        constraints: By coefficient and term: a number (fixed), ``(lower, upper)`` with ``None`` for an open end, or
            ``{"mean": .., "std": ..}``.
        constants: ``"per_window"``, or ``"common"``.
        by_surface: Symmetric coefficients from windows of the elevator, asymmetric ones from those of aileron and rudder.
    """
    if method != "ols":
        raise DoubletError(f"'{method}' is no method of fit: use ols; lstsq has stepwise and orthogonal")
    if errors not in ("coloured", "white"):
        raise DoubletError(f"'{errors}' are no errors: use coloured or white")
    if constants not in ("per_window", "common"):
        raise DoubletError(f"'{constants}' are no constants: use per_window or common")
    models = [(str(name), [str(term) for term in terms]) for name, terms in structure.items()]
    given: list[Constraint] = [(c, t, *_known(value)) for (c, t), value in constraints.items()]
    inner = _doublet.Fit.fit(
        coefs._inner, models, None if windows is None else list(windows), given, by_surface, constants == "common"
    )
    return Fit(inner, errors)


def _known(value: Any) -> tuple[str, float, float]:
    """A constraint as the engine takes it."""
    if isinstance(value, Mapping):
        return "prior", float(value["mean"]), float(value["std"])
    if isinstance(value, (tuple, list)):
        low, high = (default if end is None else float(end) for end, default in zip(value, (-np.inf, np.inf)))
        return "bounds", low, high
    return "fixed", float(value), 0.0


@dataclass(frozen=True)
class StateSpace:
    """``x' = A x + B u, y = C x + D u`` of deviations from a trim, with standard errors of A and B.

    Attributes:
        states, inputs, outputs: Names; ``units`` has their SI units.
        A, B, C, D: Matrices.
        A_stderr, B_stderr: Standard errors.
    """

    name: str
    states: list[str]
    inputs: list[str]
    outputs: list[str]
    units: dict[str, str]
    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    A_stderr: NDArray[np.float64]
    B_stderr: NDArray[np.float64]

    def to_control(self) -> Any:
        """The model as ``control.ss`` of python-control."""
        import control

        return control.ss(
            self.A, self.B, self.C, self.D, states=self.states, inputs=self.inputs, outputs=self.outputs, name=self.name
        )


class Linear:
    """How an identified aircraft flies about a trim: ``linear["longitudinal"]`` is a state space."""

    def __init__(self, row: dict[str, Any]) -> None:
        self._row = row

    @property
    def trim(self) -> dict[str, float]:
        """The trim, SI and radians."""
        return dict(self._row["trim"])

    @property
    def systems(self) -> list[str]:
        """Names of the parts of the motion."""
        return list(self._row["systems"])

    def __getitem__(self, name: str) -> StateSpace:
        row = self._row["systems"].get(name)
        if row is None:
            raise DoubletError(f"there is no linear model '{name}': there are {', '.join(self.systems)}")
        array = lambda key, rows, columns: np.asarray(row[key], dtype=np.float64).reshape(rows, columns)
        n, m, p = len(row["states"]), len(row["inputs"]), len(row["outputs"])
        units = dict(zip(row["states"] + row["inputs"] + row["outputs"],
                         row["state_units"] + row["input_units"] + row["output_units"]))
        return StateSpace(
            name, row["states"], row["inputs"], row["outputs"], units, array("A", n, n), array("B", n, m),
            array("C", p, n), array("D", p, m), array("A_standard_error", n, n), array("B_standard_error", n, m),
        )

    @property
    def modes(self) -> Table:
        """Natural modes, fastest first, with the ends of their 95 % intervals by slopes."""
        rows = []
        for mode in self._row["modes"]:
            row = {key: mode[key] for key in ("name", "frequency_rad_s", "damping", "real_1_s", "imaginary_rad_s")}
            for key in ("frequency_rad_s", "damping"):
                delta = (mode["intervals"].get(key) or {}).get("delta") or {}
                row[f"{key}_low"], row[f"{key}_high"] = delta.get("low"), delta.get("high")
            rows.append(row)
        return Table(rows, "modes")

    @property
    def qualities(self) -> dict[str, Any]:
        """Levels of the flying qualities, as ``dynamics.qualities`` of results.json."""
        return dict(self._row["qualities"])

    @property
    def notes(self) -> list[str]:
        """What is to be known of it."""
        return list(self._row["notes"])

    def to_dict(self) -> dict[str, Any]:
        """``dynamics`` of results.json."""
        return self._row

    def __repr__(self) -> str:
        return self.modes.summary()

    def _repr_html_(self) -> str:
        return self.modes._repr_html_()


@dataclass(frozen=True)
class Distribution:
    """A function of the derivatives.

    Attributes:
        value: At the estimates.
        samples: At each draw, shape (n, ...), of a function; ``None`` of an expression.
        std: Standard deviation of the draws.
        interval: Ends of the 95 % interval by quantiles of the draws.
    """

    value: Any
    samples: Optional[NDArray[np.float64]] = None
    _stderr: Optional[float] = None
    _interval: Optional[tuple[float, float]] = None

    @property
    def std(self) -> Any:
        return self._stderr if self.samples is None else np.nanstd(self.samples, axis=0, ddof=1)

    @property
    def interval(self) -> tuple[Any, Any]:
        if self.samples is None:
            return self._interval or (float("nan"), float("nan"))
        low, high = np.nanquantile(self.samples, [0.025, 0.975], axis=0)
        return low, high

    def __repr__(self) -> str:
        low, high = self.interval
        return f"<{self.value} ± {self.std}, 95 %: {low} to {high}>"


def propagate(
    fit: Fit,
    function: Union[str, Callable[[Mapping[str, float]], Any]],
    *,
    n: int = 2000,
    seed: int = 0,
    **trim: Any,
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
    """
    if isinstance(function, str):
        value, _, sampled = fit._inner.propagate(function, trim, n, seed)
        if sampled is None:
            raise DoubletError(f"'{function}' has no bounded interval: some draws have no value")
        return Distribution(value, _stderr=sampled[0], _interval=(sampled[1], sampled[2]))
    names, estimates, _, draws = fit._inner.draws(n, seed)
    at = lambda row: function(dict(zip(names, map(float, row))))
    return Distribution(at(estimates), np.asarray([at(row) for row in draws], dtype=np.float64))


@dataclass(frozen=True)
class OutputError:
    """Output error of one window.

    Attributes:
        window: Window.
        axis: ``"longitudinal"``, ``"lateral"`` or ``"both"``.
        derivatives: Estimates with errors corrected for coloured residuals.
        outputs: By name: time (s), measured and flown (SI), R².
        error: Why there is none, or ``None``.
    """

    window: str
    axis: str
    derivatives: dict[str, Value]
    outputs: dict[str, tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]]
    iterations: int = 0
    error: Optional[str] = None

    def plot(self, axes: Any = None) -> Any:
        """Draws measured and flown outputs; returns the axes."""
        from ._plots import stack

        return stack([(n, "SI", [(t, m, None), (t, f, None)]) for n, (t, m, f, _) in self.outputs.items()], axes)


def output_error(
    path: Path, fit: Fit, *, axis: Optional[str] = None, progress: Progress = None
) -> list[OutputError]:
    """Output error of every window with the equations of motion: the moved axis flies the recorded controls until its outputs
    follow the reconstructed ones; the other axis moves as reconstructed.

    Args:
        path: The path the fit was made from; only there to be named.
        fit: Fit whose derivatives are the start and whose terms are free.
        axis: ``"longitudinal"``, ``"lateral"`` or ``"both"``; without it that which each window's surface moves.
    """
    del path
    found = []
    for row in fit._inner.output_error(axis, progress):
        derivatives = {name: Value(value, error) for name, value, error in row.get("derivatives", [])}
        found.append(
            OutputError(row["window"], row["axis"], derivatives, row.get("outputs", {}), row.get("iterations", 0), row.get("error"))
        )
    return found
