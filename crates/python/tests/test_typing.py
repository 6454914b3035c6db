"""Types and documentation: the package by mypy --strict, the types of its compiled part and of its commands against what is there, docstrings."""

import inspect
import pathlib
import re
import subprocess
import sys

import doublet as db
import pytest

SETTINGS = pathlib.Path(__file__).resolve().parents[1] / "pyproject.toml"


def checked(folder, *arguments):
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", *arguments], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_mypy_strict_is_clean(tmp_path):
    checked(tmp_path, "mypy", "--config-file", str(SETTINGS), "--cache-dir", str(tmp_path), "-p", "doublet")


def test_stubtest_is_clean(tmp_path):
    checked(tmp_path, "mypy.stubtest", "--mypy-config-file", str(SETTINGS), "doublet")


def test_a_users_file_is_checked(tmp_path):
    """A right call passes, wrong ones are found."""
    pytest.importorskip("mypy")
    (tmp_path / "right.py").write_text(
        "import numpy as np\nimport doublet as db\n\n"
        "response = db.frequency_response(np.zeros(100), np.zeros(100), dt=0.1)\nresponse.to_control()\n"
        'answer: db.Answer = db.commands.structure(db.Session.load("builtin:demo"))\n'
        'path = db.reconstruct(db.read("a.csv"), windows=[(1.0, 2.0)], method="ekf")\n'
        'mean: float = float(db.coefficients(path)["a"]["Cm"].mean())\n'
        "several = db.coefficients(path)[:2]\n"
        'theta: float = float(path[0].smoothed["theta"][0])\n'
        'fit = db.fit(db.coefficients(path), "Cm ~ 1 + alpha")\n'
        'db.design_input(fit, criterion="d", airspeed=46.0)\nfit.linearise(airspeed=46.0, samples=10)\n'
        'mean = float(fit.predict("Cm", {"alpha": [0.1]}).mean()) + float(fit.predict("Cm")["a"]["observed"].mean())\n'
        'results = db.run(db.Session.load("builtin:demo"))\nmean = results.windows[0]["mean_nis"] + results.fits[0]["r_squared"]\n'
    )
    (tmp_path / "wrong.py").write_text(
        "import doublet as db\n\n"
        'db.lstsq([[1.0]], [1.0], method="nonsense")\ndb.commands.structure()\ndb.run(db.Session.load("a"), studies=["nonsens"])\n'
        'path = db.reconstruct(db.read("a.csv"), method="EKF")\npath[0].smooothed\n'
        'fit = db.fit(db.coefficients(path), "Cm ~ 1 + alpha")\n'
        'db.design_input(fit, criterion="e")\nfit.linearise(speed=3.0)\ndb.coefficients(path)["a"].nonsense\n'
        'results = db.run(db.Session.load("builtin:demo"))\nresults.windows[0]["mean_nsi"]\nresults.fits[0]["derivatives"][0]["estimat"]\n'
    )
    run = lambda name: subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), name], cwd=tmp_path, capture_output=True, text=True
    )
    assert run("right.py").returncode == 0, run("right.py").stdout
    found = run("wrong.py").stdout
    assert [line for line in range(1, 15) if f"wrong.py:{line}:" in found] == [3, 4, 5, 6, 7, 9, 10, 11, 13, 14], found


def documented():
    """Public functions, methods and properties by name."""
    for name in db.__all__:
        one = getattr(db, name)
        if inspect.isfunction(one):
            yield name, one
        for own, member in vars(one).items() if inspect.isclass(one) else ():
            if own.startswith("_"):
                continue
            if isinstance(member, (classmethod, staticmethod)):
                member = member.__func__
            if inspect.isfunction(member) or isinstance(member, property):
                yield f"{name}.{own}", member


@pytest.mark.parametrize(("name", "one"), list(documented()), ids=lambda one: one if isinstance(one, str) else "")
def test_documentation_has_every_argument_and_the_errors(name, one):
    text = inspect.getdoc(one) or ""
    assert text
    if isinstance(one, property):
        return
    arguments = [argument for argument in inspect.signature(one).parameters if argument not in ("self", "cls", "others")]
    assert [argument for argument in arguments if not re.search(rf"\b{argument}\b", text)] == []
    assert "." in name or len(arguments) < 2 or "Raises:" in text
