"""Equations of motion of one's own."""

import pickle
import signal
import threading
import time

import doublet as db
import numpy as np
import pytest

TRUTH = {"Z_alpha": -1.2, "M_alpha": -6.0, "M_q": -1.5, "M_delta_e": -8.0}
EQUATIONS = {
    "inputs": ["delta_e"],
    "states": {"alpha": "Z_alpha*alpha + q", "q": "M_alpha*alpha + M_q*q + M_delta_e*delta_e"},
    "outputs": {"alpha": "alpha", "q": "q"},
    "parameters": {"Z_alpha": -1.0, "M_alpha": -4.0, "M_q": -1.0, "M_delta_e": -5.0},
}


@pytest.fixture(scope="module")
def frame():
    """Short period after a doublet, 50 Hz, with noise of 0.1 degrees."""
    pandas = pytest.importorskip("pandas")
    step, count = 0.02, 600
    time = np.arange(count) * step
    delta = np.radians(3) * (np.where((time > 1) & (time < 2), 1.0, 0.0) - np.where((time > 2) & (time < 3), 1.0, 0.0))
    state, rows = np.zeros(2), []
    for value in delta:
        rows.append(state)
        for _ in range(20):
            alpha, q = state
            rate = np.array([TRUTH["Z_alpha"] * alpha + q, TRUTH["M_alpha"] * alpha + TRUTH["M_q"] * q + TRUTH["M_delta_e"] * value])
            state = state + step / 20 * rate
    measured = np.array(rows) + np.radians(0.1) * np.random.default_rng(1).normal(size=(count, 2))
    return pandas.DataFrame({"time": time, "delta_e": delta, "alpha": measured[:, 0], "q": measured[:, 1]})


def test_equations_of_a_mapping_find_the_truth(frame):
    found = db.equations(frame, EQUATIONS)
    assert set(found.params) == set(TRUTH) and found.method in ("output_error", "filter_error")
    for name, truth in TRUTH.items():
        assert abs(found[name] - truth) < 4 * found[name].stderr < abs(truth), name
    assert found.r2["q"] > 0.9 and found.verdict.level in ("good", "caution", "bad")
    assert f"verdict {found.verdict.level}" in found.summary() and "verdict" in found._repr_html_()
    assert {row["method"] for row in found.table} == {"equation_error", "output_error", "filter_error"} - set(found.errors)
    assert pickle.loads(pickle.dumps(found)).params == found.params


def test_equations_of_a_file_are_the_same(frame, tmp_path):
    found = db.equations(frame, "short-period")
    frame.to_csv(tmp_path / "flight.csv", index=False)
    assert db.equations(tmp_path / "flight.csv", "short-period").params == found.params
    indexed = frame.set_index("time").rename(columns={"alpha": "ALPHA"})
    again = db.equations(indexed.assign(ALPHA=np.degrees(indexed["ALPHA"])), "short-period", columns={"alpha": "ALPHA*pi/180"})
    assert again["M_alpha"] == pytest.approx(found["M_alpha"], rel=1e-6)
    part = db.equations(frame, "short-period", windows=[(0.5, 8.0)], constants={})
    assert part["M_alpha"] != found["M_alpha"]


def test_errors_say_what_is_wrong(frame):
    with pytest.raises(db.DoubletKeyError, match="no key of equations is called 'state': did you mean 'states'"):
        db.equations(frame, {"state": {}})
    with pytest.raises(db.DoubletError, match="nofile"):
        db.equations(frame, "nofile.toml")
    with pytest.raises(db.DoubletError, match="delta_e"):
        db.equations(frame.drop(columns="delta_e"), "short-period")
    with pytest.raises(db.DoubletError, match="is not a frame"):
        db.equations(object(), "short-period")
    with pytest.raises(db.DoubletKeyError, match="no method"):
        db.equations(frame, EQUATIONS).by("ols")


def rates(x, u, p):
    alpha, q = x
    return [p.Z_alpha * alpha + q, p.M_alpha * alpha + p["M_q"] * q + p.M_delta_e * u.delta_e]


FUNCTIONS = {"inputs": ["delta_e"], "states": ["alpha", "q"], "rates": rates, "parameters": EQUATIONS["parameters"]}


def point_by_point(x, u, p):
    """The same by matrices, which does not take arrays."""
    a, b = np.array([[p.Z_alpha, 1.0], [p.M_alpha, p.M_q]]), np.array([0.0, p.M_delta_e])
    return a @ x + b * u.delta_e


@pytest.mark.parametrize("function", [rates, point_by_point])
def test_a_function_gives_what_its_expressions_give(frame, function):
    frame = frame.iloc[45:145] if function is point_by_point else frame
    expected = db.equations(frame, EQUATIONS)
    found = db.equations(frame, {**FUNCTIONS, "rates": function})
    assert found.method == expected.method and found.verdict == expected.verdict
    for method in ("equation_error", "output_error", "filter_error"):
        for name, value in expected.by(method).items():
            assert found.by(method)[name] == pytest.approx(value, rel=1e-9), (method, name)
            assert found.by(method)[name].stderr == pytest.approx(value.stderr, rel=1e-6), (method, name)
    assert pickle.loads(pickle.dumps(found)).params == found.params


def test_functions_of_more_than_expressions(frame):
    """A table by interpolation, another output than the states, constants and a window."""
    grid, slope = np.array([-0.2, 0.0, 0.2]), np.array([0.2, 0.0, -0.2])
    both = {
        **FUNCTIONS,
        "rates": lambda x, u, p: {
            "q": p.M_alpha * np.interp(-x.alpha, grid, slope) * p.one + p.M_q * x.q + p.M_delta_e * u.delta_e,
            "alpha": p.Z_alpha * x.alpha + x.q,
        },
        "outputs": ["alpha", "q", "az"],
        "shows": lambda x, u, p: p.V0 * p.Z_alpha * x.alpha,
        "constants": {"V0": 40.0, "one": 1.0},
    }
    wide = frame.assign(az=50.0 * TRUTH["Z_alpha"] * frame["alpha"])
    found = db.equations(wide, both, constants={"V0": 50.0}, windows=[(0.5, 10.0)])
    for name, truth in TRUTH.items():
        assert abs(found[name] - truth) < 0.1 * abs(truth), name
    assert set(found.r2) == {"alpha", "q", "az"}
    with pytest.raises(db.DoubletKeyError, match="no constant of the equations is called 'V_0': did you mean 'V0'"):
        db.equations(wide, both, constants={"V_0": 50.0})


def test_what_a_function_does_wrong_is_said(frame):
    def boom(x, u, p):
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        db.equations(frame, {**FUNCTIONS, "rates": boom})
    for wrong, text in (
        (lambda x, u, p: [x.q], "rates returned 1 values: return one for each of alpha, q"),
        (lambda x, u, p: None, "rates returned None: return a value for each of alpha, q"),
        (lambda x, u, p: {"alpha": x.q}, "no value that rates returned is called 'q'"),
        (lambda x, u, p: [x.q, x.q * 1j], "rates returned a complex128 for 'q': return real numbers"),
        (lambda x, u, p: [x.q, p["M_alfa"]], "no value is called 'M_alfa': did you mean 'M_alpha'"),
        (lambda x, u, p: [np.zeros(3), x.q], r"array of shape \(3,\) for 'alpha'"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.equations(frame, {**FUNCTIONS, "rates": wrong})
    with pytest.raises(AttributeError, match="did you mean 'M_alpha'"):
        db.equations(frame, {**FUNCTIONS, "rates": lambda x, u, p: [x.q, p.M_alfa]})
    for wrong, text in (
        ({**FUNCTIONS, "rates": "q"}, "'rates' must be a function"),
        ({**FUNCTIONS, "outputs": ["az"]}, "output 'az' is not a state: give a function of az as 'shows'"),
        ({**FUNCTIONS, "shows": rates}, "'shows' is not used"),
        ({**FUNCTIONS, "states": {"alpha": "q"}}, "'states' must be a list of names"),
        ({**FUNCTIONS, "inputs": ["delta_e", "q"]}, "'q' is both a state and an input"),
        ({**EQUATIONS, "states": {"alpha": rates}}, "give one function of all states as 'rates'"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.equations(frame, wrong)
    with pytest.raises(db.DoubletError, match="dt is -1: give a time above 0 s"):
        db.equations(frame, FUNCTIONS, dt=-1)


def test_functions_let_others_run_and_are_interrupted(frame):
    """Another thread goes on, and Ctrl-C stops the work within a second."""
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.wait(0.001):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    timer = threading.Timer(0.5, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    start = time.perf_counter()

    def slow(x, u, p):
        time.sleep(0.001)
        return rates(x, u, p)

    try:
        with pytest.raises(KeyboardInterrupt):
            db.equations(frame, {**FUNCTIONS, "rates": slow})
    finally:
        stop.set()
        thread.join()
    assert time.perf_counter() - start < 3.0 and len(ticks) > 20


def test_an_index_without_a_name_is_the_time(frame):
    pandas = pytest.importorskip("pandas")
    expected = db.equations(frame, "short-period").params
    values = frame.drop(columns="time")
    durations = pandas.to_timedelta(frame["time"], unit="s").dt.round("ms")
    for index in (pandas.Index(frame["time"].to_numpy()), pandas.TimedeltaIndex(durations, name=None), pandas.Timestamp("2026-05-14") + pandas.TimedeltaIndex(durations)):
        found = db.equations(values.set_axis(index.rename(None)), "short-period")
        assert found["M_alpha"] == pytest.approx(expected["M_alpha"], rel=1e-6)
    assert db.equations(values, "short-period", dt=0.02)["M_alpha"] == pytest.approx(expected["M_alpha"], rel=1e-6)


def test_windows_are_those_of_the_package(frame):
    expected = db.equations(frame, "short-period", windows=[(0.5, 8.0)])
    assert db.equations(frame, "short-period", windows=[db.Window("01", 0.5, 8.0)]).params == expected.params
    apart = db.equations(frame, "short-period", windows=[db.Window("01", 0.5, 10.0, exclude=[(5.0, 6.0)])])
    assert apart.params == db.equations(frame, "short-period", windows=[(0.5, 5.0), (6.0, 10.0)]).params


def test_covariance_is_that_of_a_sum_of_parameters(frame):
    """The standard error of a sum follows from the covariance, and is the one found with the sum as a parameter."""
    found = db.equations(frame, EQUATIONS)
    states = {**EQUATIONS["states"], "q": "(Sum - M_q)*alpha + M_q*q + M_delta_e*delta_e"}
    start = {"Z_alpha": -1.0, "Sum": -5.0, "M_q": -1.0, "M_delta_e": -5.0}
    summed = db.equations(frame, {**EQUATIONS, "states": states, "parameters": start})
    names, cov = list(found.params), found.cov
    assert np.sqrt(np.diag(cov)) == pytest.approx(list(found.stderr.values()), rel=1e-9)
    np.testing.assert_allclose(cov, cov.T, rtol=1e-12, atol=0)
    for method in ("equation_error", "output_error"):
        cov, share = found.cov_by(method), np.array([name in ("M_alpha", "M_q") for name in names], dtype=float)
        assert np.sqrt(share @ cov @ share) == pytest.approx(summed.by(method)["Sum"].stderr, rel=0.02), method
        alone = np.sqrt(share @ np.diag(np.diag(cov)) @ share)
        assert abs(alone / summed.by(method)["Sum"].stderr - 1.0) > 0.02, method
    with pytest.raises(db.DoubletKeyError, match="did you mean 'output_error'"):
        found.cov_by("output_eror")


def test_fits_have_samples_and_a_criterion(frame):
    found = db.equations(frame, "short-period")
    assert found.nobs == found.document[found.method]["samples"] <= len(frame)
    row = found.document[found.method]
    square = np.array([one["rms"] ** 2 for one in row["outputs"]])
    free = len(row["parameters"]) + len(row["initial"]) + sum(not one["is_none"] for one in row.get("process_noise", []))
    assert found.aic == pytest.approx(2 * free + row["samples"] * np.sum(np.log(2 * np.pi * square) + 1))
