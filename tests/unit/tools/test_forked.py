"""Processes of tests on a system that can't fork: they are started plainly, and so are their helpers."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from forked import Python, run, start
from scanrack.jobs.trust import launcher

CODE = "import sys; print(sys.stdin.read() + sys.argv[1], end='')"


@pytest.mark.slow
def test_a_process_is_started_plainly_where_there_is_no_fork(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "fork", raising=False)
    done = run(
        [sys.executable, "-P", "-c", CODE, "word"],
        input="given ",
        capture_output=True,
        text=True,
        encoding="utf-8",
    )
    assert (done.returncode, done.stdout) == (0, "given word")
    with start([sys.executable, "-c", "pass"]) as process:
        assert type(process) is subprocess.Popen
    with launcher.launch("no_such_module:main", stderr=subprocess.PIPE) as helper:
        assert not isinstance(helper, Python)
        assert b"no_such_module" in helper.communicate()[1]
