"""Other processes, pickles and copies, sessions of recordings in memory."""

import copy
import os
import pathlib
import pickle
import subprocess
import sys
import warnings

import doublet as db
import numpy as np
import pytest

MODEL = {"Cm": ["1", "alpha", "qc/V", "delta_e"]}
FORKED = """
import multiprocessing
import warnings
import doublet as db
import numpy as np

warnings.simplefilter("ignore", db.DoubletWarning)
X = np.column_stack([np.ones(200), np.sin(np.arange(200.0))])

def level(number):
    return db.run(db.Session.load("builtin:demo")).verdict.level

def everything(results):
    path = db.reconstruct(results.recording(), db.aircraft("c337f"), windows=db.Session.load("builtin:demo").windows[:4])
    fit = db.fit(db.coefficients(path), "Cm ~ 1 + alpha + qc/V + delta_e", by_surface=False)
    regression = db.lstsq(X, np.cos(np.arange(200.0)))
    frame = db.batch(["builtin:demo"], jobs=1, frame="pandas")
    return fit.params, regression.params.tolist(), frame["estimate"].dropna().tolist()

if __name__ == "__main__":
    results = db.run(db.Session.load("builtin:demo"))
    expected = everything(results)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(level, range(4)).get(240) == [results.verdict.level] * 4
        assert pool.map_async(everything, [results] * 2).get(240) == [expected] * 2
    print("done")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_processes_forked_after_a_run_work(tmp_path):
    pytest.importorskip("pandas")
    program = tmp_path / "forked.py"
    program.write_text(FORKED)
    said = subprocess.run([sys.executable, str(program)], capture_output=True, text=True, timeout=500)
    assert said.stdout.strip() == "done", said.stderr


@pytest.fixture(scope="module")
def made(demo):
    windows = db.Session.load("builtin:demo").windows[:4]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        path = db.reconstruct(demo.recording(), db.aircraft("c337f"), windows=windows)
        coefs = db.coefficients(path)
        return path, coefs, db.fit(coefs, MODEL, by_surface=False)


def test_everything_pickles_and_copies_to_the_last_bit(demo, made):
    path, coefs, fit = made
    arrays = db.Recording.from_arrays(np.arange(50) * 0.1, {"q": np.arange(50.0), "own": (np.ones(50), "V")})
    plain = db.Aircraft(area=1.0, span=2.0, chord=0.5, mass=3.0, inertia=(1, 1, 1))
    session = db.Session.load("builtin:demo")
    same = {
        arrays: lambda one: (one.roles, one["q"].values.tolist(), one["own"].unit, one["q"].time.tolist()),
        demo.recording(): lambda one: (one.roles, one["q"].values.tolist()),
        plain: lambda one: (one.mass, one.text),
        path.aircraft: lambda one: one.span,
        session: lambda one: one.text,
        demo: lambda one: (one.to_dict(), one.failures, one.states(demo.windows[0]["name"])["theta"].tolist()),
        path: lambda one: (one.windows, one[0].smoothed["theta"].tolist(), one.verdict.level),
        coefs: lambda one: (one.windows, one[0]["Cm"].tolist()),
        fit: lambda one: (one.params, one.stderr, one.cov.tolist(), one.verdict.lines),
    }
    for one, shown in same.items():
        again = pickle.loads(pickle.dumps(one))
        assert type(again) is type(one) and shown(again) == shown(one), one
        assert shown(copy.deepcopy(one)) == shown(one) and copy.copy(one) is one
    assert pickle.loads(pickle.dumps(fit["Cm_alpha"])).stderr == fit["Cm_alpha"].stderr
    assert pickle.loads(pickle.dumps(path[0])).time.tolist() == path[0].time.tolist()


def test_sessions_and_results_pass_through_joblib(demo):
    joblib = pytest.importorskip("joblib")
    session = db.Session.load("builtin:demo")
    results = joblib.Parallel(n_jobs=2)(joblib.delayed(db.run)(session) for _ in range(2))
    assert all(one.to_dict() == demo.to_dict() for one in results)


def test_session_of_recordings_is_that_of_their_files(demo, tmp_path):
    recording = demo.recording()
    windows = db.Session.load("builtin:demo").windows
    session = db.Session.from_recordings(
        recording, aircraft=db.aircraft("c337f"), windows=windows, model={"Cm": "1 + alpha + qc/V + delta_e"}, name="mine"
    )
    assert session["title"] == "mine" and len(session.windows) == len(windows)
    results = session.run()
    assert abs(results.derivatives["Cm_alpha"] - demo.derivatives["Cm_alpha"]) < 4 * demo.derivatives["Cm_alpha"].stderr
    again = results.recording()
    assert (again["q"].values == recording["q"].values).all() and (again["q"].time == recording["q"].time).all()
    assert set(again.roles) == set(recording.roles)
    saved = session.save(tmp_path / "own.toml")
    assert pathlib.Path(tmp_path / "own_recordings").is_dir()
    copied = pickle.loads(pickle.dumps(session))
    folder = session._keeper.folder
    del session, results, again
    assert not os.path.exists(folder)
    assert saved.run().derivatives == copied.run().derivatives
    assert db.Session.load(tmp_path / "own.toml").run().derivatives == saved.run().derivatives


def test_channels_of_several_clocks_are_written_as_they_are(tmp_path):
    fast, slow = np.arange(2000) * 0.02, np.arange(400) * 0.1 + 0.003
    rows = {name: np.sin(0.3 * fast + number) for number, name in enumerate(("p", "q", "r", "ax", "ay", "az"))}
    rows["own α"] = np.where(fast > 30.0, np.nan, fast)
    # A second pitch rate that is late: an offset of clocks that no session may take for one.
    channels = {**{name: (fast, values, "") for name, values in rows.items()}, "theta": (slow, np.cos(slow), ""), "q2": (slow, np.sin(0.3 * slow), "")}
    recording = db.Recording.from_arrays(None, channels, check=False)
    session = db.Session.from_recordings(recording, windows=[(1.0, 30.0)], folder=tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["flight_001.mat", "flight_001_map.toml"]
    assert "clock" not in session.to_dict()["flight"][0]
    again = session.recording()
    for role in ("q", "az", "theta"):
        np.testing.assert_array_equal(again[role].values, recording[role].values)
        np.testing.assert_array_equal(again[role].time, recording[role].time)
    # As another reader has the file.
    written = pytest.importorskip("scipy.io").loadmat(tmp_path / "flight_001.mat", squeeze_me=True)
    np.testing.assert_array_equal(written["clock_001"]["own \\u03b1"].item(), rows["own α"])
    np.testing.assert_array_equal(written["clock_002"]["time"].item(), slow)


def test_several_recordings_are_flights_of_one_session(demo, tmp_path):
    recording = demo.recording()
    windows = db.Session.load("builtin:demo").windows[:3]
    plane = db.Aircraft(area=18.6, span=11.6, chord=1.66, mass=1980.0, inertia=(3600.0, 4500.0, 7300.0, 300.0))
    session = db.Session.from_recordings([recording, recording], aircraft=plane, windows=[windows, windows], folder=tmp_path / "kept")
    assert len(session["flight"]) == 2 and len(session.windows) == 6
    assert len({window.name for window in session.windows}) == 6
    results = session.run()
    assert len(results.windows) == 6 and (tmp_path / "kept" / "aircraft.toml").exists()
    found = db.Session.from_recordings(recording)
    assert len(found.windows) > 10
    with pytest.raises(db.DoubletError, match="give one list for each"):
        db.Session.from_recordings([recording, recording], windows=[windows])
    with pytest.raises(db.DoubletError, match="Session.from_recordings"):
        db.Session.new([recording])
    with pytest.raises(db.DoubletError, match="recordings is empty"):
        db.Session.from_recordings([])
