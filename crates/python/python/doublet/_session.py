"""Sessions, the same as those of the workbench, and their results."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Literal, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._bridge import Keeper, begin, excluded, opened
from ._doublet import DoubletError
from ._errors import DoubletKeyError, existing, unknown
from ._fit import information_criterion
from ._keys import below, check_key, plain
from ._predicted import predicted
from ._recording import Aircraft, PathLike, Progress, Recording
from ._replayed import Replayed
from ._rows import FitRow, WindowRow
from ._table import Table, Value, normal_quantile
from ._verdict import Verdict
from ._views import View
from ._window import Window

if TYPE_CHECKING:
    #: A study that a run can add.
    _Study = Literal["sensitivity", "manoeuvres", "checks", "lags", "responses", "monte-carlo", "dynamics", "experiments"]


class Session(Replayed[_doublet.Session]):
    """Recordings, windows, settings, structure. It never changes: :meth:`replace` gives another."""

    def __init__(self, inner: _doublet.Session, keeper: Optional[Keeper] = None) -> None:
        if not isinstance(inner, _doublet.Session):
            raise DoubletError(f"{inner!r} is not a session: use Session.load(path), Session.parse(text) or Session.new(recordings)")
        super().__init__(inner, None)
        self._keeper = keeper

    def __getstate__(self) -> dict[str, Any]:
        place = (self.text, os.path.abspath(os.fspath(self._inner.folder) or "."), self.path)
        return {"_made": None, "_call": (opened, (*place, self._keeper)), "_keeper": self._keeper}

    @classmethod
    def load(cls, path: PathLike) -> "Session":
        """Opens the session file ``path``, or ``"builtin:demo"`` for the one that comes with doublet."""
        return cls(_doublet.Session.load(existing(path)))

    @classmethod
    def parse(cls, text: str, *, folder: PathLike = "") -> "Session":
        """A session from its text; relative paths start from ``folder``."""
        return cls(_doublet.Session.parse(text, os.fspath(folder)))

    @classmethod
    def new(
        cls,
        recordings: Union[PathLike, Sequence[PathLike]],
        *,
        name: Optional[str] = None,
        channel_map: Optional[str] = None,
        aircraft: Optional[PathLike] = None,
        progress: Progress = None,
    ) -> "Session":
        """A session for the recordings of one flight, with the manoeuvres found as windows.

        Args:
            recordings: Files or folders.
            name: Title; by default that of the first file.
            channel_map: File or name; by default the one that fits best, or else a guess.
            aircraft: Aircraft file, or the name of one that comes with doublet; by default only flight paths are computed.
            progress: Called with the part done, 0 to 1. Ctrl-C stops.
        """
        several = [recordings] if isinstance(recordings, (str, os.PathLike)) else list(recordings)
        if any(isinstance(one, Recording) for one in several):
            raise DoubletError("a Recording is not a file: use Session.from_recordings")
        paths = [existing(path) for path in several]
        if not paths:
            raise DoubletError("recordings is empty: give one or more")
        plane = None
        if aircraft is not None:
            found = _doublet.Aircraft.named(os.fspath(aircraft))
            plane = found.reference if (found.reference or "").startswith("builtin:") else os.path.abspath(os.fspath(aircraft))
        return cls(_doublet.Session.begin(paths, name or FilePath(paths[0]).stem, channel_map, plane, progress))

    @classmethod
    def from_recordings(
        cls,
        recordings: Union[Recording, Sequence[Recording]],
        *,
        aircraft: Optional[Aircraft] = None,
        manoeuvres: Optional[Any] = None,
        windows: Optional[Any] = None,
        model: Optional[Any] = None,
        filter: Optional[Mapping[str, Any]] = None,
        preparation: Optional[Mapping[str, Any]] = None,
        estimation: Optional[Mapping[str, Any]] = None,
        sensor_errors: Optional[Mapping[str, Any]] = None,
        loading: Optional[Mapping[str, Any]] = None,
        aircraft_changes: Optional[Mapping[str, Any]] = None,
        settings: Optional[Mapping[str, Any]] = None,
        name: str = "arrays",
        folder: Optional[PathLike] = None,
        progress: Progress = None,
    ) -> "Session":
        """A session of recordings in memory, one per flight.

        Args:
            recordings: Recording, or several.
            aircraft: Aircraft; by default only flight paths are computed.
            manoeuvres: Manoeuvres of the only flight, or a list of them for each flight; by default the manoeuvres found.
            windows: Earlier name of ``manoeuvres``.
            model: Terms of each coefficient, as ``structure`` of :func:`fit`; by default that of every new session.
            filter: Keys of ``[filter]`` of a session file: ``{"method": "ekf", "measurement_noise": {"alpha": 0.002}}``; all others keep
                their default.
            preparation: Keys of ``[preparation]``: ``{"path": "filtered", "settle_s": 1.0}``.
            estimation: Keys of ``[estimation]``: ``{"weights": "huber"}``.
            sensor_errors: Keys of ``[sensor_errors]``.
            loading: Keys of ``[loading]``: fuel, seats and luggage, kg.
            aircraft_changes: Values that override the aircraft file, by its keys joined by dots: ``{"mass.mass_kg": 1400.0}``.
            settings: Any other values by dotted key, as :meth:`replace`.
            name: Title.
            folder: Folder to write the recordings to, made where it does not exist; by default a temporary one, which lasts as
                long as the session. :meth:`save` copies the files of a temporary one beside the session.
            progress: Called with the part done.
        """
        several = [recordings] if isinstance(recordings, Recording) else list(recordings)
        if not several:
            raise DoubletError("recordings is empty: give one or more")
        if manoeuvres is not None and windows is not None:
            raise DoubletError("manoeuvres and windows are the same: give manoeuvres")
        tables = dict(filter=filter, preparation=preparation, estimation=estimation, sensor_errors=sensor_errors, loading=loading)
        changes = {place: value for table, values in tables.items() for place, value in below(table, values or {})}
        if aircraft_changes is not None:
            changes["aircraft_changes"] = dict(aircraft_changes)
        changes.update(settings or {})
        for place in changes:
            check_key(place)
        keeper = Keeper() if folder is None else None
        place = keeper.folder if keeper is not None else os.fspath(folder or "")
        given = windows if manoeuvres is None else manoeuvres
        made = cls(begin(several, aircraft, given, model, name, place, progress), keeper)
        return made.replace(changes) if changes else made

    @property
    def text(self) -> str:
        """The session as its file holds it (TOML)."""
        return self._inner.text

    @property
    def path(self) -> Optional[str]:
        """Its file."""
        return None if self._inner.path is None else os.fspath(self._inner.path)

    def to_dict(self) -> dict[str, Any]:
        """The keys of its file."""
        content: dict[str, Any] = json.loads(self._inner.json())
        return content

    def __getitem__(self, key: str) -> Any:
        """The value at a dotted key: ``session["filter.method"]``, ``session["manoeuvre.0.role"]``."""
        value: Any = self.to_dict()
        for part in key.split("."):
            try:
                value = value[int(part)] if isinstance(value, list) else value[part]
            except (KeyError, IndexError, ValueError, TypeError):
                raise DoubletKeyError(f"the session has no '{key}'") from None
        return value

    @property
    def windows(self) -> list[Window]:
        """The windows that are not ignored."""
        rows = [row for row in self.to_dict().get("manoeuvre", []) if row.get("role") != "ignored"]
        keys = ("surface", "kind", "role", "flight")
        return [
            Window(row["name"], row["start_s"], row["end_s"], exclude=excluded(row), **{k: row[k] for k in keys if row.get(k) is not None})
            for row in rows
        ]

    def replace(self, changes: Optional[Mapping[str, Any]] = None, **tables: Any) -> "Session":
        """The session with other values, checked as its file would be.

        Args:
            changes: By dotted key: ``{"filter.measurement_noise.alpha": 0.002, "manoeuvre.0.role": "validation"}``.
            tables: Whole values of keys at the top: ``title="..."``.
        """
        several = {**(changes or {}), **tables}
        for place in several:
            check_key(place)
        rows = [(key, json.dumps(plain(value))) for key, value in several.items()]
        return Session(self._inner.replaced(rows), self._keeper)

    def save(self, path: PathLike) -> "Session":
        """Saves it to ``path`` in one step, paths written from the new place; the previous file stays as ``*.bak``. Recordings in a
        temporary folder are copied into ``NAME_recordings`` beside it."""
        inner = self._inner if self._keeper is None else self._keeper.moved(self._inner, os.fspath(path))
        return Session(inner.save(os.fspath(path)))

    def check(self) -> dict[str, Any]:
        """The output of ``doublet check --json``: ``findings`` and ``physics``."""
        found: dict[str, Any] = json.loads(self._inner.check())
        return found

    def run(self, **options: Any) -> "Results":
        """As :func:`run`, with its ``options``."""
        return run(self, **options)

    def recording(self, flight: Optional[str] = None) -> Recording:
        """A flight as a run reads it, the first unless it is named: on one time line, instruments and signals treated."""
        rows = [{**row, "role": "ignored"} for row in self.to_dict().get("manoeuvre", [])]
        return computed(self.replace(manoeuvre=rows), [], 1, 1).recording(flight)

    def plot(self, *names: str, flight: Optional[str] = None, axes: Any = None) -> Any:
        """Draws channels of a flight over time with the manoeuvres behind them, one below the other; returns the axes.

        Args:
            names: Roles or channels; by default the deflections and angular rates that are recorded.
            flight: Flight; the first by default.
            axes: Axes to draw on.
        """
        from ._plots import spans

        recording = self.recording(flight)
        shown = names or [role for role in ("delta_e", "delta_a", "delta_r", "p", "q", "r") if role in recording]
        drawn = recording.plot(*shown, axes=axes)
        chosen = flight or next((row["name"] for row in self.to_dict().get("flight", [])), None)
        spans(drawn, [window for window in self.windows if window.flight == chosen])
        return drawn

    def show(self, *, spawn: bool = True) -> Any:
        """Opens it in the workbench, ``spawn`` as for :func:`show`."""
        return show(self, spawn=spawn)

    def __repr__(self) -> str:
        all_ = self.to_dict()
        return f"<doublet.Session '{all_.get('title', '')}': {len(all_.get('flight', []))} flights, {len(all_.get('manoeuvre', []))} manoeuvres>"

    def _repr_html_(self) -> str:
        content = self.to_dict()
        flights = [dict(flight=row["name"], recordings=len(row.get("recording", []))) for row in content.get("flight", [])]
        keys = ("name", "flight", "start_s", "end_s", "surface", "kind", "role")
        windows = [{key: row.get(key) for key in keys} for row in content.get("manoeuvre", [])]
        return Table(flights, str(content.get("title", "")))._repr_html_() + Table(windows, "manoeuvres")._repr_html_()


class Derivatives(dict[str, Value]):
    """Derivatives by name."""

    def __missing__(self, name: str) -> Value:
        raise unknown("derivative", name, self)


class Results(View[_doublet.Results]):
    """Results of a session. :meth:`to_dict` is identical to ``results.json``. A pickle holds these numbers; ``cov``, ``states``,
    ``measurements``, ``simulate``, ``recording``, ``write`` and ``export`` then run the session again."""

    def __init__(self, inner: _doublet.Results, call: Any) -> None:
        super().__init__(inner, call)
        self._all: dict[str, Any] = json.loads(inner.json())
        self._failures: list[tuple[str, str]] = inner.failures()

    def to_dict(self) -> dict[str, Any]:
        """The content of ``results.json``."""
        return self._all

    def to_session(self) -> Session:
        """The session they are of."""
        assert self._call is not None, "results have the call that made them"
        session: Session = self._call[1][0]
        return session

    def results(self) -> "Results":
        """These results."""
        return self

    @property
    def verdict(self) -> Verdict:
        """``level`` (``good``, ``caution``, ``bad``) and ``findings``; also a mapping of ``level`` and ``reasons``."""
        return Verdict(self._all.get("verdict") or {})

    @property
    def derivatives(self) -> Derivatives:
        """Pooled derivatives by name, with corrected errors."""
        rows = [row for fit in self.fits for row in fit.get("derivatives", [])]
        errors = [row["corrected_standard_error"] for row in rows]
        values = [Value(row["estimate"], float("nan") if error is None else error) for row, error in zip(rows, errors)]
        return Derivatives({row["name"]: value for row, value in zip(rows, values)})

    def conf_int(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Ends of the intervals of ``level`` by name."""
        times = normal_quantile(level)
        return {name: (value - times * value.stderr, value + times * value.stderr) for name, value in self.derivatives.items()}

    @property
    def cov(self) -> NDArray[np.float64]:
        """Covariance of all derivatives in the order of ``derivatives``, shape (p, p), by corrected errors. Residuals of several coefficients
        in the same samples are correlated: their derivatives have the covariance that follows."""
        return self._inner.covariance()

    @property
    def nobs(self) -> dict[str, int]:
        """Samples by coefficient."""
        return {fit["coefficient"]: fit["samples"] for fit in self.fits if fit.get("derivatives")}

    @property
    def aic(self) -> dict[str, float]:
        """Akaike's criterion of white normal residuals by coefficient; compare structures over the same windows only. Not a number
        with weights or constraints, of which ``results.json`` does not have the plain residuals."""
        estimation = self.to_session().to_dict().get("estimation", {})
        is_plain = estimation.get("weights", "equal") == "equal"
        return {fit["coefficient"]: _criterion(fit) if is_plain else float("nan") for fit in self.fits if fit.get("derivatives")}

    @property
    def predictions(self) -> Table:
        """How well the estimate predicts each window: R² with the constants of the identification and with its own constant."""
        keys = dict(window="window", role="role", coefficient="coefficient", r2_identified_constants="r_squared_identified_constants",
                    r2_own_constant="r_squared_own_constant")
        return Table([{name: row.get(key) for name, key in keys.items()} for row in self._all["predictions"]], "predictions")

    def predict(self, coefficient: str, X: Any, *, manoeuvre: Optional[str] = None) -> NDArray[np.float64]:
        """Values of a coefficient at new regressors by the pooled estimates, shape (m,).

        Args:
            coefficient: Coefficient, ``"Cm"``.
            X: Coefficients of a window, or a frame with the variables of the model, ``alpha``, ``delta_e`` (rad), ``qc/V`` (dimensionless),
                as columns, found by name; a term that is a column itself is used as it is. Or an array with a column for each fitted
                term without the constant, in the order of the model.
            manoeuvre: The one whose constant counts; by default their mean, where each has its own.

        Raises:
            DoubletKeyError: The results do not have the coefficient, the frame lacks a variable, or the manoeuvre has no constant.
            DoubletError: The coefficient has no estimate, or an array has another number of columns.
        """
        found = next((fit for fit in self.fits if fit["coefficient"] == coefficient), None)
        if found is None:
            raise unknown("coefficient of the results", coefficient, [fit["coefficient"] for fit in self.fits])
        if found.get("error"):
            raise DoubletError(f"{coefficient}: {found['error']}")
        estimates = {row["name"]: row["estimate"] for row in found["derivatives"]}
        return predicted(coefficient, self.to_session().to_dict()["model"][coefficient], estimates, X, manoeuvre)

    @property
    def fits(self) -> list[FitRow]:
        """``pooled`` of ``results.json``."""
        rows: list[FitRow] = self._all["pooled"]
        return rows

    @property
    def windows(self) -> list[WindowRow]:
        """``windows`` of ``results.json``."""
        rows: list[WindowRow] = self._all["windows"]
        return rows

    @property
    def table(self) -> Table:
        """A row per pooled derivative."""
        rows = []
        for fit in self.fits:
            for row in fit.get("derivatives", []):
                verdict = (row.get("verdict") or {}).get("level")
                rows.append(
                    dict(derivative=row["name"], estimate=row["estimate"], stderr=row["corrected_standard_error"],
                         stderr_white=row["standard_error"], relative_percent=row["relative_error_percent"], verdict=verdict)
                )
        return Table(rows, f"{self._all['title']}: {self.verdict.line()}")

    def study(self, name: str) -> Table:
        """The table of the study ``name`` of the run: ``sensitivity``, ``tornado``, ``leave_one_out``, ``input_kinds``,
        ``contributions``, ``conditions``, ``checks``, ``lags``, ``monte_carlo``."""
        rows = self._all["studies"].get(name)
        if not rows:
            known = ", ".join(key for key, value in self._all["studies"].items() if value) or "none"
            raise DoubletError(f"no table of a study is called '{name}': there are {known}; add it by run(studies=...)")
        return Table(rows, name)

    @property
    def failures(self) -> list[tuple[str, str]]:
        """Failed steps: place and reason."""
        return self._failures

    def states(self, window: str) -> dict[str, Any]:
        """``time`` (s) and the smoothed states of a window by name, filtered where it was not smoothed; SI."""
        return self._inner.states(window)

    def measurements(self, manoeuvre: str) -> dict[str, dict[str, NDArray[np.float64]]]:
        """As :attr:`WindowPath.measurements`, of a ``manoeuvre``."""
        self._known(manoeuvre)
        return self._inner.measurements(manoeuvre)

    def simulate(self, manoeuvre: str) -> dict[str, dict[str, NDArray[np.float64]]]:
        """As :meth:`Fit.simulate`, of a ``manoeuvre``."""
        self._known(manoeuvre)
        return self._inner.simulated(manoeuvre)

    def _known(self, manoeuvre: str) -> None:
        """Refuses a manoeuvre that the session does not use."""
        names = [row["name"] for row in self.windows]
        if manoeuvre not in names:
            raise unknown("manoeuvre", manoeuvre, names)

    def recording(self, flight: Optional[str] = None) -> Recording:
        """A flight as the run read it, the first unless it is named: on one time line, instruments and signals treated."""
        return Recording(self._inner.recording(flight), (_recorded, (self, flight)))

    def write(
        self, folder: PathLike, *, tables: Sequence[str] = ("csv",), histories: Sequence[str] = ("hdf5",)
    ) -> str:
        """Writes what ``doublet run --out`` writes; returns the folder.

        Args:
            folder: Folder.
            tables: Formats of tables: ``"csv"`` and others of the command.
            histories: Formats of time histories: ``"hdf5"`` and others of the command.
        """
        return str(self._inner.write(os.fspath(folder), list(tables), list(histories)))

    def summary(self) -> str:
        """Verdict and derivatives as text."""
        return self.table.summary()

    def plot(self, coefficient: str, *, axes: Any = None) -> Any:
        """Draws the derivatives of a coefficient with their 95 % intervals; returns the axes."""
        from ._plots import intervals

        rows = [(n, v.value, v.stderr) for n, v in self.derivatives.items() if n.startswith(coefficient + "_") and not n.endswith("]")]
        if not rows:
            raise unknown("coefficient", coefficient, [fit["coefficient"] for fit in self.fits])
        axis = intervals(rows, "", axes)
        axis.set_xlabel("estimate and 95 % interval [per rad; rates non-dimensional]")
        return axis

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


def _criterion(fit: Mapping[str, Any]) -> float:
    if any(row.get("held") for row in fit["derivatives"]):
        return float("nan")
    count, parameters = fit["samples"], len(fit["derivatives"])
    return information_criterion(fit["residual_deviation"] ** 2 * (count - parameters), count, parameters)


def run(
    session: Session,
    *,
    studies: Sequence[_Study] = (),
    realisations: int = 200,
    seed: int = 1,
    progress: Progress = None,
) -> Results:
    """Computes everything a session asks for: the same numbers, bit for bit, as ``doublet run``.

    Args:
        studies: ``sensitivity``, ``manoeuvres``, ``checks``, ``lags``, ``responses``, ``monte-carlo``, ``dynamics``, ``experiments``.
        realisations: Of ``monte-carlo``.
        seed: Of ``monte-carlo``.
        progress: Called with the part done, 0 to 1. Ctrl-C stops; other Python threads run meanwhile.

    Raises:
        DoubletError: The session has an error, or no manoeuvre has a path. Failed steps beside others are ``results.failures``.

    Warns:
        DoubletWarning: The verdict on the session is bad; or, before the manoeuvres are computed, they need more memory than is available.
    """
    results = computed(session, studies, realisations, seed, progress)
    results.verdict.warn("run")
    return results


def computed(session: Session, studies: Sequence[_Study], realisations: int, seed: int, progress: Progress = None) -> Results:
    """Results of a session, without a warning."""
    call = (session, list(studies), realisations, seed)
    return Results(_computed(*call, progress), (_computed, call))


def _computed(
    session: Session, studies: Sequence[_Study], realisations: int, seed: int, progress: Progress = None
) -> _doublet.Results:
    return session._inner.run(studies, realisations, seed, progress)


def _recorded(results: Results, flight: Optional[str]) -> _doublet.Recording:
    return results._inner.recording(flight)


def match(results: View[Any]) -> Table:
    """As :meth:`Results.match` of ``results``, also of a fit, coefficients or a path.

    Raises:
        DoubletError: Its session cannot be run.
    """
    return results.match()


def export(results: View[Any], formats: Union[str, Sequence[str]], folder: PathLike) -> list[str]:
    """As :meth:`Results.export` of ``results`` with ``formats`` and ``folder``, also of a fit, coefficients or a path.

    Raises:
        DoubletError: A format that does not exist, a folder that cannot be written, or no identified model.
    """
    return results.export(formats, folder)


def simulate(
    scenario: str = "demo",
    *,
    out: Optional[PathLike] = None,
    seed: int = 1,
    derivatives: Optional[Mapping[str, float]] = None,
    progress: Progress = None,
) -> list[str]:
    """Flies a simulated flight whose every answer is known and writes its recordings and its truth; returns the files.

    Args:
        scenario: Name; ``doublet simulate --list`` names them.
        out: Folder, which must not exist; a temporary one by default.
        seed: Of noise, gusts and hand-flown imperfections: the same seed gives the same bytes.
        derivatives: Other values of the truth's derivatives.
        progress: Called with the part done, 0 to 1. Ctrl-C stops.

    Raises:
        DoubletError: An unknown scenario or derivative, or a folder that exists.
    """
    folder = os.path.join(tempfile.mkdtemp(prefix="doublet-"), "flight") if out is None else os.fspath(out)
    changed = [(name, float(value)) for name, value in (derivatives or {}).items()]
    return [os.fspath(path) for path in _doublet.simulate(scenario, folder, seed, changed, progress)]


def show(obj: Union[Session, PathLike], *, spawn: bool = True) -> Any:
    """Opens a session in the workbench (the program ``doublet`` on the path, or that which ``DOUBLET`` names).

    Args:
        obj: Session or its file. One without a file is saved to a temporary one first.
        spawn: Return at once with the process; otherwise wait until the window closes and return the session as it was saved.

    Raises:
        DoubletError: The program is not found.
    """
    program = os.environ.get("DOUBLET") or shutil.which("doublet")
    if program is None:
        raise DoubletError("the program doublet is not on the path: install it, or name it by the variable DOUBLET")
    session = obj if isinstance(obj, Session) else Session.load(os.fspath(obj))
    path = session.path
    if path is None:
        path = os.path.join(tempfile.mkdtemp(prefix="doublet-"), "session.toml")
        session.save(path)
    process = subprocess.Popen([program, path])
    if spawn:
        return process
    process.wait()
    return Session.load(path)
