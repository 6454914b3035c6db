"""The estimator of scikit-learn, and other forms of least squares."""

import doublet as db
import numpy as np
import pytest


#: Checks of scikit-learn that the estimator fails, each with its reason.
EXPECTED_FAILED_CHECKS = {
    "check_dtype_object": "a value that is not a number raises DoubletError, a ValueError as every other refusal, where TypeError is expected",
}
EXPECTED_FAILED_CHECKS_OF_GLS = {
    "check_fit2d_1sample": "one row is refused in other words: it is too short for the order",
}


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


def test_columns_of_a_frame_are_found_by_name(data):
    pandas = pytest.importorskip("pandas")
    X, y = data
    frame = pandas.DataFrame(X, columns=["alpha", "q"])
    model = db.LeastSquares().fit(frame, y)
    expected = model.predict(X)
    np.testing.assert_array_equal(model.predict(frame), expected)
    np.testing.assert_array_equal(model.predict(frame[["q", "alpha"]]), expected)
    np.testing.assert_array_equal(model.predict(frame.assign(beta=0.0)), expected)
    assert model.score(frame[["q", "alpha"]], y) == model.score(frame, y)
    with pytest.raises(db.DoubletKeyError, match="no column is called 'alpha': did you mean 'alfa'"):
        model.predict(frame.rename(columns={"alpha": "alfa"}))
    model.fit(X, y)
    assert not hasattr(model, "feature_names_in_")


def frames(columns):
    """The same columns as a frame of every kind."""
    yield "mapping", columns
    for library, made in (
        ("pandas", lambda one: one.DataFrame(columns)), ("polars", lambda one: one.DataFrame(columns)), ("pyarrow", lambda one: one.table(columns)),
        ("xarray", lambda one: one.Dataset({name: ("time", values) for name, values in columns.items()})),
    ):
        yield library, made(pytest.importorskip(library))


def test_frames_of_every_kind_are_regressors(data):
    X, y = data
    columns = {"one": np.ones(len(X)), "alpha": X[:, 0], "q": X[:, 1]}
    expected = db.lstsq(np.column_stack(list(columns.values())), y, names=list(columns))
    for name, frame in frames(columns):
        found = db.lstsq(frame, y)
        assert found.names == ("one", "alpha", "q"), name
        np.testing.assert_array_equal(found.params, expected.params, err_msg=name)
        np.testing.assert_allclose(found.predict(frame), expected.fitted, err_msg=name)
        np.testing.assert_allclose(db.LeastSquares(fit_intercept=False).fit(frame, y).predict(frame), expected.fitted, err_msg=name)
    for name, frame in frames({"y": y}):
        if name not in ("mapping",):
            np.testing.assert_array_equal(db.lstsq(X, frame["y"]).params, db.lstsq(X, y).params, err_msg=name)
    for wrong, text in (
        ({"a": ["1", "2", "3"]}, "column 'a' of X is text and must be numbers"),
        ({"a": [1j, 2.0, 3.0]}, "column 'a' of X is complex"),
        ({"a": [1.0, 2.0, 3.0], "b": [1.0]}, "columns 'a' and 'b' of X have different lengths"),
        ({}, "X has no columns"),
        ([["1", "2"]] * 3, "X is text"),
        ([[1.0], [1.0, 2.0]], "X must be numbers"),
        (np.ones((3, 1), complex), "X is complex"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.lstsq(wrong, [1.0, 2.0, 4.0])


def test_formulas_name_columns_of_a_frame(data):
    X, y = data
    columns = {"Cm": y, "alpha": X[:, 0], "q": X[:, 1], "qc/V": X[:, 1] / 100}
    terms = [np.ones(len(X)), X[:, 0], X[:, 0] ** 2, X[:, 0] * X[:, 1]]
    expected = db.lstsq(np.column_stack(terms), y)
    for name, frame in frames(columns):
        found = db.lstsq("Cm ~ 1 + alpha + alpha^2 + alpha*q", frame)
        assert found.names == ("1", "alpha", "alpha^2", "alpha*q"), name
        np.testing.assert_allclose(found.params, expected.params, err_msg=name)
        np.testing.assert_allclose(found.predict(frame), found.fitted, err_msg=name)
        model = db.LeastSquares(formula="Cm ~ 1 + alpha + alpha**2 + alpha*q").fit(frame)
        np.testing.assert_allclose([model.intercept_, *model.coef_], expected.params, err_msg=name)
        np.testing.assert_allclose(model.predict(frame), found.fitted, err_msg=name)
        np.testing.assert_allclose(db.LeastSquares(formula="1 + alpha + alpha^2 + alpha*q").fit(frame, y).coef_, expected.params[1:])
    assert db.lstsq("Cm ~ alpha + qc/V", columns, constraints={"qc/V": 2.0})["qc/V"] == 2.0
    no_constant = db.LeastSquares(formula="Cm ~ alpha + q").fit(columns)
    assert no_constant.intercept_ == 0.0 and list(no_constant.feature_names_in_) == ["alpha", "q"]
    for formula, text in (
        ("Cm ~ 1 + alfa", "no column is called 'alfa': did you mean 'alpha'"),
        ("Cmm ~ 1 + alpha", "no column is called 'Cmm': did you mean 'Cm'"),
        ("Cm ~ 1 + alpha*beta", "no column is called 'beta'"),
        ("Cm ~ 1 + alpha^x", "'alpha.x': 'x' is not an integer power"),
        ("Cm ~ 1 + alpha - q", "has a minus sign: write '.'"),
        ("Cm ~ alpha - 1", "leave '1' out for a fit without constant"),
        ("Cm ~ 1 + + alpha", "has an empty term"),
        ("1 + alpha", "is not a formula: write it as 'Cm ~ 1"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.lstsq(formula, columns)
    for call, text in (
        (lambda: db.lstsq("Cm ~ 1 + alpha", y), "y is a ndarray: give the frame of the formula"),
        (lambda: db.lstsq("Cm ~ 1 + alpha", columns, names=["a", "b"]), "names and a formula exclude each other"),
        (lambda: db.LeastSquares(formula="1 + alpha").fit(columns), "does not name the measurement"),
        (lambda: db.LeastSquares(formula="Cm ~ 1 + alpha").fit(X, y), "a formula needs a frame"),
        (lambda: db.LeastSquares().fit(X), "the target y is None: give the measurement"),
        (lambda: no_constant.predict(X), "a formula needs a frame"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            call()


def test_constraints_say_what_to_write(data):
    X, y = data
    for wrong, text in (
        ({"x0": {"mean": 1.0}}, "constraint of 'x0' has mean: give mean and std"),
        ({"x0": (1, 2, 3)}, "constraint of 'x0' has 3 bounds: give .lower, upper. with None"),
        ({"x0": (2.0, 1.0)}, "its lower bound 2 is above its upper bound 1"),
        ({"x0": "fixed"}, "constraint of 'x0' is 'fixed': give a number, .lower, upper."),
        ({"x0": None}, "constraint of 'x0' is None: give a number"),
        ({"x0": {"mean": "a", "std": 1.0}}, "constraint of 'x0' is 'a': give"),
        ([("x0", 1.0)], "constraints is a list: give a mapping"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.lstsq(X, y, constraints=wrong)
    assert db.lstsq(X, y, constraints={"x0": np.array([None, 0.5])}).held[0] == "at bound"
    parse = db._constraints.coefficient_constraints
    assert parse({("Cm", "qc/V"): (None, 1)}) == [("Cm", "qc/V", "bounds", -np.inf, 1.0)]
    for wrong in ({"Cm_q": -10.0}, {("Cm",): -10.0}, {"Cm": {"q": 1.0}}):
        with pytest.raises(db.DoubletError, match=r"is not a \(coefficient, term\): write \('Cm', 'qc/V'\)"):
            parse(wrong)


@pytest.mark.parametrize("settings", [{}, {"method": "stepwise"}, {"method": "gls", "order": 1}, {"weights": "huber"}])
def test_estimator_passes_the_checks_of_scikit_learn(settings):
    pytest.importorskip("sklearn", minversion="1.6")
    from sklearn.utils.estimator_checks import check_estimator

    expected = {**EXPECTED_FAILED_CHECKS, **(EXPECTED_FAILED_CHECKS_OF_GLS if "order" in settings else {})}
    check_estimator(db.LeastSquares(**settings), expected_failed_checks=expected, on_skip=None)


@pytest.mark.parametrize("settings", [{}, {"weights": "huber"}, {"constraints": {"a": 1.0}}, {"groups": np.zeros(4)}, {"std": np.ones(4)}])
def test_rows_of_y_are_those_of_x(settings):
    with pytest.raises(db.DoubletError, match="X has 5 rows and y 4"):
        db.lstsq(np.column_stack([np.ones(5), np.arange(5.0)]), np.arange(4.0) ** 2, names=["a", "b"], **settings)
    with pytest.raises(db.DoubletError, match="X has 5 rows and std 4"):
        db.lstsq(np.column_stack([np.ones(5), np.arange(5.0)]), np.arange(5.0) ** 2, std=np.ones(4))


def test_intervals_of_generalised_least_squares_hold_the_truth():
    """95 % intervals of every parameter over 200 records of 12 s whose noise is an autoregression of 0.9."""
    t, truth = np.arange(600) * 0.02, np.array([0.5, -1.0, 2.0])
    X = np.column_stack([np.ones(600), np.sin(2.0 * t), np.where((t > 2) & (t < 4), 1.0, 0.0) - np.where((t > 4) & (t < 6), 1.0, 0.0)])
    draws = np.random.default_rng(11).normal(size=(200, 600))
    noise = draws / np.sqrt(1 - 0.9**2)
    for k in range(1, 600):
        noise[:, k] = 0.9 * noise[:, k - 1] + draws[:, k]
    held = {"gls": np.zeros(3), "white": np.zeros(3)}
    width = {"gls": 0.0, "ols": 0.0}
    for row in noise:
        whitened, ordinary = db.lstsq(X, X @ truth + row, method="gls"), db.lstsq(X, X @ truth + row)
        low, high = whitened.conf_int().T
        held["gls"] += (low < truth) & (truth < high)
        held["white"] += abs(ordinary.params - truth) < 1.96 * ordinary.stderr_white
        for name, fit in (("gls", whitened), ("ols", ordinary)):
            width[name] += fit.stderr[2] / len(noise)
    assert (held["gls"] >= 0.90 * len(noise)).all() and (held["gls"] <= 0.98 * len(noise)).all(), held
    assert (held["white"] < 0.6 * len(noise)).all(), held
    assert width["gls"] < width["ols"], width


def test_estimator_refuses_what_scikit_learn_does(data):
    X, y = data
    for call, text in (
        (lambda: db.LeastSquares().fit(np.where(np.arange(400)[:, None] == 3, np.nan, X), y), "NaN or infinity in column 'x0', row 3"),
        (lambda: db.LeastSquares().fit(np.zeros((400, 0)), y), "a minimum of 1 is required"),
        (lambda: db.LeastSquares().fit(X, y).predict(np.full((2, 2), np.inf)), "NaN or infinity in column 'x0', row 0"),
        (lambda: db.LeastSquares().fit(X[:, 0], y), "Reshape your data"),
        (lambda: db.LeastSquares().fit(X * 1j, y), "Complex data not supported"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            call()
