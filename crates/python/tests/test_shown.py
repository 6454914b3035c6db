"""How objects are shown and drawn."""

import warnings

import doublet as db
import numpy as np
import pytest

WINDOW = db.Window("07 elevator", 2.0, 8.5, "elevator", "3-2-1-1", flight="FT1", exclude=[(3.0, 3.5)])


@pytest.fixture(scope="module")
def made(demo):
    windows = [one for one in db.Session.load("builtin:demo").windows if one.surface == "elevator"][:3]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", db.DoubletWarning)
        path = db.reconstruct(demo.recording(), db.aircraft("c337f"), windows=windows)
        return path, db.fit(db.coefficients(path), "Cm ~ 1 + alpha + qc/V + delta_e")


@pytest.fixture(scope="module")
def regression():
    rng = np.random.default_rng(7)
    X = np.column_stack([np.ones(300), rng.normal(size=300)])
    return db.lstsq(X, X @ [1.0, 2.0] + 0.1 * rng.normal(size=300), names=["constant", "alpha"])


@pytest.fixture
def plt():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot

    yield matplotlib.pyplot
    matplotlib.pyplot.close("all")


def is_short(one):
    return len(repr(one)) < 400 and "\n" not in repr(one) and "<table" in one._repr_html_()


def test_windows_values_and_estimators_are_short(regression):
    assert repr(WINDOW) == "<doublet.Window '07 elevator': 2 to 8.5 s, FT1, elevator, 3-2-1-1, identification, without 3 to 3.5 s>"
    assert is_short(WINDOW) and "3 to 3.5" in WINDOW._repr_html_()
    assert is_short(regression["alpha"]) and "low_95" in regression["alpha"]._repr_html_()
    model = db.LeastSquares(method="gls")
    assert is_short(model) and "not fitted" in model._repr_html_()
    assert "alpha" in db.LeastSquares().fit({"alpha": [1.0, 2.0, 4.0, 7.0]}, [1.0, 2.1, 4.0, 7.1])._repr_html_()


def test_states_are_short(demo):
    recording = demo.recording()
    states = db.reconstruct(recording, windows=[tuple(recording["q"].time[[0, 500]])]).states
    assert is_short(states) and repr(states).startswith("<doublet.States: 501 samples, ") and "rad/s" in states._repr_html_()


def test_fits_of_a_coefficient_are_short(made):
    one = made[1].coefficients["Cm"]
    assert is_short(one) and repr(one).startswith("<doublet.CoefficientFit Cm: R2 ") and "Cm_alpha" in repr(one)
    assert [row["derivative"] for row in one.table] == list(one.names)
    failed = db.CoefficientFit("Cm", [], [], error="no manoeuvre")
    assert repr(failed) == "<doublet.CoefficientFit Cm: no manoeuvre>" and failed.nobs == 0 and len(failed.table) == 0


def test_regressions_and_distributions_are_drawn(regression, plt):
    axis = plt.subplots()[1]
    assert regression.plot(axes=axis) is axis and len(axis.lines) == 2 and axis.get_xlabel() == "sample"
    verdict = regression.verdict
    drawn = db.Distribution(1.0, verdict, np.random.default_rng(1).normal(1.0, 0.1, 500)).plot()
    assert len(drawn.patches) > 10 and "verdict good" in drawn.get_title()
    assert len(db.Distribution(1.0, verdict, _stderr=0.1, _interval=(0.8, 1.2)).plot().patches) == 1
    axis = plt.subplots()[1]
    several = db.Distribution(np.arange(3.0), verdict, np.random.default_rng(1).normal(size=(500, 3)))
    assert several.plot(axes=axis) is axis and len(axis.collections) == 1


def test_equations_are_drawn(plt):
    rows = [{"name": "M_q", "estimate": -1.0, "standard_error": 0.1, "corrected_standard_error": 0.2}]
    method = {"parameters": rows, "initial": [], "outputs": [], "samples": 10}
    document = {"equation_error": method, "output_error": method, "filter_error": {"error": "unstable"}, "is_driven_by_noise": False,
                "verdict": {"level": "good"}}
    axis = plt.subplots()[1]
    assert db.EquationFit(db.Answer(document, "equations", False, [])).plot(axes=axis) is axis
    assert [text.get_text() for text in axis.get_legend().get_texts()] == ["equation error", "output error"]
    assert [label.get_text() for label in axis.get_yticklabels()] == ["M_q"]


def test_sessions_are_drawn_with_their_manoeuvres(plt):
    session = db.Session.load("builtin:demo")
    drawn = session.plot("q", "delta_e")
    assert len(drawn) == 2 and len(drawn[0].patches) == len(session.windows) == len(drawn[0].texts)
    assert drawn[0].get_ylabel() == "q [rad/s]" and drawn[1].get_xlabel() == "time [s]"


def test_axes_is_the_keyword_everywhere(plt):
    plots = [db.Recording.plot, db.WindowPath.plot, db.Coefficients.plot, db.Fit.plot, db.Results.plot, db.OutputError.plot, db.Design.plot,
             db.Linear.plot, db.Linear.bode, db._linear.StateSpace.bode, db.FrequencyResponse.plot, db.EquationFit.plot, db.Regression.plot,
             db.Distribution.plot, db.Session.plot]
    import inspect

    assert all("axes" in inspect.signature(one).parameters for one in plots)
    for one in (db.Coefficients.plot, db.Linear.plot, db.Linear.bode, db._linear.StateSpace.bode):
        assert "ax" in inspect.signature(one).parameters
    first, second = plt.subplots()[1], plt.subplots()[1]
    assert db._plots.by_either_name(first, None) is db._plots.by_either_name(None, first) is first
    with pytest.raises(db.DoubletError, match="axes and ax are the same: give axes"):
        db._plots.by_either_name(first, second)
