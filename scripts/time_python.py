#!/usr/bin/env python3
"""Times doublet beside statsmodels and aeroid on the same data in the same run and prints medians.

    scripts/time_python.py [--rows N] [--columns P] [--rounds R] [--peer-rounds R]

Least squares beside statsmodels, output error and flight-path reconstruction beside aeroid. Methods take turns, so that other load of the
machine meets all of them. Needs doublet, NumPy and pandas; what needs a package that is not installed is named and left out.
"""
import argparse
import importlib
import statistics
import time
import warnings

import doublet as db
import numpy as np

GRAVITY = 9.80665
STATES = [*"xyzuvw", "phi", "theta", "psi", *(f"bias_{name}" for name in ("ax", "ay", "az", *"pqr")), "wind_north", "wind_east", "wind_down"]
MEASURED = [*"xyz", "v_north", "v_east", "v_down", "phi", "theta", "psi", "airspeed", "alpha", "beta"]
INERTIAL = ["ax", "ay", "az", "p", "q", "r"]
TRUTH = {"Z_alpha": -1.2, "M_alpha": -6.0, "M_q": -1.8, "M_delta_e": -7.0}


def regression(rows, columns):
    """Regressors with a constant, and a measurement with noise of lag-one correlation 0.9."""
    rng = np.random.default_rng(1)
    X = np.column_stack([np.ones(rows), np.cumsum(rng.normal(size=(rows, columns - 1)), axis=0) / 10.0])
    noise = np.zeros(rows)
    for k, draw in enumerate(rng.normal(size=rows - 1), start=1):
        noise[k] = 0.9 * noise[k - 1] + 0.1 * draw
    return X, X @ np.arange(1.0, columns + 1.0) + noise


def short_period_rates(x, u, p):
    return np.array([p["Z_alpha"] * x[0] + x[1], p["M_alpha"] * x[0] + p["M_q"] * x[1] + p["M_delta_e"] * u])


def short_period_record(samples=500, dt=0.02):
    """Time, elevator, and the motion of a short period with white noise of 0.0005."""
    t = np.arange(samples) * dt
    elevator = 0.05 * (np.sign(np.sin(1.5 * t)) * (t < 6.0) + 0.4 * np.sin(5.0 * t))
    x, rows = np.zeros(2), []
    for k in range(samples):
        rows.append(x)
        ends = elevator[k], elevator[min(k + 1, samples - 1)]
        middle = sum(ends) / 2
        k1 = short_period_rates(x, ends[0], TRUTH)
        k2 = short_period_rates(x + dt / 2 * k1, middle, TRUTH)
        k3 = short_period_rates(x + dt / 2 * k2, middle, TRUTH)
        k4 = short_period_rates(x + dt * k3, ends[1], TRUTH)
        x = x + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return t, elevator, np.array(rows) + np.random.default_rng(2).normal(scale=5e-4, size=(samples, 2))


def motion(t, x, u, p):
    """Rates of the 18 states of a flight path."""
    ax, ay, az, roll, pitch, yaw = u - x[9:15]
    _, _, _, u_, v, w, phi, theta, psi = x[:9]
    north, east, down = ground_velocity(x)
    sp, cp, st, ct = np.sin(phi), np.cos(phi), np.sin(theta), np.cos(theta)
    return np.array([
        north, east, down,
        yaw * v - pitch * w - GRAVITY * st + ax, roll * w - yaw * u_ + GRAVITY * ct * sp + ay, pitch * u_ - roll * v + GRAVITY * ct * cp + az,
        roll + (pitch * sp + yaw * cp) * st / ct, pitch * cp - yaw * sp, (pitch * sp + yaw * cp) / ct, *np.zeros(9),
    ])


def ground_velocity(x):
    u, v, w, phi, theta, psi = x[3:9]
    lift, across = v * np.sin(phi) + w * np.cos(phi), v * np.cos(phi) - w * np.sin(phi)
    level = u * np.cos(theta) + lift * np.sin(theta)
    return np.array([
        level * np.cos(psi) - across * np.sin(psi), level * np.sin(psi) + across * np.cos(psi), lift * np.cos(theta) - u * np.sin(theta)
    ]) + x[15:18]


def observed(t, x, u, p):
    """The 12 measurements of a flight path."""
    flow = np.sqrt(x[3] ** 2 + x[4] ** 2 + x[5] ** 2), np.arctan2(x[5], x[3]), np.arctan2(x[4], np.hypot(x[3], x[5]))
    return np.array([*x[:3], *ground_velocity(x), *x[6:9], *flow])


def imported(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"{name} is not installed: its rows are left out")
        return None


def timed(title, calls, rounds):
    """Prints medians of calls that take turns; returns the last answer of each."""
    taken, answers = {name: [] for name in calls}, {}
    for _ in range(rounds):
        for name, call in calls.items():
            start = time.perf_counter()
            answers[name] = call()
            taken[name].append(time.perf_counter() - start)
    print(f"{title}, medians of {rounds} rounds in turns")
    for name, seconds in taken.items():
        low, high = np.quantile(seconds, [0.1, 0.9])
        print(f"{1e3 * statistics.median(seconds):10.3f} ms  ({1e3 * low:.3f} to {1e3 * high:.3f})  {name}")
    return answers


def least_squares(given):
    X, y = regression(given.rows, given.columns)
    lags = max(1, given.rows // 10)
    calls = {
        "doublet lstsq, corrected standard errors": lambda: db.lstsq(X, y),
        "doublet lstsq, gls of order 2": lambda: db.lstsq(X, y, method="gls"),
    }
    sm = imported("statsmodels.api")
    if sm is not None:
        calls |= {
            "statsmodels OLS": lambda: sm.OLS(y, X).fit().bse,
            f"statsmodels OLS, HAC with {lags} lags": lambda: sm.OLS(y, X).fit(cov_type="HAC", cov_kwds={"maxlags": lags}).bse,
            "statsmodels GLSAR of order 2": lambda: sm.GLSAR(y, X, rho=2).iterative_fit(maxiter=50).bse,
        }
    found = timed(f"least squares, {given.rows} rows, {given.columns} columns", calls, given.rounds)
    if sm is not None:
        ours = found["doublet lstsq, corrected standard errors"].params
        print(f"largest difference of the estimates: {np.abs(ours - sm.OLS(y, X).fit().params).max():.1e}\n")


def output_error(given, aeroid):
    t, elevator, values = short_period_record()
    frame = {"time": t, "delta_e": elevator, "alpha": values[:, 0], "q": values[:, 1]}
    start = {name: 0.7 * value for name, value in TRUTH.items()}

    def rates(x, u, p):
        return [p.Z_alpha * x.alpha + x.q, p.M_alpha * x.alpha + p.M_q * x.q + p.M_delta_e * u.delta_e]

    expressions = {"alpha": "Z_alpha*alpha + q", "q": "M_alpha*alpha + M_q*q + M_delta_e*delta_e"}
    common = {"inputs": ["delta_e"], "parameters": start}
    by_expressions = {**common, "states": expressions, "outputs": {"alpha": "alpha", "q": "q"}}
    by_function = {**common, "states": ["alpha", "q"], "rates": rates, "outputs": ["alpha", "q"]}
    model = aeroid.Model(["alpha", "q"], ["delta_e"], start, lambda t, x, u, p: short_period_rates(x, u[0], p))
    data = aeroid.FlightData(t, {name: frame[name] for name in ("delta_e", "alpha", "q")})
    found = timed(f"output error of the short period, {len(t)} samples, 4 parameters", {
        "doublet equations, with equation error and filter error, expressions in a process": lambda: db.equations(frame, by_expressions),
        "doublet equations, the same by a Python function": lambda: db.equations(frame, by_function),
        "aeroid identify, output error, finite differences": lambda: aeroid.identify(model, data, list(start), x0=values[0]),
    }, given.peer_rounds)
    ours, _, theirs = found.values()
    worst = max(abs(ours.by("output_error")[name] - theirs.parameters[name]) / theirs.stderr[name] for name in TRUTH)
    print(f"largest difference of the estimates: {worst:.2f} standard errors\n")


def flight_path(given, aeroid):
    session = db.Session.load("builtin:demo")
    recording, window = session.recording(), session.windows[0]
    frame = recording.to_pandas(step=0.01)
    frame = frame[(frame.index >= window.start) & (frame.index <= window.start + 10.0)]
    flight = db.Recording.from_frame(frame, check=False)
    noise = {**session["filter.process_noise"], **session["filter.measurement_noise"]}

    def ours():
        return db.reconstruct(flight, method="ekf", noise=noise, gravity=GRAVITY, outlier_limit=0.0)

    first = ours()
    names = list(first.measurements)
    channels = {name: np.interp(frame.index, row["time"], row["measured"]) for name, row in first.measurements.items()}
    model = aeroid.Model(STATES, INERTIAL, {}, motion, [f"{name}_m" for name in MEASURED], observed)
    measurements = {f"{name}_m": values for name, values in channels.items()}
    data = aeroid.FlightData(frame.index.to_numpy(), {**measurements, **{name: frame[name].to_numpy() for name in INERTIAL}})
    x0 = [first.states[name][0] for name in STATES]
    spread = {name: max(first.states.std[name][0], 1e-6) ** 2 for name in STATES}
    driven = dict(zip(["u", "v", "w", "phi", "theta", "psi"], INERTIAL))
    walk = {name: (noise[driven[name]] ** 2 * 0.01 if name in driven else 1e-12) for name in STATES}
    measured = {f"{name}_m": noise.get(name, 1.0) ** 2 for name in names}
    found = timed(f"flight path, {len(frame)} samples, 18 states, {len(names)} measurements, smoothed", {
        "doublet reconstruct, EKF": ours,
        "aeroid filter_states, EKF": lambda: aeroid.filter_states(
            model, data, process_noise=walk, measurement_noise=measured, outputs=list(measured), x0=x0, P0=spread),
    }, max(1, given.peer_rounds // 3))
    path, theirs = found.values()
    error = path.smoothed["theta"] - np.interp(path.time, theirs.time, theirs.smoothed_state("theta"))
    print(f"difference of the smoothed pitch angle: {np.degrees(np.sqrt(np.mean(error ** 2))):.3f} deg (root mean square)")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=500)
    parser.add_argument("--columns", type=int, default=4)
    parser.add_argument("--rounds", type=int, default=200)
    parser.add_argument("--peer-rounds", type=int, default=9, help="of output error; a third of them of flight paths")
    given = parser.parse_args()
    print(f"doublet {db.__version__}, {db.instructions}")
    warnings.simplefilter("ignore", db.DoubletWarning)
    least_squares(given)
    aeroid = imported("aeroid")
    if aeroid is not None:
        print(f"aeroid {aeroid.__version__}")
        output_error(given, aeroid)
        flight_path(given, aeroid)


main()
