"""Chains of causes of motion: what moves an axis, what ended it, and why an instruction was refused.

10 ms a scan. The jog reaches 2 units/s in 0.5 s; the move, 1 unit at 2 units/s, takes 0.5 s on its own ramps.
"""

import pytest
from chain_text import after, text_of
from scanrack.ladder.files import parse_program

TAGS = """PROGRAM p
TAG Ax : AXIS_VIRTUAL
TAG Servo : AXIS_CIP_DRIVE
TAG A : MOTION_INSTRUCTION
TAG B : MOTION_INSTRUCTION
TAG Go : BOOL
TAG More : BOOL
ROUTINE Main
"""
RATES = "{speed},Units per sec,{rate},Units per sec2,{rate},Units per sec2,0,0,0,0,{merge},Programmed,0,None"
JOG = f"XIC(Go)MAJ(Ax,A,Forward,{RATES.format(speed=2, rate=4, merge='Disabled')});"


def move(merge, axis="Ax"):
    return f"XIC(More)MAM({axis},B,1,1,{RATES.format(speed=4, rate=16, merge=merge)},0,0);"


GONE = "2 Go 10 More 5"
"""The jog begins in scan 2, the move in scan 12; five scans of it."""

ROWS = {
    "a jog that a merge ends": (
        move("Enabled"), GONE, "Ax.JogStatus", "MAM(Ax,B) ends it, by XIC(More)",
        "Ax.JogStatus off @12 < More on @12 operator",
    ),
    "the instruction of that jog": (
        move("Enabled"), GONE, "A.IP", "MAM(Ax,B) ends it, by XIC(More)",
        "A.IP off @12 < More on @12 operator",
    ),
    "a move that begins": (
        move("Disabled"), GONE, "Ax.MoveStatus", "MAM(Ax,B), by XIC(More)",
        "Ax.MoveStatus on @12 < More on @12 operator",
    ),
    "a jog that goes on beside it": (
        move("Disabled"), GONE, "Ax.JogStatus", "MAJ(Ax,A), by XIC(Go)",
        "Ax.JogStatus on @2 < Go on @2 operator",
    ),
    # 14 scans at 4 units/s² and 4 at 16: 0.56 and 0.64 units/s; 1.2 as a REAL
    "a velocity has both": (
        move("Disabled"), GONE, "Ax.ActualVelocity", "moved by B, A",
        "Ax.ActualVelocity = 1.2000000476837158 @16 < B.IP on @12 < More on @12 operator"
        " & A.IP on @2 < Go on @2 operator",
    ),
    # 1 unit with 16 units/s² on both sides: 4 units/s after 0.25 s and 0.5 units, at rest after 0.5 s
    "a move that has ended": (
        move("Disabled"), "2 Go 10 More 60", "Ax.MoveStatus", "the motion of B is complete",
        "Ax.MoveStatus off @62 < B.IP on @12 < More on @12 operator",
    ),
    "its instruction": (
        move("Disabled"), "2 Go 10 More 60", "B.PC", "the motion of B is complete",
        "B.PC on @62 < B.IP on @12 < More on @12 operator",
    ),
    "an axis without a servo": (
        move("Disabled", "Servo"), "2 More 2", "B.ER", "MAM(Servo,B): ERR 5, servo off, by XIC(More)",
        "B.ER on @2 < More on @2 operator",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("rung", "done", "tag", "text", "chain"), ROWS.values(), ids=ROWS)
def test_a_chain_of_motion(rung, done, tag, text, chain):
    debugger = after(parse_program(f"{TAGS}{JOG}\n{rung}\nEND\n"), done)
    link = debugger.chain(tag)
    assert link is not None
    assert (link.text, text_of(link)) == (text, chain)
