"""The commands of the command line as functions: every one of them, with an example that runs."""

import inspect
import pathlib
import pickle
import runpy
import sys
import warnings

import doublet as db
import numpy as np
import pytest

from conftest import ROOT

PRIOR = "name,mean,std error\nCm_alpha,-0.9,0.1\n"
#: A call of each command in a folder, with a session that has few manoeuvres.
EXAMPLES = {
    "inspect": lambda s, f: db.commands.inspect(f / "flight.csv"),
    "map": lambda s, f: db.commands.map(list=True),
    "new": lambda s, f: db.commands.new([flight(f)], output=f / "new.toml", guess=True),
    "aircraft_list": lambda s, f: db.commands.aircraft_list(),
    "aircraft_show": lambda s, f: db.commands.aircraft_show("c337f"),
    "aircraft_new": lambda s, f: db.commands.aircraft_new("mine", output=f / "mine.toml", area=18.6, span=11.6, chord=1.66, mass=1980.0,
                                                          inertia=[3600.0, 4500.0, 7300.0, 300.0]),
    "check": lambda s, f: db.commands.check(s),
    "run": lambda s, f: db.commands.run(s, out=f / "results", with_=["lags"]),
    "report": lambda s, f: db.commands.report(s, out=f / "report", sections=["overview"]),
    "sensitivity": lambda s, f: db.commands.sensitivity(s),
    "manoeuvres": lambda s, f: db.commands.manoeuvres(s),
    "checks": lambda s, f: db.commands.checks(s, axis="longitudinal"),
    "lags": lambda s, f: db.commands.lags(s),
    "live": lambda s, f: db.commands.live(session="builtin:demo", every=20.0, for_=60.0),
    "compatibility": lambda s, f: db.commands.compatibility(s, free=["bias_q"]),
    "structure": lambda s, f: db.commands.structure(s),
    "regress": lambda s, f: db.commands.regress(columns(), y="y", terms=["1", "x"]),
    "equations": lambda s, f: db.commands.equations(flight(f), equations="short-period"),
    "response": lambda s, f: db.commands.response(s, input="delta_e", output="q", band=(0.5, 10.0)),
    "loes": lambda s, f: db.commands.loes(s, input="delta_e", output="q", form="short-period"),
    "variants": lambda s, f: db.commands.variants(s, know={"Cm_q": -10.0}),
    "monte_carlo": lambda s, f: db.commands.monte_carlo(s, realisations=2),
    "compare": lambda s, f: db.commands.compare(s, with_=["CX"]),
    "fix": lambda s, f: db.commands.fix(s, most=1),
    "propose_manoeuvres": lambda s, f: db.commands.propose_manoeuvres(s),
    "propose_steady": lambda s, f: db.commands.propose_steady(s),
    "propose_onsets": lambda s, f: db.commands.propose_onsets(s),
    "propose_noise": lambda s, f: db.commands.propose_noise(s),
    "match": lambda s, f: db.commands.match(s),
    "qtg": lambda s, f: db.commands.qtg(s, tests=f / "none.toml", out=f / "qtg"),
    "fmu": lambda s, f: db.commands.fmu(s, out=f / "aircraft.fmu"),
    "prior": lambda s, f: db.commands.prior(s, prior=f / "prior.csv"),
    "linear": lambda s, f: db.commands.linear(s, airspeed=46.0, samples=10),
    "modes": lambda s, f: db.commands.modes(s, airspeed=46.0, samples=10),
    "qualities": lambda s, f: db.commands.qualities(s, airspeed=46.0, samples=10),
    "design": lambda s, f: db.commands.design(s, kind="3-2-1-1", rounds=0, samples=2, limit={"n_z": (0.2, 2.0)}),
    "campaign": lambda s, f: db.commands.campaign("builtin:c337f"),
    "weigh": lambda s, f: db.commands.weigh(f / "weighing.toml"),
    "swing": lambda s, f: db.commands.swing(f / "swing.toml"),
    "static_thrust": lambda s, f: db.commands.static_thrust(f / "thrust.toml"),
    "debrief": lambda s, f: db.commands.debrief(f / "no_design"),
    "enough": lambda s, f: db.commands.enough(s, goal={"Cm_q": 0.5}),
    "propagate": lambda s, f: db.commands.propagate(s, "-Cm_alpha/CZ_alpha", samples=100),
    "export": lambda s, f: db.commands.export(s, out=f / "model", format="daveml"),
    "diff": lambda s, f: db.commands.diff(s, s.replace({"filter.measurement_noise.alpha": 0.004}), settings=True),
    "batch": lambda s, f: db.commands.batch(saved(s, f), out=f / "batch.csv"),
    "coverage": lambda s, f: db.commands.coverage(realisations=2),
    "calibrate": lambda s, f: db.commands.calibrate(realisations=1),
    "fidelity": lambda s, f: db.commands.fidelity(out=f / "none" / "fidelity.md", realisations=2),
    "schema": lambda s, f: db.commands.schema("session"),
    "simulate": lambda s, f: db.commands.simulate(list=True),
    "engine": lambda s, f: db.commands.engine(
        "c337f", rpm=2500, manifold_inhg=24, altitude_ft=3000, oat_c=10, airspeed_kt=120
    ),
    "datcom": lambda s, f: db.commands.datcom(deck="c337f", output=f / "deck.inp"),
    "tune": lambda s, f: db.commands.tune(s, steps=1),
    "help": lambda s, f: db.commands.help("run"),
    "completions": lambda s, f: db.commands.completions("bash"),
    "man": lambda s, f: db.commands.man(out=f / "man"),
}
#: What an example says whose file does not exist; the library of an FMU is not in the wheel.
REFUSED = {
    "weigh": "weighing.toml",
    "swing": "swing.toml",
    "static_thrust": "thrust.toml",
    "debrief": "no_design",
    "fmu": "doublet-fmu",
    "qtg": "none.toml",
    "fidelity": "none",
}


def columns():
    x = np.linspace(0.0, 1.0, 50)
    return {"x": x, "y": 1.0 + 2.0 * x + 0.01 * np.sin(40 * x)}


def flight(folder):
    return folder / "flight.csv"


def saved(session, folder):
    session.save(folder / "session.toml")
    return folder / "session.toml"


@pytest.fixture(scope="module")
def small():
    session = db.Session.load("builtin:demo")
    rows = session["manoeuvre"]
    kept = [row for row in rows if row.get("role") == "identification"][:8] + [row for row in rows if row.get("role") == "validation"][:1]
    return session.replace(manoeuvre=kept)


@pytest.fixture
def folder(demo, tmp_path):
    pytest.importorskip("pandas")
    window = next(one for one in db.Session.load("builtin:demo").windows if one.surface == "elevator")
    frame = demo.recording().to_pandas(step=0.05).loc[window.start : window.end].reset_index()
    frame.to_csv(tmp_path / "flight.csv", index=False)
    (tmp_path / "prior.csv").write_text(PRIOR)
    return tmp_path


def names():
    return {"_".join(row["name"]).replace("-", "_") for row in db._commands.table()}


def test_no_command_is_missing():
    """The list that `doublet help` prints, the table, the functions and the examples of this file are the same."""
    lines = db.commands.help()["lines"]
    start = next(k for k, line in enumerate(lines) if line.startswith("commands"))
    listed = [line.split()[0] for line in lines[start + 1 : lines.index("", start)] if line.startswith("  ")]
    assert len(listed) > 45 and {row["name"][0] for row in db._commands.table()} == set(listed)
    assert names() == set(EXAMPLES) == set(db.commands.__all__) - {"Answer"}
    for name in names():
        made = getattr(db.commands, name)
        assert made.__name__ == name and inspect.signature(made) and "Args:" in made.__doc__ and pickle.loads(pickle.dumps(made)) is made


def test_types_are_those_of_the_table():
    """scripts/python_commands.py writes them."""
    stub = runpy.run_path(str(ROOT / "scripts" / "python_commands.py"))["stub"]()
    assert pathlib.Path(db.__file__).with_name("commands.pyi").read_text(encoding="utf-8") == stub


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_command_answers(name, small, folder):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        if name in REFUSED:
            with pytest.raises(db.DoubletError, match=REFUSED[name]):
                EXAMPLES[name](small, folder)
            return
        answer = EXAMPLES[name](small, folder)
    assert isinstance(answer, db.Answer) and answer.command == name.replace("_", "-", 1) or answer.command.split()[0] in name
    assert answer and (name in ("completions", "help") or "text" not in answer), answer
    assert pickle.loads(pickle.dumps(answer)) == answer


def test_answers_are_those_of_the_session(small):
    results = small.run()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        found = db.commands.propagate(small, "Cm_alpha", samples=10)
        tables = db.commands.variants(small).tables
    assert str(results.derivatives["Cm_alpha"].value)[:6] in str(found)
    assert any(row["derivative"] == "Cm_alpha" for table in tables for row in table)


def test_errors_and_verdicts_come_through(small, folder):
    with pytest.raises(db.DoubletError, match="^no file|not found|nofile.toml"):
        db.commands.structure("nofile.toml")
    with pytest.raises(db.DoubletError, match="'nonsense'") as caught:
        db.commands.structure(small, method="nonsense")
    assert "Usage" not in str(caught.value) and not str(caught.value).startswith("error")
    for wrong in (lambda: db.commands.structure(), lambda: db.commands.structure(small, nonsense=1)):
        with pytest.raises(TypeError):
            wrong()
    with pytest.warns(db.DoubletWarning, match="^run: verdict bad") as caught:
        answer = db.commands.run(small.replace(model={"Cm": ["1", "delta_e"]}), out=folder / "bad")
    assert answer.is_bad and answer.verdict.level == "bad" and caught[0].filename == __file__


def test_a_session_in_memory_is_not_changed_silently(small, folder):
    with pytest.raises(db.DoubletError, match="propose noise changes the file of a session: save the session and give its path"):
        db.commands.propose_noise(small, apply=True)
    path = saved(small, folder)
    db.commands.propose_noise(path, apply=True)
    assert db.Session.load(path).text != small.text


def test_the_package_is_the_command_line(small):
    import subprocess

    done = subprocess.run([sys.executable, "-m", "doublet", "aircraft", "list"], capture_output=True, text=True)
    assert done.returncode == 0 and "c337f" in done.stdout
    done = subprocess.run([sys.executable, "-m", "doublet"], capture_output=True, text=True)
    assert done.returncode == 1 and "no window" in done.stderr
    done = subprocess.run([sys.executable, "-m", "doublet", "hlep"], capture_output=True, text=True)
    assert done.returncode == 1 and "did you mean 'doublet help'?" in done.stderr


def test_help_finds_the_words_of_the_field():
    for words in ("confidence interval", "error bars"):
        assert "confidence interval" in str(db.commands.help(search=words))
    assert "short period" in str(db.commands.help(term="short period"))


def test_files_of_a_shipped_session_have_names_that_every_system_takes(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        db.commands.report("builtin:demo", out=tmp_path / "report", sections=["overview"])
    names = {path.name for path in (tmp_path / "report").iterdir()}
    assert "demo.html" in names and names <= {"demo.html", "demo.pdf", "doublet_manifest.json"}


def options(given, **row):
    with db._commands.Inputs() as inputs:
        return db._commands._options("n", {"long": "n", "takes_value": True, "repeats": False, "value": "S", **row}, given, inputs)


def test_switches_are_true_or_false():
    for value in (True, np.bool_(True), 1, np.int64(1)):
        assert options(value, takes_value=False) == ["--n"]
    for value in (False, np.bool_(False), 0, None):
        assert options(value, takes_value=False) == []
    for value in ("yes", 2, [], 0.5):
        with pytest.raises(db.DoubletError, match="n is .*: give True or False"):
            options(value, takes_value=False)
    for value in (True, False, np.bool_(True)):
        with pytest.raises(db.DoubletError, match=f"n is {bool(value)}: give a value, or leave it out"):
            options(value)


def test_lists_are_tuples_and_arrays_too():
    many, span = {"repeats": True}, {"value": "LOW..HIGH"}
    for value in ([1.5, 2.0, 4.0], (1.5, 2.0, 4.0), np.array([1.5, 2.0, 4.0])):
        assert options(value, value="S,S") == ["--n=1.5,2.0,4.0"]
        assert options(value, value="S,S", **many) == ["--n=1.5", "--n=2.0", "--n=4.0"]
    for value in ([0.5, 10.0], (0.5, 10.0), np.array([0.5, 10.0])):
        assert options(value, **span) == ["--n=0.5..10.0"]
        assert options(value, value="START:END", **many) == ["--n=0.5:10.0"]
    assert options(np.array([[1.0, 2.0], [3.0, 4.0]]), value="START:END", **many) == ["--n=1.0:2.0", "--n=3.0:4.0"]
    assert options(("elevator", "rudder"), value="SURFACE,...", **many) == ["--n=elevator", "--n=rudder"]
    assert options(range(3), **many) == ["--n=0", "--n=1", "--n=2"] and options(2.5, **many) == ["--n=2.5"]
    assert options({"n_z": np.array([0.2, 2.0])}, value="NAME=LOW:HIGH", **many) == ["--n=n_z=0.2:2.0"]


def test_arrays_are_arguments_of_commands(small):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        first, *others = (
            db.commands.response(small, input="delta_e", output="q", band=band, window_length=lengths)
            for band, lengths in (((0.5, 10.0), [4.0, 8.0]), (np.array([0.5, 10.0]), np.array([4.0, 8.0])), ([0.5, 10.0], (4.0, 8.0)))
        )
    assert all(one == first for one in others)


def test_an_index_of_times_is_the_time():
    pandas = pytest.importorskip("pandas")
    seconds = np.arange(50) * 0.02
    frame = pandas.DataFrame({"x": np.sin(seconds)})
    instants = pandas.Timestamp("2026-05-14") + pandas.to_timedelta(seconds, unit="s").round("ms")
    for index in (seconds, pandas.to_timedelta(seconds, unit="s").round("ms"), instants, instants.tz_localize("UTC")):
        names, columns = db._commands._columns(frame.set_axis(index))
        assert names == ["time", "x"], index
        np.testing.assert_allclose(columns[0], seconds, atol=1e-9)
    assert db._commands._columns(frame)[0] == ["x"]
    assert db._commands._columns(frame.set_axis(range(3, 53)))[0] == ["x"]
    names, columns = db._commands._columns(frame.assign(stamp=instants, note="a", late=pandas.NaT))
    assert names == ["x", "stamp"] and columns[1][1] == pytest.approx(0.02)
    stated = frame.set_axis(instants)
    stated.attrs["units"] = {"time": "s"}
    np.testing.assert_allclose(db._commands._columns(stated)[1][0], seconds, atol=1e-9)


def test_answers_are_shown_in_a_line(small):
    answer = db.commands.check(small)
    assert repr(answer).startswith("<doublet.Answer of check: ") and len(repr(answer)) < 300 and "\n" not in repr(answer)
    assert "findings" in str(answer) and len(str(answer)) > len(repr(answer))
    assert "<table" in answer._repr_html_() and len(answer._repr_html_()) < 100_000
