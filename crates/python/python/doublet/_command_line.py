"""Program of a process that runs one command: it loads the compiled part alone, without NumPy.

``python -I _command_line.py EXTENSION ARGUMENT...``
"""

from __future__ import annotations

import importlib.util
import signal
import sys
from typing import Sequence


def run(extension: str, arguments: Sequence[str]) -> int:
    """Runs a command as the program does; returns its exit code: 0, 1 (error), 2 (wrong arguments), 3 (something is bad)."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    spec = importlib.util.spec_from_file_location("_doublet", extension)
    if spec is None or spec.loader is None:
        raise ImportError(f"{extension}: not an extension module")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    code: int = module.run_command(list(arguments))
    return code


if __name__ == "__main__":
    sys.exit(run(sys.argv[1], sys.argv[2:]))
