"""Verdicts of arrays: the judgement of a session, beside every number."""

import warnings
from dataclasses import replace

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


def levels(verdict):
    return {name: verdict[name] for name in ("level", "windows", "coefficients")}


def levels_of_session(results):
    windows = {one["name"]: one["verdict"]["level"] for one in results.windows}
    return {"level": results.verdict.level, "windows": windows, "coefficients": {one["coefficient"]: one["verdict"]["level"] for one in results.fits}}


def test_a_bad_path_is_bad_and_warned_of(demo):
    """Noise that is stated a hundred times too small: innovations do not fit it. The derivatives hardly change by it, so that arrays and
    session call the fit a caution."""
    windows = db.Session.load("builtin:demo").windows[:3]
    with pytest.warns(db.DoubletWarning, match="flight path: verdict bad") as caught:
        path = db.reconstruct(demo.recording(), db.aircraft("c337f"), windows=windows, noise={"alpha": 1e-5, "theta": 1e-6})
    assert caught[0].filename == __file__
    assert path.verdict.level == "bad" and any(row["code"] == "nis" for row in path.verdict.findings)
    assert "verdict bad" in path.summary()
    fit = db.fit(db.coefficients(path), STRUCTURE)
    assert fit.verdict.level == "caution" and any(row["code"] == "nis" for row in fit.verdict.findings)
    assert set(fit.verdict["windows"].values()) == {"bad"} and "verdict caution" in fit.summary()
    assert levels(fit.verdict) == levels_of_session(fit.to_session().run())


def test_a_bad_fit_is_warned_of(clean):
    """A damping of the wrong sign, stated as known, is bad for arrays and session."""
    coefs = db.coefficients(clean[0])
    with pytest.warns(db.DoubletWarning, match="fit: verdict bad"):
        fit = db.fit(coefs, {"Cl": "1 + pb/2V"}, constraints={("Cl", "pb/2V"): 2.0})
    assert "verdict bad" in fit.summary()
    assert levels(fit.verdict) == levels_of_session(fit.to_session().run())


def test_attas_aileron_is_what_its_session_is():
    """The path of the only manoeuvre is bad; what that changes of the derivatives makes the fit a caution, of the session of the files too."""
    file = shared("attas/fAttasAil1.mat")
    recording, aircraft = db.read(file), db.aircraft("attas_vfw614")
    with pytest.warns(db.DoubletWarning, match="flight path: verdict bad"):
        path = db.reconstruct(recording, aircraft, windows=db.find_manoeuvres(recording))
    fit = db.fit(db.coefficients(path, aircraft), {"Cl": STRUCTURE["Cl"]})
    assert fit.verdict.level == "caution" and any("NIS" in line for line in fit.verdict.lines)
    assert levels(fit.verdict) == levels_of_session(fit.to_session().run())
    results = fit.to_session().run()
    assert {name: results.derivatives[name].value for name in fit.params} == fit.params
    # Both contain the errors of the flight path.
    for name, error in fit.stderr.items():
        assert error == pytest.approx(results.derivatives[name].stderr, rel=0.02)
    assert path.verdict.level == "bad" == results.windows[0]["verdict"]["level"]
    assert results.windows[0]["mean_nis"] == path.summary_table[0]["mean_nis"]
    of_files = db.Session.new(file, aircraft="attas_vfw614").replace(model={"Cl": STRUCTURE["Cl"].split(" + ")})
    assert of_files.run().verdict.level == fit.verdict.level


def test_arrays_as_a_session_give_the_same(clean, tmp_path):
    path, fit = clean
    session = fit.to_session(name="mine", folder=tmp_path)
    results = session.run()
    assert session["title"] == "mine" and len(session.windows) == len(path) and levels(fit.verdict)["windows"] == levels_of_session(results)["windows"]
    for name, value in fit.params.items():
        assert results.derivatives[name].value == pytest.approx(value, rel=1e-9, abs=1e-12), name
        # A session adds the errors of the flight path.
        assert results.derivatives[name].stderr >= fit.stderr[name] * (1 - 1e-9), name
    assert path.to_session()["filter"] == session["filter"]
    unnamed = [[replace(one, flight=None) for one in made.windows] for made in (db.coefficients(path).to_session(), session)]
    assert unnamed[0] == unnamed[1]
    huber = db.fit(db.coefficients(path), {"Cm": STRUCTURE["Cm"]}, weights="huber")
    assert huber.to_session()["estimation.weights"] == "huber" and huber["Cm_alpha"].value != fit["Cm_alpha"].value
    assert abs(huber["Cm_alpha"] - fit["Cm_alpha"]) < 3 * fit["Cm_alpha"].stderr
    for wrong, text in ((dict(weights="x"), "'x' are not weights"), (dict(method="wls"), "'wls' is not a method of fit")):
        with pytest.raises(db.DoubletError, match=text):
            db.fit(db.coefficients(path), {"Cm": STRUCTURE["Cm"]}, **wrong)


def test_functions_and_output_error_have_a_verdict(clean):
    _, fit = clean
    for one in (db.propagate(fit, "Cm_alpha", n=50), db.propagate(fit, lambda d: d["Cm_alpha"], n=50)):
        assert one.verdict.level == fit.verdict.level and f"verdict {fit.verdict.level}" in repr(one)
    flown = db.output_error(fit, axis="longitudinal")
    assert {one.verdict for one in flown} <= {"good", "caution", "bad"}
    done = next(one for one in flown if one.error is None)
    assert repr(done).endswith(f"verdict {fit.verdict['windows'][done.window]}") and done.table[0]["derivative"] in repr(done)


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
        (dict(hold="third"), "third.*first_order.*zero_order.*filter.hold"),
        (dict(linearisation="x"), "x.*prior.*predicted.*filter.linearisation"),
        (dict(random_walk={"wind": 1.0}), "no state of the filter is called 'wind'.* there are x, y, z"),
        (dict(initial={"mass": 1.0}), "no state of the filter is called 'mass'"),
        (dict(gravity=-1.0), "gravity"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            path(**wrong)


def test_stated_gravity_takes_the_bias_of_the_simulated_citation_away():
    """The simulator's gravity was 9.80357 m/s2: with it the bias of az is within three of its deviations of the truth, with
    standard gravity it takes the difference up and is more than nine off."""
    loadmat = pytest.importorskip("scipy.io").loadmat
    file = shared("citation_simulated/da3211_1_noisy_with_truth.mat")
    truth = loadmat(file)["x_true"][-1]
    deg = np.pi / 180.0
    noise = dict(
        ax=0.02, ay=0.02, az=0.03, p=0.005 * deg, q=0.005 * deg, r=0.002 * deg, x=1.0, y=1.0, z=1.0, v_north=0.01, v_east=0.01,
        v_down=0.01, phi=0.04 * deg, theta=0.04 * deg, psi=0.04 * deg, airspeed=0.2, alpha=0.1 * deg, beta=0.25 * deg,
    )

    def deviations_off(**gravity):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", db.DoubletWarning)
            path = db.reconstruct(db.read(file), noise=noise, hold="zero_order", method="ekf", **gravity)
        states = path[0].states
        return abs(states["bias_az"][-1] - truth[list(states).index("bias_az")]) / states.std["bias_az"][-1]

    assert deviations_off(gravity=9.80357) < 3.0
    assert deviations_off() > 9.0


def test_robust_limit_withstands_outliers(demo):
    """Spikes of 11 degrees in one of 40 samples of alpha: a limit keeps the path, none leaves it as it was before."""
    recording, window = demo.recording(), db.Session.load("builtin:demo").windows[:1]
    channels = {role: (recording[role].time, recording[role].values, recording[role].unit) for role in recording.roles}
    time, alpha, unit = channels["alpha"]
    spiked = db.Recording.from_arrays(
        None, {**channels, "alpha": (time, alpha + np.where(np.arange(len(alpha)) % 40 == 7, 0.2, 0.0), unit)}, check=False
    )

    def alpha_of(source, **settings):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", db.DoubletWarning)
            return db.reconstruct(source, windows=window, noise={"alpha": 0.004}, outlier_limit=0.0, **settings)[0].smoothed.alpha

    clean = alpha_of(recording)
    hurt = {limit: np.sqrt(np.mean((alpha_of(spiked, robust_limit=limit) - clean) ** 2)) for limit in (0.0, 2.0)}
    assert hurt[2.0] < 0.5 * hurt[0.0], hurt
    np.testing.assert_array_equal(alpha_of(recording, robust_limit=0.0), clean)
    np.testing.assert_array_equal(alpha_of(spiked, robust_limit=0.0), alpha_of(spiked))
    np.testing.assert_allclose(alpha_of(recording, robust_limit=100.0), clean, atol=1e-12)
    with pytest.raises(db.DoubletError, match="robust_limit|Huber"):
        alpha_of(recording, robust_limit=-1.0)


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
