"""What `scanrack check` costs: 1,000 rungs in 2 s, 5,000 in proportion.

    python benchmarks/check.py [--rungs N] [--smoke]

A program of stations in a row, 20 rungs each: steps with comparisons and moves, timers, counters, latches,
arithmetic, a subroutine of structured text. Some stations have a mistake each; the check must find these and
nothing else. Times are processor time, the best of the rounds; loading and building the same program in the
same run is the measure beside it.

Exit status 1 if 1,000 rungs take longer than 2 s, if five times as many take more than eight times as long,
or if a check takes more than six times as long as loading.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from math import inf
from pathlib import Path
from time import process_time

from scanrack.jobs.check import check_rack, load_any

PER_STATION = 20
MOST_S, MOST_GROWTH, MOST_RATIO = 2.0, 8.0, 6.0
ROUNDS = 3

TAGS = """\
TAG Step{n} : DINT
TAG Wait{n} : TIMER
TAG Late{n} : TIMER
TAG Parts{n} : COUNTER
TAG Fault{n} : BOOL
TAG Run{n} : BOOL
TAG Edge{n} : BOOL
TAG Speed{n} : DINT := 100
TAG Mean{n} : REAL
TAG Valve{n} : BOOL
TAG Lamp{n} : BOOL
"""

STATION = """\
XIC(S:FS)MOV(0,Step{n});
[XIC(Start),XIC(Run{n})]XIC(StopOk)XIO(Fault{n})OTE(Run{n});
EQU(Step{n},0)XIC(Run{n})XIC(Part)MOV(10,Step{n});
EQU(Step{n},10)XIC(Clamped)MOV(20,Step{n});
EQU(Step{n},20)TON(Wait{n},500,0);
XIC(Wait{n}.DN)EQU(Step{n},20)MOV(30,Step{n});
EQU(Step{n},30)XIO(Part)MOV(0,Step{n});
GRT(Step{n},0)TON(Late{n},9000,0);
[XIC(Late{n}.DN),GRT(Speed{n},4000)]OTL(Fault{n});
XIC(Reset)XIO(Late{n}.DN)OTU(Fault{n});
LIM(10,Step{n},20)OTE(Valve{n});
EQU(Step{n},30)ONS(Edge{n})CTU(Parts{n},50,0);
XIC(Reset)RES(Parts{n});
XIC(Parts{n}.DN)OTE(Lamp{n});
XIC(Valve{n})[XIC(Part),XIO(Clamped)]ADD(Speed{n},1,Speed{n});
GRT(Speed{n},5000)MOV(100,Speed{n});
CPT(Mean{n},(Mean{n}*9.0+Speed{n})/10.0);
XIC(Lamp{n})XIO(Valve{n})GRT(Mean{n},10.0)OTE(Line.{bit});
EQU(Step{n},30)XIC(Fault{n})CLR(Parts{n}.ACC);
JSR(Count,1,Parts{n}.ACC,Speed{n});
"""

MISTAKES = (
    ("contradiction", "XIC(Valve{n})[XIC(Part)", "XIC(Valve{n})XIO(Valve{n})[XIC(Part)"),
    ("preset-zero", "TON(Late{n},9000,0)", "TON(Late{n},0,0)"),
    ("division-by-zero", "/10.0)", "/0.0)"),
    ("latch-never-cleared", "XIC(Reset)XIO(Late{n}.DN)OTU(Fault{n});", "XIC(Reset)NOP();"),
    ("constant-condition", "EQU(Step{n},30)ONS", "EQU(Step{n},33)ONS"),
    ("repeated-coil", "XIC(Parts{n}.DN)OTE(Lamp{n})", "XIC(Parts{n}.DN)OTE(Lamp{n})OTE(Valve{n})"),
    ("lossy-conversion", "MOV(100,Speed{n})", "MOV(2.5,Speed{n})"),
    ("shorted-branch", "[XIC(Part),XIO(Clamped)]", "[XIC(Part),XIO(Clamped),]"),
)
"""Rule, old and new text: one in each station from the second one on."""

HEAD = """\
PROGRAM line
ALIAS Start : Local:1:I.Data.0
ALIAS StopOk : Local:1:I.Data.1
ALIAS Part : Local:1:I.Data.2
ALIAS Clamped : Local:1:I.Data.3
ALIAS Reset : Local:1:I.Data.4
TAG Line : DINT
TAG Total : DINT
TAG Made : DINT
TAG I : DINT
TAG Store : DINT[8]
"""

TAIL = """\
NEQ(Line,0)GRT(Total,Store[0])OTE(Local:2:O.Data.0);
END
ROUTINE Count ST
SBR(Made);
Total := Total + Made;
FOR I := 0 TO 7 DO
    IF Store[I] < Total THEN Store[I] := Total; END_IF;
END_FOR;
RET(Made);
END
"""


def program(rungs: int) -> tuple[str, Counter[str]]:
    """Return a program of about so many rungs, and how often each rule finds something."""
    count = max(len(MISTAKES) + 1, rungs // PER_STATION)
    stations = []
    for number in range(count):
        text = STATION
        if 1 <= number <= len(MISTAKES):
            _, old, new = MISTAKES[number - 1]
            text = text.replace(old, new)
        stations.append(text.format(n=number, bit=number % 32))
    tags = "".join(TAGS.format(n=number) for number in range(count))
    repeated = max(0, count - 32)  # Line has 32 bits
    expected = Counter({rule: 1 for rule, _, _ in MISTAKES}) + Counter({"repeated-coil": repeated})
    return f"{HEAD}{tags}ROUTINE Main\n{''.join(stations)}{TAIL}", expected


def measure(rungs: int, rounds: int) -> tuple[float, float]:
    """Return the seconds of loading and of checking a program; assert what the check finds."""
    text, expected = program(rungs)
    load_s = check_s = inf
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "line.rung"
        file.write_text(text, encoding="utf-8")
        for _ in range(rounds):
            start = process_time()
            job, alone = load_any(str(file))
            loaded = process_time()
            report = check_rack(job, alone=alone)
            check_s = min(check_s, process_time() - loaded)
            load_s = min(load_s, loaded - start)
            found = Counter(each.rule for each in report.findings)
            assert found == expected, f"found {found}, expected {expected}"
    return load_s, check_s


def main() -> int:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rungs", type=int, default=1000)
    parser.add_argument("--smoke", action="store_true", help="few rungs, one round, no limits")
    given = parser.parse_args()
    rungs, rounds = (200, 1) if given.smoke else (given.rungs, ROUNDS)
    print("rungs   load s  check s  ratio")
    rows = [(count, *measure(count, rounds)) for count in (rungs, 5 * rungs)]
    for count, load_s, check_s in rows:
        print(f"{count:5}  {load_s:7.3f}  {check_s:7.3f}  {check_s / load_s:5.2f}")
    growth = rows[1][2] / rows[0][2]
    print(f"five times as many rungs take {growth:.1f} times as long")
    if given.smoke:
        return 0
    too_slow = rows[0][2] * 1000 / rungs > MOST_S or growth > MOST_GROWTH
    return int(too_slow or any(check_s / load_s > MOST_RATIO for _, load_s, check_s in rows))


if __name__ == "__main__":
    sys.exit(main())
