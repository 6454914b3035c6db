"""Verdicts of arrays: the judgement of a session, beside every number."""

import warnings

import doublet as db
import numpy as np
import pytest

from conftest import shared

STRUCTURE = {"Cl": "1 + beta + pb/2V + rb/2V + delta_a + delta_r", "Cm": "1 + alpha + qc/V + delta_e"}


@pytest.fixture(scope="module")
def clean(demo):
    session = db.Session.load("builtin:demo")
    noise = {**session["filter.process_noise"], **session["filter.measurement_noise"]}
    walk = session["filter.random_walk"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        path = db.reconstruct(
            demo.recording(), db.aircraft("c337f"), windows=session.windows, noise=noise, random_walk=walk,
            gravity=session["filter.gravity_m_s2"],
        )
        return path, db.fit(db.coefficients(path), session["model"])


def test_levels_of_windows_are_those_of_the_session(demo, clean):
    path, fit = clean
    theirs = {window["name"]: window["verdict"] for window in demo.windows}
    ours = path.verdict["windows"]
    same = [name for name in ours if ours[name] == theirs[name]["level"]]
    assert set(ours) == set(theirs) and len(same) >= 0.8 * len(ours), (ours, theirs)
    assert set(fit.verdict["coefficients"]) == set(fit.coefficients)
    assert set(fit.verdict["derivatives"]) == set(fit.params)


def test_verdict_is_beside_the_numbers(clean):
    path, fit = clean
    for one in (path, fit):
        assert one.verdict.level in ("good", "caution", "bad")
        assert f"verdict {one.verdict.level}" in one.summary() and f"verdict {one.verdict.level}" in repr(one)
        assert one.verdict.findings.where(level="bad") is not None and one.verdict["level"] == one.verdict.level
    assert path[0].verdict in ("good", "caution", "bad") and "verdict" in fit.table.columns
    coefs = db.coefficients(path)
    assert f"verdict {coefs.verdict.level}" in repr(coefs)


def test_a_bad_path_is_bad_and_warned_of(demo):
    """Noise that is stated a hundred times too small: innovations do not fit it."""
    windows = db.Session.load("builtin:demo").windows[:3]
    with pytest.warns(db.DoubletWarning, match="flight path: verdict bad") as caught:
        path = db.reconstruct(demo.recording(), db.aircraft("c337f"), windows=windows, noise={"alpha": 1e-5, "theta": 1e-6})
    assert caught[0].filename == __file__
    assert path.verdict.level == "bad" and any(row["code"] == "nis" for row in path.verdict.findings)
    assert "verdict bad" in path.summary()
    with pytest.warns(db.DoubletWarning, match="fit: verdict bad"):
        fit = db.fit(db.coefficients(path), STRUCTURE)
    assert fit.verdict.level == "bad" and "verdict bad" in fit.summary()


def test_attas_aileron_is_bad_as_its_session_is():
    file = shared("attas/fAttasAil1.mat")
    recording, aircraft = db.read(file), db.aircraft("attas_vfw614")
    with pytest.warns(db.DoubletWarning):
        path = db.reconstruct(recording, aircraft, windows=db.find_manoeuvres(recording))
        fit = db.fit(db.coefficients(path, aircraft), {"Cl": STRUCTURE["Cl"]})
    assert fit.verdict.level == "bad" and any("NIS" in line for line in fit.verdict.lines)
    assert db.run(db.Session.new(file, aircraft="attas_vfw614")).verdict.level == "bad"


def test_another_aircraft_is_refused(clean):
    path, _ = clean
    assert db.coefficients(path, db.aircraft("c337f")).windows == db.coefficients(path).windows
    with pytest.raises(db.DoubletError, match="the path is of .*leave the aircraft out"):
        db.coefficients(path, db.aircraft("navion"))
    with pytest.raises(TypeError):
        db.output_error(path, db)


def test_gravity_hold_walks_and_initial_states_are_obeyed(demo):
    recording, window = demo.recording(), db.Session.load("builtin:demo").windows[:1]
    noise = {"alpha": 0.01}

    def path(**settings):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", db.DoubletWarning)
            return db.reconstruct(recording, windows=window, noise=noise, **settings)

    usual = path()
    assert usual.gravity == pytest.approx(9.80665, abs=0.02)
    heavy = path(gravity=9.9)
    assert heavy.gravity == 9.9
    shift = np.mean(heavy[0].smoothed["bias_az"] - usual[0].smoothed["bias_az"])
    assert shift == pytest.approx(9.9 - usual.gravity, rel=0.1) or shift == pytest.approx(usual.gravity - 9.9, rel=0.1)
    assert np.any(path(hold="zero_order")[0].smoothed["theta"] != usual[0].smoothed["theta"])
    walking = path(random_walk={"wind_north": 1.0})[0].states.std["wind_north"]
    assert walking[-1] > usual[0].states.std["wind_north"][-1]
    known = path(initial={"wind_north": 3.0}, initial_std={"wind_north": 0.0})
    assert (known[0].states["wind_north"] == 3.0).all()
    for wrong, text in (
        (dict(hold="third"), "'third' is not a hold: use first_order or zero_order"),
        (dict(linearisation="x"), "'x' is not a linearisation: use prior or predicted"),
        (dict(random_walk={"wind": 1.0}), "'wind' is not a state of the filter: use one of x, y, z"),
        (dict(initial={"mass": 1.0}), "'mass' is not a state"),
        (dict(gravity=-1.0), "gravity"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            path(**wrong)


def test_flights_are_pooled(clean):
    path, fit = clean
    model = {"CX": "1 + alpha + alpha^2", "CZ": "1 + alpha + qc/V + delta_e", "Cm": STRUCTURE["Cm"]}
    coefs = db.coefficients(path)
    both = db.fit([coefs, coefs], model)
    assert len(both.windows) == 2 * len(path) and any(name.endswith("(flight 2)") for name in both.windows)
    assert both["Cm_alpha"].value == pytest.approx(fit["Cm_alpha"].value, rel=1e-9)
    assert both["Cm_alpha"].stderr < fit["Cm_alpha"].stderr and both.nobs["Cm"] == 2 * fit.nobs["Cm"]
    assert both.linearise(airspeed=46.0, samples=10).modes
    with pytest.raises(db.DoubletError, match="differ in axes"):
        db.fit([coefs, db.coefficients(path, axes="stability")], model)
    with pytest.raises(db.DoubletError, match="no coefficients were given"):
        db.fit([], model)


def test_formulas_are_terms(clean):
    path, fit = clean
    coefs = db.coefficients(path)
    listed = db.fit(coefs, {"Cm": ["1", "alpha", "qc/V", "delta_e"]})
    for formula in ({"Cm": "1 + alpha + qc/V + delta_e"}, "Cm ~ 1 + alpha + qc/V + delta_e", ["Cm ~ 1+alpha+qc/V+delta_e"]):
        assert db.fit(coefs, formula).params == listed.params
    assert db.fit(coefs, {"CX": "1 + alpha**2"}).params.keys() == db.fit(coefs, {"CX": ["1", "alpha^2"]}).params.keys()
    with pytest.raises(db.DoubletError, match="empty term"):
        db.fit(coefs, {"Cm": "1 + + alpha"})
    with pytest.raises(db.DoubletError, match="names its coefficient"):
        db.fit(coefs, "1 + alpha")
    assert coefs[0].regressors("1 + alpha").shape == coefs[0].regressors(["1", "alpha"]).shape


def test_intervals_predictions_and_criteria(clean):
    _, fit = clean
    names, errors = list(fit.params), fit.stderr
    assert fit.cov.shape == (len(names), len(names)) and np.allclose(fit.cov, fit.cov.T)
    np.testing.assert_allclose(np.sqrt(np.diag(fit.cov)), [errors[name] for name in names], rtol=1e-6)
    low, high = fit.conf_int()["Cm_alpha"]
    assert (low, high) == pytest.approx(fit["Cm_alpha"].interval)
    wide = fit.conf_int(0.99)["Cm_alpha"]
    assert wide[0] < low and high < wide[1]
    assert fit.nobs["Cm"] == len(fit.coefficients["Cm"].residuals)
    assert fit.aic["Cm"] < fit.coefficients["Cm"].nobs * np.log(2 * np.pi * np.e * fit.coefficients["Cm"].fitted.var())
    predicted = fit.predict("Cm", constants="own")
    assert len(predicted) > len(fit.coefficients["Cm"].windows) - 1
    one = predicted[fit.coefficients["Cm"].windows[0]]
    assert one["time"].shape == one["predicted"].shape
    assert np.corrcoef(one["observed"], one["predicted"])[0, 1] > 0.9
    with pytest.raises(db.DoubletKeyError, match="no coefficient of the fit is called 'Cx'"):
        fit.predict("Cx")
    X = np.column_stack([np.ones(300), np.random.default_rng(1).normal(size=300)])
    regression = db.lstsq(X, X @ [1.0, 2.0] + 0.1 * np.sin(np.arange(300)), names=["a", "b"])
    assert regression.conf_int().shape == (2, 2) and regression.nobs == 300 and np.isfinite(regression.aic)
    np.testing.assert_allclose(regression.predict(X), regression.fitted, rtol=1e-12)
    with pytest.raises(db.DoubletError, match="give one for each of a, b"):
        regression.predict(X[:, :1])
    with pytest.raises(db.DoubletError, match="between 0 and 1"):
        regression.conf_int(95)
