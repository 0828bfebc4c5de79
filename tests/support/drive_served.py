"""`scanrack serve` of a networked drive in a process of its own."""

from __future__ import annotations

import signal
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
