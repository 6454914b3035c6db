"""The next flight: designed inputs, what they promise and what they keep within."""

import json
import os
import subprocess

import doublet as db
import numpy as np
import pytest


@pytest.fixture(scope="module")
def fit(demo):
    session = db.Session.load("builtin:demo")
    noise = {**session["filter.process_noise"], **session["filter.measurement_noise"]}
    path = db.reconstruct(demo.recording(), db.aircraft("c337f"), windows=session.windows, noise=noise)
    return db.fit(db.coefficients(path), session["model"])


@pytest.fixture(scope="module")
def design(fit):
    return db.design_input(fit, surfaces=["elevator"], duration=40.0, kind="3-2-1-1", rounds=0, samples=10, airspeed=46.0)


def test_design_keeps_its_limits(design):
    assert design.to_dict()["surfaces"] == ["elevator"] and abs(design.trim["airspeed_m_s"] - 46.0) < 1e-9
    assert sum(row["duration_s"] for row in design.manoeuvres) <= 40.0 + 1e-9
    for number, row in enumerate(design.manoeuvres, start=1):
        time, deflections = design.nodes(number)
        assert (np.diff(time) >= 0).all() and not deflections["aileron"].any() and not deflections["rudder"].any()
        assert np.isclose(np.abs(deflections["elevator"]).max(), row["peak_rad"]["elevator"])
        moving = np.diff(time) > 0
        rates = np.abs(np.diff(deflections["elevator"]))[moving] / np.diff(time)[moving]
        assert rates.max() <= np.radians(60.0) * (1 + 1e-9)
    for row in design.excursions:
        if row["limit_low"] is not None:
            assert row["limit_low"] < row["nominal_low"] <= row["trim"] <= row["nominal_high"] < row["limit_high"], row


def test_asked_for_limits_and_time_count(fit, design):
    narrow = db.design_input(
        fit, surfaces=["elevator"], duration=40.0, kind="3-2-1-1", rounds=0, samples=0, peak=0.01, envelope={"n_z": (0.8, 1.2)}, airspeed=46.0
    )
    assert max(row["peak_rad"]["elevator"] for row in narrow.manoeuvres) <= 0.01 + 1e-12
    load = narrow.excursions.where(name="n_z")[0]
    assert load["limit_source"] == "asked for" and 0.8 <= load["nominal_low"] and load["nominal_high"] <= 1.2
    error = lambda one, name: next(row["corrected"] for row in one.predicted if row["name"] == name)
    assert error(narrow, "Cm_alpha") > 1.5 * error(design, "Cm_alpha"), "a smaller input tells less"
    both = db.design_input(
        fit, surfaces=["elevator"], duration=40.0, kind="3-2-1-1", rounds=0, samples=0, with_flown=True, airspeed=46.0
    )
    for row in both.predicted:
        if row["name"].startswith("Cm_"):
            assert row["corrected"] < row["present"], row


def test_signal_is_read_at_any_time_and_saved(design, tmp_path):
    time, deflections = design.nodes()
    assert (design.at(time[-1] + 5.0)["elevator"] == 0.0).all()
    middle = 0.5 * (time[1] + time[2])
    assert np.isclose(design.at(middle)["elevator"], 0.5 * (deflections["elevator"][1] + deflections["elevator"][2]))
    design.save(tmp_path / "design.csv")
    columns = np.genfromtxt(tmp_path / "design.csv", delimiter=",", names=True)
    first = columns[columns["manoeuvre"] == 1]
    assert (first["time_s"] == time).all() and (first["elevator_rad"] == deflections["elevator"]).all()
    assert "Cm_alpha" in design.summary() and "<table>" in design._repr_html_()
    pytest.importorskip("matplotlib")
    assert design.plot().get_ylabel().endswith("[deg]")


def test_command_line_promises_the_same():
    program = os.environ.get("DOUBLET_PROGRAM")
    if not program:
        pytest.skip("DOUBLET_PROGRAM names no program")
    results = db.run(db.Session.load("builtin:demo"), studies=["dynamics"])
    ours = db.design_input(
        results, surfaces=["elevator"], duration=40.0, kind="3-2-1-1", rounds=1, samples=3, peak=float(np.radians(2.0)), envelope={"n_z": (0.5, 1.5)}
    )
    asked = ["--surfaces", "elevator", "--time", "40", "--kind", "3-2-1-1", "--rounds", "1", "--samples", "3", "--peak", "2"]
    asked += ["--limit", "n_z=0.5:1.5", "--json"]
    printed = subprocess.run([program, "design", "builtin:demo", *asked], check=True, capture_output=True, text=True)
    theirs = json.loads(printed.stdout)
    # What the command says of its own in words.
    theirs["notes"] = []
    assert ours.to_dict() == theirs and len(ours.predicted) > 20
    with pytest.raises(db.DoubletError, match="give a fit to choose another"):
        db.design_input(results, airspeed=46.0)


def test_results_without_a_model_are_refused(demo):
    with pytest.raises(db.DoubletError, match=r'run the session with studies=\["dynamics"\]'):
        db.design_input(demo)


def test_what_cannot_be_designed_is_refused(fit):
    for wrong, text in (
        (dict(surfaces=["flaps"]), "'flaps' is not a surface: use one of aileron, elevator, rudder"),
        (dict(surfaces=[]), "no surface is named"),
        (dict(kind="square"), "'square' is not a kind of input: use one of"),
        (dict(criterion="e"), "'e' is not a criterion: use one of"),
        (dict(duration=1.0, kind="3-2-1-1"), "takes at least"),
        (dict(duration=float("nan")), "duration NaN must be above zero"),
        (dict(peak=-1.0), "peak -1 must be above zero"),
        (dict(peak_thrust=0.0), "peak_thrust 0 must be above zero"),
        (dict(usage=2.0), "usage 2 must lie between"),
        (dict(gusts=-1.0), "gusts must be zero or more"),
        (dict(envelope={"q": (0.0, 1.0)}), "'q' is nothing an envelope limits"),
        (dict(envelope={"n_z": (1.2, 0.8)}), "give a lower and a higher one"),
        (dict(envelope={"alpha": (0.5, 0.6)}), "the limit of alpha leaves no room"),
        (dict(speed=3.0), "'speed' is not a quantity of a trim: did you mean airspeed"),
    ):
        with pytest.raises(db.DoubletError, match=text):
            db.design_input(fit, rounds=0, samples=0, **{"surfaces": ["elevator"], **wrong})
