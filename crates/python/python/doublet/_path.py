"""Step 1: flight path reconstruction."""

from __future__ import annotations

import inspect
import json
from typing import TYPE_CHECKING, Any, Iterator, Literal, Mapping, NoReturn, Optional, Sequence, Union, overload

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._doublet import DoubletError
from ._errors import unknown
from ._keys import check_key, plain
from ._recording import Aircraft, PathLike, Progress, Recording, WindowGiven
from ._table import Columnar, Table, stacked
from ._verdict import Verdict
from ._views import View, known, refuse_others
from ._window import Window, of_one_flight

if TYPE_CHECKING:
    from ._session import Session


class States(Columnar, Mapping[str, NDArray[np.float64]]):
    """States by name: position ``x y z`` (m, north, east, down), airspeed components ``u v w`` (m/s), attitude ``phi theta psi``
    (rad), biases ``bias_ax`` .. ``bias_r``, wind ``wind_north wind_east wind_down``. Each an array of shape (n,) over
    ``time``; ``std`` has the same keys."""

    def __init__(self, time: NDArray[np.float64], pairs: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]]):
        self.time = time
        self._values = {name: pair[0] for name, pair in pairs.items()}
        self.std: Mapping[str, NDArray[np.float64]] = {name: pair[1] for name, pair in pairs.items()}

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self._values:
            raise unknown("state", name, self._values)
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def _columns(self) -> dict[str, Any]:
        deviations = {f"{name}_std": values for name, values in self.std.items()}
        return {"time": self.time, **self._values, **deviations}

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame`` over time (s), each state with its standard deviation as the column ``NAME_std``. ``attrs["units"]`` has the
        units."""
        import pandas

        frame = pandas.DataFrame(self._columns()).set_index("time")
        frame.attrs["units"] = {"time": "s", **{name: self._unit(name) for name in frame.columns}}
        return frame

    @staticmethod
    def _unit(name: str) -> str:
        return str(_doublet.Path.units()[name.removesuffix("_std")])

    def to_xarray(self) -> Any:
        """The same as an ``xarray.Dataset`` with units."""
        import xarray

        columns = self._columns()
        time = columns.pop("time")
        variables = {name: ("time", values, {"units": self._unit(name)}) for name, values in columns.items()}
        return xarray.Dataset(variables, coords={"time": ("time", time, {"units": "s"})})

    def __repr__(self) -> str:
        if not len(self.time):
            return "<doublet.States: no samples>"
        return f"<doublet.States: {len(self.time)} samples, {self.time[0]:.5g} to {self.time[-1]:.5g} s, of {', '.join(self)}>"

    def _repr_html_(self) -> str:
        rows = [
            dict(state=name, unit=self._unit(name), low=float(np.min(values)), mean=float(np.mean(values)), high=float(np.max(values)),
                 mean_std=float(np.mean(self.std[name])))
            for name, values in self.items() if len(values)
        ]
        return Table(rows, repr(self)[1:].partition(", of")[0])._repr_html_()

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


class WindowPath(Columnar):
    """The path of one window."""

    def __init__(self, path: "Path", index: int, window: Window) -> None:
        self._path, self._index, self.window = path, index, window

    @property
    def _inner(self) -> _doublet.Path:
        return self._path._inner

    @property
    def time(self) -> NDArray[np.float64]:
        """Time of the states, s, shape (n,)."""
        return self._inner.times(self._index)[0]

    @property
    def states(self) -> States:
        """Filtered states with their standard deviations: read-only views, no copy."""
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
    def final_cov(self) -> NDArray[np.float64]:
        """Covariance of the last filtered states in the order of ``states``, shape (18, 18), SI."""
        return self._inner.final_covariance(self._index)

    @property
    def measurements(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """By measurement, each of its samples but outliers: ``time`` as recorded (s), ``measured``, ``predicted`` by the filter from
        the samples before it with ``predicted_std``, and ``reconstructed`` (that of the smoothed states, filtered where nothing is smoothed),
        SI. Predictions of a path without a filter, and of samples before its first, are not numbers."""
        return self._inner.measurements(self._index)

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

    @property
    def verdict(self) -> str:
        """Level of the window: ``"good"``, ``"caution"`` or ``"bad"``; ``path.verdict`` has the findings."""
        return str(self._path.verdict["windows"][self.window.name])

    def _best(self) -> States:
        return self.smoothed if self._path.is_smoothed else self.states

    def _columns(self) -> dict[str, Any]:
        return self._best()._columns()

    def to_pandas(self) -> Any:
        """States over time, smoothed where they were smoothed, each with a column ``NAME_std``."""
        return self._best().to_pandas()

    def to_xarray(self) -> Any:
        """The same as an ``xarray.Dataset`` with units."""
        return self._best().to_xarray()

    def plot(self, *names: str, axes: Any = None) -> Any:
        """Draws the states ``names`` over time with two standard deviations, or ``"nis"``, on ``axes``; returns the axes."""
        from ._plots import stack

        states, units = self.states, _doublet.Path.units()

        def row(name: str) -> tuple[str, str, list[tuple[Any, Any, Any]]]:
            if name == "nis":
                return name, "-", [(self.update_time, self.nis, None), (self.update_time, self.nis_degrees, None)]
            if name not in units:
                raise unknown("state", name, [*units, "nis"])
            return name, units[name], [(self.time, states[name], states.std[name])]

        return stack([row(name) for name in names or ("u", "w", "theta")], axes)

    def __repr__(self) -> str:
        return f"<doublet.WindowPath '{self.window.name}': {len(self.time)} samples, verdict {self.verdict}>"

    def _repr_html_(self) -> str:
        return self._path.summary_table.where(window=self.window.name)._repr_html_()


class Path(Columnar, View[_doublet.Path], Sequence[WindowPath]):
    """Flight paths of windows; ``path[0]`` or ``path["name"]`` is one of them. With a single window its attributes are those of
    the path."""

    def __init__(self, inner: _doublet.Path, call: Any, recording: Recording, aircraft: Optional[Aircraft]) -> None:
        super().__init__(inner, call)
        self.windows = [Window._of_row(row) for row in inner.windows()]
        self.recording, self.aircraft = recording, aircraft
        self.gravity: float = inner.gravity
        self._verdict: Optional[Verdict] = None

    @property
    def is_smoothed(self) -> bool:
        """Whether the paths were smoothed."""
        return bool(self._preparation["path"] == "smoothed")

    @property
    def _preparation(self) -> dict[str, Any]:
        """Keys of the preparation that the path was made with."""
        return dict(self._call[1][3]["preparation"]) if self._call else {"path": "filtered"}

    @property
    def estimated(self) -> Table:
        """Delays (s) and random walks of the wind (m/s per root of a second) that the innovations estimated, where ``reconstruct`` was
        called with ``estimate``; ``used`` where they are significant."""
        keys = ("kind", "of", "value", "stderr", "used")
        return Table([dict(zip(keys, row)) for row in self._inner.estimated()], "estimated from the innovations")

    @property
    def verdict(self) -> Verdict:
        """How far the paths may be trusted: the verdict of a session of the same windows."""
        if self._verdict is None:
            self._verdict = Verdict._of(self._inner.verdict())
        return self._verdict

    def to_session(self, *, name: str = "arrays", folder: Optional[PathLike] = None) -> Session:
        """The session of the same recording, manoeuvres and filter, ``name`` and ``folder`` as for :meth:`Fit.to_session`; its model is that
        of a new session."""
        from ._bridge import session_of

        return session_of([self], self._inner.session(), False, name, folder)

    def __len__(self) -> int:
        return len(self.windows)

    @overload
    def __getitem__(self, key: Union[str, int]) -> WindowPath: ...
    @overload
    def __getitem__(self, key: slice) -> list[WindowPath]: ...
    def __getitem__(self, key: Union[str, int, slice]) -> Union[WindowPath, list[WindowPath]]:
        if isinstance(key, slice):
            return [self[index] for index in range(len(self))[key]]
        if isinstance(key, str):
            names = [window.name for window in self.windows]
            if key not in names:
                raise unknown("manoeuvre", key, names)
            key = names.index(key)
        return WindowPath(self, range(len(self))[key], self.windows[key])

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
                     mean_nis=mean[0], expected_nis=mean[1], verdict=one.verdict)
            )
        return Table(rows, "flight paths")

    def to_pandas(self) -> Any:
        """All windows below each other, with a column ``window``."""
        import pandas

        return pandas.concat([one.to_pandas().assign(window=one.window.name) for one in self])

    def to_xarray(self) -> Any:
        """All windows along ``time`` as an ``xarray.Dataset`` with units; the coordinate ``window`` names the window of each sample."""
        import xarray

        several = [one.to_xarray() for one in self]
        names = np.repeat(np.array([one.window.name for one in self]), [one.sizes["time"] for one in several])
        return xarray.concat(several, "time").assign_coords(window=("time", names))

    def _columns(self) -> dict[str, Any]:
        return stacked([one._columns() for one in self], [one.window.name for one in self])

    def summary(self) -> str:
        """The windows and the verdict as text."""
        return f"{self.summary_table.summary()}\n{self.verdict.line()}"

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return self.summary_table._repr_html_() + self.verdict._repr_html_()


def reconstruct(
    recording: Recording,
    aircraft: Optional[Aircraft] = None,
    *,
    windows: Optional[Sequence[WindowGiven]] = None,
    method: Literal["ekf", "iekf", "ukf"] = "iekf",
    noise: Optional[Mapping[str, float]] = None,
    delays: Optional[Mapping[str, float]] = None,
    gravity: Optional[float] = None,
    hold: Literal["first_order", "zero_order"] = "first_order",
    linearisation: Literal["prior", "predicted"] = "prior",
    random_walk: Optional[Mapping[str, float]] = None,
    initial: Optional[Mapping[str, float]] = None,
    initial_std: Optional[Mapping[str, float]] = None,
    outlier_limit: Optional[float] = None,
    robust_limit: float = 0.0,
    spread: Optional[float] = None,
    tolerance: Optional[float] = None,
    max_iterations: Optional[int] = None,
    air_data_deviation: Optional[Mapping[str, float]] = None,
    estimate: Sequence[Literal["gusts", "delays"]] = (),
    smooth: bool = True,
    passes: int = 1,
    measured: bool = False,
    differentiation: Optional[Literal["local_quadratic", "central"]] = None,
    differentiation_half_width_s: Optional[float] = None,
    origin_altitude_m: Optional[float] = None,
    correct_accelerometer: Optional[bool] = None,
    correct_vanes: Optional[bool] = None,
    correct_antenna: Optional[bool] = None,
    sensor_errors: Optional[Mapping[str, Any]] = None,
    loading: Optional[Mapping[str, Any]] = None,
    aircraft_changes: Optional[Mapping[str, Any]] = None,
    progress: Progress = None,
    **others: NoReturn,
) -> Path:
    """Reconstructs flight paths: 18 states, up to 12 measurements each at its own rate, any subset of them.

    Args:
        recording: Needs specific force ``ax ay az`` and rates ``p q r``.
        aircraft: Moves sensors to the centre of gravity if the aircraft file states their positions.
        windows: Windows, pairs of start and end, s, with the surface as a third, slices or intervals of pandas; by default one window
            over the whole recording. Ends may be durations, or instants where the recording has an ``origin``.
        method: ``"ekf"``, ``"iekf"`` (iterated) or ``"ukf"``.
        noise: Standard deviations of inputs (``ax .. r``, the root of the diagonal of Q) and of measurements (``x y z v_north
            v_east v_down phi theta psi airspeed alpha beta``, of R), SI; others are those of good flight-test instruments.
        delays: Delay of a measurement, s.
        gravity: Acceleration of gravity, m/s²; by default that of the recorded latitude and altitude, or else the standard one.
        hold: Inputs between samples: ``"first_order"`` (linear) or ``"zero_order"``.
        linearisation: Of the transition: at the ``"prior"`` or the ``"predicted"`` state.
        random_walk: Standard deviation of a random walk on a state, SI per root of a second: ``{"wind_north": 0.3}``.
        initial: Initial value of a state, SI; by default from the first measurements, zero for biases and wind.
        initial_std: Standard deviation of the initial value, SI; zero: the value is known.
        outlier_limit: Standard deviations beyond which a spike is left out; 0 for none.
        robust_limit: Standard deviations beyond which an innovation weighs less (Huber); 0 for none.
        spread: Distance of the sigma points of ``"ukf"``, standard deviations.
        tolerance: Of ``"iekf"``: change of a state, in its standard deviations, that ends the iteration.
        max_iterations: Of ``"iekf"``: iterations of an update at most.
        air_data_deviation: Standard deviation of an error of the air data that is estimated as a state: ``{"airspeed_scale": 0.02}``,
            dimensionless or rad.
        estimate: Estimates from the innovations of all windows, in addition to the stated values: ``"gusts"`` (random walk of the wind)
            and ``"delays"``. A session does both by default. ``path.estimated`` shows what was found.
        smooth: Rauch-Tung-Striebel smoother; coefficients are then formed from the smoothed path.
        passes: Passes of the iterated smoother at most.
        measured: Coefficients use airspeed and flow angles as measured, without a filter.
        differentiation: Of the rates, for the place of the accelerometers and for coefficients: ``"local_quadratic"`` or ``"central"``.
        differentiation_half_width_s: Half width of the local quadratic, s.
        origin_altitude_m: Altitude of the origin above sea level, m, where altitude is not recorded.
        correct_accelerometer: Move accelerometers to the centre of gravity.
        correct_vanes: Correct flow angles for the place of the vanes.
        correct_antenna: Move position and ground velocity to the centre of gravity.
        sensor_errors: Keys of ``[sensor_errors]`` of a session: ``{"known": {"scale_airspeed": 0.021}}`` removes errors from the samples,
            SI; those under ``"free"`` and ``"per_manoeuvre"`` are estimated by ``path.results()``.
        loading: What is on board, keys of ``[loading]``, kg: ``{"fuel_kg": {"main": 120.0}, "seats_kg": {"pilot": 80.0}}``; by default the
            standard loading of the aircraft.
        aircraft_changes: Values that override the aircraft file, by its keys joined by dots, in its units:
            ``{"mass.mass_kg": 1400.0}``.
        progress: Called with the part done. Ctrl-C stops.

    Raises:
        DoubletError: A setting, a channel that is missing, a filter that diverges.

    Warns:
        DoubletWarning: The verdict on the paths is bad; or, before they are computed, they need more memory than is available.
    """
    refuse_others("reconstruct", others, list(inspect.signature(reconstruct).parameters)[:-1])
    if not isinstance(recording, Recording):
        raise DoubletError(
            f"recording is a {type(recording).__name__}: give one Recording; fit([coefficients(path_1), coefficients(path_2)], ...) pools flights"
        )
    given = of_one_flight(windows if windows is not None else [], recording._origin)
    if windows is None:
        base = next((recording[name] for name in ("p", "q", "r") if name in recording), None)
        if base is None:
            raise DoubletError("the recording has no p, q or r, which the filter needs")
        given = [Window("all", float(base.time[0]), float(base.time[-1]))]
    if not given:
        raise DoubletError("windows is empty: give one, or leave windows out to use the whole recording")
    names = _doublet.filter_names()
    inputs, measurements, states = names["input"], names["measurement"], names["state"]
    stated = known(noise, [*inputs, *measurements], "input or measurement of the filter")
    wrong = next((one for one in estimate if one not in ("gusts", "delays")), None)
    if wrong is not None:
        raise unknown("estimate of reconstruct", wrong, ["gusts", "delays"])
    filter_table = dict(
        method=method, hold=hold, linearisation=linearisation, gravity_m_s2=gravity,
        process_noise={name: stated[name] for name in stated if name in inputs},
        measurement_noise={name: stated[name] for name in stated if name in measurements},
        measurement_delay_s=known(delays, measurements, "measurement of the filter"),
        random_walk=known(random_walk, states, "state of the filter"), initial_state=known(initial, states, "state of the filter"),
        initial_deviation=known(initial_std, states, "state of the filter"), outlier_limit=outlier_limit, robust_limit=robust_limit,
        spread=spread, tolerance=tolerance, max_iterations=max_iterations, smoother_passes=passes,
        air_data_deviation=known(air_data_deviation, names["error of the air data"], "error of the air data"),
        **{key: "estimated" if key in estimate else "stated" for key in ("gusts", "delays")},
    )
    preparation = dict(
        path="measured" if measured else "smoothed" if smooth else "filtered", differentiation=differentiation,
        differentiation_half_width_s=differentiation_half_width_s, origin_altitude_m=origin_altitude_m,
        correct_accelerometer=correct_accelerometer, correct_vanes=correct_vanes, correct_antenna=correct_antenna,
    )
    tables = dict(sensor_errors=sensor_errors, loading=loading, aircraft_changes=aircraft_changes)
    if aircraft is None and not (loading is None and aircraft_changes is None):
        raise DoubletError("loading and aircraft_changes need an aircraft: give reconstruct one")
    for table in ("sensor_errors", "loading"):
        for name in tables[table] or {}:
            check_key(f"{table}.{name}")
    settings = dict(filter=stated_only(filter_table), preparation=stated_only(preparation), **stated_only(plain(tables)))
    call = (recording, aircraft, [one._row() for one in given], settings)
    path = Path(_reconstructed(*call, progress), (_reconstructed, call), recording, aircraft)
    path.verdict.warn("flight path")
    return path


def stated_only(table: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a table that have a value, numbers of NumPy as those of Python."""
    plain = {key: value.item() if isinstance(value, np.generic) else value for key, value in table.items()}
    return {key: value for key, value in plain.items() if value is not None}


def _reconstructed(
    recording: Recording, aircraft: Optional[Aircraft], rows: Sequence[Any], settings: dict[str, Any], progress: Progress = None
) -> _doublet.Path:
    plane = None if aircraft is None else aircraft._inner
    return _doublet.Path.reconstruct(recording._inner, plane, rows, json.dumps(settings), progress)
