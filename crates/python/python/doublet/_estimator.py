"""An estimator of scikit-learn."""

from __future__ import annotations

import inspect
import sys
import warnings
from typing import Any, Literal, Mapping, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._doublet import DoubletError
from ._errors import DoubletWarning, unknown
from ._formulas import formula as formula_terms, term_columns
from ._frames import Columns, chosen_columns, column, columns_of, is_frame, matrix_of
from ._functions import Regression, lstsq
from ._table import Table


class LeastSquares:
    """Linear least squares with errors for correlated residuals, as an estimator of scikit-learn: it works in pipelines, searches and
    cross validation. scikit-learn itself is not needed.

    Args:
        fit_intercept: Estimate a constant.
        method: As for :func:`lstsq`.
        order: As for :func:`lstsq`.
        weights: As for :func:`lstsq`.
        errors: As for :func:`lstsq`.
        constraints: By column, as for :func:`lstsq`; columns of an array are called ``x0``, ``x1`` and so on.
        formula: ``"Cm ~ 1 + alpha + alpha*delta_e"`` or ``"1 + alpha"`` of the columns of a frame. Its term ``1`` is the constant;
            ``fit_intercept`` does not count.

    It passes ``sklearn.utils.estimator_checks.check_estimator``, but for the type of the error of a value that is not a number: that is a
    :class:`DoubletError`, a ``ValueError``, not a ``TypeError``.

    Attributes:
        coef_: Estimates, shape (p,); zero for a column that was not chosen.
        intercept_: Constant; zero without one.
        stderr_: Standard errors of ``coef_``, shape (p,); not a number for a column that was not chosen.
        result_: The :class:`Regression`.
        n_features_in_: p; of a formula the terms without the constant.
        feature_names_in_: Names of the columns, where X is a frame; of a formula its terms without the constant.
    """

    _estimator_type = "regressor"

    def __init__(
        self,
        *,
        fit_intercept: bool = True,
        method: Literal["ols", "gls", "stepwise", "orthogonal"] = "ols",
        order: int = 2,
        weights: Literal["equal", "huber"] = "equal",
        errors: Literal["coloured", "white"] = "coloured",
        constraints: Optional[Mapping[str, Any]] = None,
        formula: Optional[str] = None,
    ) -> None:
        self.fit_intercept, self.method, self.order = fit_intercept, method, order
        self.weights, self.errors, self.constraints = weights, errors, constraints
        self.formula = formula

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Parameters by name; ``deep`` makes no difference."""
        return {name: getattr(self, name) for name in inspect.signature(type(self).__init__).parameters if name != "self"}

    def set_params(self, **params: Any) -> "LeastSquares":
        """Sets the parameters ``params``; returns the estimator."""
        known = self.get_params()
        for name, value in params.items():
            if name not in known:
                raise unknown("parameter", name, known)
            setattr(self, name, value)
        return self

    def fit(self, X: Any, y: Any = None, *, groups: Optional[ArrayLike] = None, std: Optional[ArrayLike] = None) -> "LeastSquares":
        """Fits y (n,) by the columns of X (n, p); rows are in order of time and evenly sampled.

        Args:
            X: Array or frame.
            y: Measurement; by default the column that the formula names.
            groups: Record of each row, shape (n,), rows of a record together.
            std: Standard deviation of each row, shape (n,).

        Raises:
            DoubletError: As for :func:`lstsq`; y is missing.
        """
        columns, matrix, measured = self._regressors(X, y)
        constant = "1" if self.formula is not None else "intercept" if self.fit_intercept else None
        if constant == "intercept":
            if constant in columns:
                raise DoubletError("a column is called intercept: rename it or set fit_intercept=False")
            columns, matrix = [constant, *columns], np.column_stack([np.ones(len(matrix)), matrix])
        self.result_: Regression = lstsq(
            matrix, measured, names=columns, groups=groups, std=std, method=self.method, order=self.order,
            weights=self.weights, errors=self.errors, constraints=self.constraints or {},
        )
        found = dict(zip(self.result_.names, zip(self.result_.params, self.result_.stderr)))
        self.intercept_ = float(found[constant][0]) if constant in found else 0.0
        columns = [name for name in columns if name != constant]
        self.coef_ = np.array([found.get(name, (0.0, 0.0))[0] for name in columns])
        self.stderr_ = np.array([found.get(name, (0.0, np.nan))[1] for name in columns])
        self.n_features_in_ = len(columns)
        if self.formula is not None or is_frame(X):
            self.feature_names_in_ = np.array(columns, dtype=object)
        elif hasattr(self, "feature_names_in_"):
            del self.feature_names_in_
        return self

    def _regressors(self, X: Any, y: Any) -> tuple[list[str], NDArray[np.float64], Any]:
        """Names and values of the columns to fit, and the measurement."""
        if self.formula is None:
            if y is None:
                raise DoubletError(
                    "LeastSquares requires y to be passed, but the target y is None: give the measurement, or a formula that names its column"
                )
            names, matrix = matrix_of(X)
            if matrix.shape[1] == 0:
                raise DoubletError(f"X has 0 feature(s) (shape={matrix.shape}) while a minimum of 1 is required: give a column")
            names = names or [f"x{k}" for k in range(matrix.shape[1])]
            return names, _finite(matrix, names), _one_column(y)
        if not is_frame(X):
            raise DoubletError(f"X is a {type(X).__name__}: a formula needs a frame")
        left, _, right = self.formula.rpartition("~")
        if y is None and not left.strip():
            raise DoubletError(f"'{self.formula}' does not name the measurement: write 'Cm ~ 1 + alpha', or give y")
        found = columns_of(X)
        terms = formula_terms(right, found.names)
        return terms, term_columns(found, terms), term_columns(found, [left.strip()])[:, 0] if y is None else y

    def predict(self, X: Any) -> NDArray[np.float64]:
        """Values at X (m, p), shape (m,). The columns of a frame are found by name, those of an array by place.

        Raises:
            DoubletError: The estimator is not fitted, X has another number of columns, or a value is not finite.
            DoubletKeyError: A column is missing.
        """
        if not hasattr(self, "coef_"):
            raise _not_fitted()
        names = getattr(self, "feature_names_in_", None)
        if names is not None and is_frame(X):
            matrix = self._by_name(columns_of(X), list(names))
        elif self.formula is not None:
            raise DoubletError(f"X is a {type(X).__name__}: a formula needs a frame")
        else:
            matrix = matrix_of(X)[1]
        if matrix.shape[1] != self.n_features_in_:
            raise DoubletError(
                f"X has {matrix.shape[1]} features, but LeastSquares is expecting {self.n_features_in_} features as input: "
                f"give {self.n_features_in_} columns, as for fit"
            )
        used = [f"x{k}" for k in range(self.n_features_in_)] if names is None else list(names)
        return np.asarray(_finite(matrix, used) @ self.coef_ + self.intercept_)

    def _by_name(self, found: Columns, names: list[str]) -> NDArray[np.float64]:
        if self.formula is not None:
            return term_columns(found, ["1", *names])[:, 1:]
        missing = next((name for name in names if name not in found.names), None)
        if missing is not None:
            raise unknown("column", missing, found.names)
        return chosen_columns(found, names)

    def score(self, X: Any, y: ArrayLike) -> float:
        """Coefficient of determination of the predictions at X (m, p) of y (m,)."""
        measured = column(y, "y")
        square = float(np.sum((measured - self.predict(X)) ** 2))
        return 1.0 - square / float(np.sum((measured - measured.mean()) ** 2))

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "coef_")

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor", target_tags=TargetTags(required=True), regressor_tags=RegressorTags(), input_tags=InputTags()
        )

    def __repr__(self) -> str:
        defaults = inspect.signature(type(self).__init__).parameters
        changed = {name: value for name, value in self.get_params().items() if value != defaults[name].default}
        return f"LeastSquares({', '.join(f'{name}={value!r}' for name, value in changed.items())})"

    def _repr_html_(self) -> str:
        title = repr(self)
        if not hasattr(self, "result_"):
            return Table([dict(parameter=name, value=str(value)) for name, value in self.get_params().items()], f"{title}, not fitted")._repr_html_()
        found = self.result_
        return Table(list(found.table), f"{title}: {found.table.title}")._repr_html_() + found.verdict._repr_html_()


def _finite(matrix: NDArray[np.float64], names: list[str]) -> NDArray[np.float64]:
    """The values, where all are finite."""
    wrong = np.argwhere(~np.isfinite(matrix))
    if len(wrong):
        row, at = wrong[0]
        raise DoubletError(f"X has NaN or infinity in column '{names[at]}', row {row}: leave such rows out")
    return matrix


def _one_column(y: Any) -> Any:
    """The measurement; that of a matrix with one column is its column."""
    if isinstance(y, np.ndarray) and y.ndim == 2 and y.shape[1] == 1:
        category = _of_sklearn("DataConversionWarning") or DoubletWarning
        warnings.warn("A column-vector y was passed when a 1d array was expected: give y.ravel()", category, stacklevel=4)
        return y[:, 0]
    return y


def _not_fitted() -> DoubletError:
    """The error of an estimator that was not fitted; with scikit-learn its ``NotFittedError`` too."""
    text, own = "the estimator is not fitted: call fit first", _of_sklearn("NotFittedError")
    kind: type[DoubletError] = DoubletError if own is None else type("DoubletNotFittedError", (DoubletError, own), {})
    return kind(text)


def _of_sklearn(name: str) -> Any:
    """An exception of scikit-learn, where that is in use."""
    return getattr(sys.modules.get("sklearn.exceptions"), name, None)
