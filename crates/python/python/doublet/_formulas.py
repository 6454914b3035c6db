"""Formulas such as ``"Cm ~ 1 + alpha + delta_e"``."""

from __future__ import annotations

import re
from typing import Any, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ._doublet import DoubletError
from ._errors import unknown
from ._frames import Columns, column

#: A minus sign that is not that of an exponent.
_MINUS = re.compile(r"(?<!\^)-")


def formula(text: str, known: Iterable[str] = ()) -> list[str]:
    """Terms of ``"1 + alpha + delta_e"``. The constant is the term ``1``. A term among ``known`` may have a minus sign in its name."""
    terms = [term.strip().replace("**", "^") for term in text.split("+")]
    if not all(terms):
        raise DoubletError(f"'{text}' has an empty term: write it as '1 + alpha + delta_e'")
    names = set(known)
    if any(term not in names and _MINUS.search(term.replace(" ", "")) for term in terms):
        raise DoubletError(f"'{text}' has a minus sign: write '+', as the estimate has the sign; leave '1' out for a fit without constant")
    return terms


def terms_of(given: Any) -> list[str]:
    """Terms of a formula or of a sequence of terms."""
    return formula(given) if isinstance(given, str) else [str(term) for term in given]


def halves_of(text: str) -> tuple[str, str]:
    """Both sides of a formula."""
    left, tilde, right = (part.strip() for part in text.partition("~"))
    if not (tilde and left and right):
        raise DoubletError(f"'{text}' is not a formula: write it as 'Cm ~ 1 + alpha + delta_e'")
    return left, right


def term_columns(found: Columns, terms: Sequence[str]) -> NDArray[np.float64]:
    """Columns of terms of a frame, shape (n, p)."""
    if not found.names:
        raise DoubletError("the frame has no columns: give one for each variable of the formula")
    count = len(column(found.get(found.names[0]), f"column '{found.names[0]}'")) if "1" in terms and "1" not in found.names else 0
    return np.column_stack([_term(found, term, count) for term in terms])


def _term(found: Columns, term: str, count: int) -> NDArray[np.float64]:
    """A column, or a product of powers of columns."""
    if term in found.names:
        return column(found.get(term), f"column '{term}'")
    if term == "1":
        return np.ones(count)
    product: Any = 1.0
    for factor in term.split("*"):
        name, power = _factor(found.names, factor.strip())
        product = product * column(found.get(name), f"column '{name}'") ** power
    return np.asarray(product, dtype=np.float64)


def _factor(names: Sequence[str], factor: str) -> tuple[str, int]:
    """Name and power of ``alpha^2``."""
    name, _, power = factor.partition("^")
    name, power = name.strip(), power.strip()
    if factor in names:
        return factor, 1
    if name not in names:
        raise unknown("column", name, names)
    if not re.fullmatch(r"-?\d+", power or "1"):
        raise DoubletError(f"'{factor}': '{power}' is not an integer power")
    return name, int(power or "1")

