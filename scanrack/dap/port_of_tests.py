"""The port on which a pytest run waits for a client of the debug adapter."""

from __future__ import annotations

from contextlib import ExitStack, nullcontext
from typing import TYPE_CHECKING, Any

from scanrack.jobs.bench import Bench
from scanrack.jobs.load.program import lines_marked
from scanrack.terminal.terminal import say
from scanrack.watch.gate import listen

from .adapter import Adapter
from .command import client_of, key_line
from .in_test import InTest
from .requests import REQUESTS

if TYPE_CHECKING:
    import pytest

WAIT_S = 60.0
"""Longest time that a test waits for a client, s."""


class PortOfTests:
    """A port that waits for a client at the first bench of a pytest run.

    Args:
        config: pytest configuration of the run.
    """

    def __init__(self, config: pytest.Config) -> None:
        self._config, self._stack = config, ExitStack()
        config.add_cleanup(self._stack.close)
        self._stack.enter_context(lines_marked())
        self._adapter: Adapter | None = None
        self._tried = False

    def __call__(self, bench: Bench) -> None:
        """Debug a bench; if no client connects in time, the test continues without one."""
        if not self._tried:
            self._tried, self._adapter = True, self._connect()
        if self._adapter is not None and not self._adapter.over:
            InTest(self._adapter, bench)

    def _say(self, text: str) -> None:
        """Print a line on the terminal, even while pytest captures output."""
        capture: Any = self._config.pluginmanager.getplugin("capturemanager")
        with nullcontext() if capture is None else capture.global_and_fixture_disabled():
            say(text)

    def _connect(self) -> Adapter | None:
        """Return the adapter after launch or attach, or None if no client connects in time."""
        listening = self._stack.enter_context(listen(0))
        key = key_line()
        self._say(f"scanrack debug: {listening.getsockname()[1]} {key}; waits {WAIT_S:.0f} s for a client")
        try:
            wire = client_of(listening, key, self._stack, WAIT_S)
        except TimeoutError:
            self._say("scanrack debug: no client has connected; the tests run without one")
            return None
        adapter = Adapter(wire, REQUESTS)
        self._stack.callback(adapter.event, "terminated")
        adapter.waits = True
        while adapter.waits and not adapter.over:
            adapter.serve(None)
        return adapter
