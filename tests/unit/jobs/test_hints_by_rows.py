"""Hints about a run are the same whether its scans go by rows or by their phases."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from scanrack.io_images.amci3601 import WORDS_3601, CommandMsw, Configuration, Idle, InputBit
from scanrack.io_images.image import Image
from scanrack.jobs.run.hints import Hints
from scanrack.runtime import Amci3601, Card, Cpu, Rack
from scanrack.runtime.loop import ahead
from scanrack.runtime.loop.listeners import ROWS_AT_ONCE
from scanrack.runtime.machine import MachineSpec, Switch

MACHINE = MachineSpec(switches=(Switch(InputBit.CW_LIMIT, 90_000, None),))
RACK: Any = SimpleNamespace(slot=[SimpleNamespace(number=1, machine=MACHINE)])
USED = Configuration(
    inputs_used=InputBit.HOME | InputBit.CCW_LIMIT, step_and_direction=True, starting_speed=1000
).to_image()
REFUSED = Image((USED[0], 0, 0, 0, 0, 0, 0, 0))
"""A starting speed of 0: the module stays in configuration mode with its error."""

MOVE = Image((CommandMsw.RELATIVE_MOVE, 0, 900, 0, 5, 0, 20, 10))
FASTER = Image((CommandMsw.RELATIVE_MOVE, 0, 900, 0, 6, 0, 20, 10))
SCRIPT = {0: REFUSED, 400: USED, 402: Idle().to_image(), 404: MOVE, 900: FASTER}


@pytest.fixture(autouse=True)
def _numpy_is_loaded(monkeypatch):
    monkeypatch.setattr(ahead, "NUMPY_WORTH_SCANS", 0)


def hints(*, by_rows: bool) -> tuple[list[str], list[str], list[int]]:
    """Run a configuration that is refused, then an accepted one, then a move that changes without an edge."""
    rack = Rack([Card(1, Amci3601(), "amci3601", "4.1", WORDS_3601)])
    told: list[str] = []
    listener = Hints(rack, RACK, told.append)
    allowed: list[int] = []

    def logic(scan) -> None:
        if scan.number in SCRIPT:
            scan.slot[1].outputs.load(SCRIPT[scan.number])
        allowed.append(listener.begin_rows(scan.number))

    cpu = Cpu(rack, logic, 2_000_000, listeners=[listener])
    cpu._ahead.enabled = by_rows
    cpu.run(1500)
    return told, listener.sentences(), allowed


def test_hints_by_rows_are_those_by_phases():
    told, sentences, allowed = hints(by_rows=True)
    assert (told, sentences, allowed) == hints(by_rows=False)
    assert len(told) == 1
    assert "cw_limit" in told[0]
    assert "scan 900" in sentences[0]
    assert allowed[300] == 0  # a configuration waits for its answer
    assert allowed[600] == ROWS_AT_ONCE
