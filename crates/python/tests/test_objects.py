"""Small objects, errors and plots."""

import json

import doublet as db
import numpy as np
import pytest


@pytest.fixture(scope="module")
def made(demo):
    session = db.Session.load("builtin:demo")
    noise = {**session["filter.process_noise"], **session["filter.measurement_noise"]}
    path = db.reconstruct(demo.recording(), db.aircraft("c337f"), windows=session.windows, noise=noise)
    return path, db.fit(db.coefficients(path), session["model"])


def test_values_are_numbers(demo):
    first, second = demo.derivatives["Cm_alpha"], demo.derivatives["Cm_q"]
    assert first * 2 == 2 * first.value and -first == -first.value and (first < second) == (first.value < second.value)
    assert f"{first:.3f}" == f"{first.value:.3f}" and f"{first}" == str(first) and "±" in repr(first)
    assert np.asarray([first, second]).dtype == np.float64 and json.dumps(first) == json.dumps(first.value)
    assert abs(first).is_integer() is False and round(first, 3) == round(first.value, 3)


def test_values_carry_their_errors_on(demo):
    pytest.importorskip("uncertainties")
    value = demo.derivatives["Cm_alpha"]
    double = 2 * value.to_uncertainties()
    assert (double.nominal_value, double.std_dev) == pytest.approx((2 * value.value, 2 * value.stderr))


def test_distributions_print_few_digits(made):
    shown = repr(db.propagate(made[1], "Cm_alpha", n=200))
    assert len(shown) < 80 and "±" in shown


def test_errors_are_those_of_the_language(demo, made, tmp_path):
    path, fit = made
    for wrong in (lambda: fit["x"], lambda: demo.recording()["x"], lambda: path["x"], lambda: demo.derivatives["x"],
                  lambda: db.coefficients(path)["x"], lambda: path[0].states["xx"], lambda: db.Session.load("builtin:demo")["x"]):
        with pytest.raises(KeyError) as caught:
            wrong()
        assert isinstance(caught.value, db.DoubletError) and str(caught.value).count("'") >= 2
    for missing in (lambda: db.Session.load(tmp_path / "no.toml"), lambda: db.read(tmp_path / "no.csv"),
                    lambda: db.Session.new(tmp_path / "no.csv")):
        with pytest.raises(FileNotFoundError) as caught:
            missing()
        assert isinstance(caught.value, db.DoubletError) and str(caught.value).count("no.") == 1
    with pytest.raises(db.DoubletError, match="paths is empty: give a file"):
        db.read([])
    with pytest.raises(KeyError, match="did you mean 'Cm_alpha'"):
        fit["Cm_alfa"]
    assert fit.get("x") is None and demo.recording().get("x", 3) == 3 and "Cm_alpha" in fit


def test_plots_refuse_what_they_cannot_draw_and_name_units(demo, made):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    path, fit = made
    for name in ("nonsense", "modes"):
        with pytest.raises(db.DoubletKeyError, match=f"no coefficient is called '{name}'"):
            demo.plot(name)
    with pytest.raises(db.DoubletKeyError, match="no state is called 'thetta': did you mean 'theta'"):
        path[0].plot("thetta")
    with pytest.raises(db.DoubletKeyError, match="no coefficient of the fit is called 'Cx'"):
        fit.plot("Cx")
    with pytest.raises(db.DoubletError, match="there are 1 axes for 2 curves"):
        path[0].plot("u", "theta", axes=plt.subplots()[1])
    axis = plt.subplots()[1]
    assert path[0].plot("theta", axes=axis)[0] is axis and axis.get_ylabel() == "theta [rad]"
    assert path[0].plot("nis")[0].get_ylabel() == "nis [-]"
    assert "[per rad" in demo.plot("Cm").get_xlabel()
    axis = fit.plot("Cm")
    assert axis.get_xlabel().endswith("[s]")
    length = sum(window.end - window.start for window in path.windows if window.name in fit.coefficients["Cm"].windows)
    assert axis.lines[0].get_xdata()[-1] == pytest.approx(length, rel=0.1)
    plt.close("all")


def test_no_panic_leaves_the_engine():
    rng = np.random.default_rng(1)
    strange = [np.zeros(0), np.zeros(1), np.full(50, 1e308), np.full(50, np.nan), np.full(50, np.inf), rng.normal(size=50) * 1e-308]
    for values in strange:
        for call in (
            lambda: db.smooth(np.arange(len(values)) * 1.0, values),
            lambda: db.differentiate(np.arange(len(values)) * 1.0, values),
            lambda: db.lstsq(np.column_stack([values, np.arange(len(values))]), values, method="stepwise"),
            lambda: db.coloured_covariance(values.reshape(-1, 1), values),
            lambda: db.frequency_response(values, values, dt=0.1),
            lambda: db.Recording.from_arrays(values, {"q": values}),
            lambda: db.Recording.from_arrays(np.arange(len(values)) * 0.1, {"q": values, "p": values, "r": values}),
        ):
            try:
                call()
            except db.DoubletError:
                pass


def test_a_panic_of_any_compiled_function_is_an_exception():
    from doublet import _doublet, _guard

    @_guard.guarded
    def fails():
        raise _doublet.PanicException("index out of bounds")

    assert not issubclass(_doublet.PanicException, Exception)
    with pytest.raises(db.DoubletError, match="^fails: internal error of doublet: index out of bounds; report it with the data$"):
        fails()
    # No function, method or attribute of the compiled part is called without the guard.
    for name, value in vars(_doublet).items():
        members = vars(value).items() if isinstance(value, type) and not issubclass(value, BaseException) else [(name, value)]
        for own, member in members:
            if own.startswith("__") or not (callable(member) or isinstance(member, (staticmethod, property))):
                continue
            if isinstance(member, type):
                continue
            call = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
            assert hasattr(call, "__wrapped__"), f"{name}.{own}"


def test_rates_and_forces_alone_are_refused_in_one_sentence():
    time = np.arange(1000) * 0.02
    still = {name: 0.1 * np.sin(time + k) for k, name in enumerate(("ax", "ay", "p", "q", "r", "delta_e"))}
    recording = db.Recording.from_arrays(time, {**still, "az": np.full(len(time), -9.8)}, check=False)
    session = db.Session.from_recordings(recording, windows=[(0.0, 9.0), (10.0, 19.0)])
    for call in (lambda: db.reconstruct(recording, windows=[(0.0, 9.0), (10.0, 19.0)]), session.run):
        with pytest.raises(db.DoubletError) as refused:
            call()
        assert str(refused.value).count("No flight-path measurement besides rates and forces") == 1, refused.value
