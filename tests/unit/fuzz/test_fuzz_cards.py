"""The fuzz search operates the contacts of cards, and writes down which."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import find
from scanrack.jobs import ContactPress, Kind, Scenario, build_cpu, build_rack, possible_kinds
from scanrack.jobs.fuzz.drawing import scenarios
from scanrack.jobs.fuzz.invariants.scan_view import Snapshot
from scanrack.jobs.fuzz.invariants.standard import STANDARD
from scanrack.jobs.fuzz.scenarios.kinds import card_buttons
from scanrack.jobs.fuzz.scenarios.rackdoc import rack_text
from scanrack.jobs.fuzz.scenarios.scenario import one_at_a_time
from scanrack.jobs.fuzz.scenarios.words import described
from scanrack.jobs.fuzz.shrink import parts_of, scenario_of
from scanrack.runtime import RackSpec, SlotSpec, parse_rack_file

MS = 1_000_000
OPTIONS: Any = {
    "inputs": {"start": 0, "home": 1, "at_two": 2},
    "cam": [{"input": "at_two", "slot": 1, "first": 10}],
}
CARDS = (SlotSpec(number=2, module="1769-IQ16", options=OPTIONS), SlotSpec(number=3, module="1769-OB16"))
RACK = RackSpec(program=lambda scan: None, slot=(SlotSpec(number=1, module="amci3601"), *CARDS))
PUSHED = Scenario(pushes=(ContactPress(2, "home", 20 * MS, 10 * MS),))


def test_a_contact_that_a_cam_operates_is_no_button() -> None:
    assert card_buttons(RACK) == [(2, "start"), (2, "home")]


def test_a_rack_of_cards_alone_has_inputs_to_press() -> None:
    wired: Any = {"inputs": {"start": 0}}
    cards = RackSpec(program=print, slot=(SlotSpec(number=1, module="1762-IQ8", options=wired),))
    assert Kind.INPUTS in possible_kinds(cards)
    assert find(scenarios(cards, 100, {Kind.INPUTS}), lambda found: bool(found.pushes)).presses == ()


def test_a_push_is_what_the_program_sees() -> None:
    """From 20 to 30 ms, scans 10 to 14 of 2 ms."""
    rack = build_rack(PUSHED.laid_over(RACK))
    seen: list[bool] = []
    build_cpu(RACK, lambda scan: seen.append(scan.slot[2].inputs.bit(0, 1)), rack).run(20)
    assert [scan for scan, on in enumerate(seen) if on] == [10, 11, 12, 13, 14]


def test_a_push_is_written_and_read_again(tmp_path: Path) -> None:
    assert Scenario.from_json(PUSHED.to_json()) == PUSHED == scenario_of(parts_of(PUSHED))
    assert described(PUSHED) == ["0.02 s: input home of slot 2 is operated for 10 ms"]
    file = tmp_path / "rack.toml"
    file.write_text(
        'program = "p"\n[[slot]]\nnumber = 2\nmodule = "1769-IQ16"\n[slot.options]\ninputs = { home = 1 }\n',
        encoding="utf-8",
    )
    text = rack_text(
        file, parse_rack_file(file.read_text(encoding="utf-8"), file).spec, PUSHED, 100, tmp_path
    )
    (slot,) = tomllib.loads(text)["slot"]
    assert slot["options"]["timeline"] == [{"at_ms": 20, "input": "home", "for_ms": 10}]
    parse_rack_file(text, file)


def test_presses_that_overlap_those_of_the_rack_file_are_written_as_one(tmp_path: Path) -> None:
    """15 to 22 ms of the rack and 20 to 30 ms of the scenario are 15 to 30 ms; a card refuses an overlap."""
    file = tmp_path / "rack.toml"
    own = 'inputs = { home = 1 }\ntimeline = [{ at_ms = 15, input = "home", for_ms = 7 }]\n'
    file.write_text(
        f'program = "p"\n[[slot]]\nnumber = 2\nmodule = "1769-IQ16"\n[slot.options]\n{own}', encoding="utf-8"
    )
    spec = parse_rack_file(file.read_text(encoding="utf-8"), file).spec
    written = parse_rack_file(rack_text(file, spec, PUSHED, 100, tmp_path), file).spec
    assert written.slot[0].options["timeline"] == [{"at_ms": 15, "input": "home", "for_ms": 15}]
    assert written.slot == PUSHED.laid_over(spec).slot


def test_a_push_of_another_rack_is_refused() -> None:
    PUSHED.check(RACK)
    with pytest.raises(ValueError, match="slot 2 has no button 'at_two', only start, home"):
        Scenario(pushes=(ContactPress(2, "at_two", 0, MS),)).check(RACK)


def test_the_words_of_a_card_are_no_commands_and_no_status() -> None:
    """Bits 0 and 1 of word 0 would be two motions of a 3601, bit 12 of its inputs COMMAND_ERROR."""
    rack = build_rack(RACK)
    rack.slots[3].outputs[0] = 0b11
    rack.slots[2].inputs[0] = -1
    now = Snapshot(rack, {})
    assert (now.slot[3].motions, now.slot[3].commands) == (0, ())
    assert not now.slot[2].status.COMMAND_ERROR
    assert str(now.slot[3]) == "outputs 16#0003; inputs 16#0000"
    assert not any(invariant.start()(now) for invariant in STANDARD.values())


def test_presses_of_a_search_that_overlap_are_one():
    """10 to 30 and 20 to 50 ms are 10 to 50 ms; 60 ms and on has no end; another input is left as it is."""
    row = {"at_ms": 20, "input": "start", "for_ms": 30}
    other = {"at_ms": 25, "input": "stop", "for_ms": 5}
    assert one_at_a_time([row, other, {"at_ms": 10, "input": "start", "for_ms": 20}]) == [
        {"at_ms": 10.0, "input": "start", "for_ms": 40.0},
        other,
    ]
    for_good = {"at_ms": 60, "input": "start"}
    assert one_at_a_time([for_good, {"at_ms": 70, "input": "start", "for_ms": 5}]) == [for_good]
    values = [{"at_ms": 5, "input": "level", "value": each} for each in (1, 2)]
    assert one_at_a_time(values) == values[1:]
