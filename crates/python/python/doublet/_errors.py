"""Errors and warnings."""

from __future__ import annotations

import difflib
import os
import warnings
from typing import Iterable

from ._doublet import DoubletError


class DoubletKeyError(DoubletError, KeyError):
    """A name that does not exist, with those that do."""

    def __str__(self) -> str:
        return str(self.args[0])


class DoubletFileNotFoundError(DoubletError, FileNotFoundError):
    """A file that does not exist."""

    def __str__(self) -> str:
        return str(self.args[0])


class DoubletWarning(UserWarning):
    """A verdict that is bad, contradictory channels of a recording, or manoeuvres that need more memory than is available."""


def nearest(name: str, known: Iterable[str]) -> str:
    """``: did you mean 'x'?`` where a known name is near, or nothing."""
    found = difflib.get_close_matches(name, list(known), n=1, cutoff=0.55)
    return f": did you mean '{found[0]}'?" if found else ""


def unknown(what: str, name: object, known: Iterable[str]) -> DoubletKeyError:
    """The error of a name that does not exist."""
    names = list(known)
    near = nearest(str(name), names)
    return DoubletKeyError(f"no {what} is called '{name}'{near or ':'} there are {', '.join(names) or 'none'}")


def existing(path: "str | os.PathLike[str]") -> str:
    """The path, where it exists or ships with doublet."""
    text = os.fspath(path)
    if not text.startswith("builtin:") and not os.path.exists(text):
        raise DoubletFileNotFoundError(f"{text}: file not found")
    return text


def warn(text: str) -> None:
    """Warns the caller of the package."""
    package = os.path.dirname(os.path.abspath(__file__))
    warnings.warn(text, DoubletWarning, stacklevel=_depth(package))


def _depth(package: str) -> int:
    """Frames from :func:`warn` to the first one outside the package."""
    import sys

    frame, depth = sys._getframe(1), 1
    while frame.f_back is not None and os.path.dirname(os.path.abspath(frame.f_code.co_filename)) == package:
        frame, depth = frame.f_back, depth + 1
    return depth
