"""Verdicts: how far results may be trusted, and why not."""

from __future__ import annotations

import json
from typing import Any, Iterator, Mapping, Sequence

from ._errors import warn
from ._table import Table


class Verdict(Mapping[str, Any]):
    """The judgement of the engine, that of ``doublet run`` for the same data.

    Attributes:
        level: ``"good"``, ``"caution"`` or ``"bad"``.
        findings: A row per finding, worst first: level, place, text, fix, code.
        lines: Findings of one kind in one line.
    """

    def __init__(self, row: Mapping[str, Any]) -> None:
        self._row = dict(row)
        self.level: str = self._row.get("level", "good")
        self.lines: list[str] = list(self._row.get("lines", [reason["text"] for reason in self._row.get("reasons", [])]))

    @classmethod
    def _of(cls, text: str) -> "Verdict":
        return cls(json.loads(text))

    def __getitem__(self, key: str) -> Any:
        return self._row[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._row)

    def __len__(self) -> int:
        return len(self._row)

    @property
    def findings(self) -> Table:
        """A row per finding, worst first."""
        rows = self._row.get("reasons", [])
        keys = dict(level="level", where="where", text="text", fix="fix", code="code")
        return Table([{name: row.get(key) for name, key in keys.items()} for row in rows], f"verdict {self.level}")

    @classmethod
    def _found(cls, findings: Sequence[tuple[str, str, str, str, str]]) -> "Verdict":
        """The verdict of findings: level, code, place, text and fix of each."""
        order = ("bad", "caution")
        rows = sorted(findings, key=lambda row: order.index(row[0]))
        reasons = [dict(level=a, code=b, where=c, text=d, fix=e) for a, b, c, d, e in rows]
        return cls({"level": rows[0][0] if rows else "good", "reasons": reasons})

    def line(self) -> str:
        """Level and most important finding."""
        more = len(self.lines) - 1
        rest = f": {self.lines[0]}" if self.lines else ""
        return f"verdict {self.level}{rest}" + (f" ({more} more in verdict.findings)" if more > 0 else "")

    def warn(self, what: str) -> None:
        """Gives a :class:`DoubletWarning` about ``what`` where it is bad."""
        if self.level == "bad":
            warn(f"{what}: {self.line()}")

    def __repr__(self) -> str:
        return "\n".join([f"verdict {self.level}", *self.lines])

    def _repr_html_(self) -> str:
        return self.findings._repr_html_()
