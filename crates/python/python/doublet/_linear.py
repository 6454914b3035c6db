"""Linear models and modes of an identified aircraft."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._doublet import DoubletError
from ._errors import unknown
from ._table import Table
from ._verdict import Verdict


class Trim(TypedDict, total=False):
    """Where an aircraft is trimmed; defaults are medians over the windows.

    Attributes:
        airspeed: m/s.
        altitude: m.
        gamma: Angle of climb, rad.
        load_factor: Of a turn, or of a pull-up.
        pull_up: Whether the load factor is that of a pull-up.
        mass: kg.
        fuel: On board in all, kg.
        stick_delay: s.
        aileron: Available from trim, rad.
        window: Name of the window whose condition it is.
    """

    airspeed: float
    altitude: float
    gamma: float
    load_factor: float
    pull_up: bool
    mass: float
    fuel: float
    stick_delay: float
    aileron: float
    window: str


@dataclass(frozen=True, repr=False)
class StateSpace:
    """``x' = A x + B u, y = C x + D u`` about a trim, with standard errors of A and B.

    Attributes:
        states, inputs, outputs: Names; ``units`` has their SI units.
        A, B, C, D: Matrices.
        A_stderr, B_stderr: Standard errors.
        verdict: That of the fit it was made from.
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
    verdict: Verdict

    def to_control(self) -> Any:
        """The model as ``control.ss`` of python-control."""
        import control

        return control.ss(
            self.A, self.B, self.C, self.D, states=self.states, inputs=self.inputs, outputs=self.outputs, name=self.name
        )

    def response(self, output: str, input: str, omega: ArrayLike) -> NDArray[np.complex128]:
        """Frequency response of an output to an input at ``omega`` (rad/s), shape (m,)."""
        if output not in self.outputs:
            raise unknown(f"output of the {self.name} model", output, self.outputs)
        if input not in self.inputs:
            raise unknown(f"input of the {self.name} model", input, self.inputs)
        row, column = self.outputs.index(output), self.inputs.index(input)
        identity = np.eye(len(self.states))
        solved = [np.linalg.solve(1j * one * identity - self.A, self.B[:, column]) for one in np.asarray(omega, dtype=np.float64)]
        return np.asarray([self.C[row] @ x + self.D[row, column] for x in solved], dtype=np.complex128)

    def bode(self, output: str, input: str, *, omega: Optional[ArrayLike] = None, axes: Any = None, ax: Any = None) -> Any:
        """Bode plot of an output to an input; returns two axes: gain, phase.

        Args:
            output: Output.
            input: Input.
            omega: Frequencies, rad/s; by default a decade beyond the slowest and the fastest mode.
            axes: Two axes to draw on.
            ax: Earlier name of ``axes``.
        """
        import matplotlib.pyplot as plt

        from ._plots import by_either_name

        given = by_either_name(axes, ax)
        axes = plt.subplots(2, 1, sharex=True, figsize=(7, 5))[1] if given is None else np.ravel(np.asarray(given, dtype=object))
        if len(axes) != 2:
            raise DoubletError(f"there are {len(axes)} axes: give two, for gain and phase")
        chosen = self._frequencies() if omega is None else np.asarray(omega, dtype=np.float64)
        response = self.response(output, input, chosen)
        axes[0].plot(chosen, 20.0 * np.log10(np.abs(response)), linewidth=1, label=self.name)
        axes[1].plot(chosen, np.degrees(np.unwrap(np.angle(response))), linewidth=1, label=self.name)
        units = f"{self.units.get(output, '-')} per {self.units.get(input, '-')}"
        for axis, label in zip(axes, (f"{output} / {input} [dB, {units}]", "phase [deg]")):
            axis.set_xscale("log")
            axis.set_ylabel(label)
            axis.grid(True, linewidth=0.3)
        axes[0].set_title(f"{self.name}, verdict {self.verdict.level}")
        axes[1].set_xlabel("frequency [rad/s]")
        return axes

    def _frequencies(self) -> NDArray[np.float64]:
        sizes = np.abs(np.linalg.eigvals(self.A))
        sizes = sizes[sizes > 1e-6]
        low, high = (float(sizes.min()), float(sizes.max())) if len(sizes) else (0.1, 10.0)
        return np.geomspace(low / 10.0, high * 10.0, 400)

    def __repr__(self) -> str:
        shown = f"states {', '.join(self.states)}; inputs {', '.join(self.inputs)}; outputs {', '.join(self.outputs)}"
        return f"<doublet.StateSpace {self.name}: {shown}; verdict {self.verdict.level}>"

    def _repr_html_(self) -> str:
        rows = [
            dict(row=f"d({state})/dt", **{
                name: f"{value:.4g} ± {error:.2g}"
                for name, value, error in zip([*self.states, *self.inputs], [*self.A[k], *self.B[k]], [*self.A_stderr[k], *self.B_stderr[k]])
            })
            for k, state in enumerate(self.states)
        ]
        return Table(rows, f"{self.name}: A and B with standard errors; {self.verdict.line()}")._repr_html_()


class Linear:
    """Linear models of an identified aircraft about a trim: ``linear["longitudinal"]`` is a state space."""

    def __init__(self, row: dict[str, Any], verdict: Verdict) -> None:
        self._row, self._verdict = row, verdict

    @property
    def verdict(self) -> Verdict:
        """How far the derivatives may be trusted that it was made from: the verdict of the fit."""
        return self._verdict

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
            array("C", p, n), array("D", p, m), array("A_standard_error", n, n), array("B_standard_error", n, m), self.verdict,
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
        return Table(rows, f"modes: {self.verdict.line()}")

    @property
    def qualities(self) -> dict[str, Any]:
        """Levels of the flying qualities, as ``dynamics.qualities`` of results.json."""
        return dict(self._row["qualities"])

    @property
    def notes(self) -> list[str]:
        """Notes of the linear model."""
        return list(self._row["notes"])

    def to_dict(self) -> dict[str, Any]:
        """``dynamics`` of results.json."""
        return self._row

    def plot(self, *, axes: Any = None, ax: Any = None) -> Any:
        """Draws the eigenvalues of the modes, both of a pair; returns the axes. ``ax`` is an earlier name of ``axes``."""
        from ._plots import by_either_name, one as axis_of

        axis = axis_of(by_either_name(axes, ax))
        for mode in self.modes:
            real, imaginary = mode["real_1_s"], mode["imaginary_rad_s"]
            both = sorted({imaginary, -imaginary})
            axis.plot([real] * len(both), both, "x", label=mode["name"])
        axis.axhline(0.0, linewidth=0.3, color="grey")
        axis.axvline(0.0, linewidth=0.3, color="grey")
        axis.set_xlabel("real part [1/s]")
        axis.set_ylabel("imaginary part [rad/s]")
        axis.set_title(f"modes, verdict {self.verdict.level}")
        axis.legend()
        return axis

    def bode(self, output: str, input: str, *, omega: Optional[ArrayLike] = None, axes: Any = None, ax: Any = None) -> Any:
        """Bode plot of the first model with this output and input; ``omega`` (rad/s), ``axes`` and ``ax`` as for :meth:`StateSpace.bode`."""
        several = [self[name] for name in self.systems]
        for system in several:
            if output in system.outputs and input in system.inputs:
                return system.bode(output, input, omega=omega, axes=axes, ax=ax)
        raise unknown("response of the linear models", f"{output}/{input}", [f"{y}/{u}" for one in several for y in one.outputs for u in one.inputs])

    def __repr__(self) -> str:
        return self.modes.summary()

    def _repr_html_(self) -> str:
        return self.modes._repr_html_() + self.verdict._repr_html_()
