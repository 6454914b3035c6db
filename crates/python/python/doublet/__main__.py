"""``python -m doublet``: the command line, without a window."""

import sys

from . import _doublet
from ._command_line import run

if __name__ == "__main__":
    sys.exit(run(_doublet.__file__, sys.argv[1:]))
