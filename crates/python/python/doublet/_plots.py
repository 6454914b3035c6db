"""Figures by matplotlib, drawn on axes that are given or made."""

from __future__ import annotations

from typing import Any, Optional, Sequence

from ._doublet import DoubletError


def stack(rows: Sequence[tuple[str, str, Sequence[tuple[Any, Any, Optional[Any]]]]], axes: Any = None) -> Any:
    """Rows of curves over time, one below the other: name, unit, curves of time, values and standard deviation."""
    import matplotlib.pyplot as plt
    import numpy as np

    if axes is None:
        _, axes = plt.subplots(len(rows), 1, sharex=True, squeeze=False, figsize=(8, 1.6 * len(rows) + 0.8))
    axes = np.ravel(np.asarray(axes, dtype=object))
    if len(axes) < len(rows):
        raise DoubletError(f"there are {len(axes)} axes for {len(rows)} curves: give one for each")
    for axis, (name, unit, curves) in zip(axes, rows):
        for time, values, deviation in curves:
            line = axis.plot(time, values, linewidth=1)[0]
            if deviation is not None:
                low, high = values - 2 * deviation, values + 2 * deviation
                axis.fill_between(time, low, high, alpha=0.25, color=line.get_color(), linewidth=0)
        axis.set_ylabel(f"{name} [{unit}]")
        axis.grid(True, linewidth=0.3)
    axes[len(rows) - 1].set_xlabel("time [s]")
    return axes


def one(axes: Any = None) -> Any:
    """Axes that were given, or new ones."""
    import matplotlib.pyplot as plt

    return plt.subplots()[1] if axes is None else axes


def by_either_name(axes: Any, ax: Any) -> Any:
    """Axes given as ``axes``, or as ``ax``, which is an earlier name of the argument."""
    if axes is not None and ax is not None:
        raise DoubletError("axes and ax are the same: give axes")
    return ax if axes is None else axes


def intervals(rows: Sequence[tuple[str, float, float]], label: str, axes: Any = None, shift: float = 0.0) -> Any:
    """Names with their estimates and 95 % intervals, one below the other; the series is ``shift`` rows lower."""
    import numpy as np

    from ._table import normal_quantile

    axis, half = one(axes), normal_quantile(0.95)
    places = np.arange(len(rows)) + shift
    axis.errorbar([value for _, value, _ in rows], places, xerr=[half * error for *_, error in rows], fmt="o", capsize=3, label=label or None)
    axis.set_yticks(range(len(rows)), [name for name, *_ in rows])
    axis.grid(True, linewidth=0.3)
    return axis


def spans(axes: Sequence[Any], windows: Sequence[Any]) -> None:
    """Shades windows behind curves, identification and validation in a colour each, and names them above the first axes."""
    colours = {"identification": "tab:blue", "validation": "tab:orange"}
    for window in windows:
        for axis in axes:
            axis.axvspan(window.start, window.end, alpha=0.15, linewidth=0, color=colours.get(window.role, "grey"))
            for start, end in window.exclude:
                axis.axvspan(start, end, alpha=0.3, linewidth=0, color="grey")
        axes[0].text(window.start, 1.02, window.name, transform=axes[0].get_xaxis_transform(), rotation=60, fontsize=6, va="bottom")
