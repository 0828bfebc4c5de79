"""Tests that a system can't run are skipped there, by what stands in their code."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import needs
import pytest

PROGRAM = "import signal\nsignal.raise_signal(signal.SIGKILL)\n"


class Session:
    @property
    def process(self) -> int:
        return os.waitpid(0, os.WNOHANG)[0]


def ends(process: SimpleNamespace) -> bool:
    process.send_signal(signal.SIGINT)
    return True


def by_a_name() -> None:
    os.mkfifo("made")


def by_a_helper() -> None:
    ends(SimpleNamespace())


def by_a_helper_inside() -> list[bool]:
    return [ends(each) for each in (SimpleNamespace(),)]


def by_a_class() -> Session:
    return Session()


def by_a_program() -> str:
    return PROGRAM


def by_a_path() -> Path:
    return Path("/dev/full")


def by_an_argument() -> SimpleNamespace:
    return SimpleNamespace(pty=True)


def by_nothing() -> str:
    """It says os.fork, signal.SIGKILL and mkfifo, and needs none of them."""
    signal.raise_signal(signal.SIGINT)
    return os.path.join("process", "full")


@pytest.mark.parametrize(
    ("used", "what"),
    [
        (by_a_name, "FIFOs"),
        (by_a_helper, "signals for one process"),
        (by_a_helper_inside, "signals for one process"),
        (by_a_class, "fork"),
        (by_a_program, "such signals"),
        (by_a_path, "/dev/full"),
        (by_an_argument, "pseudo-terminals"),
        (by_nothing, ""),
    ],
)
def test_what_a_test_needs_is_read_from_its_code(used: Callable[[], object], what: str) -> None:
    assert needs.lacking(used, needs.NEEDS) == what
    assert not needs.lacking(used, [each for each in needs.NEEDS if each.what != what])


def test_linux_has_all_that_tests_need() -> None:
    if sys.platform == "linux":
        assert all(each.there for each in needs.NEEDS)
        assert all(needs.CANNOT_BE_IMPORTED.values())


def test_a_test_is_skipped_with_its_reason(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """This one names os.fork itself, and its file has others that don't."""
    assert callable(os.fork)
    found = [each for each in request.session.items if each.path == request.path]
    before = {each: len(each.own_markers) for each in found}
    monkeypatch.setattr(needs, "NEEDS", [each._replace(there=False) for each in needs.NEEDS])
    needs.skip_without_needs(found)
    added = {each.name: each.own_markers[count:] for each, count in before.items()}
    for each, count in before.items():
        del each.own_markers[count:]
    reasons = {name: [mark.kwargs["reason"] for mark in marks] for name, marks in added.items() if marks}
    assert reasons == {request.node.name: ["this system has no fork"]}
