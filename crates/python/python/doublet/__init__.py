"""Aircraft system identification from flight test.

Recordings in; flight paths, coefficients, derivatives with errors that account for correlated residuals, modes and results out.
SI and radians everywhere. Body axes x forward, y right, z down; signs of deflections: right aileron down, elevator trailing edge
down, rudder trailing edge left are positive. Errors raise :class:`DoubletError` with one sentence.

>>> import doublet as db
>>> results = db.run(db.Session.load("builtin:demo"))
>>> results.derivatives["Cm_alpha"].value                                                              # doctest: +SKIP
"""

from . import _guard, commands
from ._after import Distribution, OutputError, output_error, propagate
from ._batch import batch
from ._coefficients import Coefficients, coefficients
from ._commands import Answer
from ._design import Design, design_input
from ._doublet import DoubletError, __version__, instructions
from ._equations import EquationFit, equations
from ._errors import DoubletFileNotFoundError, DoubletKeyError, DoubletWarning
from ._estimator import LeastSquares
from ._fit import CoefficientFit, Fit, fit
from ._functions import (
    FrequencyResponse,
    Regression,
    coloured_covariance,
    differentiate,
    frequency_response,
    lstsq,
    modes,
    smooth,
)
from ._linear import Linear
from ._path import Path, WindowPath, reconstruct
from ._recording import Aircraft, Recording, Signal, aircraft, find_manoeuvres, guess_roles, read, roles, units
from ._session import Results, Session, export, match, run, show, simulate
from ._table import Table, Value
from ._verdict import Verdict
from ._window import Window

__all__ = [
    "Aircraft",
    "Answer",
    "CoefficientFit",
    "Coefficients",
    "Design",
    "Distribution",
    "DoubletError",
    "DoubletFileNotFoundError",
    "DoubletKeyError",
    "DoubletWarning",
    "EquationFit",
    "Fit",
    "FrequencyResponse",
    "LeastSquares",
    "Linear",
    "OutputError",
    "Path",
    "Recording",
    "Regression",
    "Results",
    "Session",
    "Signal",
    "Table",
    "Value",
    "Verdict",
    "Window",
    "WindowPath",
    "__version__",
    "aircraft",
    "batch",
    "coefficients",
    "coloured_covariance",
    "commands",
    "design_input",
    "differentiate",
    "equations",
    "export",
    "find_manoeuvres",
    "fit",
    "frequency_response",
    "guess_roles",
    "instructions",
    "lstsq",
    "match",
    "modes",
    "output_error",
    "propagate",
    "read",
    "reconstruct",
    "roles",
    "run",
    "show",
    "simulate",
    "smooth",
    "units",
]
