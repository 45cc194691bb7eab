"""What a question asks of the compiled core, written down call by call and asked again without the Python around it.

No name of the core stands here: whatever function the package calls today is met, so the share of Python in a solve
stays right when the work moves from one side to the other.
"""

from __future__ import annotations

import copy
import functools
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from softlimb import _core

__all__ = ["CoreCalls"]


@dataclass(frozen=True)
class _Call:
    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    options: dict[str, Any]
    result: Any
    chained: tuple[tuple[int | str, int], ...]  # arguments that are postures found by earlier calls, and which calls


@dataclass
class CoreCalls:
    """Calls into the core in their order, with their arguments."""

    calls: list[_Call] = field(default_factory=list)

    @classmethod
    def of(cls, question: Callable[[], Any]) -> CoreCalls:
        """Ask a question and write down which functions and methods of the core it calls.

        Reading an attribute and making an object are no calls: they count as Python. Not for several threads at once.
        """
        found = cls()
        with _watched(found.calls):
            question()
        return found

    def again(self) -> list[Any]:
        """Make the calls once more: one that was given the posture of an earlier one is given its posture of now."""
        results: list[Any] = []
        for call in self.calls:
            arguments, options = call.arguments, call.options
            if call.chained:
                given = list(arguments)
                options = options.copy()
                for place, earlier in call.chained:
                    if isinstance(place, int):
                        given[place] = results[earlier]
                    else:
                        options[place] = results[earlier]
                arguments = tuple(given)
            results.append(call.function(*arguments, **options))
        return results

    def counts(self) -> Counter[str]:
        """How often each function is called."""
        return Counter(call.name for call in self.calls)

    def only(self, name: str) -> CoreCalls:
        """The calls of one function."""
        return CoreCalls([replace(call, chained=()) for call in self.calls if call.name == name])

    def fault(self) -> str | None:
        """Why the calls do not stand for the question: there are none, or they answer otherwise the second time."""
        if not self.calls:
            return "no call of the core was seen"
        for call, result in zip(self.calls, self.again(), strict=True):
            if isinstance(result, _core.Posture) and not np.array_equal(result.plates, call.result.plates):
                return f"{call.name} gives another posture when it is called again"
        return None


@contextmanager
def _watched(calls: list[_Call]) -> Iterator[None]:
    inside = [False]  # a core function that calls back into Python: what that calls is part of it
    watched: list[tuple[Any, str, Any]] = []
    owners: list[Any] = [_core, *(value for value in vars(_core).values() if isinstance(value, type))]
    for owner in owners:
        for name, value in list(vars(owner).items()):
            plain = _function_of(owner, value)
            if plain is None or name.startswith("__"):
                continue
            short = name if owner is _core else f"{owner.__name__}.{name}"
            spy = _spy(short, plain, calls, inside)
            watched.append((owner, name, value))
            setattr(owner, name, staticmethod(spy) if isinstance(value, staticmethod) else spy)
    try:
        yield
    finally:
        for owner, name, value in watched:
            setattr(owner, name, value)


def _function_of(owner: Any, value: Any) -> Callable[..., Any] | None:
    """The compiled function behind an entry of the core or of one of its classes."""
    kind = type(value).__name__
    if owner is _core:
        return value if kind == "builtin_function_or_method" else None
    return value.__func__ if kind in ("instancemethod", "staticmethod") else None


def _spy(name: str, function: Callable[..., Any], calls: list[_Call], inside: list[bool]) -> Callable[..., Any]:
    @functools.wraps(function)
    def spy(*arguments: Any, **options: Any) -> Any:
        if inside[0]:
            return function(*arguments, **options)
        # Copies: the caller may use the same arrays and lists for its next call.
        kept = tuple(_kept(value) for value in arguments)
        named = {key: _kept(value) for key, value in options.items()}
        inside[0] = True
        try:
            result = function(*arguments, **options)
        finally:
            inside[0] = False
        # The last call that gave a posture: the same one may come from several.
        found = {id(call.result): n for n, call in enumerate(calls) if isinstance(call.result, _core.Posture)}
        places: list[tuple[int | str, Any]] = [*enumerate(kept), *named.items()]
        chained = tuple((place, found[id(value)]) for place, value in places if id(value) in found)
        calls.append(_Call(name, function, kept, named, result, chained))
        return result

    return spy


def _kept(value: Any) -> Any:
    return copy.copy(value) if isinstance(value, (np.ndarray, list)) else value
