"""A client writes nothing to the user's terminal: the logs of the libraries that talk to it are closed."""

from __future__ import annotations

import subprocess
import sys

import pytest
from scanrack.runtime.live.quiet import CLIENT_LOGS

RECORDS = """
import logging
{quiet}
for name in ({name!r}, {name!r} + ".made.later"):
    for say in (logging.getLogger(name).warning, logging.getLogger(name).critical):
        say("socket.send() raised exception.")
logging.getLogger("of.the.user").warning("heard")
"""
QUIET = "from scanrack.runtime.live.quiet import CLIENT_LOGS, quiet; quiet(*CLIENT_LOGS)"


def told(quiet: str, name: str) -> list[str]:
    """Return what a process of its own writes to the terminal for records of a library."""
    code = RECORDS.format(quiet=quiet, name=name)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, encoding="utf-8"
    )
    return (done.stdout + done.stderr).splitlines()


@pytest.mark.parametrize("name", CLIENT_LOGS)
def test_records_of_a_library_that_talks_to_clients_reach_no_terminal(name: str) -> None:
    assert len(told("", name)) == 5
    assert told(QUIET, name) == ["heard"]


@pytest.mark.parametrize(
    "before", ["logging.basicConfig()", "logging.getLogger('asyncio').addHandler(logging.StreamHandler())"]
)
def test_handlers_that_are_there_already_are_not_used(before: str) -> None:
    assert [line for line in told(f"{before}; {QUIET}", "asyncio") if "send()" in line] == []
