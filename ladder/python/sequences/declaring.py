"""Declarations of a logic class: its sequences and parts, and their checks."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Coroutine, Iterator
from types import FunctionType
from typing import Any, overload

from scanrack.io_images.annotations import signature_of

from .coroutine import Sequence
from .parts import Part

Method = Callable[[Any], Coroutine[Any, Any, object]]
"""An `async def` method without arguments."""

EVERY_SCAN = "every_scan"

SHARED = (list, dict, set, bytearray)
"""Types of values that all instances of a class would share."""


class SequenceMethod:
    """A method that is a sequence; each instance of the class has a `Sequence` with its name."""

    def __init__(self, function: Method, starts: bool) -> None:
        _check_method(function)
        self.function = function
        self.starts = starts
        self.__doc__ = function.__doc__

    @overload
    def __get__(self, logic: None, owner: type) -> SequenceMethod: ...
    @overload
    def __get__(self, logic: object, owner: type) -> Sequence: ...
    def __get__(self, logic: Any, owner: type) -> Any:
        return self  # only for the class: an instance has a Sequence of this name, which Python finds first


@overload
def sequence(function: Method, /) -> SequenceMethod: ...
@overload
def sequence(*, start: bool = True) -> Callable[[Method], SequenceMethod]: ...
def sequence(function: Method | None = None, *, start: bool = True) -> Any:
    """Make an `async def` method a sequence; with `start=False`, it waits for `restart`."""
    if function is None:
        return lambda function: SequenceMethod(function, start)
    return SequenceMethod(function, start)


def _check_method(function: Any) -> None:
    """Raise a TypeError unless a function can be a sequence."""
    name, where = getattr(function, "__qualname__", repr(function)), where_is(function)
    if inspect.isasyncgenfunction(function):
        raise TypeError(f"{where}: {name} has a yield; a sequence must be an `async def` without yield")
    if not inspect.iscoroutinefunction(function):
        raise TypeError(f"{where}: {name} is not an `async def` method; a sequence must be one")
    if len(signature_of(function).parameters) != 1:
        raise TypeError(f"{where}: {name} has arguments; a sequence must have only self")


def where_is(function: Any) -> str:
    """Return the file and line of a function."""
    code = getattr(function, "__code__", None)
    return "?" if code is None else f"{code.co_filename}:{code.co_firstlineno}"


def check_class(cls: type) -> None:
    """Raise a TypeError for shared values, or an invalid `every_scan`, in a logic class."""
    for name, value in vars(cls).items():
        if isinstance(value, SHARED) and not name.startswith("__"):
            kind = type(value).__name__
            raise TypeError(
                f"{cls.__name__}.{name} is a {kind}, which all instances would share; "
                "write a tuple, or create it in __init__"
            )
    _check_every_scan(vars(cls).get(EVERY_SCAN))


def _check_every_scan(function: Any) -> None:
    """Raise a TypeError unless a function is a plain method with only self, or None."""
    if function is None:
        return
    where = where_is(function)
    if not inspect.isfunction(function) or inspect.iscoroutinefunction(function):
        raise TypeError(f"{where}: every_scan must be a plain method, without async")
    if inspect.isgeneratorfunction(function) or len(signature_of(function).parameters) != 1:
        raise TypeError(f"{where}: every_scan must be a plain method every_scan(self), without yield")


def functions_in(cls: type) -> Iterator[FunctionType]:
    """Yield the functions in the body of a class, including its sequences."""
    for value in vars(cls).values():
        function = value.function if isinstance(value, SequenceMethod) else value
        if isinstance(function, FunctionType):
            yield function


def declarations(cls: type) -> dict[str, SequenceMethod | Part]:
    """Return the sequences and parts of a class by name, in order of definition, base classes first."""
    names = {name: value for kind in reversed(cls.__mro__) for name, value in vars(kind).items()}
    return {name: value for name, value in names.items() if isinstance(value, SequenceMethod | Part)}
