"""From a frame to derivatives, modes and what follows from them, beside the results of the shipped session and its truth."""

import doublet as db
import numpy as np
import pytest

STRUCTURE = {
    "CX": ["1", "alpha", "alpha^2", "qc/V", "delta_e"],
    "CZ": ["1", "alpha", "qc/V", "delta_e"],
    "Cm": ["1", "alpha", "qc/V", "delta_e"],
    "CY": ["1", "beta", "pb/2V", "rb/2V", "delta_a", "delta_r"],
    "Cl": ["1", "beta", "pb/2V", "rb/2V", "delta_a", "delta_r"],
    "Cn": ["1", "beta", "pb/2V", "rb/2V", "delta_a", "delta_r"],
}


@pytest.fixture(scope="module")
def recording(demo):
    return demo.recording()


@pytest.fixture(scope="module")
def windows():
    return db.Session.load("builtin:demo").windows


@pytest.fixture(scope="module")
def path(recording, windows):
    session = db.Session.load("builtin:demo")
    noise = {**session["filter.process_noise"], **session["filter.measurement_noise"]}
    return db.reconstruct(recording, db.aircraft("c337f"), windows=windows, noise=noise)


@pytest.fixture(scope="module")
def fit(path):
    return db.fit(db.coefficients(path), STRUCTURE)


def test_recording_has_channels_in_si(recording):
    q = recording["q"]
    assert q.unit == "rad/s" and q.role == "q" and len(q.time) == len(q.values)
    assert not q.values.flags.writeable and not q.values.flags.owndata
    assert "alpha" in recording and "nothing" not in recording
    with pytest.raises(db.DoubletError, match="no channel or role is called 'nothing'"):
        recording["nothing"]
    assert all(row["level"] != "bad" for row in recording.check())
    found = db.find_manoeuvres(recording)
    assert len(found) > 15 and {window.surface for window in found} == {"elevator", "aileron", "rudder"}


def test_path_has_states_with_deviations(path, demo):
    assert len(path) == len(demo.windows)
    one = path[0]
    states, smoothed = one.states, one.smoothed
    assert set(states) == set(states.std) and len(states) == 18
    assert all(states[name].shape == one.time.shape for name in states)
    middle = len(one.time) // 2
    assert (smoothed.std["u"][middle:-50] <= states.std["u"][middle:-50] * (1 + 1e-9)).all()
    ours, theirs = smoothed["theta"], demo.states(one.window.name)
    assert np.abs(np.interp(theirs["time"], one.time, ours) - theirs["theta"]).max() < 0.002
    ratio = np.nanmean(one.nis) / np.mean(one.nis_degrees[one.nis_degrees > 0])
    assert 0.5 < ratio < 2.0
    assert one.window.name in path.summary() and "<table>" in path._repr_html_()
    innovations, deviations = one.innovations["alpha"]
    assert innovations.shape == one.update_time.shape and np.nanmin(deviations) > 0
    with pytest.raises(db.DoubletError, match="windows: take states of one"):
        path.states


def test_fit_is_near_the_truth_and_the_session(fit, demo):
    for name in ("Cm_alpha", "Cm_q", "Cm_delta_e", "CZ_alpha", "Cl_p", "Cl_beta", "Cn_beta", "Cn_r", "Cn_delta_r"):
        ours, theirs = fit[name], demo.derivatives[name]
        assert abs(ours.value - theirs.value) < 4 * np.hypot(ours.stderr, theirs.stderr), (name, ours, theirs)
    one = fit.coefficients["Cm"]
    assert one.r2 > 0.9 and one.cov.shape == (len(one.names),) * 2
    np.testing.assert_allclose(np.sqrt(np.diag(one.cov)), one.stderr, rtol=1e-12)
    assert (one.stderr > one.stderr_white).mean() > 0.5
    assert "Cm_alpha" in fit.summary() and "<table>" in fit._repr_html_()
    assert {row["role"] for row in fit.predictions} >= {"identification", "validation"}


def test_windows_and_constraints_are_obeyed(path):
    coefs = db.coefficients(path)
    names = [window.name for window in path.windows if window.surface == "elevator"]
    half = db.fit(coefs, {"Cm": STRUCTURE["Cm"]}, windows=names[:2])
    assert half.coefficients["Cm"].windows == names[:2]
    fixed = db.fit(coefs, {"Cm": STRUCTURE["Cm"]}, constraints={("Cm", "qc/V"): -10.0})
    assert fixed["Cm_q"].value == -10.0 and fixed.coefficients["Cm"].held[fixed.coefficients["Cm"].names.index("Cm_q")] == "fixed"
    with pytest.raises(db.DoubletError, match="no manoeuvre is called 'x'"):
        db.fit(coefs, {"Cm": ["1", "alpha"]}, windows=["x"])
    with pytest.raises(db.DoubletError, match="'Cz' is not a coefficient"):
        db.fit(coefs, {"Cz": ["1"]})
    with pytest.raises(db.DoubletError, match="term|variable"):
        db.fit(coefs, {"Cm": ["1", "alfa"]})


def test_columns_go_to_other_packages(path):
    coefs = db.coefficients(path)
    name = next(window.name for window in path.windows if window.surface == "elevator")
    frame = coefs[name].to_pandas()
    assert {"Cm", "alpha", "qc/V", "delta_e"} <= set(frame.columns)
    terms = ["alpha", "qc/V", "delta_e"]
    regression = db.lstsq(frame[terms].assign(constant=1.0), frame["Cm"])
    same = db.fit(coefs, {"Cm": STRUCTURE["Cm"]}, windows=[name])
    assert abs(regression["alpha"].value - same["Cm_alpha"].value) < 1e-9
    # A fit adds the errors of the flight path to those of the residuals.
    row = same.coefficients["Cm"]
    white = regression.stderr_white[regression.names.index("alpha")]
    assert abs(white - row.stderr_white[row.names.index("Cm_alpha")]) < 1e-9
    assert 1.0 < same["Cm_alpha"].stderr / regression["alpha"].stderr < 1.3
    columns = coefs[name].regressors(["1", "alpha^2", "qc/V"])
    assert (columns[:, 0] == 1.0).all() and (columns[:, 2] == frame["qc/V"]).all() and columns.shape == (len(frame), 3)


def test_aeroid_like_use_in_ten_lines(recording):
    control = pytest.importorskip("control")
    frame = recording.to_pandas(step=0.02)
    frame[["p", "q", "r", "alpha"]] = np.degrees(frame[["p", "q", "r", "alpha"]])
    units = {"p": "deg/s", "q": "deg/s", "r": "deg/s", "alpha": "deg"}
    rec = db.Recording.from_frame(frame, units=units)
    path = db.reconstruct(rec, db.aircraft("c337f"), windows=db.find_manoeuvres(rec))
    fit = db.fit(db.coefficients(path), STRUCTURE)
    linear = fit.linearise(airspeed=46.0, samples=50)
    system = linear["longitudinal"].to_control()
    assert isinstance(system, control.StateSpace) and system.A.shape == (4, 4)
    poles = sorted(control.poles(system), key=abs)
    fast = next(row for row in linear.modes if row["name"] == "short period")
    assert abs(abs(poles[-1]) - fast["frequency_rad_s"]) < 0.02 * fast["frequency_rad_s"]
    assert fast["frequency_rad_s_low"] < fast["frequency_rad_s"] < fast["frequency_rad_s_high"]


def test_frame_and_arrays_are_the_same_recording(recording):
    frame = recording.to_pandas(step=0.05)
    one = db.Recording.from_frame(frame)
    two = db.Recording.from_arrays(frame.index.to_numpy(), {name: frame[name].to_numpy() for name in frame.columns})
    assert one.roles == two.roles and (one["q"].values == two["q"].values).all()
    turned = db.Recording.from_frame(frame.assign(q=-frame["q"]))
    assert any(row["level"] == "bad" and row["channel"] == "q" and "sign" in row["hypothesis"] for row in turned.check())


def test_arrays_that_cannot_be_are_refused():
    t = np.arange(100) * 0.01
    with pytest.raises(db.DoubletError, match="does not increase at sample 50"):
        db.Recording.from_arrays(np.where(np.arange(100) == 50, 0.0, t), {"q": t})
    with pytest.raises(db.DoubletError, match="'q' is in kt, its role is one of rad/s"):
        db.Recording.from_arrays(t, {"q": (t, "kt")})
    with pytest.raises(db.DoubletError, match="unknown unit 'furlong'"):
        db.Recording.from_arrays(t, {"q": (t, "furlong")})
    with pytest.raises(db.DoubletError, match="has 99 values and its time 100"):
        db.Recording.from_arrays(t, {"q": t[:-1]})
    with pytest.raises(db.DoubletError, match="must be numbers"):
        db.Recording.from_arrays(t, {"q": ["a"] * 100})
    with pytest.raises(db.DoubletError, match="the recording has no ax"):
        db.reconstruct(db.Recording.from_arrays(t, {"p": t, "q": t, "r": t}))
    with pytest.raises(db.DoubletError, match="no aircraft 'none-such'"):
        db.aircraft("none-such")
    with pytest.raises(db.DoubletError, match="inertia|moments|mass"):
        db.Aircraft(area=1.0, span=1.0, chord=1.0, mass=-1.0, inertia=(1.0, 1.0, 1.0))


def test_functions_of_derivatives_have_intervals(fit):
    drawn = db.propagate(fit, lambda d: -d["Cm_alpha"] / d["CZ_alpha"], n=1000)
    named = db.propagate(fit, "-Cm_alpha/CZ_alpha", n=1000)
    assert abs(drawn.value - named.value) < 1e-12
    assert 0.7 < drawn.std / named.std < 1.4
    low, high = drawn.interval
    assert low < drawn.value < high and drawn.samples.shape == (1000,)
    assert (db.propagate(fit, lambda d: d["Cm_q"], n=50, seed=7).samples == db.propagate(fit, lambda d: d["Cm_q"], n=50, seed=7).samples).all()
    with pytest.raises(db.DoubletError, match="Cm_beta|derivative"):
        db.propagate(fit, "Cm_beta")


def test_output_error_follows_a_window(path, fit):
    name = next(window.name for window in path.windows if window.surface == "elevator")
    found = next(row for row in db.output_error(fit) if row.window == name)
    assert found.error is None and found.axis == "longitudinal"
    time, measured, flown, r2 = found.outputs["q"]
    assert time.shape == measured.shape == flown.shape and r2 > 0.9
    assert abs(found.derivatives["Cm_alpha"].value - fit["Cm_alpha"].value) < 0.3


def test_plain_aircraft_is_that_of_its_file(tmp_path):
    plain = db.Aircraft(area=18.6, span=11.6, chord=1.66, mass=1980.0, inertia=(3600.0, 4500.0, 7300.0, 300.0), name="own")
    assert plain.mass == 1980.0 and plain.inertia == [3600.0, 4500.0, 7300.0, 300.0]
    (tmp_path / "own.toml").write_text(plain.text)
    again = db.aircraft(tmp_path / "own.toml")
    assert (again.area, again.span, again.chord, again.mass) == (plain.area, plain.span, plain.chord, plain.mass)
    with pytest.raises(AttributeError):
        plain.colour


def test_plots_are_drawn(demo, path, fit, recording):
    pytest.importorskip("matplotlib")
    import matplotlib

    matplotlib.use("Agg")
    assert len(recording.plot("q", "alpha")) == 2
    assert len(path[0].plot("u", "theta")) == 2
    assert demo.plot("Cm").get_yticks().size > 2
    assert fit.plot("Cm").get_ylabel() == "Cm [-]"
