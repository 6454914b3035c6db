"""Step 1: flight path reconstruction."""

from __future__ import annotations

from typing import Any, Iterator, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._doublet import DoubletError
from ._recording import Aircraft, Progress, Recording, Window
from ._table import Table


class States(Mapping[str, NDArray[np.float64]]):
    """States by name: position ``x y z`` (m, north, east, down), airspeed components ``u v w`` (m/s), attitude ``phi theta psi``
    (rad), biases ``bias_ax`` .. ``bias_r``, wind ``wind_north wind_east wind_down``. Each an array of shape (n,) over
    ``time``; ``std`` has the same keys."""

    def __init__(self, time: NDArray[np.float64], pairs: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]]):
        self.time = time
        self._values = {name: pair[0] for name, pair in pairs.items()}
        self.std: Mapping[str, NDArray[np.float64]] = {name: pair[1] for name, pair in pairs.items()}

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self._values:
            raise DoubletError(f"no state is called '{name}': there are {', '.join(self._values)}")
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` over time."""
        import pandas

        return pandas.DataFrame(dict(self._values), index=pandas.Index(self.time, name="time"))

    @property
    def airspeed(self) -> NDArray[np.float64]:
        """True airspeed, m/s."""
        return np.sqrt(self["u"] ** 2 + self["v"] ** 2 + self["w"] ** 2)

    @property
    def alpha(self) -> NDArray[np.float64]:
        """Angle of attack, rad."""
        return np.arctan2(self["w"], self["u"])

    @property
    def beta(self) -> NDArray[np.float64]:
        """Angle of sideslip, rad."""
        return np.arctan2(self["v"], np.hypot(self["u"], self["w"]))


class WindowPath:
    """The path of one window."""

    def __init__(self, inner: _doublet.Path, index: int, window: Window) -> None:
        self._inner, self._index, self.window = inner, index, window

    @property
    def time(self) -> NDArray[np.float64]:
        """Time of the states, s, shape (n,)."""
        return self._inner.times(self._index)[0]

    @property
    def states(self) -> States:
        """Filtered states with their standard deviations; they look at the path's memory."""
        return States(self.time, self._inner.states(self._index, "filtered"))

    @property
    def smoothed(self) -> States:
        """Smoothed states with their standard deviations."""
        return States(self.time, self._inner.states(self._index, "smoothed"))

    @property
    def innovations(self) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """By measurement: innovations and their predicted standard deviations, SI, over ``update_time``; not a number where
        nothing was measured."""
        return {name: (pair[0], pair[1]) for name, pair in self._inner.innovations(self._index).items()}

    @property
    def update_time(self) -> NDArray[np.float64]:
        """Times of the innovations, s."""
        return self._inner.times(self._index)[1]

    @property
    def nis(self) -> NDArray[np.float64]:
        """Normalised innovation squared at each update; its expectation is ``nis_degrees``."""
        return self._inner.nis(self._index)[0]

    @property
    def nis_degrees(self) -> NDArray[np.float64]:
        """Measurements at each update."""
        return self._inner.nis(self._index)[1]

    @property
    def log_likelihood(self) -> float:
        """Logarithm of the likelihood of the measurements."""
        return self._inner.log_likelihood(self._index)

    @property
    def warnings(self) -> list[str]:
        """Findings, one line each."""
        return self._inner.warnings(self._index)

    def plot(self, *names: str, axes: Any = None) -> Any:
        """Draws states over time with two standard deviations; returns the axes."""
        from ._plots import stack

        states, units = self.states, _doublet.Path.units()
        rows = [(name, units[name], [(self.time, states[name], states.std[name])]) for name in names or ("u", "w", "theta")]
        return stack(rows, axes)


class Path(Sequence[WindowPath]):
    """Flight paths of windows; ``path[0]`` or ``path["name"]`` is one of them. With a single window its attributes are those of
    the path."""

    def __init__(self, inner: _doublet.Path) -> None:
        self._inner = inner
        self.windows = [Window(*row) for row in inner.windows()]

    def __len__(self) -> int:
        return len(self.windows)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            names = [window.name for window in self.windows]
            if key not in names:
                raise DoubletError(f"no window is called '{key}': there are {', '.join(names)}")
            key = names.index(key)
        return WindowPath(self._inner, range(len(self))[key], self.windows[key])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or not hasattr(WindowPath, name):
            raise AttributeError(name)
        if len(self.windows) != 1:
            raise DoubletError(f"there are {len(self.windows)} windows: take {name} of one, path[0].{name}")
        return getattr(self[0], name)

    @property
    def summary_table(self) -> Table:
        """Each window with its samples, mean normalised innovation squared and what that is expected to be."""
        rows = []
        for one in self:
            nis, degrees = one.nis, one.nis_degrees
            seen = np.isfinite(nis)
            mean = [float(column[seen].mean()) if seen.any() else float("nan") for column in (nis, degrees)]
            rows.append(
                dict(window=one.window.name, start_s=one.window.start, end_s=one.window.end, samples=len(one.time),
                     mean_nis=mean[0], expected_nis=mean[1], warnings=len(one.warnings))
            )
        return Table(rows, "flight paths")

    def summary(self) -> str:
        """The same as text."""
        return self.summary_table.summary()

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return self.summary_table._repr_html_()


def reconstruct(
    recording: Recording,
    aircraft: Optional[Aircraft] = None,
    *,
    windows: Optional[Sequence[Union[Window, tuple[float, float]]]] = None,
    method: str = "iekf",
    noise: Optional[Mapping[str, float]] = None,
    delays: Optional[Mapping[str, float]] = None,
    smooth: bool = True,
    passes: int = 1,
    progress: Progress = None,
) -> Path:
    """Reconstructs flight paths: 18 states, up to 12 measurements each at its own rate, any subset of them.

    Args:
        recording: Needs specific force ``ax ay az`` and rates ``p q r``.
        aircraft: Moves sensors to the centre of gravity where its file says where they are.
        windows: Windows, or pairs of start and end, s; without any one window over everything.
        method: ``"ekf"``, ``"iekf"`` (iterated) or ``"ukf"``.
        noise: Standard deviations of inputs (``ax .. r``, the root of the diagonal of Q) and of measurements (``x y z v_north
            v_east v_down phi theta psi airspeed alpha beta``, of R), SI; others are those of good flight-test instruments.
        delays: Delay of a measurement, s.
        smooth: Rauch-Tung-Striebel smoother; coefficients are then formed from the smoothed path.
        passes: Passes of the iterated smoother at most.
        progress: Called with the part done. Ctrl-C stops.
    """
    given: list[Window] = []
    for index, window in enumerate(windows if windows is not None else []):
        given.append(window if isinstance(window, Window) else Window(f"window {index + 1}", *map(float, window)))
    if windows is None:
        base = next((recording[name] for name in ("p", "q", "r") if name in recording), None)
        if base is None:
            raise DoubletError("the recording has none of p, q and r: the filter is driven by them")
        given = [Window("all", float(base.time[0]), float(base.time[-1]))]
    if not given:
        raise DoubletError("there is no window: give one, or leave windows out for everything")
    pairs = [list(map(lambda item: (str(item[0]), float(item[1])), (given_ or {}).items())) for given_ in (noise, delays)]
    inner = _doublet.Path.reconstruct(
        recording._inner, None if aircraft is None else aircraft._inner, [one._row() for one in given], method,
        pairs[0], pairs[1], smooth, passes, progress,
    )
    return Path(inner)
