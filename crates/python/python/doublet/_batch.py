"""Many sessions at once."""

from __future__ import annotations

import importlib
import os
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Iterable, Literal, Mapping, Optional, Sequence, Union

from ._doublet import DoubletError
from ._errors import existing, unknown
from ._recording import PathLike, Progress
from ._session import Results, Session, computed

if TYPE_CHECKING:
    from ._session import _Study

_COLUMNS = ("session", "coefficient", "derivative", "estimate", "stderr", "stderr_white", "r2", "samples", "verdict", "session_verdict",
            "error")


def batch(
    sessions: Union[Mapping[str, Union[Session, PathLike]], Iterable[Union[Session, PathLike]]],
    *,
    jobs: Optional[int] = None,
    studies: Sequence[_Study] = (),
    frame: Literal["pandas", "polars"] = "pandas",
    progress: Progress = None,
) -> Any:
    """Runs sessions in parallel and collects their derivatives in one frame.

    Args:
        sessions: Sessions or their files; of a mapping the keys name them in the table. Without one the name is the path or the
            title, with its number where it is taken.
        jobs: Sessions at the same time; by default one for each core. They run in threads of this process, which leave Python free.
        studies: As for :func:`run`.
        frame: ``"pandas"`` or ``"polars"``.
        progress: Called with the part of the sessions that is done, 0 to 1. Ctrl-C stops all.

    Returns:
        A row per session and derivative, in order: ``session, coefficient, derivative, estimate, stderr`` (corrected for coloured
        residuals), ``stderr_white, r2, samples, verdict`` (of the derivative), ``session_verdict, error``. A session, manoeuvre or
        coefficient that failed is a row with its ``error``.

    Raises:
        DoubletError: ``jobs`` is below 1, or ``sessions`` is empty.
    """
    if frame not in ("pandas", "polars"):
        raise unknown("frame", frame, ["pandas", "polars"])
    # A library that is absent is missed before the work.
    library: Any = importlib.import_module(frame)
    named = _named(sessions)
    if not named:
        raise DoubletError("sessions is empty: give one or more")
    if jobs is not None and jobs < 1:
        raise DoubletError(f"jobs is {jobs}: give 1 or more")
    stop, rows = threading.Event(), []
    with ThreadPoolExecutor(max_workers=min(jobs or os.cpu_count() or 1, len(named))) as pool:
        waiting = [pool.submit(_one, name, session, studies, stop) for name, session in named]
        try:
            for done, future in enumerate(waiting, start=1):
                rows += future.result()
                if progress is not None:
                    progress(done / len(waiting))
        except BaseException:
            stop.set()
            for future in waiting:
                future.cancel()
            raise
    return library.DataFrame({name: [row.get(name) for row in rows] for name in _COLUMNS})


class _Stopped(Exception):
    """Another session or the user stopped the batch."""


def _named(sessions: Any) -> list[tuple[str, Union[Session, PathLike]]]:
    """Sessions with names, each once."""
    if isinstance(sessions, (str, os.PathLike, Session)):
        raise DoubletError("sessions is one session: give a list of sessions")
    if isinstance(sessions, Mapping):
        return [(str(name), session) for name, session in sessions.items()]
    found: list[tuple[str, Union[Session, PathLike]]] = []
    names: set[str] = set()
    for session in sessions:
        base = (session.path or str(session["title"])) if isinstance(session, Session) else os.fspath(session)
        name, number = base, 1
        while name in names:
            number += 1
            name = f"{base} ({number})"
        names.add(name)
        found.append((name, session))
    return found


def _one(name: str, given: Union[Session, PathLike], studies: Sequence[_Study], stop: threading.Event) -> list[dict[str, Any]]:
    """Rows of one session."""

    def stopped(_: float) -> None:
        if stop.is_set():
            raise _Stopped

    try:
        stopped(0.0)
        session = given if isinstance(given, Session) else Session.load(existing(given))
        results = computed(session, studies, 200, 1, stopped)
    except DoubletError as error:
        return [dict(session=name, error=str(error))]
    return [dict(session=name, session_verdict=results.verdict.level, **row) for row in _rows(results)]


def _rows(results: Results) -> list[dict[str, Any]]:
    """A row per derivative and per failure."""
    rows: list[dict[str, Any]] = []
    for fit in results.fits:
        for row in fit.get("derivatives", []):
            rows.append(
                dict(coefficient=fit["coefficient"], derivative=row["name"], estimate=row["estimate"],
                     stderr=row["corrected_standard_error"], stderr_white=row["standard_error"], r2=fit["r_squared"],
                     samples=fit["samples"], verdict=(row.get("verdict") or {}).get("level"))
            )
    return rows + [dict(error=f"{place}: {reason}") for place, reason in results.failures]
