"""Your own equations of motion, fitted to a table."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _doublet, commands
from ._commands import Answer, Inputs, time_column
from ._doublet import DoubletError
from ._errors import unknown
from ._fit import information_criterion
from ._frames import Origin, columns_of, common_origin, is_dated, is_frame, times
from ._recording import PathLike, Recording, WindowGiven
from ._sides import Functions
from ._table import Table, Value, normal_quantile
from ._verdict import Verdict
from ._window import Window

_METHODS = ("equation_error", "output_error", "filter_error")
_Order = tuple[
    Optional[Mapping[str, str]], Optional[str], Optional[float], list[tuple[float, float]], Optional[float], Optional[float]
]
_KEYS = ("inputs", "states", "outputs", "parameters", "constants", "rates", "shows")


@dataclass(frozen=True)
class EquationFit:
    """Parameters of equations of motion by every method that has a result.

    Attributes:
        document: What ``doublet equations --json`` prints.
    """

    document: Answer

    @property
    def verdict(self) -> Verdict:
        """How far ``params`` may be trusted."""
        return Verdict(self.document["verdict"])

    @property
    def method(self) -> str:
        """The method of ``params``: ``"filter_error"`` where noise drives the motion, else the first that has a result of
        ``"output_error"``, ``"equation_error"``, ``"filter_error"``."""
        if self.document["is_driven_by_noise"]:
            return "filter_error"
        return next(name for name in ("output_error", "equation_error", "filter_error") if name not in self.errors)

    @property
    def errors(self) -> dict[str, str]:
        """Why a method has no result, by method."""
        return {name: self.document[name]["error"] for name in _METHODS if "error" in self.document[name]}

    def by(self, method: str) -> dict[str, Value]:
        """Parameters by one method, with errors corrected for correlated residuals."""
        if method not in _METHODS:
            raise unknown("method", method, _METHODS)
        if method in self.errors:
            raise DoubletError(f"{method}: {self.errors[method]}")
        return {row["name"]: _value(row) for row in self.document[method]["parameters"]}

    @property
    def params(self) -> dict[str, float]:
        """Estimates by name, of :attr:`method`."""
        return {name: float(value) for name, value in self.by(self.method).items()}

    @property
    def stderr(self) -> dict[str, float]:
        """Standard errors by name, corrected for correlated residuals."""
        return {name: value.stderr for name, value in self.by(self.method).items()}

    @property
    def cov(self) -> NDArray[np.float64]:
        """Covariance of ``params`` in their order, shape (p, p), corrected for correlated residuals."""
        return self.cov_by(self.method)

    def cov_by(self, method: str) -> NDArray[np.float64]:
        """Covariance of the parameters by one method in the order of :meth:`by`, shape (p, p)."""
        self.by(method)
        return np.array(self.document[method]["covariance"], dtype=np.float64)

    def conf_int(self, level: float = 0.95, *, method: Optional[str] = None) -> dict[str, tuple[float, float]]:
        """Ends of the intervals of ``level`` by name, of :attr:`method` or of another one."""
        times, values = normal_quantile(level), self.by(method or self.method)
        return {name: (value - times * value.stderr, value + times * value.stderr) for name, value in values.items()}

    @property
    def r2(self) -> dict[str, float]:
        """Coefficient of determination by output."""
        return {row["name"]: row["r_squared"] for row in self.document[self.method]["outputs"]}

    @property
    def nobs(self) -> int:
        """Samples of each output, of :attr:`method`."""
        return int(self.document[self.method]["samples"])

    @property
    def aic(self) -> float:
        """Akaike's criterion of white normal residuals of all outputs, of :attr:`method`; compare equations by the same samples only."""
        row = self.document[self.method]
        count = len(row["parameters"]) + len(row["initial"]) + sum(1 for noise in row.get("process_noise", []) if not noise["is_none"])
        parts = [information_criterion(output["rms"] ** 2 * row["samples"], row["samples"], 0) for output in row["outputs"]]
        return 2.0 * count + sum(parts)

    @property
    def process_noise(self) -> dict[str, float]:
        """Noise of each state by filter error, unit of the state per root second; zero where there is none."""
        rows = self.document["filter_error"].get("process_noise", [])
        return {row["state"]: 0.0 if row["is_none"] else row["intensity"] for row in rows}

    def __getitem__(self, name: str) -> Value:
        values = self.by(self.method)
        if name not in values:
            raise unknown("parameter", name, values)
        return values[name]

    @property
    def table(self) -> Table:
        """A row per parameter and method."""
        rows = [
            dict(parameter=row["name"], method=method, estimate=row["estimate"], stderr=row["corrected_standard_error"],
                 stderr_white=row["standard_error"])
            for method in _METHODS for row in self.document[method].get("parameters", [])
        ]
        return Table(rows, "equations of motion")

    def plot(self, *, axes: Any = None) -> Any:
        """Draws the parameters by every method with their 95 % intervals; returns the axes."""
        from ._plots import intervals, one

        axis, methods = one(axes), [name for name in _METHODS if name not in self.errors]
        for place, method in enumerate(methods):
            rows = [(name, value.value, value.stderr) for name, value in self.by(method).items()]
            intervals(rows, method.replace("_", " "), axis, 0.15 * (place - (len(methods) - 1) / 2))
        axis.set_xlabel("estimate and 95 % interval")
        axis.set_title(f"equations of motion, verdict {self.verdict.level}")
        axis.legend()
        return axis

    def to_dict(self) -> dict[str, Any]:
        """What ``doublet equations --json`` prints."""
        return dict(self.document)

    def summary(self) -> str:
        """Parameters by every method and the verdict as text."""
        failed = [f"{name}: {error}" for name, error in self.errors.items()]
        return "\n".join([self.table.summary(), f"params by {self.method}", *failed, self.verdict.line()])

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return self.table._repr_html_() + self.verdict._repr_html_()


def _value(row: Mapping[str, Any]) -> Value:
    error = row["corrected_standard_error"]
    return Value(row["estimate"], float("nan") if error is None else error)


def equations(
    frame: Any,
    equations: Union[PathLike, Mapping[str, Any]],
    *,
    columns: Optional[Mapping[str, str]] = None,
    constants: Optional[Mapping[str, float]] = None,
    time: Optional[str] = None,
    dt: Optional[float] = None,
    windows: Sequence[WindowGiven] = (),
    half_width: Optional[float] = None,
    piece: Optional[float] = None,
) -> EquationFit:
    """Parameters of equations of motion by equation error, output error and filter error: ``doublet equations``.

    Args:
        frame: Frame, recording or file whose columns are states, inputs and outputs; values are not converted. A frame without a
            column of time has it in its index.
        equations: ``"short-period"``, ``"longitudinal"``, ``"lateral"``, a file, or a mapping: ``{"inputs": ["delta_e"], "states":
            {"q": "M_alpha*alpha + M_q*q"}, "outputs": {"az": "V0*(q - 0.1)"}, "parameters": {"M_q": -1.0}, "constants": {"V0": 50.0}}``.
            The right-hand sides are expressions; ``parameters`` have initial values. Or the right-hand sides are functions: ``{"inputs":
            ["delta_e"], "states": ["alpha", "q"], "rates": f, "outputs": ["alpha", "q", "az"], "shows": h, "parameters": {...}}``, where
            ``f(x, u, p)`` returns the rate of each state, and ``h(x, u, p)`` the outputs that are not states, in order or by name. ``x``, ``u``,
            ``p`` (parameters and constants) have values by name, ``x.alpha`` or ``x["alpha"]``, and in order. A function that takes
            arrays is called for many points at once, another one point by point, which takes longer.
        columns: Column, or expression of columns, of an input or output that is called otherwise: ``{"alpha": "ALPHA*pi/180"}``.
        constants: Other values of constants of the equations.
        time: Column of time, s, or expression of columns.
        dt: Interval of the rows, s, of a table without time.
        windows: Rows used, as for :func:`reconstruct`; all rows by default. Excluded parts of a window are left out.
        half_width: Half width of the differentiation of equation error, s.
        piece: Length of the pieces of output error, s, for unstable motions.

    Raises:
        DoubletError: Equations, columns or time are wrong, or no method has a result. Exceptions of a function are passed on.

    Warns:
        DoubletWarning: The verdict is bad.
    """
    parts = _used_parts(windows, frame, time)
    if isinstance(equations, Mapping) and ("rates" in equations or "shows" in equations):
        _refuse_unknown(equations)
        functions = Functions(equations, constants)
        return _by_functions(frame, functions, (columns, time, dt, parts, half_width, piece))
    with Inputs() as inputs:
        source = str(inputs.file("equations.toml", _text(equations))) if isinstance(equations, Mapping) else os.fspath(equations)
        found = commands.equations(
            frame, equations=source, column=columns, constant=constants, time=time, dt=dt, window=parts,
            half_width=half_width, piece=piece,
        )
    return EquationFit(found)


def _used_parts(windows: Sequence[WindowGiven], frame: Any, time: Optional[str]) -> list[tuple[float, float]]:
    """Start and end, s, of the parts of windows that count."""
    origin = _origin(frame, time) if len(windows) else None
    parts = [part for index, window in enumerate(windows) for part in Window._of(window, index, origin).split()]
    if len(windows) and not parts:
        raise DoubletError("no samples left after exclusions: shorten the excluded parts")
    return [(part.start, part.end) for part in parts]


def _origin(frame: Any, time: Optional[str]) -> Optional[Origin]:
    """The first instant of a recording, or of a frame whose time is given as instants."""
    if isinstance(frame, Recording):
        return frame._origin
    if not is_frame(frame):
        return None
    found = columns_of(frame)
    name = time if time in found.names else time_column(found.names)
    stamps = found.stamps if name is None else found.get(name)
    return common_origin({"time": times(stamps)}) if stamps is not None and is_dated(stamps) else None


def _by_functions(frame: Any, equations: Functions, order: _Order) -> EquationFit:
    """Fits equations whose right-hand sides are functions."""
    columns, time, dt, windows, half_width, piece = order
    for name, value in (("dt", dt), ("half_width", half_width), ("piece", piece)):
        if value is not None and not 0.0 < value < float("inf"):
            raise DoubletError(f"{name} is {value}: give a time above 0 s")
    wrong = next((one for one in windows if not one[0] < one[1]), None)
    if wrong is not None:
        raise DoubletError(f"the end of the window {wrong} is not after its start")
    names = (equations.states, equations.outputs, equations.inputs, list(equations.parameters.items()))
    with Inputs() as inputs:
        found = _doublet.fit_function(
            inputs.text(frame), names, (list((columns or {}).items()), time, dt, windows, half_width, piece), equations.sides
        )
    document = json.loads(found)
    verdict = Verdict(document["verdict"])
    verdict.warn("equations")
    return EquationFit(Answer(document, "equations", verdict.level == "bad", []))


def _refuse_unknown(equations: Mapping[str, Any]) -> None:
    wrong = next((key for key in equations if key not in _KEYS), None)
    if wrong is not None:
        raise unknown("key of equations", wrong, _KEYS)


def _text(equations: Mapping[str, Any]) -> str:
    """A mapping of equations as their file."""
    _refuse_unknown(equations)
    sides = [*dict(equations.get("states", {})).values(), *dict(equations.get("outputs", {})).values()]
    if any(callable(side) for side in sides):
        raise DoubletError("a right-hand side is a function: give one function of all states as 'rates', and one of other outputs as 'shows'")
    lines = ['format = "doublet equations"', f"inputs = {json.dumps(list(equations.get('inputs', [])))}"]
    for key, head, side in (("states", "state", "rate"), ("outputs", "output", "shows")):
        for name, expression in equations.get(key, {}).items():
            lines += [f"[[{head}]]", f"name = {json.dumps(name)}", f"{side} = {json.dumps(expression)}"]
    for key in ("parameters", "constants"):
        rows = [f"{json.dumps(name)} = {float(value)!r}" for name, value in equations.get(key, {}).items()]
        lines += [f"[{key}]", *rows] if rows else []
    return "\n".join([*lines, ""])
