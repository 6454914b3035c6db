"""Functions of the command line: one for each command, made from the table of the program, each run in a process of its own."""

from __future__ import annotations

import csv
import inspect
import json
import keyword
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path as FilePath
from typing import Any, Callable, Iterable, Mapping, Optional, Protocol, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._doublet import DoubletError
from ._errors import warn
from ._frames import column, columns_of, is_dated, numeric, seconds, stated_seconds
from ._recording import Aircraft, Recording
from ._session import Session
from ._table import Table
from ._verdict import Verdict


class Frame(Protocol):
    """A frame of pandas, polars, xarray or pyarrow, or a mapping of arrays."""

    def __getitem__(self, key: Any, /) -> Any: ...


#: A value of an argument.
Scalar = Union[str, int, float, "os.PathLike[str]"]
#: A value, or an object as the file a command reads.
Input = Union[Scalar, Session, Aircraft, Recording, Frame, Sequence[Scalar]]
#: The value of an argument that repeats.
Many = Union[Input, Sequence[Input], Mapping[str, Scalar]]

#: Exit code of a command that found something bad.
_BAD = 3


class Answer(dict[str, Any]):
    """The JSON document of a command. A list is under ``rows``, several documents under ``documents``, text under ``text``.

    Attributes:
        command: Name of the command.
        is_bad: Whether the command found something bad (exit code 3).
        notes: Lines of the command on standard error.
    """

    def __init__(self, document: Mapping[str, Any], command: str, is_bad: bool, notes: Sequence[str]) -> None:
        super().__init__(document)
        self.command, self.is_bad, self.notes = command, is_bad, list(notes)

    def __reduce__(self) -> tuple[type["Answer"], tuple[dict[str, Any], str, bool, list[str]]]:
        return Answer, (dict(self), self.command, self.is_bad, self.notes)

    @property
    def verdict(self) -> Optional[Verdict]:
        """The verdict, where the document has one."""
        found = self.get("verdict")
        return Verdict(found) if isinstance(found, Mapping) else None

    def __repr__(self) -> str:
        level = self.verdict.level if self.verdict is not None else "bad" if self.is_bad else ""
        return f"<doublet.Answer of {self.command}: {', '.join(self) or 'empty'}{f'; verdict {level}' if level else ''}>"

    def __str__(self) -> str:
        return str(self["text"]) if set(self) == {"text"} else dict.__repr__(self)

    def _repr_html_(self) -> str:
        tables = {key: Table(value, key) for key, value in self.items() if _are_rows(value) and key != "tables"}
        rest = [dict(key=key, value=_shown(value)) for key, value in self.items() if key not in ("tables", *tables)]
        return "".join(one._repr_html_() for one in [Table(rest, repr(self)[1:-1]), *self.tables, *tables.values()])

    @property
    def tables(self) -> list[Table]:
        """The tables of a command that has no document of its own."""
        return [Table([dict(zip(one["columns"], row)) for row in one["rows"]], self.command) for one in self.get("tables", [])]


def _are_rows(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(row, Mapping) for row in value)


def _shown(value: Any) -> str:
    """A value of a document in a line."""
    if isinstance(value, Mapping):
        return f"{len(value)} keys: {', '.join(list(value)[:8])}"
    return str(value)[:200]


def call(name: Sequence[str], arguments: Sequence[str], has_json: bool = True) -> Answer:
    """Runs a command with its arguments as on the command line.

    Raises:
        DoubletError: The line of error of the command.

    Warns:
        DoubletWarning: The command found something bad.
    """
    if not sys.executable:
        raise DoubletError("this Python has no program (sys.executable): commands run in a process of their own and need one")
    runner = FilePath(__file__).with_name("_command_line.py")
    line = [sys.executable, "-I", str(runner), _doublet.__file__, *name, *(["--json"] if has_json else []), *arguments]
    done = subprocess.run(line, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace")
    command, notes = " ".join(name), [text for text in done.stderr.splitlines() if text.strip()]
    if done.returncode not in (0, _BAD):
        raise DoubletError(_error(command, done.returncode, done.stderr))
    answer = Answer(_document(done.stdout), command, done.returncode == _BAD, notes)
    if answer.is_bad:
        verdict = answer.verdict
        warn(f"{command}: {'something is bad' if verdict is None else verdict.line()}")
    return answer


def _error(command: str, code: int, stderr: str) -> str:
    """The error of a command; of wrong arguments the part before the usage."""
    text = stderr.split("\n\nUsage:")[0].split("\n\nFor more information")[0].strip()
    lines = [line.removeprefix("error: ").strip() for line in text.splitlines() if line.strip()]
    return "\n".join(lines) or f"the process of '{command}' ended with code {code}"


def _document(stdout: str) -> dict[str, Any]:
    try:
        found = json.loads(stdout)
    except ValueError:
        try:
            return {"documents": [json.loads(line) for line in stdout.splitlines() if line.strip()]}
        except ValueError:
            return {"text": stdout}
    return found if isinstance(found, dict) else {"rows": found}


class Inputs:
    """Objects as the files a command reads; they last as long as it runs."""

    def __init__(self) -> None:
        self._temporary = tempfile.TemporaryDirectory(prefix="doublet-")
        self._sessions: dict[str, str] = {}
        self._count = 0

    def __enter__(self) -> "Inputs":
        return self

    def __exit__(self, *_: object) -> None:
        self._temporary.cleanup()

    def file(self, name: str, text: str = "") -> FilePath:
        """A new file."""
        self._count += 1
        path = FilePath(self._temporary.name) / str(self._count) / name
        path.parent.mkdir()
        path.write_text(text, encoding="utf-8")
        return path

    def text(self, value: Any, separator: str = ",") -> str:
        """A value as an argument: objects as files, sequences joined."""
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, (str, int, float)):
            return str(value)
        if isinstance(value, os.PathLike):
            return str(os.fspath(value))
        if isinstance(value, Session):
            path = str(self.file("session.toml"))
            self._sessions[path] = value.save(path).text
            return path
        if isinstance(value, Aircraft):
            return str(value._inner.reference) if value.text is None else str(self.file("aircraft.toml", value.text))
        if getattr(value, "ndim", None) == 1 and hasattr(value, "tolist"):
            value = value.tolist()
        if isinstance(value, (list, tuple, range)):
            return separator.join(self.text(one) for one in value)
        return str(self.table(value))

    def table(self, frame: Any) -> FilePath:
        """A frame, or the channels with a role of a recording on the time of the first, as a CSV file."""
        names, columns = _channels(frame) if isinstance(frame, Recording) else _columns(frame)
        path = self.file("table.csv")
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows(zip(*[["" if value != value else repr(value) for value in one] for one in columns]))
        return path

    def refuse_changes(self, command: str) -> None:
        """A command that changed the file of a session in memory has changed nothing that lasts."""
        for path, text in self._sessions.items():
            if Session.load(path).text != text:
                raise DoubletError(f"{command} changes the file of a session: save the session and give its path")


def _channels(recording: Recording) -> tuple[list[str], list[list[float]]]:
    signals = [recording[role] for role in recording.roles]
    if not signals:
        raise DoubletError("the recording has no channel with a role: name its columns by roles")
    time = signals[0].time
    columns = [time, *(np.interp(time, one.time, one.values) for one in signals)]
    return ["time", *recording.roles], [one.tolist() for one in columns]


def time_column(names: Sequence[str]) -> Optional[str]:
    """The column of time among columns."""
    return next((name for name in ("time", "t", "time_s", "t_s") if name in names), None)


def _columns(frame: Any) -> tuple[list[str], list[list[float]]]:
    """Names and values of the columns of numbers; the index is the time where no column is."""
    found = columns_of(frame)
    names, columns = [], []
    time = time_column(found.names)
    if time is None and found.stamps is not None and _is_time(found.stamps):
        names.append("time")
        columns.append(stated_seconds(found.stamps, found.units.get("time", "")).tolist())
    for name in found.names:
        values = found.get(name)
        plain = stated_seconds(values, found.units.get(name, "")) if name == time else _as_numbers(values, f"column '{name}'")
        if plain is not None:
            names.append(name)
            columns.append(plain.tolist())
    return names, columns


def _as_numbers(values: Any, name: str) -> Optional[NDArray[np.float64]]:
    """A column of numbers, or of times as seconds; ``None`` of anything else."""
    if numeric(values):
        return column(values, name)
    try:
        return seconds(values, name=name) if is_dated(values) else None
    except DoubletError:
        return None


def _is_time(index: Any) -> bool:
    """Whether an index is a time, not the number of the row."""
    return getattr(index, "name", "time") is not None or is_dated(index) or np.asarray(index).dtype.kind == "f"


def _options(name: str, row: Mapping[str, Any], value: Any, inputs: Inputs) -> list[str]:
    """An argument with its value, as often as it has values."""
    if value is None:
        return []
    option = None if row["long"] is None else f"--{row['long']}"
    if not row["takes_value"]:
        return [str(option)] if _is_set(name, value) else []
    if isinstance(value, (bool, np.bool_)):
        raise DoubletError(f"{name} is {bool(value)}: give a value, or leave it out")
    separator = _separator(row["value"] or "")
    if row["repeats"] and isinstance(value, Mapping):
        texts = [f"{key}={inputs.text(one, separator)}" for key, one in value.items()]
    else:
        texts = [inputs.text(one, separator) for one in (_several(value, separator != ",") if row["repeats"] else [value])]
    return texts if option is None else [f"{option}={text}" for text in texts]


def _is_set(name: str, value: Any) -> bool:
    """Whether a switch is set."""
    if isinstance(value, (bool, np.bool_)) or (isinstance(value, (int, np.integer)) and value in (0, 1)):
        return bool(value)
    raise DoubletError(f"{name} is {value!r}: give True or False")


def _separator(shown: str) -> str:
    """Separator of the numbers of a value such as ``LOW..HIGH``, ``START:END`` or ``S,S``."""
    return ".." if re.search(r"\w\.\.\w", shown) else ":" if ":" in shown else ","


def _several(value: Any, are_ranges: bool) -> Iterable[Any]:
    """Values of an argument that repeats; two numbers of a range belong together."""
    if isinstance(value, range) or hasattr(value, "tolist"):
        value = list(value) if isinstance(value, range) else value.tolist()
    if not isinstance(value, (list, tuple)):
        return [value]
    is_one = are_ranges and len(value) == 2 and all(isinstance(one, (int, float, np.number)) for one in value)
    return [value] if is_one else value


def python_name(text: str) -> str:
    """A name of the command line as one of Python: ``monte_carlo``, ``with_``."""
    name = text.replace("-", "_")
    return f"{name}_" if keyword.iskeyword(name) else name


def table() -> list[dict[str, Any]]:
    """Every command: ``name``, ``about``, ``has_json`` and ``arguments``, as the command line has them."""
    rows: list[dict[str, Any]] = json.loads(_doublet.command_table())
    return rows


def parameters(row: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """Arguments of a command by their names in Python: those with a place, then required ones, then the others."""
    weight = lambda one: (one["long"] is not None, not one["required"])
    return [(python_name(one["long"] or one["name"]), one) for one in sorted(row["arguments"], key=weight)]


def _signature(row: Mapping[str, Any]) -> inspect.Signature:
    found = []
    for name, one in parameters(row):
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD if one["long"] is None else inspect.Parameter.KEYWORD_ONLY
        default = inspect.Parameter.empty if one["required"] else (None if one["takes_value"] else False)
        found.append(inspect.Parameter(name, kind, default=default))
    return inspect.Signature(found)


def _documentation(row: Mapping[str, Any]) -> str:
    lines = [row["about"] or "", "", f"``doublet {' '.join(row['name'])}``.", "", "Args:"]
    for name, one in parameters(row):
        notes = [f"one of {', '.join(one['choices'])}" if one["choices"] else "", f"default {one['default']}" if one["default"] else ""]
        shown = "; ".join(note for note in notes if note)
        lines.append(f"    {name}: {one['help'] or ''}{f' [{shown}]' if shown else ''}")
    return "\n".join([*lines, "", "Returns:", "    The document of ``--json``.", ""])


def function(row: Mapping[str, Any], module: str) -> Callable[..., Answer]:
    """The function of a command."""
    signature, several = _signature(row), parameters(row)

    def command(*arguments: Any, **options: Any) -> Answer:
        given = signature.bind(*arguments, **options).arguments
        with Inputs() as inputs:
            texts = {name: _options(name, one, given.get(name), inputs) for name, one in several}
            named = [text for name, one in several if one["long"] is not None for text in texts[name]]
            placed = [text for name, one in several if one["long"] is None for text in texts[name]]
            answer = call(row["name"], [*named, *(["--", *placed] if placed else [])], row["has_json"])
            inputs.refuse_changes(" ".join(row["name"]))
        return answer

    command.__name__ = command.__qualname__ = python_name("_".join(row["name"]))
    command.__module__, command.__doc__ = module, _documentation(row)
    command.__signature__ = signature  # type: ignore[attr-defined]
    return command
