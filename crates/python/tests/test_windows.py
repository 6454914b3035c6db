"""Manoeuvres: what a session knows of them, ends of any kind, and stretches that do not count."""

import pickle

import doublet as db
import numpy as np
import pytest

pandas = pytest.importorskip("pandas")
SECONDS = np.arange(2000) * 0.02
INSTANT = "2026-05-14T14:30:00"


def recording(time=SECONDS):
    rows = {name: np.zeros(len(SECONDS)) for name in ("p", "q", "r", "ax", "ay", "alpha", "phi", "theta")}
    rows.update(az=np.full(len(SECONDS), -9.8), airspeed=np.full(len(SECONDS), 60.0))
    return db.Recording.from_arrays(time, rows, check=False)


def ends(rec, given):
    window = db._window.of_one_flight([given], rec._origin)[0]
    return window.start, window.end


def test_windows_of_a_session_know_flight_and_exclusions():
    session = db.Session.load("builtin:demo")
    row = session["manoeuvre.0"]
    start, end = row["start_s"] + 2.0, row["start_s"] + 3.0
    window = session.replace({"manoeuvre.0.exclude": [{"start_s": start, "end_s": end}]}).windows[0]
    assert window.flight == row["flight"] and window.exclude == ((start, end),)
    assert f"without {start:.6g} to {end:.6g} s" in repr(window) and pickle.loads(pickle.dumps(window)) == window


def test_excluded_stretches_have_no_samples_or_are_split(demo):
    rec = recording()
    window = db.Window("07", 2.0, 30.0, "elevator", exclude=[(10.0, 12.0), (28.0, 30.0)])
    path = db.reconstruct(rec, windows=[window])
    assert path.windows == [window]
    states = path["07"]
    inside = (states.update_time > 10.0) & (states.update_time < 12.0)
    assert not states.nis_degrees[inside].any() and states.nis_degrees[~inside].any()
    parts = window.split()
    assert [(one.name, one.start, one.end) for one in parts] == [("07 (part 1)", 2.0, 10.0), ("07 (part 2)", 12.0, 28.0)]
    assert all(one.surface == "elevator" and one.exclude == () for one in parts)
    assert [one.name for one in db.reconstruct(rec, windows=parts).windows] == ["07 (part 1)", "07 (part 2)"]
    plain = db.Window("08", 2.0, 30.0)
    assert plain.split() == [plain]
    session = db.Session.from_recordings(demo.recording(), windows=[db.Window("07", 1100.0, 1130.0, exclude=[(1110.0, 1112.0)])])
    assert session["manoeuvre.0.exclude"] == [{"start_s": 1110.0, "end_s": 1112.0}]
    for wrong, text in (([(3.0, 2.0)], "the excluded part 3.0 to 2.0 s is empty"), ([3.0], "exclude as pairs")):
        with pytest.raises(db.DoubletError, match=text):
            db.Window("07", 2.0, 30.0, exclude=wrong)


def test_windows_of_other_flights_are_refused():
    windows = [db.Window("01", 1.0, 5.0, flight="FT1"), db.Window("02", 6.0, 9.0, flight="FT2")]
    for call in (lambda: db.reconstruct(recording(), windows=windows), lambda: db.Session.from_recordings(recording(), windows=windows)):
        with pytest.raises(db.DoubletError, match="windows are of the flights FT1, FT2: give those of one"):
            call()


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_ends_are_durations_and_instants(unit):
    durations = np.array([5, 9], "timedelta64[s]").astype(f"timedelta64[{unit}]")
    plain, dated = recording(), recording(np.datetime64(INSTANT) + (1000 * SECONDS).round().astype("timedelta64[ms]"))
    instants = np.datetime64(INSTANT, unit) + durations
    for given in (tuple(durations), durations, slice(*durations), db.Window("a", *durations)):
        assert ends(plain, given) == (5.0, 9.0)
    for given in (tuple(instants), instants, tuple(map(pandas.Timestamp, instants)), pandas.Interval(*map(pandas.Timestamp, instants)),
                  db.Window("a", *instants), slice(*instants)):
        assert ends(dated, given) == (5.0, 9.0), given
    assert ends(dated, (5.0, 9.0)) == (5.0, 9.0)
    window = db.reconstruct(dated, windows=[tuple(instants)]).windows[0]
    assert (window.start, window.end) == (5.0, 9.0)


def test_instants_need_an_origin_of_their_kind():
    first, last = (pandas.Timestamp(INSTANT) + pandas.Timedelta(seconds, "s") for seconds in (5, 9))
    with pytest.raises(db.DoubletError, match="is an instant, but the time counts seconds: give seconds"):
        db.reconstruct(recording(), windows=[(first, last)])
    index = pandas.Timestamp(INSTANT) + pandas.to_timedelta(SECONDS, unit="s").round("ms")
    zoned = recording(index.tz_localize("Europe/Paris"))
    assert zoned.origin == np.datetime64("2026-05-14T12:30:00")
    assert ends(zoned, (first.tz_localize("Europe/Paris"), last.tz_localize("Europe/Paris"))) == (5.0, 9.0)
    assert ends(pickle.loads(pickle.dumps(zoned)), (first.tz_localize("Europe/Paris"), last.tz_localize("UTC")))[0] == 5.0
    for library, made in (("polars", lambda one: one.DataFrame), ("pyarrow", lambda one: one.table)):
        columns = made(pytest.importorskip(library))({"time": index.tz_localize("Europe/Paris"), "q": SECONDS})
        found = db.Recording.from_frame(columns, check=False)
        assert found.origin == zoned.origin and ends(found, (first.tz_localize("Europe/Paris"), 9.0)) == (5.0, 9.0), library
    with pytest.raises(db.DoubletError, match="has no time zone, the recording has one"):
        ends(zoned, (first, last))
    with pytest.raises(db.DoubletError, match="'14:30' is text: give seconds, a duration or an instant"):
        ends(zoned, ("14:30", "14:31"))


def test_equations_take_windows_of_every_kind():
    stamps = pandas.Timestamp(INSTANT) + pandas.to_timedelta(SECONDS, unit="s").round("ms")
    frame = pandas.DataFrame({"q": SECONDS}, index=stamps)
    given = [(5.0, 9.0), db.Window("a", 5.0, 9.0), (stamps[250], stamps[450]), pandas.Interval(stamps[250], stamps[450])]
    assert db._equations._used_parts(given, frame, None) == [(5.0, 9.0)] * 4
    assert db._equations._used_parts([db.Window("a", 1.0, 9.0, exclude=[(2.0, 3.0)])], frame, None) == [(1.0, 2.0), (3.0, 9.0)]
    assert db._equations._used_parts(given[2:3], frame.rename_axis("stamp").reset_index(), "stamp") == [(5.0, 9.0)]
    for wrong in (3.0, (1.0,), ("a", "b"), None):
        with pytest.raises(db.DoubletError, match="windows: "):
            db.equations(frame, "short-period", windows=[wrong])
