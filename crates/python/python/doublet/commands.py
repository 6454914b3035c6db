"""One function for each command of the command line: ``commands.structure(session)`` is ``doublet structure SESSION --json``.

Arguments have the names of the command line, ``-`` being ``_``. A session, an aircraft, a recording or a frame may stand for its file; a
mapping stands for repeated ``NAME=VALUE``, a tuple of two numbers for ``LOW:HIGH``. Each command runs in a process of its own and returns
its JSON document. An error raises :class:`doublet.DoubletError`; a bad verdict gives a :class:`doublet.DoubletWarning`.
"""

from ._commands import Answer, function, table

_functions = [function(row, __name__) for row in table()]
__all__ = ["Answer", *sorted(one.__name__ for one in _functions)]
globals().update({one.__name__: one for one in _functions})
del _functions, function, table
