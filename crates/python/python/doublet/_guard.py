"""A fault of the engine as an error that ``except Exception`` catches.

A panic that leaves a compiled function arrives as ``PanicException``, which is not an ``Exception``. Every function and method of the
compiled part is wrapped once, when the package is imported, so that none can be forgotten.
"""

from __future__ import annotations

import functools
import inspect
from types import BuiltinFunctionType, MethodDescriptorType, ModuleType
from typing import Any, Callable

from . import _doublet


def guarded(call: Callable[..., Any]) -> Callable[..., Any]:
    """The function; a panic in it becomes a :class:`DoubletError`."""

    @functools.wraps(call)
    def safe(*arguments: Any, **named: Any) -> Any:
        try:
            return call(*arguments, **named)
        except _doublet.PanicException as panic:
            text = f"{call.__name__}: internal error of doublet: {panic}; report it with the data"
        raise _doublet.DoubletError(text)

    return safe


def guard(module: ModuleType) -> None:
    """Wraps every function of a compiled module, and every method, constructor and attribute of its classes."""
    for name, value in list(vars(module).items()):
        if isinstance(value, BuiltinFunctionType):
            setattr(module, name, guarded(value))
        elif inspect.isclass(value) and not issubclass(value, BaseException):
            _guard_class(value)


def _guard_class(kind: type) -> None:
    for name, member in list(vars(kind).items()):
        if isinstance(member, staticmethod):
            setattr(kind, name, staticmethod(guarded(member.__func__)))
        elif isinstance(member, MethodDescriptorType):
            setattr(kind, name, guarded(member))
        elif inspect.isgetsetdescriptor(member):
            setattr(kind, name, property(guarded(member.__get__), doc=member.__doc__))


guard(_doublet)
