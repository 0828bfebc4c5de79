"""What tests need of the system, read from their code: they are skipped where that is missing.

A test names what it needs itself, in a fixture or a helper, or in the text of a program that it runs.

    test ──> its fixtures ──> helpers in tests/ ──> strings
"""

from __future__ import annotations

import dis
import inspect
import os
import re
import signal
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import CodeType, FunctionType
from typing import NamedTuple

import pytest

TESTS = Path(__file__).parents[1]


class Need(NamedTuple):
    """Something that a system may lack.

    Attributes:
        named: pattern of a word of code or a string that needs it.
        there: whether this system has it.
        what: completes "this system has no".
    """

    named: str
    there: bool
    what: str


POSIX = os.name == "posix"
INSTALLED = bool(entry_points(group="pytest11", name="scanrack"))

NEEDS = (
    Need(
        r"\bsignal\.(SIG(ALRM|CONT|HUP|KILL|PIPE|QUIT|STOP)|setitimer)\b",
        hasattr(signal, "SIGKILL"),
        "such signals",
    ),
    # os.kill of Windows ends the process at once; Ctrl-C goes to a whole console
    Need(r"\bos\.kill\b|\.send_signal\b", POSIX, "signals for one process"),
    Need(r"\bos\.(fork|waitpid)\b", hasattr(os, "fork"), "fork"),
    Need(r"\b(openpty|PtyPort|O_NOCTTY|termios)\b|^pty$|--pty\b", hasattr(os, "openpty"), "pseudo-terminals"),
    Need(r"\bmkfifo\b", hasattr(os, "mkfifo"), "FIFOs"),
    Need(r"/dev/(full|null|zero)\b", Path("/dev/full").exists(), "/dev/full"),
    Need(r"\bgeteuid\b|\.chmod\b", POSIX, "permissions of POSIX"),
    Need(r"\.st_blocks\b|\bsysconf\b", POSIX, "sizes that POSIX tells"),
    Need(r"\bsymlink(_to)?\b", POSIX, "links that everybody may make"),
)

EVERYWHERE = {"conftest.py", "forked.py"}
"""Files that do without what they name, where it is missing."""

CANNOT_BE_IMPORTED = {
    "unit/commands/test_ending_signals.py": hasattr(signal, "SIGHUP"),
    "unit/commands/test_under_windows.py": Path("/proc/self/task").exists(),
    "unit/line/test_serial_unplugged.py": hasattr(os, "openpty"),
}
"""Files of tests whose first lines need something, and whether this system has it."""


def skip_without_needs(items: Sequence[pytest.Item]) -> None:
    """Mark the tests as skipped that need what this system lacks."""
    missing = [each for each in NEEDS if not each.there]
    lacks: dict[object, str] = {}
    for item in items:
        if "pytester" in getattr(item, "fixturenames", ()) and not INSTALLED:
            item.add_marker(
                pytest.mark.skip(reason="scanrack is not installed: its plugin has no entry point")
            )
        if not missing or not isinstance(item, pytest.Function):
            continue
        definitions = getattr(item, "_fixtureinfo").name2fixturedefs.values()  # noqa: B009 - private
        for each in (item.function, *(each.func for group in definitions for each in group)):
            if each not in lacks:
                lacks[each] = lacking(each, missing)
            if lacks[each]:
                item.add_marker(pytest.mark.skip(reason=f"this system has no {lacks[each]}"))
                break


def lacking(used: object, missing: Iterable[Need]) -> str:
    """Return the first of the missing needs that a test or a fixture has; empty if it has none."""
    words = words_of(used)
    return next((each.what for each in missing if any(re.search(each.named, word) for word in words)), "")


def words_of(used: object) -> frozenset[str]:
    """Return names, dotted names and strings in the code of a test, of its helpers and their classes."""
    found: set[str] = set()
    seen: set[object] = set()
    waiting = [used]
    while waiting:
        each = inspect.unwrap(waiting.pop())  # type: ignore[arg-type]
        if isinstance(each, str) and "import " in each:  # a program
            found.add(each)
        elif isinstance(each, type | FunctionType) and each not in seen:
            seen.add(each)
            if isinstance(each, FunctionType):
                own, helpers = _read(each)
                found |= own
                waiting += helpers
            elif _is_of_tests(sys.modules[each.__module__].__dict__.get("__file__")):
                waiting += [getattr(member, "fget", member) for member in vars(each).values()]
    return frozenset(found)


@cache
def _read(function: FunctionType) -> tuple[frozenset[str], list[object]]:
    """Return the words of a function of tests, and the globals that it names."""
    if not _is_of_tests(function.__code__.co_filename):
        return frozenset(), []
    own = frozenset(_words(function.__code__)) - {function.__doc__}
    return own, [function.__globals__[name] for name in own & function.__globals__.keys()]


@cache
def _is_of_tests(file: str | None) -> bool:
    path = Path(file or "/")
    return path.is_relative_to(TESTS) and path.name not in EVERYWHERE


def _words(code: CodeType) -> Iterator[str]:
    dotted = ""
    for each in dis.get_instructions(code):
        if each.opname in ("LOAD_GLOBAL", "LOAD_NAME", "IMPORT_NAME"):
            dotted = each.argval
            yield dotted
        elif each.opname in ("LOAD_ATTR", "LOAD_METHOD"):
            dotted = f"{dotted}.{each.argval}"
            yield dotted
        else:
            dotted = ""
    yield from _strings(code.co_consts)


def _strings(constants: Iterable[object]) -> Iterator[str]:
    for each in constants:
        if isinstance(each, str):
            yield each
        elif isinstance(each, tuple | frozenset):
            yield from _strings(each)
        elif isinstance(each, CodeType):
            yield from _words(each)
