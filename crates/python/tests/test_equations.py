"""Equations of motion of one's own."""

import pickle

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
