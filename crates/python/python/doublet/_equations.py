"""Your own equations of motion, fitted to a table."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Sequence, Union

from . import commands
from ._commands import Answer, Inputs
from ._doublet import DoubletError
from ._errors import unknown
from ._recording import PathLike
from ._table import Table, Value, normal_quantile
from ._verdict import Verdict

_METHODS = ("equation_error", "output_error", "filter_error")
_KEYS = ("inputs", "states", "outputs", "parameters", "constants")


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

    def conf_int(self, level: float = 0.95, *, method: Optional[str] = None) -> dict[str, tuple[float, float]]:
        """Ends of the intervals of ``level`` by name, of :attr:`method` or of another one."""
        times, values = normal_quantile(level), self.by(method or self.method)
        return {name: (value - times * value.stderr, value + times * value.stderr) for name, value in values.items()}

    @property
    def r2(self) -> dict[str, float]:
        """Coefficient of determination by output."""
        return {row["name"]: row["r_squared"] for row in self.document[self.method]["outputs"]}

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
    windows: Sequence[tuple[float, float]] = (),
    half_width: Optional[float] = None,
    piece: Optional[float] = None,
) -> EquationFit:
    """Parameters of equations of motion by equation error, output error and filter error: ``doublet equations``.

    Args:
        frame: Frame, recording or file whose columns are states, inputs and outputs; values are not converted. A frame without a
            column of time has it in its index.
        equations: ``"short-period"``, ``"longitudinal"``, ``"lateral"``, a file, or a mapping: ``{"inputs": ["delta_e"], "states":
            {"q": "M_alpha*alpha + M_q*q"}, "outputs": {"az": "V0*(q - 0.1)"}, "parameters": {"M_q": -1.0}, "constants": {"V0": 50.0}}``.
            The right-hand sides are expressions; ``parameters`` have initial values.
        columns: Column, or expression of columns, of an input or output that is called otherwise: ``{"alpha": "ALPHA*pi/180"}``.
        constants: Other values of constants of the equations.
        time: Column of time, s, or expression of columns.
        dt: Interval of the rows, s, of a table without time.
        windows: Start and end, s, of what is used; all rows by default.
        half_width: Half width of the differentiation of equation error, s.
        piece: Length of the pieces of output error, s, for unstable motions.

    Raises:
        DoubletError: Equations, columns or time are wrong, or no method has a result.

    Warns:
        DoubletWarning: The verdict is bad.
    """
    with Inputs() as inputs:
        source = str(inputs.file("equations.toml", _text(equations))) if isinstance(equations, Mapping) else os.fspath(equations)
        found = commands.equations(
            frame, equations=source, column=columns, constant=constants, time=time, dt=dt, window=[tuple(one) for one in windows],
            half_width=half_width, piece=piece,
        )
    return EquationFit(found)


def _text(equations: Mapping[str, Any]) -> str:
    """A mapping of equations as their file."""
    wrong = next((key for key in equations if key not in _KEYS), None)
    if wrong is not None:
        raise unknown("key of equations", wrong, _KEYS)
    lines = ['format = "doublet equations"', f"inputs = {json.dumps(list(equations.get('inputs', [])))}"]
    for key, head, side in (("states", "state", "rate"), ("outputs", "output", "shows")):
        for name, expression in equations.get(key, {}).items():
            lines += [f"[[{head}]]", f"name = {json.dumps(name)}", f"{side} = {json.dumps(expression)}"]
    for key in ("parameters", "constants"):
        rows = [f"{json.dumps(name)} = {float(value)!r}" for name, value in equations.get(key, {}).items()]
        lines += [f"[{key}]", *rows] if rows else []
    return "\n".join([*lines, ""])
