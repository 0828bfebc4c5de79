"""Analyzes the bytecode of a user's condition to find what it reads.

A condition that reads only tags and images has the same result until one of them changes. A condition that
reads the time, stores something between calls, or calls unknown code can have a different result in any scan.
A condition that can't be analyzed is treated as the second kind.
"""

from __future__ import annotations

import builtins
import dis
import math
import re
from collections.abc import Callable, Iterator
from enum import Enum, auto
from functools import lru_cache
from itertools import zip_longest
from types import CodeType, FunctionType, ModuleType
from typing import Any


class ConditionReads(Enum):
    """The kinds of dependencies of a condition, from few to many."""

    IMAGES_AND_TAGS = auto()
    COUNTS = auto()  # also accumulated values of timers
    ANYTHING = auto()


TIMED = frozenset({"ns", "seconds", "scan", "shaft", "axes", "rules", "state"})
"""Attributes of a snapshot that can change while the memory and the images stay the same."""

CHANGING = ("STORE_GLOBAL", "STORE_ATTR", "STORE_SUBSCR", "DELETE_", "IMPORT_")
"""Prefixes of bytecode instructions that can store something beyond a call."""

_KNOWN_NAMES = (
    "abs all any bool dict divmod enumerate filter float frozenset getattr int isinstance len list map max "
    "min pow range reversed round set sorted str sum tuple zip"
)

KNOWN = frozenset(getattr(builtins, name) for name in _KNOWN_NAMES.split(" "))
"""Builtins that depend only on their arguments."""

PLAIN = (bool, int, float, str, bytes, type(None), Enum)
"""Types of values that never change."""

COUNT = re.compile(r"(^|\.)ACC$", re.IGNORECASE)
"""Matches the end of the name of a timer's accumulated value."""

DEEP = 5
"""Maximum depth of nested calls to analyze."""


@lru_cache(maxsize=1024)
def reads_of(condition: Callable[..., Any]) -> ConditionReads:
    """Return what a condition depends on.

    >>> reads_of(lambda now: now.tags["Step"] == 7 and now.slot[1].status.MOVING_CW).name
    'IMAGES_AND_TAGS'
    >>> reads_of(lambda now: now.tags["Delay.ACC"] < 100).name, reads_of(lambda now: now.ns > 5).name
    ('COUNTS', 'ANYTHING')
    """
    reads = list(_reads(condition, DEEP))
    return max(reads, key=lambda read: read.value, default=ConditionReads.IMAGES_AND_TAGS)


def _reads(function: object, depth: int) -> Iterator[ConditionReads]:
    """Yield the dependencies of a function and of the functions that it calls, down to a depth."""
    if not isinstance(function, FunctionType) or not depth or not _is_constant(function.__defaults__ or ()):
        yield ConditionReads.ANYTHING
        return
    names = {**function.__globals__, **_closure(function)}
    for code in _codes(function.__code__):
        yield from _code_reads(code, function.__code__.co_freevars)
        for name in _names(code):
            value = names.get(name, getattr(builtins, name, None))
            if isinstance(value, FunctionType):
                yield from _reads(value, depth - 1)
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
    """Yield the names of the global and closure variables that code reads."""
    for instruction in dis.get_instructions(code):
        if instruction.opname in ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_DEREF", "LOAD_CLASSDEREF"):
            yield instruction.argval


def _code_reads(code: CodeType, closure_names: tuple[str, ...]) -> Iterator[ConditionReads]:
    """Yield the dependencies of the instructions in code.

    Args:
        closure_names: names of the closure variables, which outlive a call.
    """
    instructions = [
        instruction
        for instruction in dis.get_instructions(code)
        if instruction.opname not in ("CACHE", "EXTENDED_ARG")
    ]
    for instruction, next_instruction in zip_longest(instructions, instructions[1:]):
        if _stores(instruction, closure_names) or _reads_time(instruction):
            yield ConditionReads.ANYTHING
        elif _loads_tags(instruction) and not _loads_plain_tag_name(next_instruction):
            yield ConditionReads.COUNTS


def _stores(instruction: dis.Instruction, closure_names: tuple[str, ...]) -> bool:
    """Return whether an instruction stores something beyond the call."""
    is_closure_store = instruction.opname == "STORE_DEREF" and instruction.argval in closure_names
    return is_closure_store or instruction.opname.startswith(CHANGING)


def _reads_time(instruction: dis.Instruction) -> bool:
    """Return whether an instruction reads something that changes with time, or loads its name."""
    if instruction.opname not in ("LOAD_ATTR", "LOAD_METHOD", "LOAD_CONST"):
        return False
    return isinstance(instruction.argval, str) and instruction.argval in TIMED


def _loads_tags(instruction: dis.Instruction) -> bool:
    return instruction.opname == "LOAD_ATTR" and instruction.argval == "tags"


def _loads_plain_tag_name(instruction: dis.Instruction | None) -> bool:
    """Return whether an instruction loads the name of a tag that is not the count of a timer."""
    if instruction is None or instruction.opname != "LOAD_CONST":
        return False
    return isinstance(instruction.argval, str) and not COUNT.search(instruction.argval)


def _is_constant(value: object) -> bool:
    """Return whether a value never changes."""
    if isinstance(value, tuple | frozenset):
        return all(map(_is_constant, value))
    return isinstance(value, (*PLAIN, re.Pattern)) or (isinstance(value, type) and issubclass(value, Enum))


def _is_hashable(value: object) -> bool:
    return not isinstance(value, ModuleType) and getattr(type(value), "__hash__", None) is not None
