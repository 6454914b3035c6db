#!/usr/bin/env python3
"""Times db.lstsq beside statsmodels on the same data in the same run and prints medians.

    scripts/time_python.py [--rows N] [--columns P] [--rounds R]

Methods take turns, so that other load of the machine meets all of them. Needs doublet, NumPy and statsmodels.
"""
import argparse
import statistics
import time

import doublet as db
import numpy as np
import statsmodels.api as sm


def data(rows, columns):
    """Regressors with a constant, and a measurement with noise of lag-one correlation 0.9."""
    rng = np.random.default_rng(1)
    X = np.column_stack([np.ones(rows), np.cumsum(rng.normal(size=(rows, columns - 1)), axis=0) / 10.0])
    noise = np.zeros(rows)
    for k, draw in enumerate(rng.normal(size=rows - 1), start=1):
        noise[k] = 0.9 * noise[k - 1] + 0.1 * draw
    return X, X @ np.arange(1.0, columns + 1.0) + noise


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=500)
    parser.add_argument("--columns", type=int, default=4)
    parser.add_argument("--rounds", type=int, default=200)
    given = parser.parse_args()
    X, y = data(given.rows, given.columns)
    lags = max(1, given.rows // 10)
    calls = {
        "doublet lstsq, corrected standard errors": lambda: db.lstsq(X, y).stderr,
        "statsmodels OLS": lambda: sm.OLS(y, X).fit().bse,
        f"statsmodels OLS, HAC with {lags} lags": lambda: sm.OLS(y, X).fit(cov_type="HAC", cov_kwds={"maxlags": lags}).bse,
        "doublet lstsq, gls of order 2": lambda: db.lstsq(X, y, method="gls").stderr,
        "statsmodels GLSAR of order 2": lambda: sm.GLSAR(y, X, rho=2).iterative_fit(maxiter=50).bse,
    }
    taken = {name: [] for name in calls}
    for _ in range(given.rounds):
        for name, call in calls.items():
            start = time.perf_counter()
            call()
            taken[name].append(time.perf_counter() - start)
    ours, theirs = db.lstsq(X, y).params, sm.OLS(y, X).fit().params
    print(f"{given.rows} rows, {given.columns} columns, medians of {given.rounds} rounds in turns; doublet {db.__version__}")
    for name, seconds in taken.items():
        low, high = np.quantile(seconds, [0.1, 0.9])
        print(f"{1e3 * statistics.median(seconds):8.3f} ms  ({1e3 * low:.3f} to {1e3 * high:.3f})  {name}")
    print(f"largest difference of the estimates of least squares: {np.abs(ours - theirs).max():.1e}")


main()
