"""What the pointer is on in rungs: every instruction of each dialect, every block that scanrack brings."""

from __future__ import annotations

import pytest
from scanrack.ladder.files.rungreader import LIBRARIES, load_library
from scanrack.ladder.lowering.dialects import DIALECTS, LOGIX
from scanrack.lsp import rungs

TEXTS = {dialect: f"PROGRAM a\n{'' if dialect == LOGIX else f'DIALECT {dialect}'}\n" for dialect in DIALECTS}


def meaning(text: str, word: str) -> str:
    return rungs.meaning(text, f"{word}(A,B);", 1)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_instruction_says_what_it_is(dialect: str) -> None:
    silent = [
        name
        for name, spec in DIALECTS[dialect].items()
        if not meaning(TEXTS[dialect], name).startswith(f"```rung\n{spec.name}(")
    ]
    assert silent == []


@pytest.mark.parametrize("library", LIBRARIES)
def test_every_block_says_its_operands_and_what_it_does(library: str) -> None:
    for block in load_library(library).add_ons.values():
        said = meaning(TEXTS[LOGIX], block.name)
        assert block.comment in said
        assert all(each.name in said for each in block.required)


def test_a_block_is_written_as_a_rung_has_it() -> None:
    said = meaning(TEXTS[LOGIX], "MC_Home")
    assert said.startswith(
        "```rung\nMC_Home(instance, Axis, Execute, Direction, Velocity, Acceleration, Deceleration)\n```"
        "\n\nhomes the axis; the position becomes 0 there"
    )
    assert "INPUT Direction : INT  // 1 clockwise, -1 counterclockwise" in said
    assert "OUTPUT CommandAborted : BOOL  // another block has taken over the axis" in said
    assert "Refused" not in said, "what the block keeps to itself"


def test_an_instruction_of_the_text_comes_before_a_block_of_the_same_name() -> None:
    assert "ours" in meaning("INSTRUCTION MC_Home // ours\nINPUT Go : BOOL\n", "MC_Home")


def test_blocks_and_their_members_are_offered() -> None:
    text = "PROGRAM a\nUSE axis3601\nTAG Axis : AXIS_3601\nTAG Feed : MC_MoveAbsolute\n"
    names = {each.name for each in rungs.offers(text, "XIC(A)", structured=False)}
    assert {"MC_Home", "Configure3601", "Feed"} <= names
    members = {each.name for each in rungs.offers(text, "XIC(Feed.", structured=False)}
    assert {"Done", "Busy", "ErrorID"} <= members
    assert "Position" in {each.name for each in rungs.offers(text, "MOV(Axis.", structured=False)}
    unused = {each.name for each in rungs.offers("PROGRAM a\n", "XIC(A)", structured=False)}
    assert "MC_Home" not in unused, "a program takes them with USE"
    slc = {each.name for each in rungs.offers("PROGRAM a\nDIALECT slc\n", "XIC(A)", structured=False)}
    assert "SUS" in slc
    assert "ALMD" not in slc
