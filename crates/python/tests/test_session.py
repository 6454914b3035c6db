"""Sessions: the same as those of the window and the command line, number for number."""

import json
import math
import os
import random
import subprocess
import threading
import time

import doublet as db
import numpy as np
import pytest


def numbers(value, path=""):
    """Every number of a document with its place."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(inner, f"{path}.{key}")
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from numbers(inner, f"{path}[{index}]")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield path, value


def test_a_thousand_numbers_are_those_of_the_command_line(demo, tmp_path):
    program = os.environ.get("DOUBLET_PROGRAM")
    if not program:
        pytest.skip("DOUBLET_PROGRAM names no program")
    out = tmp_path / "results"
    subprocess.run([program, "run", "builtin:demo", "--out", str(out)], check=True, capture_output=True)
    written = json.loads((out / "results.json").read_text())
    ours, theirs = dict(numbers(demo.to_dict())), dict(numbers(written))
    assert ours.keys() == theirs.keys() and len(ours) > 3000
    chosen = random.Random(1).sample(sorted(ours), 1000)
    assert all(ours[place] == theirs[place] for place in chosen)
    assert demo.to_dict() == written


def test_results_are_tables_and_values(demo):
    value = demo.derivatives["Cm_alpha"]
    assert -3 < value.value < 0 and 0 < value.stderr < 0.1
    low, high = value.interval
    assert low < value.value < high
    assert "Cm_alpha" in demo.summary() and "<table>" in demo._repr_html_()
    assert demo.verdict["level"] in ("good", "caution", "bad")
    frame = demo.table.to_pandas()
    assert set(frame["derivative"]) >= {"Cm_alpha", "Cl_p", "Cn_r"}
    row = frame.set_index("derivative").loc["Cm_alpha"]
    assert row["estimate"] == value.value and row["stderr"] == value.stderr


def test_replace_keeps_the_rules_of_the_file(demo):
    session = db.Session.load("builtin:demo")
    changed = session.replace({"filter.measurement_noise.alpha": 0.004, "title": "other"})
    assert changed["filter.measurement_noise.alpha"] == 0.004 and session["title"] != "other"
    assert changed.run().derivatives["CZ_alpha"].value != demo.derivatives["CZ_alpha"].value
    with pytest.raises(db.DoubletError, match="filter.method|unknown"):
        session.replace({"filter.method": "best"})
    with pytest.raises(db.DoubletError, match="outside the list"):
        session.replace({"manoeuvre.99.role": "validation"})


def test_saved_session_opens_and_gives_the_same(tmp_path, demo):
    session = db.Session.load("builtin:demo").save(tmp_path / "copy.toml")
    again = db.Session.load(tmp_path / "copy.toml")
    assert again.to_dict() == session.to_dict()
    assert again.run().derivatives == demo.derivatives
    with pytest.raises(db.DoubletError, match="shipped session"):
        session.save("builtin:demo")


def test_errors_are_the_sentence_of_the_command_line(tmp_path):
    program = os.environ.get("DOUBLET_PROGRAM")
    if not program:
        pytest.skip("DOUBLET_PROGRAM names no program")
    path = tmp_path / "wrong.toml"
    path.write_text('format = "doublet session"\nversion = 2\nmodle = 1\n')
    said = subprocess.run([program, "run", str(path), "--out", str(tmp_path / "out")], capture_output=True, text=True)
    with pytest.raises(db.DoubletError) as caught:
        db.Session.load(path)
    assert said.stderr.strip() == f"error: {caught.value}"
    assert issubclass(db.DoubletError, ValueError)


def test_progress_is_told_and_other_threads_run():
    session, parts, ticks, done = db.Session.load("builtin:demo"), [], [0], threading.Event()

    def tick():
        while not done.is_set():
            ticks[0] += 1
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    db.run(session, studies=["monte-carlo"], realisations=20, progress=parts.append)
    done.set()
    thread.join()
    assert parts == sorted(parts) and len(parts) >= 2 and 0 <= parts[0] and parts[-1] <= 1
    assert ticks[0] > 20


def test_what_progress_raises_stops_the_run():
    started = time.perf_counter()

    def stop(part):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        db.run(db.Session.load("builtin:demo"), studies=["monte-carlo"], realisations=100_000, progress=stop)
    assert time.perf_counter() - started < 30


def test_studies_and_exports(tmp_path, demo):
    results = db.run(db.Session.load("builtin:demo"), studies=["lags"])
    assert {row["control"] for row in results.study("lags")} >= {"elevator"} or len(results.study("lags")) > 0
    with pytest.raises(db.DoubletError, match="no table of a study"):
        demo.study("lags")
    bands = db.match(demo)
    assert len(bands) > 5 and all(row["passed"] for row in bands)
    files = db.export(demo, "daveml", tmp_path / "model")
    assert any(name.endswith((".dml", ".xml")) for name in files)
    folder = demo.write(tmp_path / "results", histories=[])
    assert json.load(open(os.path.join(folder, "results.json"))) == demo.to_dict()


def test_numbers_that_do_not_exist_are_not_made_up(demo):
    for place, value in numbers(demo.to_dict()):
        assert not (isinstance(value, float) and math.isnan(value)), place


def test_a_bad_verdict_is_warned_of(demo, recwarn):
    session = db.Session.load("builtin:demo")
    with pytest.warns(db.DoubletWarning, match="^run: verdict bad") as caught:
        results = db.run(session.replace(model={"Cm": ["1", "delta_e"]}))
    assert results.verdict.level == "bad" and caught[0].filename == __file__
    recwarn.clear()
    frame = db.batch([session.replace(model={"Cm": ["1", "delta_e"]})])
    assert set(frame["session_verdict"]) == {"bad"} and not [one for one in recwarn if one.category is db.DoubletWarning]


def test_results_have_what_a_fit_has(demo):
    names, cov = list(demo.derivatives), demo.cov
    assert cov.shape == (len(names), len(names)) and np.isfinite(cov).all() and (cov == cov.T).all()
    errors = [0.0 if np.isnan(value.stderr) else value.stderr for value in demo.derivatives.values()]
    np.testing.assert_allclose(np.sqrt(np.diag(cov)), errors, rtol=1e-12)
    first, second = names.index("Cm_alpha"), names.index("Cm_q")
    assert cov[first, second] != 0.0 and cov[first, names.index("Cl_p")] == 0.0
    assert set(demo.nobs) == set(demo.aic) == {fit["coefficient"] for fit in demo.fits} and demo.nobs["Cm"] > 1000
    row = demo.fits[0]
    free, count = len(row["derivatives"]), row["samples"]
    square = row["residual_deviation"] ** 2 * (count - free)
    assert demo.aic[row["coefficient"]] == pytest.approx(2 * free + count * (np.log(2 * np.pi * square / count) + 1))
    held = db.run(db.Session.load("builtin:demo").replace({"estimation.constraint": [{"coefficient": "Cm", "term": "alpha", "fixed": -0.9}]}))
    assert np.isnan(held.aic["Cm"]) and held.cov[first, first] == 0.0
    assert {one["role"] for one in demo.predictions} >= {"identification"} and len(demo.predictions) == len(demo.to_dict()["predictions"])
    assert np.isfinite([one["r2_own_constant"] for one in demo.predictions if one["r2_own_constant"] is not None]).all()


def test_a_flight_is_read_without_a_run(demo):
    session = db.Session.load("builtin:demo")
    recording = session.recording()
    assert recording.roles == demo.recording().roles and (recording["q"].values == demo.recording()["q"].values).all()


def test_rows_of_results_have_the_keys_that_their_types_state(demo):
    """Every key of a row of ``results.windows`` and ``results.fits`` is in its type, so that a misspelt one is found by a type checker."""
    from doublet import _rows

    def check(row, stated):
        assert set(row) <= set(stated.__annotations__), set(row) - set(stated.__annotations__)

    assert demo.windows and demo.fits
    for window in demo.windows:
        check(window, _rows.WindowRow)
        for state in window["states"]:
            check(state, _rows.StateRow)
        for innovation in window["innovations"]:
            check(innovation, _rows.InnovationRow)
    for fit in [*demo.fits, *(fit for window in demo.windows for fit in window["fits"])]:
        check(fit, _rows.FitRow)
        for derivative in fit["derivatives"]:
            check(derivative, _rows.DerivativeRow)
