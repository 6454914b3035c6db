"""Functions of arrays against NumPy, closed forms and published figures."""

import tracemalloc

import doublet as db
import numpy as np
import pytest

from conftest import shared


def test_least_squares_and_white_errors_are_the_textbook_s():
    rng = np.random.default_rng(1)
    X = np.column_stack([np.ones(400), rng.normal(size=(400, 2))])
    y = X @ [1.0, -2.0, 0.5] + 0.1 * rng.normal(size=400)
    fit = db.lstsq(X, y, names=["a", "b", "c"], errors="white")
    expected, square, *_ = np.linalg.lstsq(X, y, rcond=None)
    cov = square[0] / (400 - 3) * np.linalg.inv(X.T @ X)
    np.testing.assert_allclose(fit.params, expected, rtol=1e-12)
    np.testing.assert_allclose(fit.cov, cov, rtol=1e-10)
    assert fit["b"].value == fit.params[1] and "R2" in fit.summary() and "<table>" in fit._repr_html_()
    np.testing.assert_allclose(fit.residuals + fit.fitted, y, rtol=1e-12)


def test_intervals_hold_the_truth_where_white_ones_do_not():
    rng, n, runs, hold = np.random.default_rng(2), 1500, 120, {"coloured": 0, "white": 0}
    t = np.arange(n) * 0.02
    X = np.column_stack([np.ones(n), np.sin(2.0 * t), np.cos(0.7 * t)])
    for _ in range(runs):
        noise, e = np.zeros(n), rng.normal(size=n)
        for k in range(1, n):
            noise[k] = 0.95 * noise[k - 1] + e[k]
        y = X @ [1.0, 2.0, 3.0] + noise
        for errors in hold:
            fit = db.lstsq(X, y, errors=errors)
            hold[errors] += abs(fit.params[1] - 2.0) < 1.96 * fit.stderr[1]
    assert hold["coloured"] / runs > 0.87 and hold["white"] / runs < 0.6, hold


@pytest.mark.parametrize(
    ("coefficient", "terms", "printed"),
    [
        ("CL", ["alpha_rad"], ["0.234957", "5.22568"]),
        ("Cm", ["alpha_rad", "qn", "de_rad"], ["0.0803194", "-0.87762", "-5.81993", "-0.98406"]),
        ("Cn", ["beta_rad", "pn", "rn", "dr_rad"], ["0.0028078", "0.254494", "-0.0444249", "-0.134247", "-0.143862"]),
    ],
)
def test_attas_table_from_a_frame_in_one_call(coefficient, terms, printed):
    """Every printed digit of the published estimates (Jategaonkar, supplement), from a pandas frame."""
    pandas = pytest.importorskip("pandas")
    frame = pandas.read_csv(shared("attas/regression_table.csv"))
    fit = db.lstsq(frame[terms].assign(constant=1.0)[["constant", *terms]], frame[coefficient])
    assert [f"{value:.5e}" for value in fit.params] == [f"{float(value):.5e}" for value in printed]
    assert fit.names == ("constant", *terms) and (fit.stderr > fit.stderr_white).any()


def test_groups_constraints_and_weights():
    rng = np.random.default_rng(3)
    X = np.column_stack([np.ones(600), rng.normal(size=600)])
    y = X @ [1.0, 2.0] + rng.normal(size=600)
    whole, halves = db.lstsq(X, y), db.lstsq(X, y, groups=np.repeat([0, 1], 300))
    np.testing.assert_allclose(whole.params, halves.params, rtol=1e-12)
    fixed = db.lstsq(X, y, names=["a", "b"], constraints={"b": 1.5})
    assert fixed["b"].value == 1.5 and fixed.held[1] == "fixed"
    held = db.lstsq(X, y, names=["a", "b"], constraints={"b": (None, 1.0)})
    assert held["b"].value == 1.0 and held.held[1] == "at bound"
    sure = np.where(np.arange(600) < 300, 0.1, 10.0)
    weighted = db.lstsq(X, y, std=sure)
    first = db.lstsq(X[:300], y[:300])
    np.testing.assert_allclose(weighted.params, first.params, atol=5e-3)


def test_what_is_refused_says_which_column():
    X = np.ones((50, 2))
    with pytest.raises(db.DoubletError, match="'b' depends on 'a'|depends on"):
        db.lstsq(X, np.arange(50.0), names=["a", "b"])
    with pytest.raises(db.DoubletError, match="not finite|NaN|finite"):
        db.lstsq(np.column_stack([np.ones(5), np.arange(5.0)]), [1, 2, np.nan, 4, 5])
    with pytest.raises(db.DoubletError):
        db.lstsq(np.ones((5, 1)), np.arange(4.0))
    with pytest.raises(db.DoubletError, match="dimensions"):
        db.lstsq(np.ones(5), np.arange(5.0))


def test_a_million_samples_are_filtered_without_copies():
    n = 1_000_000
    time = np.arange(n) * 0.01
    values = np.sin(time) + 0.01 * np.cos(37.0 * time)
    assert db._frames.column(values, "values") is values or np.shares_memory(db._frames.column(values, "values"), values)
    tracemalloc.start()
    smoothed = db.smooth(time, values, width=11)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 0.2 * values.nbytes + smoothed.nbytes, peak
    assert smoothed.shape == (n,) and np.abs(smoothed - np.sin(time))[100:-100].max() < 0.011
    slope = db.differentiate(time, np.sin(time))
    np.testing.assert_allclose(slope[5:-5], np.cos(time)[5:-5], atol=1e-8)
    with pytest.raises(db.DoubletError, match="increase"):
        db.smooth(time[::-1], values)


def test_frequency_response_of_a_known_system():
    rng, dt, n = np.random.default_rng(4), 0.02, 20_000
    u = rng.normal(size=n)
    y, state = np.zeros(n), 0.0
    a = np.exp(-2.0 * dt)
    for k in range(n - 1):
        state = a * state + (1 - a) * u[k]
        y[k + 1] = state
    found = db.frequency_response(u, y + 0.01 * rng.normal(size=n), dt=dt, band=(0.3, 20.0), window=20.0)
    z = np.exp(1j * found.freq * dt)
    exact = (1 - a) / (z - a)
    good = found.coherence > 0.9
    assert good.sum() > 20
    error = np.abs(found.response / exact - 1)[good]
    assert np.median(error / found.std[good]) < 2.5 and error.max() < 0.15
    both = db.frequency_response(np.stack([u, rng.normal(size=n)]), y, dt=dt, band=(0.5, 10.0), window=20.0)
    assert len(both) == 2 and np.median(np.abs(both[1].response)) < 0.05


def test_modes_are_named_by_their_states():
    A = [[-0.02, 5.0, 0.0, -9.81], [-0.002, -1.5, 1.0, 0.0], [0.0, -6.0, -2.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
    found = db.modes(A, ["V", "alpha", "q", "theta"])
    names = [row["name"] for row in found]
    assert "short period" in names and "phugoid" in names
    values = np.linalg.eigvals(np.asarray(A))
    fastest = values[np.argmax(np.abs(values))]
    assert abs(found[0]["frequency_rad_s"] - abs(fastest)) < 1e-9
    with pytest.raises(db.DoubletError, match="one name per row"):
        db.modes(A, ["V", "alpha"])


def test_tables_become_frames():
    table = db.roles()
    assert table.columns == ["role", "unit", "description"] and table.where(role="q")[0]["unit"] == "rad/s"
    assert len(db.units()) > 20
    assert list(table.to_pandas()["role"])[:6] == ["ax", "ay", "az", "p", "q", "r"]


def test_roles_of_a_file_are_guessed_with_their_confidence(tmp_path):
    rows = "".join(f"{0.02 * k},{k % 50},{k % 9},{k % 7}\n" for k in range(500))
    path = tmp_path / "log.csv"
    path.write_text("time [s],Pitch [deg],pitch_angle [deg],q [deg/s]\n" + rows)
    table = db.guess_roles(path)
    found = {row["role"]: row for row in table}
    assert set(found) == {"theta", "q"}
    assert found["theta"]["runner_up"] is not None and found["q"]["runner_up"] is None
    assert all(0.9 < row["confidence"] <= 1.0 for row in table)


def test_what_is_out_of_range_is_refused_in_a_sentence():
    u = np.sin(np.arange(200.0))
    for arguments in ({"dt": 0.0}, {"dt": float("nan")}, {"dt": 0.02, "points": 2**63}, {"dt": 0.02, "points": 0}):
        with pytest.raises(db.DoubletError, match="give"):
            db.frequency_response(u, u, **arguments)
    with pytest.raises(db.DoubletError):
        db.frequency_response(u, np.full(200, 1e308), dt=0.02)
    with pytest.raises(db.DoubletError, match="empty"):
        db.modes(np.zeros((0, 0)), [])
    with pytest.raises(db.DoubletError, match="Session.load"):
        db.Session("a.toml")


def test_windows_beyond_the_memory_are_refused_before_they_are_taken():
    n = 400_000
    rows = {name: np.zeros(n) for name in ("p", "q", "r", "ax", "ay", "alpha", "phi", "theta")}
    rows.update(az=np.full(n, -9.8), airspeed=np.full(n, 60.0))
    recording = db.Recording.from_arrays(np.arange(n) * 0.01, rows)
    with pytest.raises(db.DoubletError, match="GB"):
        db.reconstruct(recording, windows=[(0.0, 3999.0)] * 5000)
    with pytest.raises(db.DoubletError, match="too many"):
        db.reconstruct(recording, windows=[(0.0, 1.0)] * 10_001)
