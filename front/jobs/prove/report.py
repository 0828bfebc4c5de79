"""Answers as lines and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from ...ladder.prove.induction import VerdictKind
from .proving import FoundAnswer, Questions, Result
from .scenario import told
from .subject import ProofSubject

HELD_SHOWN = 12
"""Held numbers that the text lists."""

BLAME_SHOWN = 3
"""Reasons of an unknown claim that the text lists."""


def line_of(result: Result, width: int) -> str:
    """Return the line of a claim: name, verdict, and what comes with it.

    Args:
        width: columns of the name.
    """
    found = result.answer
    return f"{result.name:<{width}}  {found.word:<8}  {detail_of(result)}".rstrip()


def detail_of(result: Result) -> str:
    """Return what comes with a verdict."""
    found, verdict = result.answer, result.answer.verdict
    if found.steps:
        return f"scan {verdict.k:,}   {result.scenario}"
    if verdict.kind is VerdictKind.PROVED:
        reached = "no run reaches it   " if not found else ""
        return f"{reached}{result.spent_ns / 1e9:.2f} s   ({found.deciding:,} tags of {found.tags:,})"
    more = len(verdict.blame) - BLAME_SHOWN
    said = "; ".join(verdict.blame[:BLAME_SHOWN])
    return f"{said}; and {more:,} more" if more > 0 else said


def below(subject: ProofSubject, result: Result) -> Iterator[str]:
    """Yield the lines below that of a claim: its scenario, and what the rack did."""
    for number, step in enumerate(result.answer.steps, start=1):
        yield f"scan {number}: {told(step, subject.job.spec)}"
    if result.rack is not None:
        yield str(result.rack)


def question_lines(answers: Questions) -> Iterator[str]:
    """Yield a line for each finding of the built-in questions, with its run, and one for what is open."""
    for each in answers.found:
        scenario = f"   {each.scenario}" if each.scenario else ""
        yield f"{each.finding.rule:<10}  {each.finding.site.where}: {each.finding.text}{scenario}"
        for number, step in enumerate(each.steps, start=1):
            yield f"    scan {number}: {step}"
        if each.rack:
            yield f"    {each.rack}"
    asked, left = sum(answers.asked.values()), sum(answers.open.values())
    by_rule = ", ".join(f"{rule} {count:,}" for rule, count in sorted(answers.open.items()) if count)
    if asked:
        yield f"{asked:,} questions about rungs, contacts, coils and faults" + (
            f"; {left:,} are open: {by_rule}" if left else ""
        )


def assumptions(subject: ProofSubject, results: Iterable[Result]) -> list[str]:
    """Return what the answers depend on, a sentence each: the report's list of assumptions."""
    held: dict[str, Any] = {}
    said: dict[str, None] = {}
    for each in results:
        held |= dict(each.answer.held)
        said |= dict.fromkeys(each.answer.assumed)
    bounds = subject.problem.bounds
    lines = [f"scans are {bounds.low_ms:,} to {bounds.high_ms:,} ms apart", *subject.assumed, *said]
    return [*lines, held_text(held)] if held else lines


def held_text(held: Mapping[str, Any]) -> str:
    """Return the held numbers in a line, by name; the first ones if there are many."""
    shown = [f"{name} = {value}" for name, value in sorted(held.items())]
    more = [f"and {len(shown) - HELD_SHOWN:,} more (--json lists all)"] * (len(shown) > HELD_SHOWN)
    return f"held, as nothing writes them: {', '.join([*shown[:HELD_SHOWN], *more])}"


def as_json(subject: ProofSubject, results: Sequence[Result], answers: Questions) -> dict[str, Any]:
    """Return the answers in JSON's types; times in ns, scans from 1."""
    return {
        "properties": [_row(each) for each in results],
        "found": [_found(each) for each in answers.found],
        "asked": dict(sorted(answers.asked.items())),
        "open": dict(sorted(answers.open.items())),
        "scan_ms": [subject.problem.bounds.low_ms, subject.problem.bounds.high_ms],
        "modules": list(subject.assumed),
    }


def _row(result: Result) -> dict[str, Any]:
    found, verdict, site = result.answer, result.answer.verdict, result.answer.claim.site
    return {
        "name": result.name,
        "claim": found.claim.sentence,
        "routine": site.routine,
        "number": site.rung,
        "verdict": found.word,
        "spent_ns": result.spent_ns,
        "k": verdict.k,
        "values": found.deciding,
        "tags": found.tags,
        "invariants": list(verdict.invariants),
        "held": dict(found.held),
        "assumed": list(found.assumed),
        "blame": list(verdict.blame),
        "scans": [{"ms": each.ms, "set": dict(each.changes)} for each in found.steps],
        "scenario": None if result.scenario is None else str(result.scenario),
        "rack": None if result.rack is None else result.rack.to_json(),
    }


def _found(found: FoundAnswer) -> dict[str, Any]:
    finding = found.finding
    site = finding.site
    return {
        "rule": finding.rule,
        "file": site.file,
        "line": site.line,
        "routine": site.routine,
        "number": site.rung,
        "text": finding.text,
        "scans": [{"ms": each.ms, "set": dict(each.changes)} for each in found.steps],
        "scenario": None if found.scenario is None else str(found.scenario),
        "rack": found.rack or None,
    }
