"""A walk over a ladder program notes what reading every tag after every scan gives.

Broken on purpose: elements one place too far, an array read from its first element, a bit left a number,
changes of forces passed over: the test turns red.
"""

from __future__ import annotations

from scanrack.ladder.debug.executed import TracedEngine
from scanrack.ladder.files.rungfile import parse_program
from scanrack.watch.history.catalog import shown_value, value_of
from scanrack.watch.share.changes import ChangeLists
from scanrack.watch.share.ladder_walk import LadderWalk

TEXT = """
PROGRAM kinds
SLOT card : 1
TYPE Part (On : BOOL, Count : DINT, Row : INT[3], Level : REAL)
INSTRUCTION Adder
INPUT By : DINT REQUIRED
INOUT Row : INT[3]
OUTPUT Odd : BOOL
LOCAL Own : DINT
LOCAL Past : DINT[4]
ROUTINE Logic
ADD(Own,By,Own) MOV(Own,Past[2]) MOV(By,Row[1]);
XIC(Own.0)OTE(Odd);
END
END INSTRUCTION
TAG Sum : Adder[2]
TAG Row : INT[3]
TAG Parts : Part[2]
TAG Grid : DINT[2,3]
TAG Flags : BOOL[4]
TAG Count : DINT
TAG At : DINT
TAG Wide : LREAL
TAG Level : REAL
TAG Lamp : BOOL
TAG Name : STRING
TAG Clock : TIMER
ROUTINE Main
ADD(Count,1,Count) AND(Count,1,At);
ADD(Grid[At,2],Count,Grid[At,2]) MOV(Count,Parts[1].Row[2]) MOV(Count,Parts[At].Count);
XIC(Count.1)OTE(Parts[0].On);
XIC(Count.2)OTE(Flags[3]);
XIC(Count.0)OTE(Lamp);
DIV(Count,3,Wide) MOV(Wide,Parts[0].Level) MUL(Level,1e30,Level) ADD(Level,1,Level);
EQU(Count,4)MOV(Count,Name.LEN);
XIO(Clock.DN)TON(Clock,20,0);
Adder(Sum[1],Count,Row);
MOV(Count,card.O.Data[2]);
END
"""
NAMES = """
Parts Parts[1] Parts[0].On Parts[1].Row Parts[1].Row[2] Parts[At].Count Parts[0].Level Grid Grid[At,2]
Grid[0,2] Grid[0,2].1 Flags Flags[3] Count Count.1 Wide Level Lamp
Sum Sum[1] Sum[1].Own Sum[1].Odd Sum[1].Past Sum[1].Past[2] Row Row[1] Name
Clock.ACC Clock.DN card.O.Data[2] Nothing
"""


def test_a_walk_notes_what_reading_every_tag_gives() -> None:
    program = parse_program(TEXT)
    engine = TracedEngine(program.build(), program.scanner)
    names = NAMES.split()
    lists, changes = ChangeLists(), dict.fromkeys(names, 0)
    walk = LadderWalk(lists, 0, engine, [], names)
    forced = engine.memory.layout.leaf("Count").ident
    for scan in range(100, 160):
        if scan in (130, 140):
            engine.hold({(forced, 0): (None, 77)} if scan == 130 else {})
        engine.do(scan * 10_000_000, first=scan == 100)
        walk.note(scan)
        for name in names:
            if name in engine.tags:
                value = shown_value(value_of(engine.tags, name))
                assert lists.value_in(f"tags\n0\n{name}", scan) == value, (name, scan)
                assert type(lists.value_in(f"tags\n0\n{name}", scan)) is type(value), (name, scan)
                changes[name] += lists.list_of(f"tags\n0\n{name}")[0][-1] == scan
    assert changes.pop("Nothing") == 0
    assert not [name for name, count in changes.items() if count < 2]
