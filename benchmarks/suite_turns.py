"""A plugin of pytest: collect, then run files as they are named, and answer what their tests cost.

It is one side of suite.py: `pytest -p suite_turns --turns SOCKET FILES`, with the socket's descriptor.
Answers are lines of JSON: the processor seconds so far, when all is collected; then for each file that a line
names the seconds by test. A file's last test has the end of its fixtures.
"""

from __future__ import annotations

import json
import os
from itertools import pairwise
from socket import socket
from time import process_time
from typing import TextIO

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--turns", type=int, help="the descriptor of the socket")


def pytest_configure(config: pytest.Config) -> None:
    with socket(fileno=config.getoption("--turns")) as other:
        config.pluginmanager.register(Turns(other.makefile("rw", encoding="utf-8", buffering=1)))


def processor_s() -> float:
    """Return the processor time of this process and of those that it has waited for."""
    times = os.times()  # whole ticks, which is enough for other processes only
    return process_time() + times.children_user + times.children_system


class Turns:
    """The loop over the tests."""

    def __init__(self, lines: TextIO) -> None:
        self._lines = lines
        self._seconds: dict[str, float] = {}

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        if session.testsfailed:
            return True
        self._answer(processor_s())
        files: dict[str, list[pytest.Item]] = {}
        for item in session.items:
            files.setdefault(item.path.relative_to(session.config.rootpath).as_posix(), []).append(item)
        for line in self._lines:
            self._seconds = {}
            self._run(files.get(line.strip(), []))
            self._answer(self._seconds)
        session._setupstate.teardown_exact(None)
        return True

    def _run(self, items: list[pytest.Item]) -> None:
        for item, following in pairwise([*items, None]):
            assert item is not None
            before = processor_s()
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            self._seconds[item.nodeid] = processor_s() - before

    def _answer(self, what: object) -> None:
        self._lines.write(json.dumps(what) + "\n")
        self._lines.flush()
