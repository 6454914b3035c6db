"""Settings of a session as arguments: each does what the session's key does, and unknown names are refused with the nearest."""

import warnings

import doublet as db
import numpy as np
import pytest

pytestmark = pytest.mark.filterwarnings("ignore::doublet.DoubletWarning")
MODEL = {"Cm": "1 + alpha + qc/V + delta_e"}


@pytest.fixture(scope="module")
def given(demo):
    session = db.Session.load("builtin:demo")
    windows = [one for one in session.windows if one.surface == "elevator"][:2]
    noise = {**session["filter.process_noise"], **session["filter.measurement_noise"]}
    return demo.recording(), db.aircraft("c337f"), windows, noise


@pytest.fixture(scope="module")
def usual(given):
    return path_of(given)


def path_of(given, **settings):
    recording, aircraft, windows, noise = given
    return db.reconstruct(recording, aircraft, windows=windows, **{"noise": noise, **settings})


def fit_of(path, **settings):
    return db.fit(db.coefficients(path, **settings), MODEL)


def same_as_its_session(fit):
    results = fit.results()
    assert {name: results.derivatives[name].value for name in fit.params} == pytest.approx(fit.params, rel=1e-9, abs=1e-12)


def test_delays_and_gusts_are_estimated_as_by_a_session(given):
    """Ground velocity recorded 150 ms late: its delay is found, that of the attitude is not, and the session of the arrays finds the same."""
    recording, aircraft, _, noise = given
    windows = [one for one in db.Session.load("builtin:demo").windows if one.surface == "elevator"][:5]
    channels = {role: (recording[role].time, recording[role].values, recording[role].unit) for role in recording.roles}
    late = {name: (channels[name][0] + 0.15, *channels[name][1:]) for name in ("v_north", "v_east", "v_down")}
    given = (db.Recording.from_arrays(None, {**channels, **late}, check=False), aircraft, windows, noise)
    stated, found = path_of(given), path_of(given, estimate=["gusts", "delays"])
    assert len(stated.estimated) == 0 and stated.to_session()["filter.delays"] == stated.to_session()["filter.gusts"] == "stated"
    delay = next(row for row in found.estimated if "v_north" in row["of"])
    assert delay["kind"] == "delay" and delay["used"] and abs(delay["value"] - 0.15) < 4 * delay["stderr"] < 0.05, found.estimated
    assert not any(row["used"] for row in found.estimated if "theta" in row["of"])
    assert {row["kind"] for row in found.estimated} == {"delay", "random walk"}
    assert "delays" not in found.to_session()["filter"]
    fit = fit_of(found)
    same_as_its_session(fit)
    assert fit["Cm_alpha"] != fit_of(stated)["Cm_alpha"]
    theirs = next(row for row in fit.results().to_dict()["sensor_delays"] if "v_north" in row["measurements"])
    assert theirs["delay_s"] == pytest.approx(delay["value"], rel=1e-9)


def test_settings_of_the_filter_reach_it(given, usual):
    for settings, key, value in (
        (dict(method="ukf", spread=1.2), "spread", 1.2),
        (dict(max_iterations=1), "max_iterations", 1),
        (dict(tolerance=1.0), "tolerance", 1.0),
        (dict(air_data_deviation={"airspeed_scale": 0.02}), "air_data_deviation", {"airspeed_scale": 0.02}),
    ):
        path = path_of(given, **settings)
        assert path.to_session()["filter"][key] == value
        assert (path[0].smoothed["u"] != usual[0].smoothed["u"]).any(), settings
    once = path_of(given, method="iekf", max_iterations=1)
    np.testing.assert_allclose(once[0].smoothed["u"], path_of(given, method="ekf")[0].smoothed["u"], rtol=1e-12)
    same_as_its_session(fit_of(path_of(given, air_data_deviation={"airspeed_scale": 0.02})))


def test_settings_of_the_preparation_reach_the_coefficients(given, usual):
    nominal = db.coefficients(usual)
    length = len(nominal[0].time)
    settled = db.coefficients(usual, settle_s=np.float64(1.0))
    assert 0 < length - len(settled[0].time) and settled[0].time[0] == pytest.approx(nominal[0].time[0] + 1.0, abs=0.1)
    late = db.coefficients(usual, control_lag={"elevator": {"delay_s": 0.1}})
    moved = np.interp(nominal[0].time - 0.1, nominal[0].time, nominal[0]["delta_e"])
    inside = slice(length // 4, -length // 4)
    assert np.abs(late[0]["delta_e"] - moved)[inside].max() < 0.2 * np.ptp(moved)
    assert (late[0]["delta_e"] != nominal[0]["delta_e"]).any()
    for name, settings in (
        ("Cm", dict(moment_reference=(5.0, 0.0, 0.0))),
        ("Cm", dict(angular_acceleration="smoother")),
        ("delta_e", dict(actuator_lag_s=0.1)),
        ("Cm", dict(matched_smoothing=False)),
        ("Cl", dict(axes="stability")),
    ):
        assert not np.array_equal(db.coefficients(usual, **settings)[0][name], nominal[0][name]), settings
    several = dict(moment_reference="centre_of_gravity", gyroscopic="ignored", settle_s=0.5, actuator_lag_s=0.05, matched_smoothing=False)
    same_as_its_session(fit_of(usual, **several))
    assert {key: fit_of(usual, **several).to_session()["preparation"][key] for key in several} == several


def test_settings_of_the_preparation_reach_the_path(given, usual):
    several = dict(correct_vanes=False, correct_accelerometer=False, correct_antenna=False, differentiation="central", origin_altitude_m=500.0)
    path = path_of(given, **several)
    kept = path.to_session()["preparation"]
    assert {key: kept[key] for key in several} == several
    assert (path[0].smoothed["u"] != usual[0].smoothed["u"]).any()
    same_as_its_session(fit_of(path))
    wide = db.coefficients(path_of(given, differentiation_half_width_s=0.3, differentiation="local_quadratic"))
    assert not np.array_equal(wide[0]["Cm"], db.coefficients(usual)[0]["Cm"])
    assert path_of(given, smooth=False).is_smoothed is False and usual.is_smoothed
    assert path_of(given, measured=True).to_session()["preparation.path"] == "measured"


def test_unknown_names_are_refused_with_the_nearest(given, usual):
    recording, aircraft, windows, _ = given
    for call, text in (
        (lambda: path_of(given, robust_limt=2.0), "no argument of reconstruct is called 'robust_limt': did you mean 'robust_limit'"),
        (lambda: path_of(given, noise={"alfa": 0.1}), "'alfa': did you mean 'alpha'"),
        (lambda: path_of(given, delays={"airspede": 0.1}), "no measurement of the filter is called 'airspede': did you mean 'airspeed'"),
        (lambda: path_of(given, random_walk={"wind_nort": 0.1}), "did you mean 'wind_north'"),
        (lambda: path_of(given, air_data_deviation={"airspeed_scal": 0.1}), "did you mean 'airspeed_scale'"),
        (lambda: path_of(given, estimate=["gust"]), "did you mean 'gusts'"),
        (lambda: db.coefficients(usual, setle_s=1.0), "no argument of coefficients is called 'setle_s': did you mean 'settle_s'"),
        (lambda: db.coefficients(usual, control_lag={"elevatr": {}}), "did you mean 'elevator'"),
        (lambda: db.coefficients(usual, thrust="removd"), "did you mean 'removed'"),
        (lambda: db.Session.load("builtin:demo").replace({"filter.methd": "ekf"}), "no key of a session is called 'filter.methd': did you mean 'filter.method'"),
        (lambda: db.Session.load("builtin:demo").replace({"manoeuvre.0.rol": "validation"}), "did you mean 'manoeuvre.0.role'"),
        (lambda: db.Session.load("builtin:demo").replace(titel="x"), "did you mean 'title'"),
        (lambda: db.Session.from_recordings(recording, filter={"smoother_pases": 2}), "did you mean 'filter.smoother_passes'"),
    ):
        with pytest.raises(db.DoubletKeyError, match=text):
            call()
    with pytest.raises(db.DoubletError, match="correct_vanes is an argument of reconstruct"):
        db.coefficients(usual, correct_vanes=False)
    for settings in (dict(spread=-1.0, method="ukf"), dict(tolerance=0.0), dict(max_iterations=0)):
        with pytest.raises(db.DoubletError):
            path_of(given, **settings)
    with pytest.raises(db.DoubletError):
        db.coefficients(usual, settle_s=-1.0)


def test_session_of_recordings_takes_settings(given):
    recording, aircraft, windows, _ = given
    session = db.Session.from_recordings(
        recording, aircraft=aircraft, manoeuvres=windows, model=MODEL, filter={"method": "ekf", "measurement_noise": {"alpha": 0.003}},
        preparation={"settle_s": 0.5}, estimation={"weights": "autoregression"}, settings={"manoeuvre.0.role": "validation"},
    )
    assert session["filter.method"] == "ekf" and session["filter.measurement_noise.alpha"] == 0.003
    assert session["filter.measurement_noise.theta"] > 0 and session["preparation.settle_s"] == 0.5
    assert session["estimation.weights"] == "autoregression" and session["manoeuvre.0.role"] == "validation"
    assert [one.name for one in session.windows] == [one.name for one in windows]
    old = db.Session.from_recordings(recording, aircraft=aircraft, windows=windows, model=MODEL)
    new = db.Session.from_recordings(recording, aircraft=aircraft, manoeuvres=windows, model=MODEL)
    assert old["manoeuvre"] == new["manoeuvre"]
    with pytest.raises(db.DoubletError, match="manoeuvres and windows are the same"):
        db.Session.from_recordings(recording, manoeuvres=windows, windows=windows)
    with pytest.raises(db.DoubletError, match="autoregression_order: 0 is not an order"):
        session.replace({"estimation.autoregression_order": 0})


def test_generalised_least_squares_of_a_path(given):
    """Specific force with an autoregressive error of 0.98: generalised intervals are shorter and hold the estimate of the clean flight."""
    recording, aircraft, windows, noise = given
    clean = db.fit(db.coefficients(path_of(given)), {"CZ": "1 + alpha + qc/V + delta_e"})
    rng = np.random.default_rng(2)
    channels = {role: (recording[role].time, recording[role].values, recording[role].unit) for role in recording.roles}
    time, az, unit = channels["az"]
    error = np.zeros(len(az))
    for k, draw in enumerate(rng.normal(size=len(az) - 1), start=1):
        error[k] = 0.98 * error[k - 1] + 0.3 * np.sqrt(1 - 0.98**2) * draw
    noisy = db.Recording.from_arrays(None, {**channels, "az": (time, az + error, unit)}, check=False)
    coefs = db.coefficients(path_of((noisy, aircraft, windows, {**noise, "az": 0.3})))
    structure = {"CZ": ["1", "alpha", "qc/V", "delta_e"]}
    ordinary, whitened = db.fit(coefs, structure), db.fit(coefs, structure, method="gls")
    assert whitened["CZ_delta_e"].stderr < 0.7 * ordinary["CZ_delta_e"].stderr
    at = ordinary.coefficients["CZ"].names.index("CZ_delta_e")
    assert ordinary.coefficients["CZ"].stderr_white[at] < 0.6 * ordinary["CZ_delta_e"].stderr
    for name in ("CZ_alpha", "CZ_delta_e"):
        assert abs(whitened[name] - clean[name]) < 4 * np.hypot(whitened[name].stderr, clean[name].stderr), name
    one = coefs[0].name
    single = db.fit(coefs, structure, windows=[one], method="gls", order=3)
    columns = db.lstsq(coefs[one].regressors(structure["CZ"]), coefs[one]["CZ"], names=structure["CZ"], method="gls", order=3)
    assert single["CZ_alpha"] == pytest.approx(columns["alpha"], rel=1e-6)
    assert single.coefficients["CZ"].residuals == pytest.approx(columns.residuals, abs=1e-9)
    # A fit adds the errors of the flight path to those of the residuals.
    at = single.coefficients["CZ"].names.index("CZ_alpha")
    assert single.coefficients["CZ"].stderr_white[at] == pytest.approx(columns.stderr_white[columns.names.index("alpha")], rel=1e-6)
    assert 1.0 < single["CZ_alpha"].stderr / columns["alpha"].stderr < 1.02
    session = whitened.to_session()
    assert session["estimation.weights"] == "autoregression"
    same_as_its_session(whitened)
    assert db.fit(coefs, structure, method="gls", order=3).to_session()["estimation.autoregression_order"] == 3
    fixed = db.fit(coefs, structure, method="gls", constraints={("CZ", "qc/V"): -5.0})
    assert fixed["CZ_q"] == -5.0 and fixed["CZ_alpha"] != whitened["CZ_alpha"]
    assert whitened.cov.shape == (len(whitened.params),) * 2 and np.isfinite(whitened.cov).all()
    for wrong, text in (
        (dict(method="gls", weights="huber"), "exclude each other"),
        (dict(method="gls", order=0), "order is 0"),
        (dict(method="wls"), "'wls' is not a method of fit: use ols or gls"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.fit(coefs, structure, **wrong)


LIGHT = {"fuel_kg": {"main right": 60.0, "main left": 60.0}, "seats_kg": {"captain": 80.0}}


def ratio_of(path, usual):
    """Force coefficient of a path over that of another one: the ratio of the masses."""
    return float(np.median(db.coefficients(path)[0]["CZ"] / db.coefficients(usual)[0]["CZ"]))


def test_loading_and_changes_of_the_aircraft_reach_the_coefficients(given, usual):
    light = path_of(given, loading=LIGHT)
    assert 0.6 < ratio_of(light, usual) < 0.9
    assert light.to_session()["loading.seats_kg"] == {"captain": 80.0} and light.to_session()["loading.fuel_kg"]["main left"] == 60.0
    heavy = path_of(given, aircraft_changes={"mass.mass_kg": np.float64(1482.1)})
    assert 1.03 < ratio_of(heavy, usual) < 1.07
    assert heavy.to_session()["aircraft_changes"] == {"mass.mass_kg": 1482.1}
    for path in (light, heavy):
        same_as_its_session(fit_of(path))
    both = path_of(given, loading=LIGHT, aircraft_changes={"mass.mass_kg": 1482.1})
    assert ratio_of(both, light) == pytest.approx((1482.1 + 200.0) / (1382.1 + 200.0), rel=0.02)
    recording, _, windows, noise = given
    plane = db.Aircraft(area=18.7, span=11.6, chord=1.68, mass=2000.0, inertia=(2500.0, 3000.0, 5000.0))
    alone, changed = (path_of((recording, plane, windows, noise), **one) for one in ({}, {"aircraft_changes": {"mass.mass_kg": 4000.0}}))
    assert ratio_of(changed, alone) == pytest.approx(2.0, rel=1e-9)
    session = db.Session.from_recordings(recording, aircraft=plane, manoeuvres=windows, aircraft_changes={"mass.mass_kg": 4000.0}, loading={})
    assert session["aircraft_changes"] == {"mass.mass_kg": 4000.0}


def test_flights_have_loadings_of_their_own(given, usual):
    light = path_of(given, loading=LIGHT)
    pooled = db.fit([db.coefficients(usual), db.coefficients(light)], MODEL)
    flights = pooled.to_session()["flight"]
    assert "loading" not in flights[0] and flights[1]["loading"]["seats_kg"] == {"captain": 80.0}
    same_as_its_session(pooled)
    alike = db.fit([db.coefficients(path_of(given, loading=LIGHT)), db.coefficients(light)], MODEL).to_session()
    assert alike["loading.seats_kg"] == {"captain": 80.0} and not any("loading" in flight for flight in alike["flight"])
    heavy = path_of(given, aircraft_changes={"mass.mass_kg": 1482.1})
    with pytest.raises(db.DoubletError, match="the flights differ in aircraft_changes"):
        db.fit([db.coefficients(usual), db.coefficients(heavy)], MODEL)


def test_known_errors_of_sensors_are_removed(given, usual):
    path = path_of(given, sensor_errors={"known": {"scale_airspeed": 0.05}})
    assert float(np.median(path[0].smoothed.airspeed / usual[0].smoothed.airspeed)) == pytest.approx(1 / 1.05, abs=0.02)
    assert path.to_session()["sensor_errors.known"] == {"scale_airspeed": 0.05}
    same_as_its_session(fit_of(path))
    free = path_of(given, sensor_errors={"free": ["scale_alpha"], "outputs": ["airspeed", "alpha", "theta"]})
    np.testing.assert_array_equal(free[0].smoothed["u"], usual[0].smoothed["u"])
    found = free.results().to_dict()["sensor_errors"]["errors"]
    assert [row["error"] for row in found] == ["scale_alpha"] and found[0]["corrected_standard_error"] > 0


def test_what_an_aircraft_cannot_have_is_refused(given):
    recording, _, windows, noise = given
    for settings, text in (
        (dict(loading={"fuel_kg": {"main rigth": 1.0}}), "loading.fuel_kg.main rigth: the aircraft has no such place: did you mean .*main right"),
        (dict(loading={"seats_kg": {"captain": -1.0}}), "loading.seats_kg.captain is -1 kg: give 0 or more"),
        (dict(loading={"fuel": {}}), "no key of a session is called 'loading.fuel': did you mean 'loading.fuel_kg'"),
        (dict(sensor_errors={"knwon": {}}), "did you mean 'sensor_errors.known'"),
        (dict(sensor_errors={"known": {"scale_airsped": 0.1}}), "scale_airspeed"),
        (dict(aircraft_changes={"mass.mas_kg": 1.0}), "with the session's changes"),
        (dict(aircraft_changes={"mass.mass_kg": "heavy"}), "expected a number, three numbers"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            path_of(given, **settings)
    with pytest.raises(db.DoubletError, match="loading and aircraft_changes need an aircraft"):
        db.reconstruct(recording, windows=windows, noise=noise, loading=LIGHT)


def test_predictions_are_by_means_of_the_manoeuvres(given, usual):
    coefs = db.coefficients(usual)
    pooled, means = db.fit(coefs, MODEL), db.fit(coefs, MODEL, predict_with="manoeuvre_means")
    assert means.params == pooled.params and means.to_session()["estimation.predict_with"] == "manoeuvre_means"
    singles = [db.fit(coefs, MODEL, windows=[name]).coefficients["Cm"] for name in coefs.windows]
    assert all([name.partition("[")[0] for name in one.names] == ["Cm_0", "Cm_alpha", "Cm_q", "Cm_delta_e"] for one in singles)
    estimates = np.mean([one.estimates for one in singles], axis=0)
    for window in coefs:
        expected = window.regressors(MODEL["Cm"]) @ estimates
        np.testing.assert_allclose(means.predict("Cm")[window.name]["predicted"], expected, rtol=1e-6, atol=1e-9)
        assert not np.allclose(pooled.predict("Cm")[window.name]["predicted"], expected, rtol=1e-6, atol=1e-9)
    with pytest.raises(db.DoubletError, match="use pooled or manoeuvre_means"):
        db.fit(coefs, MODEL, predict_with="mean")
