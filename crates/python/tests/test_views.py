"""Paths, coefficients, fits and results as views of one session: reports, exports, proof of match, verdicts, frames, plots."""

import copy
import pickle
import warnings

import doublet as db
import numpy as np
import pytest

STRUCTURE = {"CX": "1 + alpha + alpha^2", "CZ": "1 + alpha + qc/V + delta_e", "Cm": "1 + alpha + qc/V + delta_e"}


@pytest.fixture(scope="module")
def made(demo):
    session = db.Session.load("builtin:demo")
    windows = [one for one in session.windows if one.surface == "elevator" and one.role == "identification"][:4]
    windows += [one for one in session.windows if one.surface == "elevator" and one.role == "validation"][:1]
    noise = {**session["filter.process_noise"], **session["filter.measurement_noise"]}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        path = db.reconstruct(
            demo.recording(), db.aircraft("c337f"), windows=windows, noise=noise, random_walk=session["filter.random_walk"],
            gravity=session["filter.gravity_m_s2"],
        )
        coefs = db.coefficients(path)
        return path, coefs, db.fit(coefs, STRUCTURE)


def test_every_view_has_results_reports_exports_and_matches(made, demo, tmp_path):
    fit = made[2]
    expected = fit.to_session().run()
    assert fit.results().to_dict()["pooled"] == expected.to_dict()["pooled"] and fit.results() is fit.results()
    bands = fit.match()
    assert len(bands) > 0 and list(bands) == list(db.match(fit)) and "verdict" in bands.title
    assert list(db.match(demo)) == list(demo.match())
    for number, one in enumerate([*made, demo]):
        assert one.results().verdict.level in ("good", "caution", "bad")
        assert isinstance(one.match(), db.Table)
        files = one.export("daveml", tmp_path / f"model{number}")
        assert any(name.endswith((".dml", ".xml")) for name in files)
    assert [name.rsplit("/")[-1] for name in db.export(fit, ["daveml"], tmp_path / "again")] == [
        name.rsplit("/")[-1] for name in fit.export("daveml", tmp_path / "third")
    ]
    with pytest.raises(db.DoubletError, match="'x' is not a format"):
        fit.export("x", tmp_path / "none")


def test_criterion_of_results_is_that_of_the_fit(made):
    fit = made[2]
    results = fit.results()
    assert results.nobs == fit.nobs
    for name, value in fit.aic.items():
        assert results.aic[name] == pytest.approx(value, rel=1e-6), name


def test_reports_are_written(made, demo, tmp_path):
    for number, one in enumerate([made[0], made[2], demo]):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", db.DoubletWarning)
            answer = one.report(tmp_path / f"report{number}", sections=["overview"])
        page = next((tmp_path / f"report{number}").glob("*.html")).read_text(encoding="utf-8")
        assert isinstance(answer, db.Answer) and "<html" in page
    assert made[2].results().to_dict()["title"] in next((tmp_path / "report1").glob("*.html")).read_text(encoding="utf-8")


def test_a_verdict_is_beside_models_designs_and_regressions(made):
    fit = made[2]
    linear = fit.linearise(airspeed=46.0, samples=10)
    assert linear.verdict == fit.verdict and linear["longitudinal"].verdict == fit.verdict
    for text in (repr(linear), fit.modes(airspeed=46.0, samples=10).summary(), repr(linear["longitudinal"])):
        assert f"verdict {fit.verdict.level}" in text
    design = db.design_input(fit, surfaces=["elevator"], duration=20.0, kind="3-2-1-1", rounds=0, samples=2, airspeed=46.0)
    assert design.verdict == fit.verdict and f"verdict {fit.verdict.level}" in design.summary()


def codes(regression):
    return {row["code"] for row in regression.verdict.findings}


def test_regressions_have_a_quality_check():
    rng = np.random.default_rng(4)
    X = np.column_stack([np.ones(600), rng.normal(size=(600, 2))])
    y = X @ [1.0, 2.0, -1.0] + 0.1 * rng.normal(size=600)
    good = db.lstsq(X, y)
    assert good.verdict.level == "good" and codes(good) == set() and "verdict good" in good.summary()
    twin = np.column_stack([X, X[:, 1] + 1e-4 * rng.normal(size=600)])
    near = db.lstsq(twin, y)
    assert codes(near) >= {"condition", "relative-error"} and near.verdict.level == "caution"
    assert "(limit 100)" in near.verdict.lines[0] and all(row["fix"] for row in near.verdict.findings)
    noise = np.zeros(600)
    for k, draw in enumerate(rng.normal(size=599), start=1):
        noise[k] = 0.999 * noise[k - 1] + draw
    assert codes(db.lstsq(X, y + noise, errors="white")) >= {"white"}
    assert codes(db.lstsq(X, y + noise)) >= {"correlation"} and "correlation" not in codes(db.lstsq(X, y + noise, method="gls"))
    groups = np.arange(600) // 2
    assert abs(db.lstsq(X, y + noise, groups=groups).correlation) < db.lstsq(X, y + noise).correlation
    wild = y + np.where(np.arange(600) % 50 == 7, 5.0, 0.0)
    assert codes(db.lstsq(X, wild)) == {"outliers"}
    assert "samples" in codes(db.lstsq(X[:20], y[:20]))
    fixed = db.lstsq(X, y, constraints={"x1": 2.0})
    assert codes(fixed) == set()


def test_intervals_of_results_output_error_and_equations(made, demo):
    low, high = demo.conf_int()["Cm_alpha"]
    assert (low, high) == pytest.approx(demo.derivatives["Cm_alpha"].interval)
    assert demo.conf_int(0.99)["Cm_alpha"][0] < low
    flown = next(one for one in db.output_error(made[2], axis="longitudinal") if one.error is None)
    assert flown.conf_int()["Cm_alpha"] == pytest.approx(flown.derivatives["Cm_alpha"].interval)
    assert np.sqrt(np.diag(flown.cov)) == pytest.approx([one.stderr for one in flown.derivatives.values()], rel=1e-9)
    correlation = flown.cov / np.outer(*[np.sqrt(np.diag(flown.cov))] * 2)
    np.testing.assert_allclose(correlation, correlation.T, atol=1e-12)
    assert np.linalg.eigvalsh(correlation).min() > -1e-9 and np.abs(np.triu(correlation, 1)).max() > 0.1
    assert flown.filter_error_cov.shape == (0, 0)
    filtered = next(one for one in db.output_error(made[2], axis="longitudinal", filter_error=True) if one.filter_error)
    assert np.sqrt(np.diag(filtered.filter_error_cov)) == pytest.approx([one.stderr for one in filtered.filter_error.values()], rel=1e-9)
    window = made[0].windows[0]
    found = db.equations(demo.recording(), "short-period", windows=[(window.start, window.end)])
    assert found.conf_int()["M_alpha"] == pytest.approx(found["M_alpha"].interval)
    with pytest.raises(db.DoubletError, match="between 0 and 1"):
        demo.conf_int(95)


def test_coefficients_are_predicted_at_new_regressors(made):
    pandas = pytest.importorskip("pandas")
    _, coefs, fit = made
    results = fit.results()
    for name, window in [(one.name, one) for one in coefs][:2]:
        known = fit.predict("Cm")[name]["predicted"]
        np.testing.assert_allclose(fit.predict("Cm", window), known, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(results.predict("Cm", window.to_pandas()), known, rtol=1e-6, atol=1e-8)
        own = fit.predict("Cm", window, manoeuvre=name)
        np.testing.assert_allclose(own, fit.predict("Cm", constants="own")[name]["predicted"], rtol=1e-9, atol=1e-12)
        assert not np.allclose(own, known)
    columns = np.column_stack([coefs[0][name] for name in ("alpha", "qc/V", "delta_e")])
    np.testing.assert_allclose(fit.predict("Cm", columns), fit.predict("Cm", coefs[0]), rtol=1e-12)
    frame = pandas.DataFrame({"alpha": [0.0, 0.1]})
    rise = fit["CX_alpha"] * 0.1 + fit["CX_alpha2"] * 0.01
    assert np.diff(fit.predict("CX", frame)) == pytest.approx([rise])
    assert np.diff(fit.predict("CX", frame.assign(**{"alpha^2": 0.0}))) == pytest.approx([fit["CX_alpha"] * 0.1])
    for call, text in (
        (lambda: results.predict("Cmm", frame), "no coefficient of the results is called 'Cmm': did you mean 'Cm'"),
        (lambda: results.predict("CX", frame.rename(columns={"alpha": "alfa"})), "no column is called 'alpha': did you mean 'alfa'"),
        (lambda: results.predict("Cm", frame), "no column is called 'qc/V'"),
        (lambda: results.predict("CX", frame, manoeuvre="nine"), "no manoeuvre with a constant is called 'nine'"),
    ):
        with pytest.raises(db.DoubletKeyError, match=text):
            call()
    with pytest.raises(db.DoubletError, match="X has 2 columns: give one for each of alpha, qc/V, delta_e"):
        results.predict("Cm", columns[:, :2])


def test_every_object_has_html_and_a_short_repr(made, demo):
    path, coefs, fit = made
    recording = demo.recording()
    t = np.arange(400) * 0.05
    response = db.frequency_response(np.sin(t) + np.sin(3 * t), np.cos(t), dt=0.05)
    linear = fit.linearise(airspeed=46.0, samples=10)
    flown = db.output_error(fit, axis="longitudinal")
    objects = [
        db.Session.load("builtin:demo"), db.aircraft("c337f"), path[0], coefs[0], flown[0], response, linear["longitudinal"],
        db.propagate(fit, "Cm_alpha", n=50), db.propagate(fit, lambda d: [d["Cm_alpha"], d["Cm_q"]], n=50), recording["q"], linear, fit, path,
    ]
    for one in objects:
        assert "<table" in one._repr_html_() and "</table>" in one._repr_html_(), type(one)
    for one in (response, recording["q"], linear["longitudinal"], path[0], coefs[0], db.Session.load("builtin:demo")):
        assert len(repr(one)) < 300 and "\n" not in repr(one), repr(one)
    assert "rad/s" in repr(recording["q"]) and "coherence" in repr(response)
    assert repr(db.Signal("x", np.zeros(0), np.zeros(0), "m", None)) == "<doublet.Signal x: no samples>"


def test_models_and_coefficients_are_drawn(made):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    _, coefs, fit = made
    linear = fit.linearise(airspeed=46.0, samples=10)
    axis = plt.subplots()[1]
    assert linear.plot(ax=axis) is axis and len(axis.lines) >= 2 and axis.get_xlabel() == "real part [1/s]"
    system = linear["longitudinal"]
    pair = plt.subplots(2, 1)[1]
    drawn = linear.bode(system.outputs[0], system.inputs[0], ax=pair)
    assert drawn[0] is pair[0] and drawn[1].get_xlabel() == "frequency [rad/s]"
    omega = np.array([0.5, 2.0])
    expected = [system.C[0] @ np.linalg.inv(1j * w * np.eye(len(system.states)) - system.A) @ system.B[:, 0] + system.D[0, 0] for w in omega]
    np.testing.assert_allclose(system.response(system.outputs[0], system.inputs[0], omega), expected, rtol=1e-9)
    with pytest.raises(db.DoubletKeyError, match="no response of the linear models"):
        linear.bode("nothing", "delta_e")
    with pytest.raises(db.DoubletError, match="give two"):
        system.bode(system.outputs[0], system.inputs[0], ax=axis)
    axis = plt.subplots()[1]
    assert coefs.plot("Cm", ax=axis) is axis and len(axis.lines) == len(coefs) and axis.get_ylabel() == "Cm [-]"
    assert len(coefs.plot("alpha", windows=coefs.windows[:1]).lines) == 1
    with pytest.raises(db.DoubletKeyError, match="did you mean 'alpha'"):
        coefs.plot("alfa")
    plt.close("all")


def test_frames_of_every_kind(made, demo):
    pytest.importorskip("pandas")
    pytest.importorskip("polars")
    pyarrow = pytest.importorskip("pyarrow")
    pytest.importorskip("xarray")
    path, coefs, _ = made
    recording = demo.recording()
    states = path[0].states.to_pandas()
    assert (states["theta_std"].to_numpy() == path[0].states.std["theta"]).all() and states.index.name == "time"
    for one in (recording, path, path[0], path[0].smoothed, coefs, coefs[0]):
        table, frame = one.to_pandas().reset_index(), one.to_polars()
        assert set(frame.columns) == set(table.columns) and len(frame) == len(table), type(one)
        for name in table.columns:
            if name != "window":
                np.testing.assert_array_equal(frame[name].to_numpy(), table[name].to_numpy(), err_msg=name)
        arrow = pyarrow.table(one)
        assert arrow.num_rows == len(table) and set(arrow.column_names) == set(table.columns)
    assert path.to_polars()["window"].to_list() == path.to_pandas()["window"].to_list()
    dataset = path.to_xarray()
    assert dataset.sizes["time"] == sum(len(one.time) for one in path) and dataset["theta"].attrs["units"] == "rad"
    second = dataset.isel(time=dataset["window"].to_numpy() == path.windows[1].name)
    np.testing.assert_array_equal(second["theta"].to_numpy(), path[1].smoothed["theta"])
    np.testing.assert_array_equal(second["theta_std"].to_numpy(), path[1].smoothed.std["theta"])
    again = db.Recording.from_frame(recording.to_polars(), check=False)
    assert again.roles == recording.roles


def test_what_follows_from_a_fit_pickles_and_copies(made, demo):
    _, coefs, fit = made
    t = np.arange(400) * 0.05
    regression = db.lstsq(np.column_stack([np.ones(400), np.sin(t)]), np.cos(t))
    linear = fit.linearise(airspeed=46.0, samples=10)
    flown = next(one for one in db.output_error(fit, axis="longitudinal") if one.error is None)
    design = db.design_input(fit, surfaces=["elevator"], duration=20.0, kind="3-2-1-1", rounds=0, samples=2, airspeed=46.0)
    window = made[0].windows[0]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        equations = db.equations(demo.recording(), "short-period", windows=[window])
    same = [
        (design, lambda one: (one.to_dict(), one.verdict, one.nodes()[0].tolist())),
        (linear, lambda one: (one.to_dict(), one.verdict)),
        (linear["longitudinal"], lambda one: (one.A.tolist(), one.units, one.verdict)),
        (equations, lambda one: (one.params, one.verdict, one.nobs)),
        (flown, lambda one: (one.derivatives, one.error, [values.tolist() for values in one.outputs["q"][:3]])),
        (db.frequency_response(np.sin(t) + np.sin(3 * t), np.cos(t), dt=0.05), lambda one: (one.response.tolist(), repr(one))),
        (regression, lambda one: (one.names, one.params.tolist(), one.verdict)),
        (db.propagate(fit, lambda d: d["Cm_alpha"], n=50), lambda one: (one.value, one.samples.tolist(), one.interval)),
        (db.propagate(fit, "Cm_alpha", n=50), lambda one: (one.value, one.interval)),
        (fit.verdict, lambda one: (dict(one), one.level, one.lines)),
        (fit.coefficients["Cm"], lambda one: (one.names, one.cov.tolist())),
        (coefs[0], lambda one: (one.name, one["Cm"].tolist())),
        (made[0][0].smoothed, lambda one: (one.time.tolist(), one["theta"].tolist(), one.std["theta"].tolist())),
        (window, repr),
        (db.LeastSquares().fit({"alpha": np.sin(t)}, np.cos(t)), lambda one: (one.coef_.tolist(), list(one.feature_names_in_))),
    ]
    for one, shown in same:
        for again in (pickle.loads(pickle.dumps(one)), copy.deepcopy(one), copy.copy(one)):
            assert type(again) is type(one) and shown(again) == shown(one), type(one)
