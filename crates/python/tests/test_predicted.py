"""Covariance between coefficients, predicted measurements, simulated manoeuvres, and warnings before a run."""

import os
import subprocess
import sys
import warnings

import doublet as db
import numpy as np
import pytest

STRUCTURE = {"CX": "1 + alpha + alpha^2", "CZ": "1 + alpha + qc/V + delta_e", "Cm": "1 + alpha + qc/V + delta_e"}


@pytest.fixture(scope="module")
def made(demo):
    session = db.Session.load("builtin:demo")
    windows = [one for one in session.windows if one.surface == "elevator"]
    windows = [one for one in windows if one.role == "identification"][:3] + [one for one in windows if one.role == "validation"][:1]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        path = db.reconstruct(
            demo.recording(), db.aircraft("c337f"), windows=windows, gravity=session["filter.gravity_m_s2"],
            noise={**session["filter.process_noise"], **session["filter.measurement_noise"]}, random_walk=session["filter.random_walk"],
        )
        coefs = db.coefficients(path)
        return path, coefs, db.fit(coefs, STRUCTURE, constants="common")


def correlation(cov):
    deviations = np.sqrt(np.diag(cov))
    return cov / np.outer(deviations, deviations)


def sandwich(coefs, fit):
    """Correlation of all estimates by the definition: sums over pairs of samples, cross-correlations of residuals tapered by Parzen's
    window; without what the fit took of the noise."""
    used = fit.coefficients["Cm"].windows
    X = {name: [coefs[one].regressors(terms) for one in used] for name, terms in STRUCTURE.items()}
    ends = np.cumsum([len(part) for part in X["Cm"]])[:-1]
    parts = {name: np.split(row.residuals, ends) for name, row in fit.coefficients.items()}
    lengths = [len(part) for part in X["Cm"]]
    most = min(min(lengths) // 2, sum(lengths) // 5)
    x = np.arange(most + 1) / (most + 1)
    taper = np.where(x <= 0.5, 1 - 6 * x**2 * (1 - x), 2 * (1 - x) ** 3)
    rows = []
    for a in STRUCTURE:
        row, inverse_a = [], np.linalg.inv(sum(part.T @ part for part in X[a]))
        for b in STRUCTURE:
            lags = np.arange(-most, most + 1)
            products = [sum(u[max(0, -k) : len(u) - max(0, k)] @ v[max(0, k) : len(v) + min(0, k)] for u, v in zip(parts[a], parts[b])) for k in lags]
            noise = dict(zip(lags, taper[abs(lags)] * products / sum(lengths)))
            middle = np.zeros((X[a][0].shape[1], X[b][0].shape[1]))
            for left, right in zip(X[a], X[b]):
                count = len(left)
                matrix = np.array([[noise.get(j - i, 0.0) for j in range(count)] for i in range(count)])
                middle += left.T @ matrix @ right
            row.append(inverse_a @ middle @ np.linalg.inv(sum(part.T @ part for part in X[b])))
        rows.append(row)
    return correlation(np.block(rows))


def test_covariance_between_coefficients_is_that_of_their_common_residuals(made):
    _, coefs, fit = made
    names, found = list(fit.params), correlation(fit.cov)
    expected = sandwich(coefs, fit)
    across = np.array([[a.split("_")[0] != b.split("_")[0] for b in names] for a in names])
    assert np.abs(expected[across]).max() > 0.2
    np.testing.assert_allclose(found, expected, atol=0.03)
    np.testing.assert_allclose(found, found.T, atol=1e-12)
    assert np.linalg.eigvalsh(found).min() > -1e-9
    white = db.fit(coefs, STRUCTURE, constants="common", errors="white").cov
    assert (white[across] == 0.0).all() and (np.diag(white) > 0).all()


def test_covariance_of_results_is_that_of_the_fit(made, demo):
    fit = made[2]
    results = fit.results()
    assert list(results.derivatives) == list(fit.params)
    np.testing.assert_allclose(correlation(results.cov), correlation(fit.cov), atol=1e-6)
    errors = np.array([one.stderr for one in demo.derivatives.values()])
    np.testing.assert_allclose(np.sqrt(np.diag(demo.cov)), errors, rtol=1e-9)
    # With a constant for each manoeuvre: constants and derivatives of several coefficients too.
    assert np.linalg.eigvalsh(correlation(demo.cov)).min() > -1e-9
    names = list(demo.derivatives)
    assert abs(demo.cov[names.index("CZ_alpha"), names.index("Cm_alpha")]) > 0
    # A function of two coefficients has the deviation that the covariance gives it.
    slope = np.zeros(len(fit.params))
    slope[list(fit.params).index("CZ_delta_e")], slope[list(fit.params).index("Cm_delta_e")] = 1.0, 1.0
    drawn = db.propagate(fit, lambda d: d["CZ_delta_e"] + d["Cm_delta_e"], n=20000)
    assert drawn.std == pytest.approx(np.sqrt(slope @ fit.cov @ slope), rel=0.02)


def test_measurements_are_predicted_and_reconstructed(made, demo):
    path = made[0]
    one = path[0]
    found = one.measurements
    assert set(found) == set(one.innovations)
    for name, row in found.items():
        innovations, deviations = (values[np.isfinite(one.innovations[name][0])] for values in one.innovations[name])
        known = np.isfinite(row["predicted"])
        assert np.sum(~known) <= 2
        np.testing.assert_allclose((row["measured"] - row["predicted"])[known], innovations, atol=1e-9, err_msg=name)
        np.testing.assert_array_equal(row["predicted_std"][known], deviations)
        assert row["time"].shape == row["reconstructed"].shape and one.window.start <= row["time"][0] <= row["time"][-1] <= one.window.end
    smoothed = one.smoothed
    np.testing.assert_allclose(found["theta"]["reconstructed"], np.interp(found["theta"]["time"], one.time, smoothed["theta"]), atol=1e-12)
    np.testing.assert_allclose(found["alpha"]["reconstructed"], np.interp(found["alpha"]["time"], one.time, smoothed.alpha), atol=1e-6)
    recording = demo.recording()
    inside = np.isin(recording["theta"].time, found["theta"]["time"])
    np.testing.assert_allclose(recording["theta"].values[inside], found["theta"]["measured"], atol=1e-9)
    np.testing.assert_allclose(np.sqrt(np.diag(one.final_cov)), [one.states.std[name][-1] for name in one.states], rtol=1e-9)
    np.testing.assert_allclose(one.final_cov, one.final_cov.T, rtol=1e-9)
    # Prediction is worse than reconstruction, and as good as it says.
    theta = found["theta"]
    late = slice(len(theta["time"]) // 4, None)
    error = (theta["measured"] - theta["predicted"])[late]
    assert 0.5 < np.nanmean((error / theta["predicted_std"][late]) ** 2) < 2.0
    assert np.nanstd(error) > np.std((theta["measured"] - theta["reconstructed"])[late])
    window = demo.windows[0]["name"]
    theirs, states = demo.measurements(window), demo.states(window)
    expected = np.interp(theirs["theta"]["time"], states["time"], states["theta"])
    # Delays that the session found move the samples.
    assert np.abs(theirs["theta"]["reconstructed"] - expected).max() < 0.01
    with pytest.raises(db.DoubletKeyError, match="no manoeuvre is called 'x'"):
        demo.measurements("x")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        plain = db.reconstruct(recording, windows=path.windows[:1], measured=True)[0].measurements["theta"]
    assert np.isnan(plain["predicted"]).all() and np.isfinite(plain["reconstructed"]).all()


def theil(measured, simulated):
    """Theil's inequality coefficient of the changes from the start."""
    a, b = measured - measured[0], simulated - measured[0]
    return np.sqrt(np.mean((a - b) ** 2)) / (np.sqrt(np.mean(a**2)) + np.sqrt(np.mean(b**2)))


def test_manoeuvres_are_simulated_by_the_model(demo):
    replayed = demo.to_dict()["proof_of_match"]["windows"]
    assert len(replayed) > 1
    for row in replayed:
        found = demo.simulate(row["window"])
        for expected in row["theil"]:
            one = found[expected["signal"]]
            assert theil(one["measured"], one["simulated"]) == pytest.approx(expected["coefficient"], rel=1e-9), (row["window"], expected)
    used = next(one for one in demo.windows if one["role"] == "identification" and "elevator" in one["name"])["name"]
    one = demo.simulate(used)
    time, phi, theta, q, r = one["q"]["time"], *(one[name]["simulated"] for name in ("phi", "theta", "q", "r"))
    # The motion obeys kinematics: pitch rate and yaw rate turn the pitch angle.
    rate = q * np.cos(phi) - r * np.sin(phi)
    turned = theta[0] + np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))])
    np.testing.assert_allclose(turned, theta, atol=2e-4)
    assert np.ptp(theta) > 0.02


def test_a_fit_simulates_as_its_session(made, demo):
    session = db.Session.load("builtin:demo")
    used = [one for surface in ("aileron", "rudder") for one in [row for row in session.windows if row.surface == surface][:2]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        path = db.reconstruct(
            demo.recording(), db.aircraft("c337f"), windows=[*used, *made[0].windows], gravity=session["filter.gravity_m_s2"],
            noise={**session["filter.process_noise"], **session["filter.measurement_noise"]},
        )
        fit = db.fit(db.coefficients(path), session["model"])
    validation = made[0].windows[-1].name
    ours, theirs = fit.simulate(validation), fit.results().simulate(validation)
    assert set(ours) == set(theirs) >= {"airspeed", "alpha", "theta", "q"}
    for name in ("alpha", "q"):
        np.testing.assert_allclose(ours[name]["simulated"], theirs[name]["simulated"], atol=1e-6)
        assert np.corrcoef(ours[name]["measured"], ours[name]["simulated"])[0, 1] > 0.9
    with pytest.raises(db.DoubletKeyError, match="no manoeuvre is called 'x'"):
        fit.simulate("x")
    lacking = db.fit(made[1], {"Cm": STRUCTURE["Cm"]})
    with pytest.raises(db.DoubletError, match=f"manoeuvre '{validation}'"):
        lacking.simulate(validation)


def test_output_error_without_a_result_is_refused(made):
    with pytest.raises(db.DoubletError, match="^window '"):
        db.output_error(made[2], axis="lateral")


def test_generalised_least_squares_of_an_exact_fit_is_exact():
    X = np.column_stack([np.ones(200), np.sin(0.1 * np.arange(200)), np.cos(0.37 * np.arange(200))])
    found = db.lstsq(X, X @ [1.0, -2.0, 0.5], method="gls")
    np.testing.assert_allclose(found.params, [1.0, -2.0, 0.5], rtol=1e-12)
    assert (found.stderr < 1e-13).all() and np.abs(found.residuals).max() < 1e-13 and found.r2 == pytest.approx(1.0)
    assert db.lstsq(X, np.zeros(200), method="gls").params.tolist() == [0.0, 0.0, 0.0]
    assert found.df_resid == 197 and db.lstsq(X, X[:, 1], constraints={"x0": 0.0}).df_resid == 198
    model = db.LeastSquares(method="gls", fit_intercept=False).fit(X, X[:, 1])
    np.testing.assert_allclose(model.coef_, [0.0, 1.0, 0.0], atol=1e-13)


#: A recording that is long beside what the process may still take, with warnings as errors: the run does not begin.
SHORT_OF_MEMORY = """
import re, resource, warnings
import numpy as np
import doublet as db

t = np.arange(240_000) * 0.01
still = {name: np.zeros(len(t)) for name in ("ax", "ay", "p", "q", "r", "phi", "theta")}
recording = db.Recording.from_arrays(t, {**still, "az": np.full(len(t), -9.8), "airspeed": (np.full(len(t), 50.0), "m/s")}, check=False)
session = db.Session.from_recordings(recording, windows=[(0.0, 2399.0)])
warnings.simplefilter("ignore")
session.recording()
taken = 1024 * int(re.search(r"VmSize:\\s*(\\d+)", open("/proc/self/status").read())[1])
# 240,000 samples need 288 to 432 MB.
resource.setrlimit(resource.RLIMIT_AS, (taken + 420_000_000, resource.getrlimit(resource.RLIMIT_AS)[1]))
warnings.simplefilter("error", db.DoubletWarning)
for call in (lambda: db.reconstruct(recording, windows=[(0.0, 2399.0)]), session.run):
    try:
        call()
    except db.DoubletWarning as warning:
        print(warning)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="limits of memory by the system's own files")
def test_a_lack_of_memory_is_warned_of_before_the_run():
    done = subprocess.run(
        [sys.executable, "-c", SHORT_OF_MEMORY], capture_output=True, text=True, timeout=600, env={**os.environ, "MALLOC_ARENA_MAX": "1"}
    )
    lines = done.stdout.splitlines()
    assert len(lines) == 2, done.stdout + done.stderr
    for line in lines:
        assert "samples need up to 0.4 GB (available 0.4 GB)" in line and "Shorten the manoeuvres" in line, line
