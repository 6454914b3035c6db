"""Sessions: the same as those of the window and the command line, number for number."""

import json
import math
import os
import random
import subprocess
import threading
import time

import doublet as db
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
