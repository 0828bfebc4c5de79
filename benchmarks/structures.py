"""Structures and strings as a whole: copies, fills, string instructions, add-ons that take structures.

    python benchmarks/structures.py            ns of each instruction, beside a copy of as many bytes of DINTs
    python benchmarks/structures.py --smoke    a short run that only checks

The floor of every row is COP of an array of DINT to another: what a copy of numbers costs in the same run. A
structure has 300 members in 1,248 bytes; four of them, 59 STRINGs and 1,300 DINTs have about 5.2 kB each.

Checked: compiled and interpreted have the same memory after scans of all these instructions.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable

from scanrack.ladder.files.rungfile import parse_program

from ladder import TIMED_OUT_NS, per_call

PERIOD_MS = 10
REPEATS = 200
MEASURED_S = 0.05

UNIT = ", ".join(
    [
        *(f"Flag{number} : BOOL" for number in range(40)),
        *(f"Count{number} : DINT" for number in range(140)),
        *(f"Level{number} : REAL" for number in range(119)),
        "Label : STRING, Delay : TIMER, Codes : INT[30], Marks : SINT[40]",
    ]
)
HEAD = f"""PROGRAM structures
TYPE Unit ({UNIT})
TYPE Small (Run : BOOL, Stop : BOOL, Level : REAL, Parts : DINT, Total : DINT, Word : INT, Mode : INT)
INSTRUCTION Drive
INPUT Go : BOOL REQUIRED
INOUT Item : Unit
INOUT Title : STRING
LOCAL Kept : Unit
ROUTINE Logic
COP(Item,Kept,1);
MOV(Kept.Label,Title);
XIC(Go)ADD(Item.Count0,1,Item.Count0);
END
END INSTRUCTION
TAG Numbers : DINT[1300]
TAG Others : DINT[1300]
TAG Units : Unit[8]
TAG Unit0 : Unit
TAG Small0 : Small
TAG Small1 : Small
TAG Names : STRING[60]
TAG Name : STRING := "Station 12"
TAG Text : STRING
TAG Raw : SINT[88]
TAG Drive0 : Drive
TAG Drives : Drive[4]
TAG I : DINT := 3
TAG N : DINT := 4
TAG At : DINT
TAG Level : REAL := 1.5
TAG Same : BOOL
"""

FLOOR = "COP(Numbers[0],Others[0],1300);"

ROWS = (
    ("COP of 4 structures, 5.2 kB", "COP(Units[0],Units[4],4);"),
    ("COP of 59 strings, 5.2 kB", "COP(Names[0],Names[1],59);"),
    ("COP of DINTs to 4 structures", "COP(Numbers[0],Units[4],4);"),
    ("CPS of a structure of 300", "CPS(Unit0,Units[2],1);"),
    ("COP of an element by subscript", "COP(Units[I],Unit0,1);"),
    ("COP of N elements by subscript", "COP(Units[0],Units[I],N);"),
    ("COP of a small structure", "COP(Small0,Small1,1);"),
    ("FLL of 4 structures with 0", "FLL(0,Units[4],4);"),
    ("FLL of 4 structures with 7", "FLL(7,Units[4],4);"),
    ("MOV of a string", "MOV(Name,Names[I]);"),
    ("COP of a string to SINTs", "COP(Name,Raw[0],88);"),
    ("EQU of strings", "EQU(Name,Names[I])OTE(Same);"),
    ("CONCAT", "CONCAT(Name,'-x',Text);"),
    ("MID", "MID(Name,2,N,Text);"),
    ("FIND", "FIND(Name,'12',1,At);"),
    ("INSERT", "INSERT(Name,'new',N,Text);"),
    ("DELETE", "DELETE(Name,2,N,Text);"),
    ("UPPER", "UPPER(Name,Text);"),
    ("DTOS", "DTOS(At,Text);"),
    ("RTOS", "RTOS(Level,Text);"),
    ("STOD", "STOD(Name,At);"),
    ("add-on: a structure and a string", "Drive(Drive0,1,Unit0,Text);"),
    ("add-on: elements by subscript", "Drive(Drives[1],1,Units[I],Names[I]);"),
    ("XIC and OTE of members", "XIC(Unit0.Flag3)OTE(Units[1].Flag9);"),
    ("ADD of members", "ADD(Units[I].Count5,1,Unit0.Count7);"),
)
"""Each instruction by its name; what makes its tags bytes is in the other routine, which does not run."""

KEPT = ("COP(Units[0],Units[1],1);", "COP(Unit0,Units[0],1);", "COP(Names[0],Names[1],1);")


def program(lines: Iterable[str]) -> str:
    """Return the text of a program of these rungs."""
    return "\n".join([HEAD, "ROUTINE Main", *lines, "END", "ROUTINE Rest", *KEPT, "END", ""])


def check() -> None:
    """Run all instructions in both back ends."""
    built = parse_program(program([FLOOR, *(line for _, line in ROWS)]))
    compiled, interpreted = built.compile(), built.interpret()
    for number in range(3):
        for engine in (compiled, interpreted):
            engine.tags["Numbers"] = [number * each for each in range(1300)]
            engine.tags["Unit0.Label"] = f"unit {number}"
            engine.step(PERIOD_MS)
        assert compiled.memory.snapshot() == interpreted.memory.snapshot()
    assert compiled.minor_faults == interpreted.minor_faults
    assert bytes(compiled.tags["Raw"]).rstrip(b"\0") == b"\x0a\0\0\0Station 12"
    assert (compiled.tags["Units[7].Count139"], compiled.tags["Units[7].Level0"]) == (7, 7.0)


def cost_ns(line: str, seconds: float) -> float:
    """Return ns per rung of a program that repeats it."""
    engine = parse_program(program([line] * REPEATS)).compile()
    engine.step(PERIOD_MS)
    scan = engine._scan
    return (per_call(lambda: scan(TIMED_OUT_NS), seconds) - per_call(lambda: None, seconds)) / REPEATS * 1e9


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    given = parser.parse_args()
    check()
    if given.smoke:
        return
    floor = cost_ns(FLOOR, MEASURED_S)
    print(f"{'floor: COP of 1,300 DINTs':36} {floor:8.0f} ns")
    for name, line in ROWS:
        taken = cost_ns(line, MEASURED_S)
        print(f"{name:36} {taken:8.0f} ns, {taken / floor:6.3f} x the floor")


if __name__ == "__main__":
    main()
