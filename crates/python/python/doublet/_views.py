"""Paths, coefficients, fits and results as views of the results of one session: reports, exports, proof of match."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Generic, Literal, Optional, Sequence, TypeVar, Union

from ._errors import unknown
from ._replayed import Replayed
from ._table import Table

if TYPE_CHECKING:
    from ._commands import Answer
    from ._recording import PathLike
    from ._session import Results, Session

Inner = TypeVar("Inner")


class View(Replayed[Inner], Generic[Inner]):
    """A view of the results of a session."""

    _results: Optional["Results"] = None

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_results": None}

    def to_session(self) -> "Session":
        """The session of the same recordings, manoeuvres and settings."""
        raise NotImplementedError

    def results(self) -> "Results":
        """The results of :meth:`to_session`, computed once."""
        if self._results is None:
            from ._session import run

            self._results = run(self.to_session())
        return self._results

    def report(
        self,
        out: PathLike,
        *,
        format: Union[Literal["html", "pdf"], Sequence[Literal["html", "pdf"]]] = "html",
        sections: Sequence[str] = (),
        no_appendix: bool = False,
        prior: Optional[PathLike] = None,
    ) -> "Answer":
        """Writes the report of the session, as ``doublet report``; the answer names the files.

        Args:
            out: Folder of the report.
            format: ``"html"``; ``"pdf"`` in a build with the feature ``pdf``.
            sections: Sections; all by default.
            no_appendix: Leave out the appendices.
            prior: CSV file of earlier estimates to compare with.
        """
        from . import commands

        return commands.report(
            self.to_session(), out=out, format=format, sections=list(sections) or None, no_appendix=no_appendix, prior=prior
        )

    def export(self, formats: Union[str, Sequence[str]], folder: PathLike) -> list[str]:
        """Writes the identified model for other simulators, ``"jsbsim"`` and ``"daveml"``; returns the files."""
        several = [formats] if isinstance(formats, str) else list(formats)
        return [os.fspath(path) for path in self.results()._inner.export(several, os.fspath(folder))]

    def match(self) -> Table:
        """Proof of match: every tolerance band of every test of every validation manoeuvre, simulated by the identified model."""
        results, rows = self.results(), []
        for window in (results.to_dict().get("proof_of_match") or {}).get("windows", []):
            if window.get("error"):
                rows.append(dict(window=window["window"], error=window["error"]))
            for test in window.get("tests", []):
                for band in test["bands"]:
                    rows.append(dict(window=window["window"], test=test["id"], passed=test["passed"], **{
                        f"band_{key}" if key == "passed" else key: value for key, value in band.items()}))
        return Table(rows, f"proof of match: {results.verdict.line()}")


def known(values: Any, names: Sequence[str], what: str) -> dict[str, float]:
    """Values by name, each name one that exists."""
    for name in values or {}:
        if str(name) not in names:
            raise unknown(what, name, names)
    return {str(name): float(value) for name, value in (values or {}).items()}


def refuse_others(function: str, others: Any, settings: Sequence[str]) -> None:
    """Refuses arguments that a function does not have, with the nearest ones."""
    for name in others:
        raise unknown(f"argument of {function}", name, settings)
