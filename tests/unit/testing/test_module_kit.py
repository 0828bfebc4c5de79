"""The test kit for modules: every module of scanrack passes it, and it finds planted mistakes."""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Any

import pytest
from scanrack.runtime.modules.record import Trait
from scanrack.runtime.modules.registry import OWN
from scanrack.testing.modules import ContractError, any_script, check_module, record_in

BLINKER = Path(__file__).parents[3] / "examples/own_module/blinker.py"
TIMED: dict[str, Any] = {
    "timeline": [{"at_ms": 0.5, "input": "start", "for_ms": 1.25}],
    "inputs": {"start": 4},
}


def moves(dice: Random) -> list[int]:
    """Draw words of a 3601: its configuration, or a command with a legal profile."""
    if dice.randrange(3) == 0:
        return [0x843E, 0x3F, 1, 0]
    distance, speed = dice.choice([(3, 0), (-2, -500), (40, 0)]), dice.choice([(0, 40), (5, 0), (90, 0)])
    return [dice.choice([0, 0, 1, 2, 4, 16, 128, 1024]), 0, *distance, *speed, 20, 10]


@pytest.mark.parametrize("name", [name for name, record in OWN.items() if Trait.LINE not in record.traits])
def test_each_module_keeps_the_contract(name):
    check_module(OWN[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, record in OWN.items() if Trait.MACHINE in record.traits])
def test_each_stepper_keeps_it_while_it_moves(name):
    """An adapter's line is computed character by character: two scripts are half a minute of it."""
    check_module(OWN[name], seeds=range(2 if Trait.LINE in OWN[name].traits else 25), words=moves)


def test_a_card_keeps_it_while_its_inputs_are_operated():
    check_module(OWN["discrete16"], TIMED, seeds=range(5))


MISTAKES = {
    "a time counted from the call": (
        "self._on_since_ns = self._now_ns",
        "self._on_since_ns = now_ns",
        "calls between must not matter",
    ),
    "calls counted": (
        "self._inputs[1] = 0 if",
        "self._inputs[2] += 1\n        self._inputs[1] = 0 if",
        "calls between must not matter; seed 0, step 1: input word 2 is 2, then",
    ),
    "an event at each call": (
        "self._now_ns = now_ns",
        'self._now_ns = now_ns\n        self.events.append(Event(now_ns, "lamp", "asked", {}))',
        "calls between must not matter; seed 0, step 1: events are",
    ),
    "a memory that modules share": (
        "self._inputs[1] = 0 if",
        "REMEMBERED.append(1)\n        self._inputs[2] = len(REMEMBERED)\n        self._inputs[1] = 0 if",
        "two runs must be equal; seed 0, step 0: input word 2 is 1, then 14",
    ),
    "a word that is too large": (
        "self._now_ns = now_ns",
        "self._now_ns = now_ns\n        self._inputs[2] = outputs[1] * 2",
        "any words must be survived; .* in step .* ns, outputs",
    ),
    "a range that is divided by": (
        "// self._half_ns",
        "// (self._half_ns - 1_000_000)",
        "'half_ms': 1}: any words must be survived; .*ZeroDivisionError",
    ),
    "a name too few": ("range(2, 8)", "range(3, 8)", "it names 7 input words and returns 8"),
    "an output among the inputs": (
        'BitPlace("I", 0, 0)',
        'BitPlace("O", 0, 0)',
        "LIT must decode to its name",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_planted_mistake_is_found(mistake, tmp_path):
    right, wrong, said = MISTAKES[mistake]
    source = BLINKER.read_text(encoding="utf-8").replace("REST =", "REMEMBERED: list[int] = []\nREST =")
    assert right in source
    planted = tmp_path / "planted.py"
    planted.write_text(source.replace(right, wrong), encoding="utf-8")
    with pytest.raises(ContractError, match=f"planted with options .*{said}"):
        check_module(record_in(planted))


def test_a_script_depends_on_its_seed_only():
    assert any_script(7) == any_script(7) != any_script(8)
    assert any(not step.running for seed in range(5) for step in any_script(seed))
    assert any(step.act for seed in range(5) for step in any_script(seed))
