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


def one(axis: Any = None) -> Any:
    """Axes that were given, or new ones."""
    import matplotlib.pyplot as plt

    return plt.subplots()[1] if axis is None else axis
