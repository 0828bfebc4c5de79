"""Proofs: machines of 50 to 3,000 rungs, four presses, an edit, random programs; random scans attack proofs.

    python benchmarks/prove.py              all of it: some minutes
    python benchmarks/prove.py --smoke      the small ones: a short run that only checks
    python benchmarks/prove.py --only presses edit
    python benchmarks/prove.py --only attack --scans 1000000

Checked: every verdict is the known one; every refutation has run on the compiled program; no random scan
breaks a proof; a dropped contact is named; equal programs are; two runs say the same; z3 and cvc5 confirm
each proof; 2,000 proofs in one process stay small. It ends with a row for each part; the status is 1 if one
of them misses its bar.

Times are CPU seconds of this process, and as many compiled scans of the same machine as fit into them: the
ratio does not depend on the computer.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

import against
from bars import highest_mib
from proofs import LIMITS, Proofs, claims, program_text
from scanrack.jobs.prove.checking import Opinion, Solver, check, solvers
from scanrack.ladder.files.rungfile import parse_program
from scanrack.ladder.lowering.runnable import LadderLogic
from scanrack.ladder.prove.certificate import written
from scanrack.ladder.prove.difference import Difference, compare
from scanrack.ladder.prove.differing_runs import random_runs
from scanrack.ladder.prove.induction import Limits, Verdict, VerdictKind, prove
from scanrack.ladder.prove.monitors import WatchedClaim, monitored
from scanrack.ladder.prove.questions import Answers, ask
from scanrack.ladder.prove.system import ProgramSystem, ScanBounds

TIMES = {"translation": 2.0, "median property": 1.0, "dead rungs": 15.0, "presses": 2.0, "edit": 2.0}
"""Bars, seconds."""

COILS = ("FWD", "REV", "FAULT", "LAMP")

DECIDED = 0.93
"""Share of the coils whose "never on?" is decided in 5 s each."""

COIL_LIMITS = Limits(scans=8, k=2, fuse=64_000)


def spent(run: Callable[[], object]) -> tuple[float, object]:
    """Return CPU seconds and the result."""
    begin = time.process_time()
    result = run()
    return time.process_time() - begin, result


def said(name: str, seconds: float, what: str, scan: float = 0.0) -> None:
    """Print a line, with the bar if there is one."""
    bar = f", bar {TIMES[name]:g} s" if name in TIMES else ""
    scans = f" = {seconds / scans_of(scan):,.0f} compiled scans" if scan else ""
    print(f"{name:>16}: {seconds:8.3f} s{bar}{scans}; {what}", flush=True)


def scans_of(scan: float) -> float:
    """Return a divisor that is never 0."""
    return max(scan, 1e-9)


# --- machines


def machine(rungs: int, timers: int, changed: str = "") -> str:
    """Return motors with interlocks, dwell, faults, counters; every seventh rung uses numbers.

    Args:
        rungs: about how many.
        timers: how many.
        changed: a contact of the middle motor that is left out.
    """
    rng = Random(1)
    motors = max(1, rungs // 7)
    tags, lines = [], []
    for n in range(motors):
        tags += [f"TAG {x}{n} : BOOL" for x in ("Start", "Stop", "Fwd", "Rev", "Fault", "Ack", "Lamp")]
        tags.append(f"TAG N{n} : DINT")
        timer, other = n * timers // motors, rng.randrange(motors)
        lines += [
            f"[XIC(Start{n}),XIC(Fwd{n})]XIO(Rev{n})XIO(Stop{n})XIO(Fault{n})OTE(Fwd{n});",
            f"[XIC(Start{other}),XIC(Rev{n})]XIO(Fwd{n})XIO(Stop{n})XIO(Fault{n})OTE(Rev{n});",
            f"XIC(T{timer}.DN)XIC(Fwd{n})OTL(Fault{n});",
            f"XIC(Ack{n})XIO(Fwd{n})OTU(Fault{n});",
            f"XIC(Fault{n})EQU(N{n},3)OTE(Lamp{n});",
            f"XIC(Start{n})LES(N{n},10)ADD(N{n},1,N{n});",
            f"GEQ(N{n},10)MOV(0,N{n});",
        ]
        if n < timers:
            tags.append(f"TAG T{n} : TIMER")
            lines.append(f"[XIC(Fwd{n}),XIC(Rev{other})]TON(T{n},{rng.choice((500, 2000, 5000))},0);")
    a = motors // 2
    never = [
        f"XIC(Fwd{a})XIC(Rev{a})NOP();",
        f"GRT(N{a},10)NOP();",
        f"XIC(T{min(a, timers - 1)}.DN)XIC(T{min(a, timers - 1)}.TT)NOP();",
        f"XIC(Fault{a})NOP();",
        f"XIC(Fault{a})XIC(Lamp{a})EQU(N{a},4)NOP();",
    ]
    if changed:
        at = next(number for number, line in enumerate(lines) if line.startswith(f"[XIC(Start{a})"))
        lines[at] = lines[at].replace(changed + f"{a})", "", 1)
    parts = ["PROGRAM machine", "ALLOW repeated coils", *tags, "ROUTINE Main", *lines, "END"]
    return "\n".join([*parts, "ROUTINE NEVER", *never, "END", ""])


WANTED = [
    VerdictKind.PROVED,
    VerdictKind.PROVED,
    VerdictKind.PROVED,
    VerdictKind.REFUTED,
    VerdictKind.REFUTED,
]


def scan_seconds(program: LadderLogic, scans: int = 50) -> float:
    """Return CPU seconds of a compiled scan."""
    engine = program.compile()
    engine.step()
    begin = time.process_time()
    for _ in range(scans):
        engine.step()
    return (time.process_time() - begin) / scans


def machines(smoke: bool) -> None:
    """Translate machines and ask for properties and dead rungs."""
    for rungs, timers in ((50, 5),) if smoke else ((50, 5), (700, 50), (3000, 200)):
        program = parse_program(machine(rungs, timers))
        scan = scan_seconds(program)
        checked = monitored(program)
        count = sum(len(each.lines) for each in program.build().routines.values())
        seconds, problem = spent(lambda: ProgramSystem(checked.program))  # noqa: B023
        assert isinstance(problem, ProgramSystem)
        said("translation", seconds, f"{count} rungs", scan)
        found, times = [], []
        for watched in checked.properties:
            seconds, verdict = spent(lambda: prove(problem, watched.bit, Limits(scans=12, k=4)))  # noqa: B023
            assert isinstance(verdict, Verdict)
            found.append(verdict.kind)
            times.append(seconds)
        assert found == WANTED, found
        said("median property", statistics.median(times), f"worst {max(times):.2f} s", scan)
        seconds, answers = spent(lambda: ask(problem, ["dead-rung"]))  # noqa: B023
        assert isinstance(answers, Answers)
        text = f"{answers.counts['dead-rung']} asked, {len(answers.findings)} dead"
        said("dead rungs", seconds, text, scan)
        assert answers.open["dead-rung"] <= count // 50, answers


def coils(smoke: bool) -> None:
    """Ask of coils of the largest machine whether they are ever on."""
    program = parse_program(machine(50 if smoke else 3000, 5 if smoke else 200))
    problem = ProgramSystem(program)
    keys = sorted(key for key in problem.machine.written if key[0].startswith(COILS))
    chosen = Random(4).sample(keys, 8 if smoke else 28)
    decided, times = 0, []
    for key in chosen:
        seconds, verdict = spent(lambda: prove(problem, key, COIL_LIMITS))  # noqa: B023
        assert isinstance(verdict, Verdict)
        decided += seconds <= 5 and verdict.kind is not VerdictKind.UNKNOWN
        times.append(seconds)
    share = decided / len(chosen)
    said(
        "coils", statistics.median(times), f"{share:.0%} decided, bar {DECIDED:.0%}; worst {max(times):.1f} s"
    )
    assert share >= DECIDED, share


# --- presses: four buttons in their order, each held 300 ms

PRESSES = """PROGRAM presses
TAG A : BOOL
TAG B : BOOL
TAG C : BOOL
TAG D : BOOL
TAG P1 : TIMER
TAG P2 : TIMER
TAG P3 : TIMER
TAG S1 : BOOL
TAG S2 : BOOL
TAG S3 : BOOL
TAG Open : BOOL
ROUTINE Main
XIC(A)XIO(B)XIO(C)XIO(D)TON(P1,300,0);
XIC(P1.DN)OTL(S1);
XIC(S1)XIC(B)XIO(A)XIO(C)XIO(D)TON(P2,300,0);
XIC(P2.DN)OTL(S2);
XIC(S2)XIC(C)XIO(A)XIO(B)XIO(D)TON(P3,300,0);
XIC(P3.DN)OTL(S3);
XIC(S3)XIC(D)XIO(A)XIO(B)XIO(C)OTL(Open);
[XIC(A)XIC(D),XIC(B)XIC(D)]OTU(S1);
XIO(S1)OTU(S2);
XIO(S2)OTU(S3);
END
ROUTINE NEVER
XIC(Open)NOP();
XIC(S3)XIO(S1)NOP();
END
"""


def presses(smoke: bool) -> None:
    """Find how the four presses open, with scans of any time and of 10 ms."""
    program = parse_program(PRESSES)
    scan = scan_seconds(program)
    for bounds in (ScanBounds(1, 1000), ScanBounds(10, 10)):
        checked = monitored(parse_program(PRESSES))
        problem = ProgramSystem(checked.program, bounds)
        opened, order = checked.properties
        seconds, verdict = spent(lambda: prove(problem, opened.bit))  # noqa: B023
        assert isinstance(verdict, Verdict)
        assert verdict.kind is VerdictKind.REFUTED
        assert prove(problem, order.bit).kind is VerdictKind.PROVED
        text = f"scans of {bounds.low_ms} to {bounds.high_ms} ms: refuted in scan {verdict.k}"
        said("presses", seconds, text, scan)
        assert sum(each.ms for each in verdict.scans) >= 900
        assert prove(problem, opened.bit) == verdict, "two runs differ"


def edit(smoke: bool) -> None:
    """Compare a machine with one that lacks a contact."""
    rungs, timers = (50, 5) if smoke else (700, 50)
    old, new = (parse_program(machine(rungs, timers, changed)) for changed in ("", "XIO(Stop"))
    scan = scan_seconds(old)
    seconds, found = spent(lambda: compare(old, new))
    assert isinstance(found, Difference)
    now = [each.name for each in found.changed if each.now]
    shown = [each for each in found.changed if each.scans]
    middle = max(1, rungs // 7) // 2
    assert f"FWD{middle}" in now, now
    assert shown
    text = (
        f"{found.compared} values: {len(now)} differ now, {len(found.changed)} ever, {len(shown)} with a run"
    )
    said("edit", seconds, text, scan)
    assert not compare(old, parse_program(machine(rungs, timers))).changed


def edits(smoke: bool) -> None:
    """Drop or negate a contact of random programs: values that differ in random scans are reported."""
    begin, reported, seen, silent = time.process_time(), 0, 0, 0
    for seed in range(4 if smoke else 200):
        rng = Random(seed)
        text = program_text(rng)
        other = edited_text(text, rng)
        if other is None:
            continue
        old, new = parse_program(text), parse_program(other)
        one, two = (ProgramSystem(each) for each in (old, new))
        keys = sorted({*one.key_of.values()} & {*two.key_of.values()})
        apart = random_runs(one, two, [key for key in keys if "~" not in key[0]])
        changed = {each.key for each in compare(old, new).changed}
        assert apart.keys() <= changed, (seed, apart.keys() - changed)
        reported += len(changed)
        seen += len(apart)
        silent += not changed
    text = f"{seen} values differ in random scans, {reported} are reported, {silent} edits change nothing"
    said("edits", time.process_time() - begin, text)


def edited_text(text: str, rng: Random) -> str | None:
    """Return a program with one contact left out or negated; None if it has none."""
    contacts = list(re.finditer(r"(XIC|XIO)\(\w+(?:\.\w+)?\)", text))
    if not contacts:
        return None
    at = rng.choice(contacts)
    other = "XIO" if at[1] == "XIC" else "XIC"
    instead = "" if rng.random() < 0.5 and text[at.end()] not in ",]" else other + at[0][3:]
    return text[: at.start()] + instead + text[at.end() :]


def twice(smoke: bool) -> None:
    """Run whole commands twice, with other orders of hashes: the same text but for times; not if short."""
    if smoke:
        return
    begin = time.perf_counter()
    examples = Path(__file__).parents[1] / "examples"
    files = [examples / "three_stations_ladder/line.toml", examples / "feeder/feeder.toml"]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "presses.rung").write_text(PRESSES, encoding="utf-8")
        for file in (Path(folder) / "presses.rung", *files):
            one, other = (_said(file, folder, seed) for seed in ("1", "2"))
            assert one == other, file
    said("twice", time.perf_counter() - begin, f"{1 + len(files)} programs: the same text")


def _said(file: Path, folder: str, hash_seed: str) -> str:
    """Return what a command says, without its times."""
    done = subprocess.run(
        (sys.executable, "-m", "scanrack", "prove", str(file), "--out", "out"),
        cwd=folder,
        env={**os.environ, "PYTHONHASHSEED": hash_seed},
        capture_output=True,
        text=True,
        check=False,
        encoding="utf-8",
    )
    assert done.returncode in (0, 1, 3), done.stderr
    return re.sub(r"\d+\.\d\d s", "", done.stdout)


def attack(smoke: bool, scans: int = 1_000_000) -> None:
    """Prove what can be of random programs; attack it with random scans."""
    found, seed = Proofs(), 0
    begin = time.process_time()
    while found.count["scans"] < (3_000 if smoke else scans):
        found.try_one(seed)
        seed += 1
    text = ", ".join(
        f"{found.count[name]} {name}" for name in ("programs", "proved", "refuted", "unknown", "scans")
    )
    said("attack", time.process_time() - begin, f"{text}; {len(found.broken)} broken")
    assert not found.broken, found.broken


def opinions(smoke: bool) -> None:
    """Give the certificate of each proof of machines, presses and random programs to z3 and to cvc5."""
    others, proofs, refused, gave_up = solvers(), 0, [], []
    assert len(others) == 2, f"{[each.name for each in others]}: this takes z3 and cvc5, the extra `check`"
    times = dict.fromkeys(("the search", *[each.name for each in others]), 0.0)
    for problem, properties, limits in _searches(smoke):
        for watched in properties:
            seconds, verdict = spent(lambda: prove(problem, watched.bit, limits))  # noqa: B023
            assert isinstance(verdict, Verdict)
            times["the search"] += seconds
            proofs += bool(verdict)
            for other in others if verdict else ():
                seconds, opinion = spent(lambda: _opinion(verdict, other))  # noqa: B023
                assert isinstance(opinion, Opinion)
                times[other.name] += seconds
                refused += [(watched.claim.text, opinion)] if opinion.refused else []
                gave_up += [] if opinion.confirmed or opinion.refused else [other.name]  # not in its time
    each = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in times.items())
    text = f"{proofs} proofs, {len(refused)} refused, {len(gave_up)} of {2 * proofs} opinions late; {each}"
    said("opinions", sum(times.values()), text)
    assert proofs > 10, proofs
    assert not refused, refused


def _opinion(verdict: Verdict, other: Solver) -> Opinion:
    relation, roles = written(verdict.certificates)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "proof.smt2").write_text(relation, encoding="utf-8")
        (Path(folder) / "proof.json").write_text(json.dumps(roles), encoding="utf-8")
        return check(Path(folder), other)


def _searches(smoke: bool) -> Iterator[tuple[ProgramSystem, Sequence[WatchedClaim], Limits]]:
    """Yield programs of this benchmark with their claims."""
    sizes = ((50, 5),) if smoke else ((50, 5), (700, 50))
    for text in (PRESSES, *(machine(*each) for each in sizes)):
        checked = monitored(parse_program(text))
        yield ProgramSystem(checked.program), checked.properties, Limits(scans=12, k=4)
    for seed in range(12 if smoke else 200):
        rng = Random(seed)
        checked = monitored(parse_program(program_text(rng)), claims(rng))
        yield ProgramSystem(checked.program, ScanBounds(1, 100)), checked.properties, LIMITS


MEMORY = 80
"""Bar, MB of a process that has done many proofs."""


def memory(smoke: bool) -> None:
    """Do 2,000 proofs in a process of its own, which has to end without a crash."""
    many = 40 if smoke else 2_000
    begin = time.perf_counter()
    code = f"import prove; prove.many({many})"
    command = (sys.executable, "-c", code)
    done = subprocess.run(
        command, cwd=Path(__file__).parent, capture_output=True, text=True, check=False, encoding="utf-8"
    )
    assert done.returncode == 0, f"status {done.returncode}: {done.stderr[-300:]}"
    text = f"{many:,} proofs, {int(done.stdout)} MB, bar {MEMORY} MB"
    said("memory", time.perf_counter() - begin, text)
    assert int(done.stdout) <= MEMORY, text


def many(count: int) -> None:
    """Do proofs; print the most memory that this process had, in MB."""
    found, seed = Proofs(), 900_000
    while found.count["proved"] + found.count["refuted"] + found.count["unknown"] < count:
        found.try_one(seed, runs=0)
        seed += 1
    print(round(highest_mib()))


FIRST_SCAN_ONLY = "Awake is never off again"
"""A finding of the other commit that is none: the coil is off in the first scan of each run."""

QUESTIONS_AT_MOST, FIRST_AT_MOST = 0.1, 0.02
"""Bars of `questions`: all answers, and the first ones, as shares of all at the other commit."""


def questions(smoke: bool) -> None:
    """Ask the built-in questions of examples, here and at another commit, in turns: minutes there."""
    commit = against.named_commit()
    if smoke or not against.has(commit):
        return  # what is found is in tests
    worst = 0.0
    with against.sides_of(commit) as sides, against.workers(sides, "prove") as (other, this):
        for name in this.rows:
            here = [this.measure(name)]
            there = other.measure(name)
            here += [this.measure(name) for _ in range(4)]
            lost = [each for each in set(there[2]) - set(here[0][2]) if FIRST_SCAN_ONLY not in each]
            assert not lost, lost
            ratios, firsts = (sorted(each[place] / there[0] for each in here) for place in (0, 1))
            text = (
                f"{name}: {there[0]:.1f} s there; {ratios[2]:.3f}, {ratios[0]:.3f} to {ratios[-1]:.3f}, "
                f"bar {QUESTIONS_AT_MOST}; first answers {firsts[2]:.3f}, bar {FIRST_AT_MOST}; "
                f"open {there[3]}, now {here[0][3]}; {len(here[0][2])} findings"
            )
            said("questions", statistics.median(each[0] for each in here), text)
            worst = max(worst, ratios[2] / QUESTIONS_AT_MOST, firsts[2] / FIRST_AT_MOST)
    assert worst <= 1, worst


PARTS: dict[str, Callable[[bool], None]] = {
    "machines": machines,
    "coils": coils,
    "presses": presses,
    "edit": edit,
    "edits": edits,
    "twice": twice,
    "attack": attack,
    "opinions": opinions,
    "memory": memory,
    "questions": questions,
}


def missed(run: Callable[[], None]) -> str:
    """Run a part; return what it misses, empty if nothing."""
    try:
        run()
    except Exception as error:  # it is this part's row, and the other parts are run
        at = traceback.extract_tb(error.__traceback__)[-1]
        return f"line {at.lineno}: {at.line}: {type(error).__name__} {str(error)[:300]}"
    return ""


def main() -> None:
    """Run the parts; end with a table of them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--smoke", action="store_true")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--scans", type=int, default=1_000_000, help="random scans of the attack")
    given = parser.parse_args()
    PARTS["attack"] = partial(attack, scans=given.scans)
    rows = {name: missed(partial(PARTS[name], given.smoke)) for name in given.only}
    for name, why in rows.items():
        print(f"{name:>16}: {'missed, ' + why if why else 'held'}")
    sys.exit(any(rows.values()))


if __name__ == "__main__":
    main()
