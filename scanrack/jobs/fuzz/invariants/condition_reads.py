"""Finds what a user's condition reads by looking at its code.

A condition that reads only tags and images has the same answer until one of them changes. A condition that
reads the time, keeps something between calls, or calls unknown code may change its answer in any scan.
In doubt, a condition counts as the second kind.
"""

from __future__ import annotations

import builtins
import dis
import math
import re
from collections.abc import Callable, Iterator
from enum import Enum, auto
from functools import lru_cache
from types import CodeType, FunctionType, ModuleType
from typing import Any


class ConditionReads(Enum):
    """What a condition depends on."""

    IMAGES_AND_TAGS = auto()
    COUNTS = auto()  # also tags that count time: accumulated values of timers
    ANYTHING = auto()


TIMED = frozenset({"ns", "seconds", "scan", "shaft", "axes", "rules", "state"})
"""Attributes of a snapshot that change, or may change, while program and modules stand still."""

CHANGING = ("STORE_GLOBAL", "STORE_ATTR", "STORE_SUBSCR", "DELETE_", "IMPORT_")
"""Bytecode instructions by which a function may keep something."""

_KNOWN_NAMES = (
    "abs all any bool dict divmod enumerate filter float frozenset getattr int isinstance len list map max "
    "min pow range reversed round set sorted str sum tuple zip"
)

KNOWN = frozenset(getattr(builtins, name) for name in _KNOWN_NAMES.split(" "))
"""Builtins that depend only on their arguments."""

PLAIN = (bool, int, float, str, bytes, type(None), Enum)

COUNT = re.compile(r"(^|\.)ACC$", re.IGNORECASE)
"""Matches the end of the name of a timer's accumulated value."""

DEEP = 5
"""Largest depth of nested calls that are followed."""


@lru_cache(maxsize=1024)
def reads_of(condition: Callable[..., Any]) -> ConditionReads:
    """Return what a condition depends on.

    >>> reads_of(lambda now: now.tags["Step"] == 7 and now.slot[1].status.MOVING_CW).name
    'IMAGES_AND_TAGS'
    >>> reads_of(lambda now: now.tags["Delay.ACC"] < 100).name, reads_of(lambda now: now.ns > 5).name
    ('COUNTS', 'ANYTHING')
    """
    reads = list(_reads(condition, DEEP))
    return max(reads, key=lambda each: each.value, default=ConditionReads.IMAGES_AND_TAGS)


def _reads(function: object, deep: int) -> Iterator[ConditionReads]:
    """Yield what a function and the functions that it calls depend on."""
    if not isinstance(function, FunctionType) or not deep or not _is_constant(function.__defaults__ or ()):
        yield ConditionReads.ANYTHING
        return
    names = {**function.__globals__, **_closure(function)}
    for code in _codes(function.__code__):
        yield from _of_code(code, function.__code__.co_freevars)
        for name in _names(code):
            value = names.get(name, getattr(builtins, name, None))
            if isinstance(value, FunctionType):
                yield from _reads(value, deep - 1)
            elif not (_is_constant(value) or value is math or (_is_hashable(value) and value in KNOWN)):
                yield ConditionReads.ANYTHING


def _closure(function: FunctionType) -> dict[str, Any]:
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    return {name: cell.cell_contents for name, cell in cells}


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield the code of a function and of the functions inside it."""
    yield code
    for const in code.co_consts:
        if isinstance(const, CodeType):
            yield from _codes(const)


def _names(code: CodeType) -> Iterator[str]:
    """Yield the names of the globals and closure variables that some code reads."""
    for instruction in dis.get_instructions(code):
        if instruction.opname in ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_DEREF", "LOAD_CLASSDEREF"):
            yield instruction.argval


def _of_code(code: CodeType, outer: tuple[str, ...]) -> Iterator[ConditionReads]:
    """Yield what each instruction depends on; `outer` has the variables that outlive a call."""
    steps = [
        instruction
        for instruction in dis.get_instructions(code)
        if instruction.opname not in ("CACHE", "EXTENDED_ARG")
    ]
    for step, following in zip(steps, [*steps[1:], None], strict=True):
        if _keeps(step, outer) or _reads_time(step):
            yield ConditionReads.ANYTHING
        elif step.opname == "LOAD_ATTR" and step.argval == "tags" and not _is_plain_tag(following):
            yield ConditionReads.COUNTS


def _keeps(step: dis.Instruction, outer: tuple[str, ...]) -> bool:
    """Return whether an instruction keeps something beyond the call."""
    return step.opname.startswith(CHANGING) or (step.opname == "STORE_DEREF" and step.argval in outer)


def _reads_time(step: dis.Instruction) -> bool:
    """Return whether an instruction reads something that changes with time, or names it for `getattr`."""
    named = step.opname in ("LOAD_ATTR", "LOAD_METHOD", "LOAD_CONST") and isinstance(step.argval, str)
    return named and step.argval in TIMED


def _is_plain_tag(step: dis.Instruction | None) -> bool:
    """Return whether the instruction after `tags` loads the name of a tag that is not a timer's count."""
    name = step.argval if step is not None and step.opname == "LOAD_CONST" else None
    return isinstance(name, str) and not COUNT.search(name)


def _is_constant(value: object) -> bool:
    """Return whether a value never changes."""
    if isinstance(value, tuple | frozenset):
        return all(map(_is_constant, value))
    return isinstance(value, (*PLAIN, re.Pattern)) or (isinstance(value, type) and issubclass(value, Enum))


def _is_hashable(value: object) -> bool:
    return not isinstance(value, ModuleType) and getattr(type(value), "__hash__", None) is not None
