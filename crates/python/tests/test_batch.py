"""Many sessions at once."""

import doublet as db
import pytest

pandas = pytest.importorskip("pandas")


def test_batch_is_a_tidy_frame_with_failures_as_rows(demo, tmp_path):
    session = db.Session.load("builtin:demo")
    other = session.replace({"title": "other", "filter.measurement_noise.alpha": 0.004})
    (tmp_path / "wrong.toml").write_text('format = "doublet session"\nversion = 2\nmodle = 1\n')
    parts = []
    frame = db.batch([session, session, other, tmp_path / "wrong.toml", tmp_path / "absent.toml"], jobs=2, progress=parts.append)
    assert parts == sorted(parts) and parts[-1] == 1.0
    names = list(dict.fromkeys(frame["session"]))
    assert names[1] == f"{names[0]} (2)" and names[2] == "other" and len(names) == 5
    first = frame[(frame["session"] == names[0]) & frame["error"].isna()].set_index("derivative")
    assert first["estimate"].to_dict() == {name: value.value for name, value in demo.derivatives.items()}
    assert first.loc["Cm_alpha", "stderr"] == demo.derivatives["Cm_alpha"].stderr
    assert set(first["session_verdict"]) == {demo.verdict.level} and set(first["verdict"]) <= {"good", "caution", "bad"}
    assert first.loc["Cm_alpha", "coefficient"] == "Cm" and first.loc["Cm_alpha", "samples"] > 100
    second = frame[frame["session"] == "other"].set_index("derivative")
    assert second.loc["CZ_alpha", "estimate"] != first.loc["CZ_alpha", "estimate"]
    wrong, absent = (frame[frame["session"] == str(tmp_path / name)] for name in ("wrong.toml", "absent.toml"))
    assert len(wrong) == 1 and "modle" in wrong["error"].iloc[0] and wrong["estimate"].isna().all()
    assert len(absent) == 1 and "file not found" in absent["error"].iloc[0]


def test_names_of_a_mapping_and_refusals():
    frame = db.batch({"a": "builtin:demo", "b": db.Session.load("builtin:demo")})
    assert list(dict.fromkeys(frame["session"])) == ["a", "b"]
    for wrong, text in (
        (lambda: db.batch([]), "sessions is empty"),
        (lambda: db.batch(["builtin:demo"], jobs=0), "jobs is 0: give 1 or more"),
        (lambda: db.batch("builtin:demo"), "give a list"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            wrong()


def test_interrupt_stops_all():
    def interrupt(part):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        db.batch(["builtin:demo"] * 30, jobs=2, progress=interrupt)


def test_batch_as_polars(demo):
    polars = pytest.importorskip("polars")
    session = db.Session.load("builtin:demo")
    frame, table = db.batch({"a": session}, frame="polars"), db.batch({"a": session})
    assert isinstance(frame, polars.DataFrame) and frame.columns == list(table.columns) and len(frame) == len(table)
    assert frame["estimate"].to_list() == table["estimate"].to_list()
    with pytest.raises(db.DoubletKeyError, match="did you mean 'polars'"):
        db.batch({"a": session}, frame="polar")


def levels(names):
    """Verdicts of sessions; what a process of joblib or dask is given."""
    frame = db.batch({name: db.Session.load("builtin:demo").replace({"filter.measurement_noise.alpha": float(name)}) for name in names}, jobs=1)
    return frame.set_index(["session", "derivative"])["estimate"]


def test_joblib_spreads_batches():
    joblib = pytest.importorskip("joblib")
    expected = levels(["0.001", "0.004"])
    found = joblib.Parallel(n_jobs=2)(joblib.delayed(levels)([name]) for name in ("0.001", "0.004"))
    assert pandas.concat(found).to_dict() == expected.to_dict()
    sessions = [db.Session.load("builtin:demo")] * 2
    results = joblib.Parallel(n_jobs=2)(joblib.delayed(db.run)(one) for one in sessions)
    assert results[0].derivatives == results[1].derivatives == sessions[0].run().derivatives


def test_dask_spreads_batches():
    dask = pytest.importorskip("dask")
    expected = levels(["0.001", "0.004"])
    several = [dask.delayed(levels)([name]) for name in ("0.001", "0.004")]
    for scheduler in ("threads", "processes"):
        found = dask.compute(*several, scheduler=scheduler)
        assert pandas.concat(found).to_dict() == expected.to_dict(), scheduler
