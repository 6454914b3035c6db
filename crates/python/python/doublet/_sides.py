"""Equations of motion whose right-hand sides are functions."""

from __future__ import annotations

import difflib
from typing import Any, Callable, ClassVar, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from ._doublet import DoubletError
from ._errors import unknown

#: Right-hand sides at ``x`` (states), ``u`` (inputs) and ``p`` (parameters and constants): a value for each name, in order or by name.
RightHandSide = Callable[["Values", "Values", "Values"], Any]

#: Points at which a function is tried with arrays; few functions of matrices take just so many.
_TRIED = 7


class Values(tuple[Any, ...]):
    """Values by name or in order: ``x.alpha``, ``x["alpha"]``, ``alpha, q = x``."""

    __slots__ = ()
    _places: ClassVar[dict[str, int]] = {}

    def __getattr__(self, name: str) -> Any:
        if name in self._places:
            return tuple.__getitem__(self, self._places[name])
        if name.startswith("_"):
            # NumPy asks every sequence for its protocols.
            raise AttributeError(name)
        near = difflib.get_close_matches(name, self._places, n=1)
        raise AttributeError(f"no value is called '{name}': there are {', '.join(self._places) or 'none'}" + (f"; did you mean '{near[0]}'?" if near else ""))

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            if key not in self._places:
                raise unknown("value", key, self._places)
            key = self._places[key]
        return tuple.__getitem__(self, key)

    def __repr__(self) -> str:
        return f"<{', '.join(f'{name}={tuple.__getitem__(self, at)!r}' for name, at in self._places.items())}>"


def _values(names: Sequence[str]) -> type[Values]:
    return type("Values", (Values,), {"_places": {name: place for place, name in enumerate(names)}})


class Sides:
    """Functions of one's own as the engine calls them: columns for columns. A function that takes arrays is called once for many points, another one
    point by point."""

    def __init__(
        self, states: Sequence[str], inputs: Sequence[str], parameters: Mapping[str, float], constants: Mapping[str, float],
        functions: Mapping[str, tuple[RightHandSide, Sequence[str]]],
    ) -> None:
        self._x, self._u, self._p = _values(states), _values(inputs), _values([*parameters, *constants])
        self._constants = [np.float64(value) for value in constants.values()]
        self._functions = functions
        self._takes_arrays: dict[str, bool] = {}

    def __call__(
        self, what: str, states: Sequence[NDArray[np.float64]], inputs: Sequence[NDArray[np.float64]], parameters: Sequence[NDArray[np.float64]]
    ) -> list[NDArray[np.float64]]:
        count = len(states[0])
        columns = (states, inputs, [column if len(column) == count > 1 else column[0] for column in parameters])
        with np.errstate(all="ignore"):
            if what not in self._takes_arrays:
                self._takes_arrays[what] = self._try_arrays(what, states, inputs, parameters)
            return self._at_once(what, columns, count) if self._takes_arrays[what] else self._one_by_one(what, columns, count)

    def _call(self, what: str, x: Sequence[Any], u: Sequence[Any], p: Sequence[Any]) -> list[Any]:
        """Values of a function in order."""
        function, names = self._functions[what]
        found = function(self._x(x), self._u(u), self._p([*p, *self._constants]))
        if isinstance(found, Mapping):
            missing = next((name for name in names if name not in found), None)
            if missing is not None:
                raise unknown(f"value that {what} returned", missing, [str(name) for name in found])
            return [found[name] for name in names]
        if found is None or isinstance(found, str) or not hasattr(found, "__iter__"):
            found = [found] if len(names) == 1 and found is not None else found
        try:
            several = list(found)
        except TypeError:
            raise DoubletError(f"{what} returned {found!r}: return a value for each of {', '.join(names)}") from None
        if len(several) != len(names):
            raise DoubletError(f"{what} returned {len(several)} values: return one for each of {', '.join(names)}")
        return several

    def _at_once(self, what: str, columns: Sequence[Sequence[Any]], count: int) -> list[NDArray[np.float64]]:
        names = self._functions[what][1]
        return [_column(what, name, value, count) for name, value in zip(names, self._call(what, *columns))]

    def _one_by_one(self, what: str, columns: Sequence[Sequence[Any]], count: int) -> list[NDArray[np.float64]]:
        names = self._functions[what][1]
        found = np.empty((len(names), count))
        x, u, p = (list(zip(*[np.broadcast_to(column, (count,)) for column in several])) or [()] * count for several in columns)
        for point in range(count):
            try:
                values = self._call(what, x[point], u[point], p[point])
            except ArithmeticError:
                # As with arrays: no value here, and the search tries another step.
                found[:, point] = np.nan
                continue
            for row, value in enumerate(values):
                found[row, point] = value if type(value) in (np.float64, float) else _column(what, names[row], value, 1)[0]
        return list(found)

    def _try_arrays(self, what: str, states: Sequence[Any], inputs: Sequence[Any], parameters: Sequence[Any]) -> bool:
        """Whether arrays give what the points one by one give."""
        near = 1.0 + 0.01 * np.arange(_TRIED)
        columns = [[np.resize(column, _TRIED) * near for column in several] for several in (states, inputs, parameters)]
        expected = self._one_by_one(what, columns, _TRIED)
        try:
            found = self._at_once(what, columns, _TRIED)
        except Exception:  # whatever it raises, it does not take arrays
            return False
        return all(np.allclose(a, b, rtol=1e-9, atol=0.0, equal_nan=True) for a, b in zip(found, expected))


def _column(what: str, name: str, value: Any, count: int) -> NDArray[np.float64]:
    """A value, or a value for each point, as a column."""
    array = np.asarray(value)
    if array.dtype.kind not in "biuf":
        raise DoubletError(f"{what} returned a {array.dtype} for '{name}': return real numbers")
    if array.shape == (count,) or array.size == 1:
        return np.ascontiguousarray(np.broadcast_to(array.reshape(-1), (count,)), dtype=np.float64)
    raise DoubletError(f"{what} returned an array of shape {array.shape} for '{name}': return a number for each point")


class Functions:
    """A mapping of equations whose right-hand sides are functions, understood."""

    def __init__(self, given: Mapping[str, Any], constants: Optional[Mapping[str, float]]) -> None:
        self.states, self.inputs = _names(given, "states"), _names(given, "inputs")
        self.outputs = _names(given, "outputs") if "outputs" in given else list(self.states)
        self.parameters = {str(name): float(value) for name, value in dict(given.get("parameters", {})).items()}
        known = {str(name): float(value) for name, value in dict(given.get("constants", {})).items()}
        for name in constants or {}:
            if name not in known:
                raise unknown("constant of the equations", name, known)
        self.constants = {**known, **{name: float(value) for name, value in (constants or {}).items()}}
        twice = [name for name in self.constants if name in self.parameters]
        if twice:
            raise DoubletError(f"'{twice[0]}' is both a parameter and a constant: give one of them another name")
        others = [name for name in self.outputs if name not in self.states]
        functions = {"rates": (_function(given, "rates"), self.states)}
        if others:
            if "shows" not in given:
                raise DoubletError(f"output '{others[0]}' is not a state: give a function of {', '.join(others)} as 'shows'")
            functions["shows"] = (_function(given, "shows"), others)
        elif "shows" in given:
            raise DoubletError("'shows' is not used, as every output is a state: leave it out, or name its outputs")
        self.sides = Sides(self.states, self.inputs, self.parameters, self.constants, functions)


def _names(given: Mapping[str, Any], key: str) -> list[str]:
    found = given.get(key, [])
    if isinstance(found, (str, Mapping)):
        raise DoubletError(f"'{key}' must be a list of names where 'rates' is a function")
    return [str(name) for name in found]


def _function(given: Mapping[str, Any], key: str) -> RightHandSide:
    found = given.get(key)
    if not callable(found):
        raise DoubletError(f"'{key}' must be a function of x, u and p")
    return found  # type: ignore[no-any-return]
