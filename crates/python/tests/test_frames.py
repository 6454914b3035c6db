"""Frames of other packages: times of any kind, names of roles, and datasets."""

import datetime

import doublet as db
import numpy as np
import pytest

pandas = pytest.importorskip("pandas")
SECONDS = np.arange(500) * 0.02
INSTANT = "2026-05-14T14:30:00"


@pytest.fixture(scope="module")
def frame(demo):
    return demo.recording().to_pandas(step=0.02).iloc[: len(SECONDS)].set_axis(pandas.Index(SECONDS, name="time"))


def read_time(frame, **options):
    return db.Recording.from_frame(frame, **options)["q"].time


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_instants_and_durations_of_pandas_become_seconds(frame, unit):
    if unit == "s":
        frame = frame.iloc[::50]
    expected = frame.index.to_numpy()
    durations = pandas.to_timedelta(expected, unit="s").round("ms").as_unit(unit)
    instants = pandas.Timestamp(INSTANT) + durations
    for index in (durations, instants, instants.tz_localize("Europe/Paris")):
        np.testing.assert_allclose(read_time(frame.set_axis(index), check=False), expected, atol=1e-9)
        column = frame.reset_index(drop=True).assign(stamp=index)
        np.testing.assert_allclose(read_time(column, time="stamp", check=False), expected, atol=1e-9)


def test_python_s_own_times_and_arrays_of_numpy_become_seconds(frame):
    start = datetime.datetime(2026, 5, 14, 14, 30, tzinfo=datetime.timezone.utc)
    steps = [datetime.timedelta(milliseconds=20 * k) for k in range(len(SECONDS))]
    for stamps in (steps, [start + step for step in steps], [(start + step).time() for step in steps]):
        rec = db.Recording.from_arrays(np.array(stamps, dtype=object), {"q": frame["q"]})
        np.testing.assert_allclose(np.diff(rec["q"].time), 0.02, atol=1e-9)
    stamps = np.datetime64(INSTANT, "ms") + (1000 * SECONDS).round().astype("timedelta64[ms]")
    np.testing.assert_allclose(db.Recording.from_arrays(stamps, {"q": frame["q"]})["q"].time, SECONDS, atol=1e-9)


def test_unit_of_time_is_obeyed_and_what_is_wrong_is_refused(frame):
    in_ms = frame.set_axis(1e3 * SECONDS)
    np.testing.assert_allclose(read_time(in_ms, units={"time": "ms"}), SECONDS)
    column = frame.reset_index(drop=True).assign(clock=1e3 * SECONDS)
    np.testing.assert_allclose(read_time(column, time="clock", units={"clock": "ms"}), SECONDS)
    in_ms.attrs["units"] = {"time": "ms"}
    np.testing.assert_allclose(read_time(in_ms), SECONDS)
    with pytest.raises(db.DoubletError, match="'fortnight' is not a unit of time: use one of s, ms"):
        read_time(frame, units={"time": "fortnight"})
    with pytest.raises(db.DoubletError, match="leave its unit out"):
        read_time(frame.set_axis(pandas.to_timedelta(SECONDS, unit="s")), units={"time": "ms"})
    with pytest.raises(db.DoubletError, match="time is text: convert it"):
        read_time(frame.set_axis([f"{second} s" for second in SECONDS]))
    broken = pandas.to_timedelta(SECONDS, unit="s").to_series()
    broken.iloc[7] = pandas.NaT
    with pytest.raises(db.DoubletError, match="no value at sample 7"):
        read_time(frame.set_axis(pandas.TimedeltaIndex(broken)))


def test_a_time_that_cannot_be_seconds_is_refused(demo):
    whole = demo.recording().to_pandas(step=0.02)
    with pytest.raises(db.DoubletError, match="time: .*check=False takes it as it is"):
        db.Recording.from_frame(whole.set_axis(1e9 * whole.index.to_numpy()))
    kept = db.Recording.from_frame(whole.set_axis(1e9 * whole.index.to_numpy()), check=False)
    assert kept["q"].time[-1] > 1e9 and "channel map" not in kept.check().summary()


def test_channels_that_contradict_each_other_are_warned_of(demo):
    whole = demo.recording().to_pandas(step=0.05)
    with pytest.warns(db.DoubletWarning, match="q: .*sign") as caught:
        turned = db.Recording.from_frame(whole.assign(q=-whole["q"]))
    assert caught[0].filename == __file__
    assert "Channel q: reverse the sign." in turned.check()["fix"]


def test_frames_of_polars_pyarrow_and_xarray_are_the_same_recording(demo, frame):
    expected = db.Recording.from_frame(frame, check=False)
    durations = pandas.to_timedelta(SECONDS, unit="s")
    columns = {"time": np.datetime64(INSTANT, "us") + durations.to_numpy().astype("timedelta64[us]"),
               **{name: frame[name].to_numpy() for name in frame}}
    others = {}
    polars = pytest.importorskip("polars")
    others["polars"] = polars.DataFrame(columns)
    others["polars zone"] = others["polars"].with_columns(polars.col("time").dt.replace_time_zone("UTC"))
    others["pyarrow"] = pytest.importorskip("pyarrow").table(columns)
    pytest.importorskip("xarray")
    others["xarray"] = expected.to_xarray()
    others["mapping"] = columns
    for name, other in others.items():
        found = db.Recording.from_frame(other, check=False)
        assert found.roles == expected.roles, name
        assert (found["q"].values == expected["q"].values).all(), name
        np.testing.assert_allclose(found["q"].time, SECONDS, atol=1e-9, err_msg=name)


def test_units_of_a_dataset_are_used(demo):
    pytest.importorskip("xarray")
    dataset = demo.recording().to_xarray()
    dataset["q"] = ("time", np.degrees(dataset["q"].to_numpy()), {"units": "deg/s"})
    again = db.Recording.from_frame(dataset)
    np.testing.assert_allclose(again["q"].values, demo.recording().to_xarray()["q"].to_numpy(), rtol=1e-12)
    with pytest.raises(db.DoubletError, match="do not share one dimension"):
        db.Recording.from_frame(dataset.assign(other=("else", [1.0, 2.0])))


def test_names_that_are_no_roles_are_refused_with_the_nearest(frame):
    renamed = frame.rename(columns={"airspeed": "TAS"})
    with pytest.raises(db.DoubletError, match="'true_airspeed' of column 'TAS' is not a role: did you mean 'airspeed'"):
        db.Recording.from_frame(renamed, names={"TAS": "true_airspeed"})
    with pytest.raises(db.DoubletError, match="columns 'p' and 'p2' are both 'p'"):
        db.Recording.from_frame(frame.assign(p2=99.0), names={"p2": "p"})
    with pytest.raises(db.DoubletError, match="no column is called 'aplha': did you mean 'alpha'"):
        db.Recording.from_frame(frame, units={"aplha": "deg"})
    with pytest.raises(db.DoubletError, match="no column is called 'clock'"):
        db.Recording.from_frame(frame, time="clock")
    assert "airspeed" in db.Recording.from_frame(renamed, names={"TAS": "airspeed"}, check=False)


def test_signals_are_arrays(demo):
    q = demo.recording()["q"]
    assert np.asarray(q).shape == (len(q),) and np.shares_memory(np.asarray(q), q.values)
    assert np.mean(q) == np.mean(q.values) and (q * 2 == 2 * q.values).all() and (np.degrees(q) == np.degrees(q.values)).all()
    assert (q - q[0]).shape == q.values.shape and len(q[10:20]) == 10 and float(q[3]) == q.values[3]
    assert np.asarray(q, dtype=np.float32).dtype == np.float32


def test_paths_become_frames_with_deviations(demo):
    path = db.reconstruct(demo.recording(), db.aircraft("c337f"), windows=db.Session.load("builtin:demo").windows[:2])
    table = path.to_pandas()
    assert len(set(table["window"])) == 2 and {"theta", "theta_std", "wind_north_std"} <= set(table.columns)
    pytest.importorskip("xarray")
    dataset = path[0].to_xarray()
    assert dataset["theta"].attrs["units"] == "rad" and (dataset["theta"].to_numpy() == path[0].smoothed["theta"]).all()


def test_manoeuvres_are_given_in_many_ways(demo):
    recording, first = demo.recording(), db.Session.load("builtin:demo").windows[0]
    start, end = float(first.start), float(first.end)
    ends = pandas.Timedelta(start, "s"), pandas.Timedelta(end, "s")
    given = [(start, end), (start, end, "elevator"), [start, end], np.array([start, end]), slice(start, end),
             pandas.Interval(start, end), pandas.Interval(*ends), ends]
    for one in given:
        window = db.reconstruct(recording, windows=[one]).windows[0]
        assert (window.start, window.end) == pytest.approx((start, end)), one
        assert window.surface == ("elevator" if len(one if isinstance(one, tuple) else ()) == 3 else None)
    session = db.Session.from_recordings(recording, windows=[pandas.Interval(start, end)])
    assert session.windows[0].start == pytest.approx(start)
    for wrong, text in (
        ((end, start), "its end .* is not after its start"),
        ((start, end, "flap"), "'flap' is not a surface"),
        ((start, end, 4), "is not a manoeuvre: give"),
        (start, "is not a manoeuvre: give"),
        (("a", "b"), "'a' is text: give seconds"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.reconstruct(recording, windows=[wrong])
    with pytest.raises(db.DoubletError, match="recording is a list: .* pools flights"):
        db.reconstruct([recording, recording])


def test_columns_of_different_indices_are_refused():
    X, y = pandas.DataFrame({"a": [1.0, 2.0, 4.0]}), pandas.Series([1.0, 2.0, 3.0], index=[5, 6, 7])
    with pytest.raises(db.DoubletError, match="different indices"):
        db.lstsq(X, y)
    with pytest.raises(db.DoubletError, match="column 'a' of X .*must be numbers"):
        db.lstsq(pandas.DataFrame({"a": ["x"] * 9}), np.arange(9.0))


@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
def test_slopes_over_times_of_any_kind_are_per_second(unit):
    values, durations = np.sin(SECONDS), pandas.to_timedelta(SECONDS, unit="s").round("ms").as_unit(unit)
    expected, smoothed = db.differentiate(SECONDS, values), db.smooth(SECONDS, values)
    for time in (durations, pandas.Timestamp(INSTANT) + durations, durations.to_numpy()):
        np.testing.assert_allclose(db.differentiate(time, pandas.Series(values)), expected, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(db.smooth(time, values), smoothed, rtol=1e-9, atol=1e-9)
    with pytest.raises(db.DoubletError, match="values holds durations, not numbers"):
        db.smooth(SECONDS, durations)


def test_columns_that_are_not_numbers_are_refused_where_they_are_known(frame):
    count, options = len(frame), {"check": False}
    for wrong, text in (
        ({"alpha": ["1.0"] * count}, "column 'alpha' .*must be numbers"),
        ({"alpha": np.arange(count) > 5}, "column 'alpha' is True or False and must be numbers"),
        ({"alpha": [*frame["alpha"].iloc[1:], "late"]}, "column 'alpha' must be numbers, 'late' is text"),
        ({"alpha": np.full(count, 1j)}, "column 'alpha' is complex"),
        ({"alpha": pandas.to_timedelta(SECONDS, unit="s")}, "column 'alpha' holds durations"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.Recording.from_frame(frame.assign(**wrong), **options)
    with pytest.raises(db.DoubletError, match="column 'AoA' .*must be numbers"):
        db.Recording.from_frame(frame.drop(columns="alpha").assign(AoA=["a"] * count), names={"AoA": "alpha"}, **options)
    with pytest.raises(db.DoubletError, match="column 'flap' .*must be numbers"):
        db.Recording.from_frame(frame.assign(flap=["a"] * count), units={"flap": "deg"}, **options)
    noted = db.Recording.from_frame(frame.assign(note=["a"] * count, gear=np.arange(count) > 5), **options)
    assert "note" not in noted and "gear" not in noted


def test_objects_that_are_numbers_are_converted(frame):
    import decimal

    expected = frame["alpha"].to_numpy()
    objects = frame.assign(alpha=pandas.Series([float(one) for one in expected], dtype=object, index=frame.index),
                           own=pandas.Series([decimal.Decimal(k) for k in range(len(frame))], dtype=object, index=frame.index),
                           rare=pandas.array([None, *range(1, len(frame))], dtype="Int64"))
    found = db.Recording.from_frame(objects, check=False)
    np.testing.assert_array_equal(found["alpha"].values, expected)
    assert found["own"].values[3] == 3.0
    assert np.isnan(found["rare"].values[0]) and found["rare"].values[1] == 1.0
    for wrong, text in ((["1", "2"], "'q' is text and must be numbers"), ([1j, 2j], "'q' is complex"), ([None, "x"], "'x' is text"),
                        (np.zeros(2, "f4,f4"), "'q' must be numbers, not")):
        with pytest.raises(db.DoubletError, match=text):
            db.Recording.from_arrays([0.0, 1.0], {"q": wrong})


def test_clocks_of_channels_have_one_origin():
    start = np.datetime64(INSTANT, "ms")
    first, second = (start + (1000 * (late + SECONDS)).round().astype("timedelta64[ms]") for late in (0.0, 5.0))
    rec = db.Recording.from_arrays(None, {"q": (second, SECONDS, ""), "alpha": (first, SECONDS, "")}, check=False)
    assert rec["alpha"].time[0] == 0.0 and rec["q"].time[0] == 5.0 and rec.origin == start
    shared = db.Recording.from_arrays(second, {"q": SECONDS, "alpha": (first, SECONDS, "")}, check=False)
    assert shared["q"].time[0] == 5.0 and shared["alpha"].time[0] == 0.0
    assert db.Recording.from_arrays(SECONDS, {"q": SECONDS}, check=False).origin is None
    assert len(db._frames.seconds(first[:0])) == 0
    with pytest.raises(db.DoubletError, match="time of 'q' holds instants and time of 'alpha' does not"):
        db.Recording.from_arrays(None, {"q": (first, SECONDS, ""), "alpha": (SECONDS, SECONDS, "")})
    zoned = pandas.DatetimeIndex(second).tz_localize("UTC")
    with pytest.raises(db.DoubletError, match="only one of .* has a time zone"):
        db.Recording.from_arrays(None, {"q": (first, SECONDS, ""), "alpha": (zoned, SECONDS, "")})


def test_frames_state_their_units(demo, frame):
    recording = demo.recording()
    table = recording.to_pandas(step=0.05)
    assert table.attrs["units"]["q"] == "rad/s" and table.attrs["units"]["time"] == "s"
    pytest.importorskip("xarray")
    assert recording.to_xarray()["time"].attrs["units"] == "s"
    again = db.Recording.from_frame(table.set_axis(pandas.to_timedelta(table.index, unit="s")), check=False)
    assert (again["q"].values == table["q"].to_numpy()).all()
    path = db.reconstruct(recording, windows=[tuple(recording["q"].time[[0, 500]])])
    states = path.states.to_pandas()
    assert states.attrs["units"]["theta"] == "rad" and states.attrs["units"]["theta_std"] == "rad" and states.attrs["units"]["u"] == "m/s"
    assert path.to_pandas().attrs["units"]["u"] == "m/s"
