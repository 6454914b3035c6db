"""Objects of the engine that can be pickled."""

from __future__ import annotations

from typing import Any, Callable, Generic, Optional, TypeVar

Inner = TypeVar("Inner")
Call = tuple[Callable[..., Any], tuple[Any, ...]]


class Replayed(Generic[Inner]):
    """Holds an object of the engine and the call that made it. A pickle holds the call: the engine is deterministic, so that the
    object is made again, equal to the last bit, where it is first used. Objects never change: a copy is the object."""

    def __init__(self, inner: Inner, call: Optional[Call]) -> None:
        self._made: Optional[Inner] = inner
        self._call = call

    @property
    def _inner(self) -> Inner:
        if self._made is None:
            assert self._call is not None, "a pickle holds the call"
            function, arguments = self._call
            self._made = function(*arguments)
        return self._made

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_made": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)

    def __copy__(self) -> Any:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Any:
        return self
