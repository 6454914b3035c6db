"""Linear models and modes of an identified aircraft."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import unknown
from ._table import Table


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
            raise unknown("linear model", name, self.systems)

        def array(key: str, rows: int, columns: int) -> NDArray[np.float64]:
            return np.asarray(row[key], dtype=np.float64).reshape(rows, columns)

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
