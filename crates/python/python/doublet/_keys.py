"""Keys of session files, and values as they hold them."""

from __future__ import annotations

import json
from typing import Any, Iterator, Mapping

import numpy as np

from . import _doublet
from ._errors import unknown


def below(place: str, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Values of a table by dotted key; a table inside it keeps its other values."""
    for name, value in values.items():
        key = f"{place}.{name}"
        yield from below(key, value) if isinstance(value, Mapping) else [(key, value)]


def check_key(place: str) -> None:
    """Refuses a dotted key that a session file does not have, with the nearest one."""
    node, above = _schema(), ""
    for part in place.split("."):
        keys = node.get("properties", {})
        if part in keys:
            node = keys[part]
        elif part.isdigit() and isinstance(node.get("items"), dict):
            node = node["items"]
        elif keys and node.get("additionalProperties") is False:
            raise unknown("key of a session", f"{above}{part}", [f"{above}{one}" for one in keys])
        else:
            return
        above += f"{part}."


#: The schema of session files, read when it is first needed.
_SCHEMA: dict[str, Any] = {}


def _schema() -> dict[str, Any]:
    if not _SCHEMA:
        _SCHEMA.update(json.loads(_doublet.session_schema()))
    return _SCHEMA


def plain(value: Any) -> Any:
    """A value of NumPy as one of Python."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    return value
