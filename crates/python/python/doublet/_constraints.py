"""Constraints on parameters: fixed, between bounds, or known with a standard deviation."""

from __future__ import annotations

import math
from typing import Any, Mapping, Optional

import numpy as np

from ._doublet import DoubletError

#: Coefficient, term, kind and two numbers, as the engine takes them.
Constraint = tuple[str, str, str, float, float]
_FORMS = "give a number, (lower, upper) with None for an open end, or {'mean': .., 'std': ..}"


def coefficient_constraints(given: Optional[Mapping[Any, Any]]) -> list[Constraint]:
    """Constraints by coefficient and term."""
    rows = []
    for key, value in _items(given):
        if not (isinstance(key, tuple) and len(key) == 2 and all(isinstance(part, str) for part in key)):
            raise DoubletError(f"constraints: {key!r} is not a (coefficient, term): write ('Cm', 'qc/V')")
        rows.append((*key, *_parsed(key, value)))
    return rows


def column_constraints(given: Optional[Mapping[Any, Any]]) -> list[tuple[str, str, float, float]]:
    """Constraints by column."""
    return [(str(name), *_parsed(name, value)) for name, value in _items(given)]


def _items(given: Optional[Mapping[Any, Any]]) -> Any:
    if given is not None and not isinstance(given, Mapping):
        raise DoubletError(f"constraints is a {type(given).__name__}: give a mapping")
    return (given or {}).items()


def _parsed(key: Any, value: Any) -> tuple[str, float, float]:
    """A constraint as the engine takes it."""
    if isinstance(value, Mapping):
        if set(value) != {"mean", "std"}:
            raise DoubletError(f"constraint of {key!r} has {', '.join(map(str, value)) or 'no keys'}: give mean and std")
        return "prior", _number(key, value["mean"]), _number(key, value["std"])
    if isinstance(value, (tuple, list)) or (isinstance(value, np.ndarray) and value.ndim == 1):
        if len(value) != 2:
            raise DoubletError(f"constraint of {key!r} has {len(value)} bounds: give (lower, upper) with None for an open end")
        low, high = (default if end is None else _number(key, end) for end, default in zip(value, (-math.inf, math.inf)))
        if low > high:
            raise DoubletError(f"constraint of {key!r}: its lower bound {low:g} is above its upper bound {high:g}")
        return "bounds", low, high
    return "fixed", _number(key, value), 0.0


def _number(key: Any, value: Any) -> float:
    if not isinstance(value, (str, bool)):
        try:
            return float(value)
        except (TypeError, ValueError):
            pass
    raise DoubletError(f"constraint of {key!r} is {value!r}: {_FORMS}")
