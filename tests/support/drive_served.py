"""`scanrack serve` of a networked drive in a process of its own."""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import forked

TIMEOUT_S = 60


class Served(NamedTuple):
    """A command that serves; its first line."""

    line: str
    process: subprocess.Popen[str]

    @property
    def port(self) -> int:
        return int(self.line.split("  ")[0].rpartition(":")[2])


@contextmanager
def serving(*words: str, cwd: Path | None = None) -> Iterator[Served]:
    process = forked.start(
        [sys.executable, "-m", "scanrack", "serve", *words, "--quiet"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        cwd=cwd,
    )
    try:
        assert process.stdout is not None
        yield Served(process.stdout.readline(), process)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=TIMEOUT_S)
        assert (process.returncode, said) == (130, "")
    finally:
        process.kill()
        process.communicate()


class ControlLine:
    """The test port that a first line names; the key is given.

    Args:
        line: of a service with `--test-port`.
    """

    def __init__(self, line: str) -> None:
        words = [each.strip(";") for each in line.split()]
        host, _, port = words[words.index("at") + 1].rpartition(":")
        self._socket = socket.create_connection((host, int(port)), timeout=TIMEOUT_S)
        self._lines = self._socket.makefile("rw", encoding="utf-8", newline="\n")
        assert self.ask(key=words[words.index("key") + 1]) == {"ok": True}

    def ask(self, **request: object) -> dict[str, object]:
        self._lines.write(json.dumps(request) + "\n")
        self._lines.flush()
        answer = json.loads(self._lines.readline())
        assert isinstance(answer, dict)
        return answer

    def close(self) -> None:
        self._lines.close()
        self._socket.close()
