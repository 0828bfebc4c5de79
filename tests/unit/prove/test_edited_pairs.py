"""Whatever runs of two programs show, their comparison lists: for each instruction, and each kind of edit.

Pairs of programs that differ in one place, for each instruction, and random runs that tell them apart.

A pair has an instruction among a few rungs or statements. The edit is one of `EDITS`; `same` changes nothing
that any run could show. What a run of both compiled programs shows, `scanrack prove OLD NEW` has to list.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random
from typing import Any

import pytest
from relation import random_value, same
from relation_programs import HEAD, TAGS
from relation_rows import (
    BLOCKS,
    DATA,
    GUARD,
    HAVOCKED,
    MORE_TAGS,
    ROUTINES,
    ROWS,
    SLC_HAVOCKED,
    SLC_OUT,
    SLC_ROWS,
)
from scanrack.ladder.files import parse_program
from scanrack.ladder.instructions import NAMES, SPECS
from scanrack.ladder.instructions.slc.rows import SLC_SPECS
from scanrack.ladder.model.errors import LadderError, LadderFault
from scanrack.ladder.model.predefined.block_types import BLOCKS as BLOCK_TYPES
from scanrack.ladder.model.predefined.process_types import ARRAYS
from scanrack.ladder.model.spec import Use
from scanrack.ladder.model.types import FBD_COUNTER, FBD_ONESHOT, FBD_TIMER
from scanrack.ladder.prove import ProgramSystem, ScanBounds
from scanrack.ladder.prove.difference import Difference, compared
from scanrack.ladder.prove.differing_runs import FAULT
from scanrack.ladder.prove.induction import Limits
from scanrack.ladder.prove.system import RUN_ONLY, shown
from slc_bench import imported

SYSTEM: dict[str, tuple[str, ...]] = {
    "SSV": ("XIC(B1)SSV(WallClockTime,,DateTime,Arr[0]);",),
    "MSG": ("XIC(B1)MSG(Mess);",),
    "HMIBC": ("HMIBC(Button);",),
    "EVENT": ("XIC(B1)EVENT(Late);",),
    "DCS": ("XIC(B1)DCS(Dci,SAFETY GATE,EQUIVALENT - ACTIVE HIGH,50,MANUAL,MANUAL,In1,In2,In3,In4);",),
    "CROUT": ("XIC(B1)CROUT(Cr,NEGATIVE,30,In1,In2,In3,In4,In2,In5);",),
}
"""Rungs of instructions that reach beyond the tags they name."""

_TYPES_OF_TIMERS = {
    **dict.fromkeys(("TONR", "TOFR", "RTOR"), FBD_TIMER),
    **dict.fromkeys(("OSRI", "OSFI"), FBD_ONESHOT),
    "CTUD": FBD_COUNTER,
}

PROCESS = [
    spec.name
    for spec in SPECS
    if spec.uses and spec.uses[0] is Use.BLOCK and spec.name not in BLOCKS and spec.name in BLOCK_TYPES
]
"""Function blocks beside those of `BLOCKS`."""

_UNPAIRED = (
    "SFR SFP EOT IOT ABL ACB ACL AHL ARD ARL AWA AWT PCMD PCLF PXRQ PRNP PPD PATT PDET PFL POVR",
    "SATT SDET SCMD SCLF SOVR SASI",
)
UNPAIRED = frozenset(" ".join(_UNPAIRED).split())
"""Instructions of charts, ports, phases and motion, which a program without these can't have."""

RUNGS = {**ROWS, **HAVOCKED, **SYSTEM}
EDITS = ("condition", "operand", "parameter", "destination", "task", "order", "same")
LIMITS = Limits(scans=3, k=1, work=40_000, fuse=4_000, helped=False)
SCANS, RUNS = 8, 3

_NUMBERED = re.compile(r"\b([SIDLRUFBTC])([0-2])\b")
_CONSTANT = re.compile(r"(?<=[,(<>=*+ ])(\d+)(?=[,)*+;])")


@dataclass
class Pair:
    """Two texts of a program, which edit they differ by, and the tags whose numbers are free."""

    name: str
    edit: str
    old: str
    new: str
    free: tuple[str, ...] = ()
    is_slc: bool = False

    def programs(self) -> tuple[Any, Any]:
        """Return both; a LadderError or an AssertionError for one that can't be built."""
        made = _slc if self.is_slc else parse_program
        old, new = made(self.old), made(self.new)
        old.build()
        new.build()
        return old, new


def names() -> list[str]:
    """Return what pairs are made of: instructions of rungs, blocks, and rows of an SLC, marked by `slc `."""
    return [*RUNGS, *BLOCKS, *PROCESS, *(f"slc {name}" for name in (*SLC_ROWS, *SLC_HAVOCKED))]


def pair_of(seed: int) -> Pair:
    """Return a pair of the next instruction with an edit that suits it."""
    rng, every = Random(seed), names()
    name, edit = every[seed % len(every)], EDITS[seed // len(every) % len(EDITS)]
    if name.startswith("slc "):
        return _pair_of_slc(name, edit if edit != "task" else "condition", rng)
    if name in RUNGS and name != "EVENT":
        return _pair_of_rungs(name, edit, rng)
    return _pair_of_tasks(name, "task", rng) if name == "EVENT" else _pair_of_blocks(name, edit, rng)


# --- edits of a text


def _sibling(text: str, rng: Random, *, last: bool) -> str:
    """Name another tag of the same type in one place of a text, by default in any place."""
    places = list(_NUMBERED.finditer(text))
    if not places:
        return text
    found = places[-1] if last else rng.choice(places)
    most = 2 if found[1] == "C" else 3
    return f"{text[: found.start()]}{found[1]}{(int(found[2]) + 1) % most}{text[found.end() :]}"


def _other_constant(text: str, rng: Random) -> str:
    places = list(_CONSTANT.finditer(text))
    if not places:
        return text
    found = rng.choice(places)
    return f"{text[: found.start()]}{int(found[1]) + rng.choice((1, 2))}{text[found.end() :]}"


def _edited(edit: str, text: str, rng: Random) -> str:
    """Return a rung with an edit of its own text; unchanged if the edit is none of these."""
    if edit == "condition":
        if text.startswith("XIC(B1)"):
            return "XIO" + text[3:]
        return text.replace("XIC(In0)", "XIO(In0)", 1)
    if edit in ("operand", "destination"):
        return _sibling(text, rng, last=edit == "destination")
    return _other_constant(text, rng) if edit == "parameter" else text


def _free_in(text: str, rng: Random) -> tuple[str, ...]:
    found = sorted({each[0] for each in _NUMBERED.finditer(text) if each[1] in "SIDLRUF"})
    return tuple(rng.sample(found, min(len(found), 2)))


# --- programs


_OWN_TAGS = (
    *(f"In{at} : BOOL" for at in range(6)),
    *("Count : DINT", "Extra : BOOL", "Mess : MESSAGE", "Button : HMIBC"),
    *("Dci : DCI_STOP", "Cr : CONFIGURABLE_ROUT"),
)


def _tags(initials: dict[str, str]) -> str:
    lines = []
    for each in (*TAGS, *MORE_TAGS, *_OWN_TAGS):
        name = each.partition(" ")[0]
        initial = initials.get(name)
        lines.append(f"TAG {each}" + (f" := {initial}" if initial else ""))
    return "\n".join([*lines, f"STUB MSG : done after {initials.get('MSG', '20')} ms"])


_LENGTHS = {"K": '{"LEN": 3}', "K2": '{"LEN": 3}'}


def _pair_of_rungs(name: str, edit: str, rng: Random) -> Pair:
    text = rng.choice(RUNGS[name])
    first, *rest = text.split("\n")
    if not first.startswith(("XIC(B1)", "XIC(B")) and not first.startswith("LBL") and rng.random() < 0.7:
        first = f"XIC(In0){first}"
    elif edit == "condition" and not first.startswith("XIC(B1)"):
        first = f"XIC(In0){first}" if not first.startswith("LBL") else first
    free = _free_in(text, rng)
    source = next((each[0] for each in _NUMBERED.finditer(text) if each[1] in "DILSRUF"), "D1")
    feed, other = f"XIC(In2)MOV(Count,{source});", "XIC(In3)MOV(Count,D2);"
    before = [GUARD, "XIC(In1)ADD(Count,1,Count);", feed]
    old, new = [*before, first, *rest, other], [*before, _edited(edit, first, rng), *rest, other]
    initials = dict(_LENGTHS), dict(_LENGTHS)
    if edit == "order":
        new = [*before[:2], first, *rest, feed, other]
    if edit == "same":
        new = ["NOP();", *before, first, *rest, "XIC(In4)XIO(In4)OTL(Extra);", other]
    if edit == "parameter" and (old == new or rng.random() < 0.5):
        new = old
        initials[1].update({"K": '{"LEN": 2}', source.partition("[")[0]: "3", "Pd": '{"KP": 2.0}'})
        initials[1].update({"Al": '{"Severity": 7}', "Aa": '{"HLimit": 5.0}', "C0": '{"PRE": 5}'})
        initials[1].update({"T0": '{"PRE": 70}', "Arr": "[1,2,3,4,5,6]", "W": '"ab"', "MSG": "40"})
    if edit == "task":
        return Pair(name, edit, _in_tasks(old, initials[0], 10), _in_tasks(new, initials[0], 20), free)
    texts = [_program(each, given) for each, given in zip((old, new), initials, strict=True)]
    return Pair(name, edit, texts[0], texts[1], free)


def _program(rungs: list[str], initials: dict[str, str], *, statements: bool = False) -> str:
    main = "ROUTINE Main ST" if statements else "ROUTINE Main"
    return "\n".join([HEAD + _tags(initials), main, *rungs, "END", ROUTINES])


def _in_tasks(rungs: list[str], initials: dict[str, str], ms: int, *, statements: bool = False) -> str:
    """Return a controller with rungs or statements in a periodic task, and others in a continuous one."""
    head = HEAD.replace("PROGRAM drawn", "CONTROLLER drawn")
    kind = " ST" if statements else ""
    lines = [head, _tags(initials), "TASK Idle : CONTINUOUS RUNS Rest"]
    lines += [f"TASK Quick : PERIODIC {ms} ms PRIORITY 3 RUNS Work", "PROGRAM Rest", "ROUTINE R"]
    lines += ["XIC(In5)ADD(D2,1,D2);", "END", "END PROGRAM"]
    lines += ["PROGRAM Work", f"ROUTINE Main{kind}", *rungs, "END", ROUTINES, "END PROGRAM", ""]
    return "\n".join(lines)


def _pair_of_tasks(name: str, edit: str, rng: Random) -> Pair:
    """Return a pair with an event task, which EVENT triggers or not."""
    texts = []
    for contact in ("XIC", rng.choice(("XIO", "XIC(In1)XIC"))):
        lines = ["CONTROLLER events", *(f"TAG {each}" for each in _OWN_TAGS), "TAG Done : DINT"]
        lines += [
            "TASK Idle : CONTINUOUS RUNS Rest",
            "TASK Late : EVENT PRIORITY 5 RUNS Work",
            "PROGRAM Rest",
        ]
        lines += [
            "ROUTINE R",
            f"{contact}(In0)EVENT(Late);",
            "XIC(In2)ADD(Count,1,Count);",
            "END",
            "END PROGRAM",
        ]
        lines += ["PROGRAM Work", "ROUTINE W", "ADD(Done,1,Done);", "END", "END PROGRAM", ""]
        texts.append("\n".join(lines))
    return Pair(name, edit, texts[0], texts[1])


def _pair_of_blocks(name: str, edit: str, rng: Random) -> Pair:
    kind: Any = _TYPES_OF_TIMERS.get(name) or BLOCK_TYPES[name]
    arrays = "".join(f",Rs[{at}]" for at, _ in enumerate(ARRAYS.get(name, ())))
    members = [*kind.members]
    reals = [each.name for each in members if each.type.is_real]
    bits = [each.name for each in members if each.type.is_bool and each.name not in ("EnableIn", "EnableOut")]
    own, calls = "Blk", f"{name}(Blk{arrays});"
    feeds = [f"Blk.{rng.choice(reals)} := R0;"] if reals else []
    feeds += [f"Blk.{rng.choice(bits)} := In1;"] if bits else []
    reads = [f"R1 := Blk.{rng.choice(reals)};"] if reals else []
    truth = rng.random() < 0.5

    def block(condition: str, call: str) -> list[str]:
        return [f"IF {condition} THEN", call, "END_IF;"] if truth or edit == "condition" else [call]

    count = ["IF In2 THEN Count := Count + 1; END_IF;"]
    old = [*count, *feeds, *block("In0", calls), *reads]
    new = list(old)
    values: tuple[dict[str, str], dict[str, str]] = ({own: ""}, {own: ""})
    if edit == "condition":
        new = [*count, *feeds, *block("NOT In0", calls), *reads]
    elif edit == "operand":
        new = [
            *count,
            *[each.replace("R0", "F0").replace("In1", "In3") for each in feeds],
            *old[len(feeds) + 1 :],
        ]
    elif edit == "order":
        new = [*count, *block("In0", calls), *feeds, *reads]
    elif edit == "same":
        new = ["Extra := In4 AND NOT In4;", *old]
        old = ["Extra := 0;", *old]
    elif edit == "destination":
        new = [each.replace("R1 :=", "R2 :=") for each in old]
    elif edit == "parameter":
        number = rng.choice([each for each in members if each.name not in ("EnableIn", "EnableOut")])
        values[1][own] = f'{{"{number.name}": {"true" if number.type.is_bool else 2}}}'
    texts: list[str] = []
    for lines, initials in ((old, values[0]), (new, values[1])):
        text = _program(lines, {}, statements=True)
        if edit == "task":
            text = _in_tasks(lines, {}, 10 if not texts else 20, statements=True)
        initial = f" := {initials[own]}" if initials[own] else ""
        texts.append(text.replace("TAG Count", f"TAG Blk : {kind.name}{initial}\nTAG Count", 1))
    return Pair(name, edit, texts[0], texts[1], ("R0", "F0") if rng.random() < 0.7 else ())


def _pair_of_slc(name: str, edit: str, rng: Random) -> Pair:
    row = name.removeprefix("slc ")
    text = rng.choice({**SLC_ROWS, **SLC_HAVOCKED}[row])
    first, *rest = text.split("\n")
    first = first if first.startswith("XIC") else f"XIC I:1/0 {first}"
    feed = "XIC I:1/1 ADD N7:1 1 N7:1"
    old = [feed, first, *rest, "OTU S:5/0"]
    new = list(old)
    if edit == "condition":
        new[1] = "XIO" + first[3:]
    elif edit in ("operand", "destination"):
        places = list(re.finditer(r"\b([NFL]\d+):(\d)\b", first))
        if places:
            found = places[-1] if edit == "destination" else rng.choice(places)
            number = (int(found[2]) + 1) % 3
            new[1] = f"{first[: found.start()]}{found[1]}:{number}{first[found.end() :]}"
    elif edit == "parameter":
        new[1] = re.sub(r"(?<= )(\d+)(?= |$)", lambda each: str(int(each[1]) + 1), first, count=1)
    elif edit == "order":
        new = [first, *rest, feed, "OTU S:5/0"]
    elif edit == "same":
        new = ["XIC I:1/2 XIO I:1/2 OTL B3:3/3", *old]
    return Pair(name, edit, "\n".join(old), "\n".join(new), is_slc=True)


def _slc(text: str) -> Any:
    found = imported(*text.splitlines(), data=DATA)
    if found.report.refused:
        raise LadderError(str(found.report.refused[0]))
    return found.program


# --- runs


@dataclass
class Judged:
    """What became of pairs."""

    count: Counter[str] = field(default_factory=Counter)
    false: list[str] = field(default_factory=list)

    def judge(self, seed: int) -> None:
        """Compare a pair, run both programs, and note what a run shows and the comparison does not."""
        pair = pair_of(seed)
        try:
            programs = pair.programs()
        except (LadderError, AssertionError):
            self.count["not built"] += 1
            return
        bounds = ScanBounds(1, 100)
        given: dict[str, Any] = {"free": pair.free, "happens": RUN_ONLY}
        old = ProgramSystem(programs[0], bounds, **given)
        new = ProgramSystem(programs[1], bounds, **given, beside=old)
        found = compared(old, new, LIMITS, 400_000)
        named = {each.name for each in found.changed}
        self.count["pairs"] += 1
        self.count[f"{pair.edit} listed"] += bool(named or found.fault)
        self.count[f"{pair.edit} equal"] += not (named or found.fault or found.unfollowed)
        shows = seen_in_runs(programs, shared_inputs(old, new), Random(seed))
        self.count[f"{pair.edit} shown by a run"] += bool(shows)
        missed = {each for each in shows if not _is_listed(each, named, found)}
        if missed:
            self.false.append(f"{seed} {pair.name} {pair.edit}: {sorted(missed)[:3]}")


def _is_listed(place: str, named: set[str], found: Difference) -> bool:
    if place == FAULT[0]:
        return found.fault is not None
    return place in named or place.partition("[")[0] in found.uncompared


def shared_inputs(old: ProgramSystem, new: ProgramSystem) -> list[tuple[str, int]]:
    """Return the values that are free in both systems from the first scan on."""
    found = []
    for name, key in old.key_of.items():
        free = all(
            each.role(name) == "free" and name not in each.late and name in each.key_of for each in (old, new)
        )
        if free and not key[0].startswith(("~", "S:")) and key[0] != "S":
            found.append(key)
    return sorted(found)


def seen_in_runs(programs: tuple[Any, Any], inputs: list[tuple[str, int]], rng: Random) -> set[str]:
    """Return what differs after a scan of random runs: values, and whether a major fault has stopped one."""
    found: set[str] = set()
    for _ in range(RUNS):
        engines = [each.compile() for each in programs]
        begun = dict(_unlike(engines))
        for number in range(SCANS):
            for path, index in inputs:
                if number and rng.random() < 0.5:
                    continue
                value = random_value(engines[0].lowered.layout.leaf(path), rng)
                for each in engines:
                    each.memory.write(each.lowered.layout.leaf(path), index, value)
            ms, stopped = rng.choice((1, 5, 10, 20, 60, 100)), []
            for each in engines:
                try:
                    each.step(ms)
                    stopped.append(False)
                except LadderFault:
                    stopped.append(True)
            found |= {name for name, values in _unlike(engines) if begun.get(name) != values}
            found |= {FAULT[0]} if stopped[0] is not stopped[1] else set()
            if any(stopped):
                break
    return found


def _unlike(engines: list[Any]) -> Iterator[tuple[str, str]]:
    """Yield what differs now, with both values; what only begins with another value is no difference."""
    layouts = [each.lowered.layout for each in engines]
    for path, leaf in layouts[0].leaves.items():
        other = layouts[1].find(path)
        if path.startswith(("~", "S:")) or ".~" in path or path == "S" or other is None:
            continue
        for at in range(min(leaf.size, other.size)):
            one, two = engines[0].memory.read(leaf, at), engines[1].memory.read(other, at)
            if not same(one, two):
                yield shown(f"{path}[{at}]"), repr((one, two))


pytestmark = pytest.mark.extra("prove")

MOTION = {spec.name for spec in SPECS if "motion" in spec.run.__module__}
PAIRS, SAMPLE = 2000, 160


def test_every_instruction_has_pairs() -> None:
    """Who adds an instruction gives it a text, or says here why no pair has it."""
    assert set(NAMES) - MOTION == {*RUNGS, *BLOCKS, *PROCESS, *UNPAIRED}
    own = {name for name, spec in SLC_SPECS.items() if spec not in SPECS}
    assert own - {*SLC_ROWS, *SLC_HAVOCKED} == SLC_OUT


def judged(seeds: range) -> Judged:
    found = Judged()
    for seed in seeds:
        found.judge(seed)
    return found


@pytest.mark.parametrize(
    ("name", "edit"), [("XIC", "operand"), ("TOD", "condition"), ("DEG", "order"), ("BTDT", "same")]
)
def test_some_pairs_are_not_called_equal_where_a_run_differs(name: str, edit: str) -> None:
    place = names().index(name) + len(names()) * EDITS.index(edit)
    found = judged(range(place, place + 1))
    assert found.false == []
    assert found.count[f"{edit} equal"] == (edit == "same")


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_no_pair_of_a_sample_is_called_equal_where_a_run_differs(part: int) -> None:
    sound_and_useful(range(part, PAIRS, 4 * PAIRS // SAMPLE))


@pytest.mark.long
@pytest.mark.parametrize("part", range(20))
def test_no_pair_is_called_equal_where_a_run_differs(part: int) -> None:
    sound_and_useful(range(part, PAIRS, 20))


def sound_and_useful(seeds: range) -> None:
    """Assert that no pair is called equal wrongly, and that most edits without an effect are called equal."""
    found = judged(seeds)
    count = found.count
    assert found.false == []
    assert count["pairs"] > 0.9 * len(seeds)
    assert sum(count[f"{each} shown by a run"] for each in EDITS[:-1]) > 0.25 * count["pairs"]
    alike = count["same equal"], count["same listed"]
    assert alike[0] > 0.8 * sum(alike)
