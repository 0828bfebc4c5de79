"""The power that a compiled rung notes is what the interpreter finds, for every setting of its tags."""

from itertools import product

import pytest
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program

TAGS = "abcdefgh"
HEAD = "".join(f"TAG {name} : BOOL\n" for name in TAGS) + "TAG n : DINT\nTAG t : TIMER\n"
RUNGS = {
    "a run": "XIC(a)XIO(b)XIC(c)OTE(h)",
    "a branch behind a run": "XIC(a)XIO(b)[XIC(c)XIC(d),XIC(e)]OTE(h)",
    "branches in branches": "XIC(a)[XIC(b)XIC(c)[XIC(d)XIC(e),XIO(f)],XIC(g)]OTE(h)MOV(1,n)",
    "branch behind branch": "XIC(a)[XIC(b)XIC(c),XIC(d)][XIC(e)XIC(f),XIO(g)]OTE(h)",
    "a branch in front": "[XIC(a)XIC(b),XIC(c)]XIC(d)OTE(h)",
    "an empty leg": "XIC(a)[XIC(b)XIC(c),]OTE(h)",
    "outputs in legs": "XIC(a)[XIC(b)OTE(g)OTL(f),XIC(c)MOV(2,n)]OTE(h)",
    "a timer in a leg": "XIC(a)[XIC(b)TON(t,0,0),XIC(t.EN)XIC(c)]OTE(h)",
    "several outputs": "XIC(a)XIC(b)OTE(g)MOV(3,n)OTE(h)",
    "a condition between outputs": "XIC(a)OTE(g)XIC(b)XIC(c)OTE(h)",
    "no condition": "OTE(h)OTE(g)",
    "the end behind a branch": "XIC(a)[XIC(b)XIC(c),XIC(d)]TND()",
    "the end in front of more": "XIC(a)XIC(b)TND()XIC(c)XIC(d)OTE(h)",
}


@pytest.mark.parametrize("rung", RUNGS.values(), ids=RUNGS)
def test_power_behind_every_instruction(rung):
    program = parse_program(f"PROGRAM noted\n{HEAD}\nROUTINE Main\n{rung};\nEND\n")
    ours, theirs = Debugger(program), Debugger(program)
    theirs.interpreted = True
    used = [name for name in TAGS if f"({name})" in rung]
    settings = list(product([False, True], repeat=len(used)))
    for values in settings + settings[::-1]:
        for debugger in (ours, theirs):
            for name, value in zip(used, values, strict=True):
                debugger.tags[name] = value
            debugger.scan(1)
        assert ours.truth("Main") == theirs.truth("Main"), dict(zip(used, values, strict=True))
        for name in (*TAGS, "n", "t.EN"):
            assert ours.tags[name] == theirs.tags[name]


def test_a_routine_that_runs_twice_shows_the_second_time():
    """What the first pass notes of a branch says nothing once the second finds no power in front of it."""
    text = f"""PROGRAM noted
{HEAD}
ROUTINE Main
CLR(n);
JSR(Twice,0);
OTU(a)JSR(Twice,0);
END

ROUTINE Twice
XIC(a)[XIC(b)XIC(b),EQU(n,5)]ADD(n,1,n);
END
"""
    found = []
    for interpreted in (False, True):
        debugger = Debugger(parse_program(text))
        debugger.interpreted = interpreted
        for _ in range(2):
            debugger.tags["a"] = debugger.tags["b"] = True
            debugger.scan(1)
            found.append(debugger.truth("Twice"))
    assert found == [[(False,) * 5]] * 4
