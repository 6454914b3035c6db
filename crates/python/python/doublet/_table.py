"""Rows with names: printed as text, shown as HTML, handed on to pandas, polars, xarray and Arrow."""

from __future__ import annotations

import html
from statistics import NormalDist
from typing import Any, Iterator, Mapping, Optional, Sequence

import numpy as np

from ._doublet import DoubletError


def normal_quantile(level: float) -> float:
    """Half width of an interval of ``level`` in standard errors."""
    if not 0.0 < level < 1.0:
        raise DoubletError(f"level is {level}: give a part between 0 and 1, such as 0.95")
    return NormalDist().inv_cdf(0.5 + 0.5 * level)


class Value(float):
    """A number with its standard error. It calculates, compares and formats as its estimate: results are plain numbers without an
    error, which :func:`propagate` and :meth:`to_uncertainties` carry on.

    Attributes:
        value: Estimate, SI.
        stderr: Standard error, corrected for correlated residuals where there are any; not a number where it is held.
        unit: Unit, empty where it has none.
    """

    stderr: float
    unit: str

    def __new__(cls, value: float, stderr: float, unit: str = "") -> "Value":
        made = super().__new__(cls, value)
        made.stderr, made.unit = float(stderr), unit
        return made

    def __reduce__(self) -> tuple[type["Value"], tuple[float, float, str]]:
        return Value, (self.value, self.stderr, self.unit)

    @property
    def value(self) -> float:
        """Estimate, SI."""
        return float(self)

    @property
    def interval(self) -> tuple[float, float]:
        """Ends of the 95 % interval."""
        half = normal_quantile(0.95) * self.stderr
        return self.value - half, self.value + half

    def to_uncertainties(self) -> Any:
        """The value as ``uncertainties.ufloat``."""
        import uncertainties

        return uncertainties.ufloat(self.value, self.stderr)

    def __str__(self) -> str:
        return f"{self.value:.5g} ± {self.stderr:.2g}{' ' + self.unit if self.unit else ''}"

    def __repr__(self) -> str:
        return f"<{self}>"

    def _repr_html_(self) -> str:
        low, high = self.interval
        return Table([dict(estimate=self.value, stderr=self.stderr, low_95=low, high_95=high, unit=self.unit or None)])._repr_html_()

    def __format__(self, form: str) -> str:
        return format(self.value, form) if form else str(self)


class Columnar:
    """Columns of equal length, for polars and Arrow. pandas has the time as its index, these have it as the column ``time``, s."""

    def _columns(self) -> dict[str, Any]:
        """Columns by name."""
        raise NotImplementedError

    def to_polars(self) -> Any:
        """A ``polars.DataFrame`` with the column ``time``, s."""
        import polars

        return polars.DataFrame(self._columns())

    def to_arrow(self) -> Any:
        """A ``pyarrow.Table`` with the column ``time``, s."""
        import pyarrow

        return pyarrow.table(self._columns())

    def __arrow_c_stream__(self, requested_schema: Optional[object] = None) -> object:
        return self.to_arrow().__arrow_c_stream__(requested_schema)


def stacked(parts: Sequence[Mapping[str, Any]], names: Sequence[str]) -> dict[str, Any]:
    """Columns of several windows below each other, with the column ``window``; values that a window lacks are not numbers."""
    keys = list(dict.fromkeys(key for part in parts for key in part))
    lengths = [len(part["time"]) for part in parts]
    whole: dict[str, Any] = {"window": np.repeat(np.asarray(names, dtype=str), lengths)}
    for key in keys:
        whole[key] = np.concatenate([part.get(key, np.full(n, np.nan)) for part, n in zip(parts, lengths)])
    return whole


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return "" if value != value else f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(_cell(item) for item in value)
    return str(value)


class Table(Sequence[Mapping[str, Any]]):
    """Rows of the same columns, in order. It prints as text, shows as HTML in a notebook and becomes a frame by
    :meth:`to_pandas` or :meth:`to_polars`; where pyarrow is installed it is an Arrow stream too."""

    def __init__(self, rows: Sequence[Mapping[str, Any]], title: str = "") -> None:
        self._rows = [dict(row) for row in rows]
        self.title = title
        self.columns: list[str] = list(dict.fromkeys(key for row in self._rows for key in row))

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, str):
            return [row.get(index) for row in self._rows]
        return self._rows[index]

    def __iter__(self) -> Iterator[Mapping[str, Any]]:
        return iter(self._rows)

    def where(self, **values: Any) -> "Table":
        """The rows whose columns have these values."""
        return Table([row for row in self._rows if all(row.get(k) == v for k, v in values.items())], self.title)

    def summary(self) -> str:
        """The table as text, a line per row."""
        cells = [[_cell(row.get(column)) for column in self.columns] for row in self._rows]
        widths = [max([len(column), *(len(row[k]) for row in cells)]) for k, column in enumerate(self.columns)]

        def line(row: Sequence[str]) -> str:
            parts = [text.ljust(w) if k == 0 else text.rjust(w) for k, (text, w) in enumerate(zip(row, widths))]
            return "  ".join(parts).rstrip()

        head = [self.title] if self.title else []
        return "\n".join([*head, line(self.columns), *(line(row) for row in cells)])

    __str__ = summary

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{html.escape(column)}</th>" for column in self.columns)
        rows = "".join(
            "<tr>" + "".join(f"<td>{html.escape(_cell(row.get(column)))}</td>" for column in self.columns) + "</tr>"
            for row in self._rows
        )
        caption = f"<caption>{html.escape(self.title)}</caption>" if self.title else ""
        return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"

    def to_dict(self) -> dict[str, list[Any]]:
        """Columns by name."""
        return {column: [row.get(column) for row in self._rows] for column in self.columns}

    def to_pandas(self) -> Any:
        """A ``pandas.DataFrame``."""
        import pandas

        return pandas.DataFrame(self.to_dict())

    def to_polars(self) -> Any:
        """A ``polars.DataFrame``."""
        import polars

        return polars.DataFrame(self.to_dict())

    def __arrow_c_stream__(self, requested_schema: Optional[object] = None) -> object:
        import pyarrow

        return pyarrow.table(self.to_dict()).__arrow_c_stream__(requested_schema)
