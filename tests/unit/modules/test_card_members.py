"""Cards have Rockwell's member names, in programs, forces and traces."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from scanrack.io_images.addresses import parse_address
from scanrack.io_images.cards import KINDS, MEMBERS, CardKind, member_of
from scanrack.jobs import open_bench
from scanrack.ladder.model.operands import Place
from scanrack.ladder.model.resolver import Resolver
from scanrack.ladder.model.tags import Layout
from scanrack.runtime.modules.cards.card_options import CardOptions
from scanrack.traces import open_trace
from scanrack.traces.query import query

ANALOG_IN = [
    # channel, status, over-range, under-range: word and bit [table 3.1]
    (0, (4, 0), (5, 14), (5, 15)),
    (1, (4, 1), (5, 12), (5, 13)),
    (2, (4, 2), (5, 10), (5, 11)),
    (3, (4, 3), (5, 8), (5, 9)),
]
ANALOG_OUT = [
    # channel, status, over-range, under-range, echo [1769-IN087A, page 15]
    (0, (0, 0), (0, 8), (0, 9), 1),
    (1, (0, 1), (0, 10), (0, 11), 2),
    (2, (0, 2), (0, 12), (0, 13), 3),
    (3, (0, 3), (0, 14), (0, 15), 4),
]


@pytest.mark.parametrize("row", ANALOG_IN)
def test_members_of_a_1769_if4(row: tuple[int, ...]) -> None:
    channel, *bits = row
    names = [f"Ch{channel}{what}" for what in ("Status", "Overrange", "Underrange")]
    assert [member_of("1769-IF4", "I", name)[1:] for name in names] == bits  # type: ignore[index]
    assert member_of("1769-IF4", "I", f"Ch{channel}Data") == ("I", channel, None)


@pytest.mark.parametrize("row", ANALOG_OUT)
def test_members_of_a_1769_of4(row: tuple[int, ...]) -> None:
    channel, *bits, echo = row
    names = [f"Ch{channel}{what}" for what in ("Status", "Overrange", "Underrange")]
    assert [member_of("1769-OF4", "I", name)[1:] for name in names] == bits  # type: ignore[index]
    assert member_of("1769-OF4", "I", f"Ch{channel}DataEcho") == ("I", echo, None)
    assert member_of("1769-OF4", "O", f"Ch{channel}Data") == ("O", channel, None)
    assert member_of("1769-OF4", "I", f"Ch{channel}Data") is None


def test_the_members_are_where_the_card_puts_them() -> None:
    few = {name: {each for each, _ in table} for name, table in MEMBERS.items() if not KINDS[name].analog}
    assert few == {name: {"ReadBack"} if KINDS[name].echo else set() for name in few}
    assert {"discrete16", "1769-IQ32", "1769-OB16", "1769-OW8"} < few.keys()
    assert {"1769-IF4", "1769-OF4"} <= MEMBERS.keys() - few.keys()
    cards = ("discrete16", "1769-OW8", "1769-OB32", "1769-IF4")
    assert [KINDS[name].data_bits for name in cards] == [16, 16, 32, 0]


def test_addresses_of_members() -> None:
    words = {
        2: CardOptions().words(KINDS["1769-OB32"]),
        3: CardOptions().words(KINDS["1769-IF4"]),
        4: CardOptions().words(KINDS["1769-OF4"]),
    }
    for text, place in {
        "Local:2:I.ReadBack.20": "Local:2:I.Data[1].4",
        "Local:2:I.ReadBack.3": "Local:2:I.Data[0].3",
        "local:3:i.ch1overrange": "Local:3:I.Data[5].12",
        "Local:4:I.Ch2DataEcho": "Local:4:I.Data[3]",
        "Local:4:I.Ch2DataEcho.15": "Local:4:I.Data[3].15",
        "Local:4:O.Ch3Data": "Local:4:O.Data[3]",
    }.items():
        assert str(parse_address(text, words)) == place
    for text, says in {
        "Local:2:I.ReadBack.32": "bit 32 does not exist: bits are 0 to 31",
        "Local:4:I.Ch2DataEcho.16": "bit 16 does not exist: bits are 0 to 15",
        "Local:3:I.Ch1Overrang": "did you mean Ch1Overrange?",
        "Local:3:I.Ch1Overrange.1": "nothing can follow a bit",
    }.items():
        with pytest.raises(ValueError, match=re.escape(says)):
            parse_address(text, words)


def test_a_read_back_behind_inputs_has_the_same_word_in_addresses_and_in_rungs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Bit 18 of an echo in words 2 and 3 is bit 2 of word 3."""
    kind = CardKind("both", inputs=(0x003F,), outputs=(0xFFFF, 0x000F), echo=True, echo_at=2)
    monkeypatch.setitem(MEMBERS, kind.name, tuple(kind.members()))
    words = {2: CardOptions().words(kind)}
    assert str(parse_address("Local:2:I.ReadBack.18", words)) == "Local:2:I.Data[3].2"
    assert str(parse_address("Local:2:I.ReadBack", words)) == "Local:2:I.Data[2]"
    place = Resolver(Layout([], modules=words)).named("Local:2:I.ReadBack.18")
    assert isinstance(place, Place)
    assert place.address == "Local:2:I.Data[3].2"


PROGRAM = """PROGRAM members
TAG Back : BOOL
TAG Echo : INT
TAG Over : BOOL
TAG Under : BOOL
TAG Bad : BOOL
ROUTINE Main
XIC(Local:2:I.ReadBack.20)OTE(Back);
OTE(Local:2:O.Data.20);
MOV(Local:4:I.Ch2DataEcho,Echo);
MOV(-300,Local:4:O.Ch2Data);
MOV(-300,Local:4:O.Ch1Data);
XIC(Local:3:I.Ch1Overrange)OTE(Over);
XIC(Local:4:I.Ch1Underrange)OTE(Under);
XIC(Local:3:I.Ch1Status)OTE(Bad);
END
"""
RACK = """program = "members.rung"
controller = "compactlogix"
scan_ms = 2
run_for_s = 0.05
trace = "members.mcap"

[[slot]]
number = 2
module = "1769-OB32"

[[slot]]
number = 3
module = "1769-IF4"
[slot.options]
inputs = { level = 1 }
ranges = { level = "4..20 mA" }
timeline = [{ at_ms = 10, input = "level", value = 20.5 }]

[[slot]]
number = 4
module = "1769-OF4"
[slot.options]
outputs = { valve = 1 }
ranges = { valve = "0..10 V" }
"""


def test_members_in_a_program_and_on_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("members.rung").write_text(PROGRAM, encoding="utf-8")
    Path("members.toml").write_text(RACK, encoding="utf-8")
    with open_bench("members.toml", "members.mcap") as bench:
        bench.scan(20)
        tags = bench.program.tags
        assert (tags.Back, tags.Echo, tags.Over, tags.Under, tags.Bad) == (True, -300, True, True, True)
    with open_trace(Path("members.mcap")) as trace:
        for text in (
            "Local:2:I.ReadBack.20",
            "Local:3:I.Ch1Overrange and Local:3:I.Ch1Status",
            "Local:4:I.Ch2DataEcho == -300",
            "Local:4:I.Ch1Underrange",
            "Local:4:O.Ch2Data == -300",
        ):
            assert query(trace, f"count({text})").count == 1, text


def test_a_member_of_an_unknown_card_is_refused_where_cards_differ(tmp_path: Path) -> None:
    from scanrack.ladder import BuildError
    from scanrack.ladder.files import parse_program

    with pytest.raises(BuildError, match="Ch1Status"):
        parse_program(PROGRAM).build()
