"""The table of cards: words and addresses of each kind, cams of another slot's machine, analog channels."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import cards_page
import pytest
from cards_page import PAGE, REMEDY, missing, written
from scanrack import Configuration, InputBit, Move, MoveKind, PresetPosition
from scanrack.io_images.addresses import Address, parse_address
from scanrack.io_images.cards import KINDS, CardKind, RangeBits
from scanrack.io_images.image import Image
from scanrack.io_images.module_words import terminals_in
from scanrack.io_images.signal_ranges import FORMATS, RANGES
from scanrack.jobs import build_cpu, build_rack
from scanrack.jobs.drive.card_bench import CardBench
from scanrack.jobs.drive.requests import RequestError
from scanrack.jobs.imports.export_slots import ExportSlot, slot_tables
from scanrack.runtime import RackFileError, RackSpec, SlotSpec, parse_rack_file
from scanrack.runtime.machine import MachineSpec, Switch, press
from scanrack.runtime.modules.cards.card_options import CardOptions
from scanrack.runtime.modules.cards.module import GenericCard
from scanrack.runtime.modules.registry import MODULES, words_of


def card(kind: str, **options: Any) -> GenericCard:
    """Return a card with its power on."""
    return GenericCard(CardOptions(**options), KINDS[kind])


def wired(**inputs: int) -> Any:
    """Return options that name inputs."""
    return {"inputs": inputs}


@pytest.mark.parametrize("name", KINDS)
def test_every_card_can_be_put_into_a_slot(name: str) -> None:
    spec = RackSpec(program=lambda scan: None, slot=(SlotSpec(number=2, module=name),))
    assert build_rack(spec).slots[2].catalog == name
    assert MODULES[name].name == name


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
def test_a_card_has_as_many_points_as_its_catalog_number_says(kind: CardKind) -> None:
    """Behind the bulletin each number counts points: 1769-IQ6XOW4 has 6 inputs and 4 outputs."""
    points = len(terminals_in(kind.inputs)) + len(terminals_in(kind.outputs))
    stated = [int(number) for number in re.findall(r"\d+", kind.name.partition("-")[2])]
    if stated:
        assert points + kind.channels_in + kind.channels_out == sum(stated)


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
def test_the_wiring_that_an_export_proposes_for_a_card_can_be_taken(kind: CardKind) -> None:
    proposed = [line.removeprefix("# ") for line in slot_tables([ExportSlot(2, "", module=kind.name)])]
    assert ("[slot.options]" in proposed) is bool(kind.inputs or kind.channels_in)
    parse_rack_file('program = "line.rung"\n' + "\n".join(proposed), Path("line.toml"))


def test_terminals_may_be_any_bits_of_words() -> None:
    """Four inputs on the even bits of word 0, eight on the upper half of word 1."""
    kind = CardKind("even", inputs=(0x55, 0xFF00))
    module = GenericCard(CardOptions(inputs={"low": 2, "high": 31}, normally_closed=("low", "high")), kind)
    assert list(module.update(0, Image()))[:3] == [4, -0x8000, 0]
    with pytest.raises(ValueError, match=r"'odd': a even has no terminal 3: 0, 2, 4, 6, 24 to 31"):
        GenericCard(CardOptions(inputs={"odd": 3}), kind)


BOTH = CardKind("6 and 20", inputs=(0x003F,), outputs=(0xFFFF, 0x000F), echo=True, echo_at=2)
"""Six inputs in word 0, nothing in word 1, and the echo of 20 outputs in words 2 and 3."""


@pytest.mark.parametrize("kind", [*KINDS.values(), BOTH], ids=lambda kind: kind.name)
def test_inputs_and_echoed_outputs_show_together(kind: CardKind) -> None:
    """All inputs are on and every output word is written: neither hides the other, in either mode."""
    numbers = range(kind.channels_in) if kind.analog else terminals_in(kind.inputs)
    module = GenericCard(CardOptions(inputs={f"in{at}": at for at in numbers}), kind)
    for at in numbers:
        if kind.analog:
            module.set_value(f"in{at}", 100 + at)
        else:
            module.set_input(f"in{at}", True)
    written = [0x1234, 0x5678, 0x0F0F, 0x00FF, 0, 0, 0, 0]
    read = [*range(100, 100 + kind.channels_in)] if kind.analog else [*kind.inputs]
    for running in (True, False):
        module.plc_run(running)
        in_force = [word & mask for word, mask in zip(written, kind.outputs, strict=False)]
        in_force = (written[: kind.channels_out] if kind.analog else in_force) if kind.echo else []
        shown = [*read, *[0] * 8][:8]
        shown[kind.echo_at : kind.echo_at + len(in_force)] = in_force if running else [0] * len(in_force)
        assert [word & 0xFFFF for word in module.update(0, Image(written))] == shown


def test_the_echo_of_a_card_with_inputs_has_words_names_and_terminals_of_its_own() -> None:
    assert BOTH.shown == (0x003F, 0, 0xFFFF, 0x000F)
    assert dict(BOTH.members())["ReadBack"] == ("I", 2, None)
    words = CardOptions(inputs={"start": 5}, outputs={"lamp": 17}).words(BOTH)
    assert words.terminals_instead("I", 0, 6) == "inputs 0 to 5, 32 to 51"
    assert [words.terminals_instead("I", 0, 5), words.terminals_instead("I", 3, 3)] == ["", ""]
    with pytest.raises(ValueError, match="both: echo_at = 0: words 0 to 1 are inputs"):
        CardKind("both", inputs=(0xFFFF, 0x00FF), outputs=(0xFFFF,), echo=True)


def test_an_analog_input_and_an_output_of_one_number_are_two_channels() -> None:
    """Channel 0 of either image: 4 to 20 mA come in, 0 to 10 V go out, each with range bits of its own."""
    kind = CardKind(
        "both",
        channels_in=2,
        channels_out=2,
        bits={"I": RangeBits(4, 5, 14, -2), "O": RangeBits(6, 7, 0, 2)},
        ranges=tuple(RANGES),
        formats=FORMATS,
    )
    ranges = {"level": "4..20 mA", "valve": "0..10 V"}
    options = CardOptions(inputs={"level": 0}, outputs={"valve": 0}, ranges=ranges)
    assert {at: channel.range.name for at, channel in options.channels(kind).items()} == {
        ("I", 0): "4..20 mA",
        ("O", 0): "0..10 V",
    }
    module = GenericCard(options, kind)
    module.set_value("level", 20.5)
    shown = module.update(0, Image([32_767]))
    assert list(shown) == [int(20.5 / 21 * 32_767), 0, 0, 0, 1, 1 << 14, 1, 1]
    bits = options.words(kind).groups["status"]
    assert [bits[f"{name}_over"] for name in ranges] == [("I", 5, 14), ("I", 7, 0)]


def test_the_page_of_cards_has_the_rows_of_all() -> None:
    wrong = missing(PAGE.read_text(encoding="utf-8"))
    assert not wrong, f"{wrong}: {REMEDY}"


def test_a_card_that_the_page_lacks_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    page = written(PAGE.read_text(encoding="utf-8"))
    monkeypatch.setattr(cards_page, "KINDS", {**KINDS, "1769-OV16": CardKind("1769-OV16", outputs=(0xFFFF,))})
    assert missing(page) == ["missing: | `1769-OV16` |  | 16 | output word 0 |"]
    assert missing(written(page)) == []


def test_ranges_and_formats_of_every_card_are_known() -> None:
    for kind in KINDS.values():
        assert set(kind.ranges) <= set(RANGES), kind.name
        assert kind.bits.keys() == {image for image, count in kind.channels.items() if count}, kind.name
        assert bool(kind.ranges) is bool(kind.formats) is kind.analog, kind.name


def test_terminal_20_is_bit_20_of_a_dint_and_bit_4_of_word_1() -> None:
    words = {2: words_of("1769-IQ32", wired(gate=20))}
    for text in ("Local:2:I.Data.20", "I:2.1/4", "Local:2:I.Data[1].4", "slot2.input.gate"):
        assert parse_address(text, words) == Address(2, "I", 1, 4)
    with pytest.raises(ValueError, match="bit 32 does not exist: bits are 0 to 31"):
        parse_address("Local:2:I.Data.32", words)
    with pytest.raises(ValueError, match="has 32 bits"):
        parse_address("Local:2:I.Data", words)
    shown = card("1769-IQ32", inputs={"gate": 20}, normally_closed=["gate"]).update(0, Image())
    assert list(shown) == [0, 1 << 4, 0, 0, 0, 0, 0, 0]


def test_an_analog_channel_is_a_word_with_the_profiles_name() -> None:
    words = {3: words_of("1769-IF4", wired(level=2))}
    assert parse_address("Local:3:I.Ch2Data", words) == Address(3, "I", 2, None)
    assert parse_address("Local:3:I.Ch2Data.15", words) == Address(3, "I", 2, 15)
    assert (
        parse_address("Local:3:I.Data[2]", words) == parse_address("I:3.2", words) == Address(3, "I", 2, None)
    )
    assert words[3].inputs[:4] == ("ch0_data", "ch1_data", "level", "ch3_data")
    with pytest.raises(ValueError, match="did you mean Ch3Data"):
        parse_address("Local:3:I.Ch7Data", words)
    with pytest.raises(ValueError, match="slot 3 has no output 'Ch0Data'"):
        parse_address("Local:3:O.Ch0Data", words)


def test_two_wirings_have_message_types_of_their_own() -> None:
    wirings: Any = (wired(a_b=0), wired(a=0, b=1), wired(a_b=1), {})
    found = [words_of("1762-IF4", each) for each in wirings] + [words_of("1762-OF4", {})]
    assert len({each.message for each in found}) == len(found)


def test_an_analog_input_keeps_its_value_until_the_next() -> None:
    timeline = [{"at_ms": 1, "input": "level", "value": 6240}, {"at_ms": 3, "input": "level", "value": -5}]
    module = card("1769-IF4", inputs={"level": 1}, timeline=timeline)
    shown = [module.update(ms * 1_000_000, Image())[1] for ms in range(5)]
    assert shown == [0, 6240, 6240, -5, -5]
    assert [event.text for event in module.events] == ["The level input is 6240.", "The level input is -5."]


def test_a_compact_output_card_repeats_the_outputs_in_force() -> None:
    """The output data echo; the card has 8 outputs, so bit 8 goes nowhere. In program mode it is 0."""
    module = card("1769-OW8")
    assert module.update(0, Image([0x181]))[0] == 0x81
    module.plc_run(False)
    assert module.update(1, Image([0x181]))[0] == 0
    assert card("1762-OW8").update(0, Image([0x181]))[0] == 0


@pytest.mark.parametrize(
    ("kind", "options", "says"),
    [
        ("1762-IQ8", {"inputs": {"a": 8}}, "a 1762-IQ8 has no terminal 8: 0 to 7"),
        ("1762-IQ8", {"outputs": {"a": 0}}, "outputs: a 1762-IQ8 has no outputs"),
        ("1769-IF4", {"inputs": {"a": 4}}, "a 1769-IF4 has no channel 4: 0 to 3"),
        ("1769-IF4", {"inputs": {"a": 0}, "normally_closed": ["a"]}, "a 1769-IF4 has no contacts"),
        ("1769-IF4", {"inputs": {"a": 0}, "timeline": [{"at_ms": 1, "input": "a"}]}, "needs a value"),
        (
            "1769-IF4",
            {"inputs": {"a": 0}, "timeline": [{"at_ms": 1, "input": "a", "value": 1, "for_ms": 1}]},
            "remove for_ms",
        ),
        (
            "1769-IQ16",
            {"inputs": {"a": 0}, "timeline": [{"at_ms": 1, "input": "a", "value": 1}]},
            "has no value",
        ),
        (
            "1769-IQ16",
            {"inputs": {"a": 0}, "cam": [{"input": "a", "slot": 1}]},
            "needs a switch, or first, last or both",
        ),
        (
            "1769-IQ16",
            {"inputs": {"a": 0}, "cam": [{"input": "a", "slot": 1, "first": 2, "last": 1}]},
            "first 2 is above last 1",
        ),
        (
            "1769-IQ16",
            {"inputs": {"a": 0}, "cam": [{"input": "a", "slot": 1, "switch": "hom"}]},
            "no switch 'hom'",
        ),
        (
            "1769-IQ16",
            {"inputs": {"a": 0}, "cam": [{"input": "a", "slot": 1, "first": 2}] * 2},
            "'a' is wired twice",
        ),
    ],
)
def test_wiring_that_a_card_cannot_have_is_refused(kind: str, options: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        card(kind, **options)


CONFIGURATION = Configuration(
    inputs_used=InputBit.CAPTURE | InputBit.HOME | InputBit.CW_LIMIT,
    step_and_direction=True,
    starting_speed=500,
)
MACHINE = MachineSpec(
    switches=(Switch(InputBit.CW_LIMIT, 900, None),),
    timeline=press(41_300_000, InputBit.CAPTURE, 20_000_000),
)


def move(scan: Any) -> None:
    """Configure at once, preset in scan 200, move to 1000 in scan 300; a limit switch stands at 900."""
    outputs = scan.slot[STEPPER].outputs
    if scan.number == 0:
        outputs.load(CONFIGURATION.to_image())
    elif scan.number in (150, 250):
        outputs.clear()
    elif scan.number == 200:
        outputs.load(PresetPosition(0).to_image())
    elif scan.number == 300:
        outputs.load(Move(MoveKind.ABSOLUTE, 1000, speed=5000, acceleration=1, deceleration=1).to_image())


STEPPER = 2
CAMS: Any = {
    "inputs": {"half": 3, "home": 5, "sensed": 4},
    "normally_closed": ["home"],
    "cam": [
        {"input": "half", "slot": STEPPER, "first": 300, "last": 600},
        {"input": "home", "slot": STEPPER, "last": -1},
        {"input": "sensed", "slot": STEPPER, "switch": "capture"},
    ],
}


def images(*cards: int, module: str = "amci3601") -> list[tuple[bytes, list[int], int]]:
    """Run a move; return by scan the stepper's inputs, its words, and the word of the first card."""
    slots = [SlotSpec(number=number, module="1769-IQ16", options=CAMS) for number in cards]
    slots.append(SlotSpec(number=STEPPER, module=module, machine=MACHINE))
    spec = RackSpec(program=move, slot=tuple(slots))
    rack = build_rack(spec)
    seen = []

    def look(scan: Any) -> None:
        stepper = rack.slots[STEPPER].inputs
        first = rack.slots[cards[0]].inputs[0] if cards else 0
        seen.append((bytes(stepper), list(stepper), first))
        move(scan)

    build_cpu(spec, look, rack).run(900)
    return seen


@pytest.mark.parametrize("module", ["amci3601", "pcl601-adapter"])
def test_a_cam_is_closed_while_the_shaft_is_in_its_range(module: str) -> None:
    """In the scan's own instant, whichever of the two slots comes first; the 3601 notices nothing."""
    before, behind, alone = images(1, module=module), images(3, module=module), images(module=module)
    assert [each[0] for each in before] == [each[0] for each in behind] == [each[0] for each in alone]
    assert [each[2] for each in before] == [each[2] for each in behind]
    if module == "amci3601":
        for _, words, shown in before[300:]:
            position = 1000 * words[2] + words[3]
            assert bool(shown >> 3 & 1) is (300 <= position <= 600)
    assert {each[2] >> 3 & 1 for each in before} == {0, 1}
    assert all(each[2] >> 5 & 1 for each in before)  # normally closed, and the shaft is never below 0


def test_a_card_sees_a_switch_of_the_machine_in_the_instant_of_the_scan() -> None:
    """Capture is energized from 41.3 to 61.3 ms: in the scans at 42 to 60 ms, which are 21 to 30."""
    shown = [each[2] >> 4 & 1 for each in images(1)]
    assert [scan for scan, level in enumerate(shown) if level] == list(range(21, 31))


def test_a_cam_needs_a_simulated_stepper(tmp_path: Path) -> None:
    text = """
program = "p.py"
[[slot]]
number = 1
module = "1769-IQ16"
[slot.options]
inputs = { a = 0 }
cam = [{ input = "a", slot = 3, first = 0 }]
[[slot]]
number = 2
module = "amci3601"
"""
    with pytest.raises(RackFileError, match="slot 3 has no simulated stepper; there is one in 2"):
        parse_rack_file(text, tmp_path / "rack.toml")


def test_only_the_machine_operates_a_cam() -> None:
    """Also on the bench of `drive`, where there is no machine."""
    module = card("1769-IQ16", inputs={"a": 0}, cam=[{"input": "a", "slot": 1, "first": 0}])
    with pytest.raises(ValueError, match="wired to a cam"):
        module.set_input("a", True)
    cams = {"inputs": {"a": 0}, "cam": [{"input": "a", "slot": 1, "first": 0}]}
    with pytest.raises(RequestError, match="this bench has no other slot"):
        CardBench(MODULES["1769-IQ16"]).answer(json.dumps({"new": {"options": cams}}))


def test_the_bench_knows_the_terminals_of_the_second_word() -> None:
    bench = CardBench(MODULES["1769-IQ32"])
    request = {"new": {"options": {"inputs": {"gate": 20}}}, "inputs": {"gate": 1}}
    reply = bench.answer(json.dumps(request))
    assert (reply["in"][:2], reply["bits"]) == ([0, 16], ["gate"])
