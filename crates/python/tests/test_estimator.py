"""The estimator of scikit-learn, and other forms of least squares."""

import doublet as db
import numpy as np
import pytest


@pytest.fixture(scope="module")
def data():
    rng = np.random.default_rng(3)
    X = np.cumsum(rng.normal(size=(400, 2)), axis=0) / 10
    noise = np.zeros(400)
    for k in range(1, 400):
        noise[k] = 0.98 * noise[k - 1] + 0.02 * rng.normal()
    return X, 0.5 + X @ [1.0, -2.0] + noise


def test_estimator_is_lstsq(data):
    X, y = data
    model = db.LeastSquares().fit(X, y)
    expected = db.lstsq(np.column_stack([np.ones(len(X)), X]), y)
    np.testing.assert_array_equal([model.intercept_, *model.coef_], expected.params)
    np.testing.assert_array_equal(model.stderr_, expected.stderr[1:])
    assert model.score(X, y) == pytest.approx(expected.r2) and model.n_features_in_ == 2
    np.testing.assert_allclose(model.predict(X), expected.fitted)
    assert repr(model.set_params(method="gls")) == "LeastSquares(method='gls')" and model.get_params()["order"] == 2
    with pytest.raises(db.DoubletKeyError, match="did you mean 'method'"):
        model.set_params(methd="ols")
    with pytest.raises(db.DoubletError, match="not fitted"):
        db.LeastSquares().predict(X)
    with pytest.raises(db.DoubletError, match="give 2 columns"):
        model.predict(X[:, :1])


def test_estimator_works_in_scikit_learn(data):
    pytest.importorskip("sklearn")
    from sklearn.base import clone, is_regressor
    from sklearn.linear_model import LinearRegression
    from sklearn.model_selection import GridSearchCV, TimeSeriesSplit, cross_val_score
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import PolynomialFeatures, StandardScaler

    X, y = data
    folds = TimeSeriesSplit(4)
    ours, theirs = (cross_val_score(make_pipeline(StandardScaler(), one), X, y, cv=folds) for one in (db.LeastSquares(), LinearRegression()))
    np.testing.assert_allclose(ours, theirs, rtol=1e-6)
    assert is_regressor(db.LeastSquares()) and clone(db.LeastSquares(order=3)).order == 3
    search = GridSearchCV(db.LeastSquares(), {"method": ["ols", "gls"], "fit_intercept": [True]}, cv=folds).fit(X, y)
    assert search.best_params_["method"] in ("ols", "gls")
    grown = make_pipeline(PolynomialFeatures(2, include_bias=False), db.LeastSquares(method="stepwise")).fit(X, y)
    assert grown.score(X, y) > 0.9 and np.isnan(grown[-1].stderr_).sum() == (grown[-1].coef_ == 0).sum()


def test_frames_name_the_columns(data):
    pandas = pytest.importorskip("pandas")
    X, y = data
    frame = pandas.DataFrame(X, columns=["alpha", "q"])
    model = db.LeastSquares(constraints={"q": -2.0}).fit(frame, y)
    assert list(model.feature_names_in_) == ["alpha", "q"] and model.coef_[1] == pytest.approx(-2.0)
    assert model.result_.names == ("intercept", "alpha", "q")


def test_generalised_least_squares_is_shorter_under_coloured_noise(data):
    X, y = data
    regressors = np.column_stack([np.ones(len(X)), X])
    ordinary, whitened = db.lstsq(regressors, y), db.lstsq(regressors, y, method="gls")
    assert (whitened.stderr[1:] < 0.7 * ordinary.stderr[1:]).all()
    assert (abs(whitened.params[1:] - [1.0, -2.0]) < 4 * whitened.stderr[1:]).all()
    np.testing.assert_allclose(whitened.residuals, y - regressors @ whitened.params)
    groups = np.repeat([0, 1], 200)
    assert db.lstsq(regressors, y, method="gls", order=1, groups=groups)["x1"] == pytest.approx(1.0, abs=0.1)
    for wrong, text in (
        (dict(method="gls", weights="huber"), "exclude each other"),
        (dict(method="gls", std=np.ones(400)), "exclude each other"),
        (dict(method="gls", constraints={"x1": 1.0}), "cannot be combined"),
        (dict(method="gls", order=400), "order"),
        (dict(order=0), "order is 0: give 1 or more"),
        (dict(weights="tukey"), "'tukey' are not weights: use equal or huber"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.lstsq(regressors, y, **wrong)


def test_hubers_weights_withstand_outliers():
    rng = np.random.default_rng(5)
    X = np.column_stack([np.ones(500), rng.normal(size=500)])
    y = X @ [1.0, 2.0] + 0.1 * rng.normal(size=500)
    wild = y + np.where(rng.uniform(size=500) < 0.05, 20.0 * np.sign(X[:, 1]), 0.0)
    equal, huber = db.lstsq(X, wild), db.lstsq(X, wild, weights="huber")
    assert abs(huber["x1"] - 2.0) < 0.05 < abs(equal["x1"] - 2.0)
    np.testing.assert_allclose(huber.residuals, wild - X @ huber.params)
    np.testing.assert_allclose(db.lstsq(X, y, weights="huber").params, db.lstsq(X, y).params, atol=0.02)
    assert huber.r2 == pytest.approx(1 - np.sum(huber.residuals**2) / np.sum((wild - wild.mean()) ** 2))
