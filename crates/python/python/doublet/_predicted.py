"""Values of an identified coefficient at regressors it was not fitted to."""

from __future__ import annotations

from typing import Any, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from . import _doublet
from ._doublet import DoubletError
from ._errors import unknown
from ._formulas import term_columns
from ._frames import columns_of, is_frame, matrix_of


def predicted(
    coefficient: str, terms: Sequence[str], params: Mapping[str, float], X: Any, manoeuvre: Optional[str]
) -> NDArray[np.float64]:
    """Values of a coefficient at X, shape (m,): estimates ``params`` times their terms, those left out not counted.

    Args:
        coefficient: Coefficient.
        terms: Its terms in the model.
        params: Estimates by name.
        X: Frame with a column for each variable or term, or an array with a column per fitted term without the constant.
        manoeuvre: The one whose constant counts; by default the mean of the constants.
    """
    pairs = _doublet.derivative_names(coefficient, list(terms))
    used = [(term, params[name]) for term, name in pairs if term != "1" and name in params]
    names = [term for term, _ in used]
    matrix = term_columns(columns_of(X), ["1", *names])[:, 1:] if is_frame(X) else matrix_of(X)[1]
    if matrix.shape[1] != len(names):
        raise DoubletError(f"X has {matrix.shape[1]} columns: give one for each of {', '.join(names)}")
    constant = next((_constant(name, params, manoeuvre) for term, name in pairs if term == "1"), 0.0)
    return np.asarray(matrix @ np.array([value for _, value in used], dtype=np.float64) + constant)


def _constant(name: str, params: Mapping[str, float], manoeuvre: Optional[str]) -> float:
    """The constant called ``name``: that of a manoeuvre, one for all, or the mean over the manoeuvres."""
    own = {key[len(name) + 1 : -1]: value for key, value in params.items() if key.startswith(f"{name}[") and key.endswith("]")}
    if manoeuvre is not None and own:
        if manoeuvre not in own:
            raise unknown("manoeuvre with a constant", manoeuvre, own)
        return own[manoeuvre]
    return params[name] if name in params else float(np.mean(list(own.values()))) if own else 0.0
