"""An estimator of scikit-learn."""

from __future__ import annotations

import inspect
from typing import Any, Literal, Mapping, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._doublet import DoubletError
from ._errors import unknown
from ._functions import Regression, lstsq


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

    Attributes:
        coef_: Estimates, shape (p,); zero for a column that was not chosen.
        intercept_: Constant; zero without one.
        stderr_: Standard errors of ``coef_``, shape (p,); not a number for a column that was not chosen.
        result_: The :class:`Regression`.
        n_features_in_: p.
        feature_names_in_: Names of the columns, where X is a frame.
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
    ) -> None:
        self.fit_intercept, self.method, self.order = fit_intercept, method, order
        self.weights, self.errors, self.constraints = weights, errors, constraints

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Parameters by name."""
        return {name: getattr(self, name) for name in inspect.signature(type(self).__init__).parameters if name != "self"}

    def set_params(self, **params: Any) -> "LeastSquares":
        """Sets parameters; returns the estimator."""
        known = self.get_params()
        for name, value in params.items():
            if name not in known:
                raise unknown("parameter", name, known)
            setattr(self, name, value)
        return self

    def fit(self, X: Any, y: ArrayLike, *, groups: Optional[ArrayLike] = None, std: Optional[ArrayLike] = None) -> "LeastSquares":
        """Fits y (n,) by the columns of X (n, p); rows are in order of time and evenly sampled.

        Args:
            groups: Record of each row, shape (n,), rows of a record together.
            std: Standard deviation of each row, shape (n,).
        """
        names = [str(column) for column in X.columns] if hasattr(X, "columns") else None
        matrix = np.asarray(X, dtype=np.float64)
        if matrix.ndim != 2:
            raise DoubletError(f"X has {matrix.ndim} dimensions: give samples by columns")
        columns = names or [f"x{k}" for k in range(matrix.shape[1])]
        constant = ["intercept"] if self.fit_intercept else []
        if constant and "intercept" in columns:
            raise DoubletError("a column is called intercept: rename it or set fit_intercept=False")
        full = np.column_stack([np.ones(len(matrix)), matrix]) if constant else matrix
        self.result_: Regression = lstsq(
            full, np.asarray(y), names=[*constant, *columns], groups=groups, std=std, method=self.method, order=self.order,
            weights=self.weights, errors=self.errors, constraints=self.constraints or {},
        )
        found = dict(zip(self.result_.names, zip(self.result_.params, self.result_.stderr)))
        self.coef_ = np.array([found.get(name, (0.0, 0.0))[0] for name in columns])
        self.stderr_ = np.array([found.get(name, (0.0, np.nan))[1] for name in columns])
        self.intercept_ = float(found["intercept"][0]) if constant else 0.0
        self.n_features_in_ = len(columns)
        if names is not None:
            self.feature_names_in_ = np.array(names, dtype=object)
        return self

    def predict(self, X: Any) -> NDArray[np.float64]:
        """Values at X (m, p), shape (m,)."""
        if not hasattr(self, "coef_"):
            raise DoubletError("the estimator is not fitted: call fit first")
        matrix = np.asarray(X, dtype=np.float64)
        if matrix.ndim != 2 or matrix.shape[1] != self.n_features_in_:
            raise DoubletError(f"X has the shape {matrix.shape}: give {self.n_features_in_} columns, as for fit")
        return np.asarray(matrix @ self.coef_ + self.intercept_)

    def score(self, X: Any, y: ArrayLike) -> float:
        """Coefficient of determination of the predictions at X (m, p) of y (m,)."""
        measured = np.asarray(y, dtype=np.float64)
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
