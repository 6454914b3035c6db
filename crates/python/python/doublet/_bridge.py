"""Recordings in memory as sessions: their samples are written to files that a session can name."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Iterable, Mapping, Optional, Sequence

import numpy as np

from . import _doublet
from ._doublet import DoubletError
from ._fit import _models
from ._mat import write_mat
from ._path import Path
from ._recording import Aircraft, PathLike, Progress, Recording
from ._window import Window, of_one_flight

if TYPE_CHECKING:
    from ._session import Session


class Keeper:
    """A temporary folder with the files of a session; it is removed with the last session that uses it. A pickle holds the files."""

    def __init__(self) -> None:
        self._temporary = tempfile.TemporaryDirectory(prefix="doublet-")
        self.folder = self._temporary.name
        self.former = self.folder

    def __getstate__(self) -> dict[str, Any]:
        files = {path.name: path.read_bytes() for path in FilePath(self.folder).iterdir()}
        return {"files": files, "former": self.folder}

    def __setstate__(self, state: dict[str, Any]) -> None:
        Keeper.__init__(self)
        self.former = state["former"]
        for name, content in state["files"].items():
            (FilePath(self.folder) / name).write_bytes(content)

    def moved(self, inner: _doublet.Session, path: str) -> _doublet.Session:
        """The session with its files beside ``path``."""
        target = os.path.abspath(os.path.splitext(path)[0] + "_recordings")
        shutil.copytree(self.folder, target, dirs_exist_ok=True)
        return _relocated(inner, self.folder, target)


def opened(text: str, folder: str, path: Optional[str], keeper: Optional[Keeper]) -> _doublet.Session:
    """A session that was pickled."""
    inner = _doublet.Session.restore(text, folder, path)
    return inner if keeper is None else _relocated(inner, keeper.former, keeper.folder)


def _relocated(inner: _doublet.Session, former: str, folder: str) -> _doublet.Session:
    """The session with the paths in one folder replaced by those in another."""

    def changed(value: Any) -> Any:
        if isinstance(value, str) and value.startswith(former):
            return folder + value[len(former):]
        if isinstance(value, list):
            return [changed(one) for one in value]
        if isinstance(value, dict):
            return {key: changed(one) for key, one in value.items()}
        return value

    rows: Mapping[str, Any] = json.loads(inner.json())
    keys = [key for key in ("flight", "aircraft") if key in rows]
    return inner.replaced([(key, json.dumps(changed(rows[key]))) for key in keys])


def begin(
    recordings: Sequence[Recording],
    aircraft: Optional[Aircraft],
    windows: Optional[Any],
    model: Optional[Any],
    name: str,
    folder: str,
    progress: Progress,
) -> _doublet.Session:
    """A session of recordings, one per flight, whose files are in ``folder``."""
    os.makedirs(folder, exist_ok=True)
    given = _windows_of(recordings, windows)
    plane = None if aircraft is None else _aircraft_file(aircraft, folder)
    flights: list[Any] = []
    rows: list[dict[str, Any]] = []
    first: Optional[_doublet.Session] = None
    for index, recording in enumerate(recordings):
        flight = name if len(recordings) == 1 else f"{name} {index + 1}"
        files, channel_map = _written(recording, os.path.join(os.path.abspath(folder), f"flight_{index + 1:03}"))
        begun = _doublet.Session.begin(files, flight, channel_map, plane, progress)
        content = json.loads(begun.json())
        flights += content["flight"]
        found = content.get("manoeuvre", []) if given is None else [_window_row(one, flight) for one in given[index]]
        names = {row["name"] for row in rows}
        for row in found:
            rows.append({**row, "name": f"{row['name']} (flight {index + 1})" if row["name"] in names else row["name"]})
        first = first or begun
    assert first is not None
    changes: dict[str, Any] = {"title": name, "flight": flights, "manoeuvre": rows}
    if model is not None:
        changes["model"] = {coefficient: terms for coefficient, terms in _models(model)}
    return first.replaced([(key, json.dumps(value)) for key, value in changes.items()])


def session_of(paths: Sequence[Path], content: str, has_model: bool, name: str, folder: Optional[PathLike]) -> Session:
    """The session of flight paths, one per flight, with the settings of ``content`` (JSON of a session without recordings). Without a
    model it has that of a new session."""
    from ._session import Session

    rows: dict[str, Any] = json.loads(content)
    for key in ("filter", "sensor_errors"):
        if any(json.loads(path._inner.session()).get(key) != rows.get(key) for path in paths):
            raise DoubletError(f"the flights differ in settings of '{key}', which a session has once: reconstruct all flights alike")
    flights = [flight["name"] for flight in rows["flight"]]
    windows = [[_window_of(row) for row in rows["manoeuvre"] if row["flight"] == flight] for flight in flights]
    given: Any = windows[0] if len(paths) == 1 else windows
    session = Session.from_recordings(
        [path.recording for path in paths], aircraft=paths[0].aircraft, windows=given, name=name, folder=folder
    )
    keys = ("filter", "preparation", *(("model", "estimation") if has_model else ()))
    # Arrays take every sample; a session by default takes a held sample once.
    signals = {f"flight.{index}.signals": {"held_samples": "keep"} for index in range(len(paths))}
    aircraft: dict[str, Any] = {key: rows[key] for key in ("aircraft_changes", "loading", "sensor_errors") if key in rows}
    loadings = {f"flight.{index}.loading": flight["loading"] for index, flight in enumerate(rows["flight"]) if "loading" in flight}
    return session.replace({**{key: rows.get(key, {}) for key in keys}, **aircraft, **loadings, **signals})


def _window_of(row: Mapping[str, Any]) -> Window:
    return Window(row["name"], row["start_s"], row["end_s"], row.get("surface"), row.get("kind", ""), row["role"], exclude=excluded(row))


def excluded(row: Mapping[str, Any]) -> tuple[tuple[float, float], ...]:
    """Excluded parts of a manoeuvre of a session."""
    return tuple((part["start_s"], part["end_s"]) for part in row.get("exclude", []))


def _windows_of(recordings: Sequence[Recording], windows: Optional[Any]) -> Optional[list[list[Window]]]:
    """Windows by flight, where they are given."""
    if windows is None:
        return None
    lists = [windows] if len(recordings) == 1 else list(windows)
    if len(lists) != len(recordings):
        raise DoubletError(f"there are {len(recordings)} recordings and {len(lists)} lists of windows: give one list for each")
    return [of_one_flight(several, recording._origin) for recording, several in zip(recordings, lists)]


def _window_row(window: Window, flight: str) -> dict[str, Any]:
    row = dict(name=window.name, flight=flight, start_s=float(window.start), end_s=float(window.end), role=window.role)
    if window.surface is not None:
        row["surface"] = window.surface
    if window.kind:
        row["kind"] = window.kind
    if window.exclude:
        row["exclude"] = [dict(start_s=start, end_s=end) for start, end in window.exclude]
    return row


def _aircraft_file(aircraft: Aircraft, folder: str) -> str:
    """How a session names an aircraft; one described by its numbers is written into the folder."""
    if aircraft.text is None:
        reference = str(aircraft._inner.reference)
        return reference if reference.startswith("builtin:") else os.path.abspath(reference)
    path = os.path.join(os.path.abspath(folder), "aircraft.toml")
    FilePath(path).write_text(aircraft.text, encoding="utf-8")
    return path


def _written(recording: Recording, stem: str) -> tuple[list[str], str]:
    """Writes a recording, a source for the channels of each clock, and its channel map; returns the files. Sources of one file share the
    time line: no session looks for offsets between them."""
    signals = [recording[name] for name in recording]
    clocks: list[list[Any]] = []
    for signal in signals:
        same = next((one for one in clocks if np.array_equal(one[0].time, signal.time)), None)
        if same is None:
            clocks.append([signal])
        else:
            same.append(signal)
    sources, roles = {}, []
    for number, several in enumerate(clocks, start=1):
        source = os.path.basename(stem) if len(clocks) == 1 else f"clock_{number:03}"
        names = _column_names(several)
        sources[source] = {"time": several[0].time, **{name: one.values for name, one in zip(names, several)}}
        for name, signal in zip(names, several):
            if signal.role is not None:
                place = f"channel = {json.dumps(name)}, source = {json.dumps(source)}"
                roles.append(f"{signal.role} = {{ {place}, unit = {json.dumps(signal.unit or '-')} }}")
    head = ['format = "doublet channel map"', "version = 1", 'name = "arrays"', "", "[[time]]", 'channel = "time"', 'unit = "s"']
    channel_map = f"{stem}_map.toml"
    FilePath(channel_map).write_text("\n".join([*head, "", "[roles]", *roles, ""]), encoding="utf-8")
    write_mat(f"{stem}.mat", next(iter(sources.values())) if len(clocks) == 1 else sources)
    return [f"{stem}.mat"], channel_map


def _column_names(signals: Iterable[Any]) -> list[str]:
    """Names of columns: roles by their own, others by that of their channel, each once."""
    names: list[str] = []
    for signal in signals:
        name = signal.role or signal.name
        while name in names or name == "time":
            name += "_"
        names.append(name)
    return names
