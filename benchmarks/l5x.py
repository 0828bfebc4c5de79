"""An exported controller: from XML to the first scan, compiled, and the memory that takes.

    python benchmarks/l5x.py            3,000 rungs and 25,000 tags
    python benchmarks/l5x.py --smoke    300 rungs and 1,000 tags: a short run that only checks
    python benchmarks/l5x.py --against FILE    a file against itself and an edited copy only

The floor is what lxml alone needs for the same bytes. CPU time of a process of its own each, since the
highest memory of a process never falls. Checked: all rungs are imported, and the trial shows no difference.
A comparison is measured against lxml's parsing and writing of the same file, in one process.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from bars import Bars
from ladder_machine import highest_mib
from lxml import etree
from scanrack.rockwell.diff import compare_exports
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.trial import run_trial

RUNG_BAR_MS = 0.6
MEMORY_BAR_MIB = 200
COMPARISON_BAR = 1.6
DENSE_BAR = 4
"""Of comparing the document below, whose thousands of small tags and routines are elements to compare."""
PER_ROUTINE = 50

HEAD = """<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<RSLogix5000Content SchemaRevision="1.0" SoftwareRevision="32.02" TargetType="Controller">
<Controller Use="Target" Name="Plant"><DataTypes>
<DataType Name="Recipe" Family="NoFamily" Class="User"><Members>
<Member Name="ZZ0" DataType="SINT" Dimension="0" Hidden="true"/>
<Member Name="On" DataType="BIT" Dimension="0" Hidden="false" Target="ZZ0" BitNumber="0"/>
<Member Name="Speed" DataType="REAL" Dimension="0" Hidden="false"/>
<Member Name="Steps" DataType="DINT" Dimension="3" Hidden="false"/>
</Members></DataType></DataTypes><Tags>
"""
VALUES = {
    "BOOL": '<DataValue DataType="BOOL" Radix="Decimal" Value="0"/>',
    "DINT": '<DataValue DataType="DINT" Radix="Decimal" Value="7"/>',
    "TIMER": """<Structure DataType="TIMER">
<DataValueMember Name="PRE" DataType="DINT" Radix="Decimal" Value="5000"/>
<DataValueMember Name="ACC" DataType="DINT" Radix="Decimal" Value="0"/>
<DataValueMember Name="EN" DataType="BOOL" Value="0"/>
<DataValueMember Name="TT" DataType="BOOL" Value="0"/>
<DataValueMember Name="DN" DataType="BOOL" Value="0"/>
</Structure>""",
    "Recipe": """<Structure DataType="Recipe">
<DataValueMember Name="On" DataType="BOOL" Value="1"/>
<DataValueMember Name="Speed" DataType="REAL" Radix="Float" Value="1.5e+001"/>
<ArrayMember Name="Steps" DataType="DINT" Dimensions="3"><Element Index="[0]" Value="1"/>
<Element Index="[1]" Value="2"/><Element Index="[2]" Value="5"/></ArrayMember>
</Structure>""",
}
SHARES = {"BOOL": 6, "DINT": 2, "TIMER": 1, "Recipe": 1}
"""Tags of each type among ten."""

RUNGS = (
    "[XIC({BOOL}),XIC({BOOL})XIO({BOOL})]XIO({BOOL})OTE({BOOL});",
    "XIC({BOOL})TON({TIMER},?,?)XIC({TIMER}.DN)OTL({BOOL});",
    "XIC({BOOL})ONS({BOOL})ADD({DINT},1,{DINT})[GRT({DINT},100)MOV(0,{DINT}),LES({DINT},5)OTE({BOOL})];",
    "XIC({Recipe}.On)MOV({Recipe}.Steps[2],{DINT})OTE({Recipe}.On);",
    "XIC({DINT}.7)XIO({TIMER}.TT)CPT({DINT},({DINT}+{DINT})/2)OTU({BOOL});",
    "EQU({DINT},3)XIC({BOOL})[OTE({BOOL}),RES({TIMER})];",
)


class Names(dict[str, str]):
    """A tag of a type, drawn again at each use."""

    def __init__(self, tags: int, seed: int) -> None:
        self._draw = random.Random(seed)
        self._counts = {kind: max(1, tags * share // 10) for kind, share in SHARES.items()}

    def __missing__(self, kind: str) -> str:
        return f"{kind}_{self._draw.randrange(self._counts[kind])}"

    def all(self) -> Iterator[tuple[str, str]]:
        """Yield names and types."""
        for kind, count in self._counts.items():
            yield from ((f"{kind}_{number}", kind) for number in range(count))


def document(rungs: int, tags: int) -> str:
    """Return an export of so many rungs and tags."""
    names = Names(tags, seed=1)
    parts = [HEAD]
    for name, kind in names.all():
        said = f"<Description>\n<![CDATA[{name} of the plant]]>\n</Description>"
        data = f'<Data Format="Decorated">\n{VALUES[kind]}\n</Data>'
        parts.append(f'<Tag Name="{name}" TagType="Base" DataType="{kind}">\n{said}\n{data}\n</Tag>\n')
    parts.append('</Tags><Programs><Program Name="P" MainRoutineName="Main"><Routines>\n')
    count = -(-rungs // PER_ROUTINE)
    parts += routine("Main", [f"JSR(R{number},0);" for number in range(count)])
    for number in range(count):
        chosen = [RUNGS[at % len(RUNGS)].format_map(names) for at in range(PER_ROUTINE)]
        parts += routine(f"R{number}", chosen)
    parts.append("</Routines></Program></Programs></Controller></RSLogix5000Content>\n")
    return "".join(parts)


def routine(name: str, rungs: list[str]) -> Iterator[str]:
    """Yield a routine as an export prints it."""
    yield f'<Routine Name="{name}" Type="RLL">\n<RLLContent>\n'
    for number, text in enumerate(rungs):
        said = f"<Comment>\n<![CDATA[rung {number} of {name}]]>\n</Comment>"
        yield f'<Rung Number="{number}" Type="N">\n{said}\n<Text>\n<![CDATA[{text}]]>\n</Text>\n</Rung>\n'
    yield "</RLLContent>\n</Routine>\n"


def measure(path: str, *, floor: bool) -> None:
    """Print rungs, CPU seconds and the highest memory of this process."""
    count, start = 0, time.process_time()
    if floor:
        etree.fromstring(Path(path).read_bytes())
    else:
        imported = import_l5x(path)
        assert imported.report.complete
        assert imported.controller is not None
        imported.controller.step()
        count = imported.report.rungs
    taken = time.process_time() - start
    print(json.dumps([count, taken, highest_mib()]))


def measured(path: Path, mode: str) -> tuple[int, float, float]:
    """Return what `measure` prints in a process of its own."""
    words = [sys.executable, __file__, mode, str(path)]
    count, taken, highest = json.loads(
        subprocess.run(words, capture_output=True, text=True, check=True, encoding="utf-8").stdout
    )
    return count, taken, highest


def seconds(call: Callable[[], object]) -> float:
    """Return the least processor time of some calls."""
    least = float("inf")
    for _ in range(7):
        start = time.process_time()
        call()
        least = min(least, time.process_time() - start)
    return least


def compare(path: Path, bars: Bars, most: float = COMPARISON_BAR) -> None:
    """Print the times of comparing a file with itself and an edited copy, by lxml's parsing and writing."""
    data = path.read_bytes()
    copy = path.with_name("edited.L5X")
    edited = re.sub(rb"XIC\(", b"XIO(", data, count=1)
    copy.write_bytes(re.sub(rb'Value="\d+"', b'Value="99"', edited, count=1))
    once = seconds(lambda: etree.tostring(etree.fromstring(data)))
    for name, new, least in (("itself", path, 0), ("an edited copy", copy, 2)):
        found = compare_exports(path, new)
        assert len(found.differences) == least, found.summary
        ratio = seconds(partial(compare_exports, path, new)) / once
        bar = bars.most(f"times lxml against {name}", ratio, most)
        print(f"{len(data):,} bytes against {name}: {ratio:.2f} times lxml's parsing and writing ({bar})")
    copy.unlink()


def main() -> int:
    """Measure, print, and say whether the bars hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    parser.add_argument("--measure", metavar="FILE", help="import a file; print rungs, CPU s and MiB")
    parser.add_argument("--floor", metavar="FILE", help="parse a file only; print the same")
    parser.add_argument("--against", metavar="FILE", help="compare a file with itself and an edited copy")
    given = parser.parse_args()
    if given.measure or given.floor:
        measure(given.measure or given.floor, floor=bool(given.floor))
        return 0
    bars = Bars(count=not given.smoke)
    if given.against:
        with tempfile.TemporaryDirectory() as folder:
            compare(Path(shutil.copy(given.against, folder)), bars)
        return bars.status()
    rungs, tags = (300, 1_000) if given.smoke else (3_000, 25_000)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "machine.L5X"
        path.write_text(document(rungs, rungs), encoding="utf-8")
        count, taken, _ = measured(path, "--measure")
        _, least, _ = measured(path, "--floor")
        rung_ms, alone_ms = (1e3 * each / count for each in (taken, least))
        print(f"{count:,} rungs, {rungs:,} tags: {rung_ms:.2f} ms a rung from XML to first scan ", end="")
        print(f"({bars.most('ms a rung', rung_ms, RUNG_BAR_MS)}), lxml alone {alone_ms:.3f}")
        trial = import_l5x(path, trial=True)
        run_trial(trial, scans=3)
        assert trial.report.ran == count, trial.report.faults
        compare(path, bars, DENSE_BAR)
        path.write_text(document(rungs // 3, tags), encoding="utf-8")
        _, _, highest = measured(path, "--measure")
        _, _, lowest = measured(path, "--floor")
        bar = bars.most("MiB", highest, MEMORY_BAR_MIB)
        print(f"{tags:,} tags: {highest:.0f} MiB in all ({bar}), lxml alone {lowest:.0f}")
    return bars.status()


if __name__ == "__main__":
    sys.exit(main())
