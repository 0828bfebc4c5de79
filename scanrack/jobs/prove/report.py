"""Formats answers as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from scanrack.io_images.times import time_text
from scanrack.ladder.prove.answers import ScenarioStep
from scanrack.ladder.prove.induction import VerdictKind
from scanrack.ladder.prove.system.events import assumed

from .checking import Opinion
from .proving import FoundAnswer, Questions, Result
from .scenario import step_text
from .subject import ProofSubject

HELD_SHOWN = 12
"""Maximum number of constants that the text lists."""

LATEST_MS = 1000
"""Maximum time between two scans that a rack file can set with `scan_ms`, ms."""

BLAME_SHOWN = 3
"""Maximum number of reasons that the text lists for an unknown claim."""


def line_of(result: Result, width: int) -> str:
    """Return the line of a claim: name, verdict and detail.

    Args:
        width: width of the name, columns.
    """
    return f"{result.name:<{width}}  {result.word:<8}  {detail_of(result)}".rstrip()


def own_time_text(result: Result) -> str:
    """Return a sentence about the rack's own scan time if only longer scans break a claim, else ""."""
    if result.at_own_time is None:
        return ""
    is_proved = result.at_own_time.verdict.kind is VerdictKind.PROVED
    verdict = "it is proved" if is_proved else "no run breaks it within the limits"
    return f"only with scans longer than the rack's: with scans of {time_text(result.own_ns)} {verdict}   "


def detail_of(result: Result) -> str:
    """Return the detail of a verdict: the scenario, the effort of the proof, or the reasons for unknown."""
    answer, verdict = result.answer, result.answer.verdict
    if result.refused_by:
        return "; ".join(
            f"{opinion.solver} refuses the proof, {opinion.why}" for opinion in result.refused_by
        )
    if answer.steps:
        return f"{own_time_text(result)}scan {verdict.k:,}   {result.scenario}"
    if verdict.kind is VerdictKind.PROVED:
        reached = "no run reaches it   " if not answer else ""
        proved = f"{reached}{result.spent_ns / 1e9:.2f} s   ({answer.deciding:,} tags of {answer.tags:,})"
        return f"{proved}   {opinions_text(result.opinions)}".rstrip()
    hidden = len(verdict.blame) - BLAME_SHOWN
    reasons = "; ".join(verdict.blame[:BLAME_SHOWN])
    return f"{reasons}; and {hidden:,} more" if hidden > 0 else reasons


def opinions_text(opinions: Iterable[Opinion]) -> str:
    """Return the verdicts of other solvers on a proof as text; "" if there are none."""
    return "; ".join(
        f"{opinion.solver} {'confirms it' if opinion.confirmed else f'does not confirm it: {opinion.why}'}"
        for opinion in opinions
    )


def below(subject: ProofSubject, result: Result) -> Iterator[str]:
    """Yield the lines below a claim: its scenario, the run on the rack, and advice."""
    for number, step in enumerate(result.answer.steps, start=1):
        yield f"scan {number}: {step_text(step, subject.job.spec)}"
    yield from result.answer.end
    if result.rack is not None:
        yield str(result.rack)
    if result.answer.advice:
        yield f"to do: {result.answer.advice}"


def questions_text(count: int) -> str:
    """Return the number of built-in questions as text."""
    return f"{count:,} questions about rungs, contacts, coils and faults"


def found_lines(answer: FoundAnswer) -> Iterator[str]:
    """Yield the lines of a finding of the built-in questions, with its run."""
    texts = (str(answer.scenario or ""), opinions_text(answer.opinions))
    details = "".join(f"   {text}" for text in texts if text)
    finding = answer.finding
    yield f"{finding.rule:<10}  {finding.site.where}: {finding.text}{details}"
    for number, step in enumerate(answer.steps, start=1):
        yield f"    scan {number}: {step}"
    if answer.rack:
        yield f"    {answer.rack}"


def open_text(answers: Questions) -> str:
    """Return the number of open questions as text, by rule; "" if there are none."""
    open_count = sum(answers.open.values())
    by_rule = ", ".join(f"{rule} {count:,}" for rule, count in sorted(answers.open.items()) if count)
    return f"{open_count:,} of them are open (--work 10 may decide more): {by_rule}" if open_count else ""


def question_lines(answers: Questions) -> Iterator[str]:
    """Yield the results of the built-in questions; findings are in program order."""
    if count := sum(answers.counts.values()):
        yield questions_text(count)
    for answer in answers.found:
        yield from found_lines(answer)
    if open_line := open_text(answers):
        yield open_line


def assumptions(subject: ProofSubject, results: Iterable[Result]) -> list[str]:
    """Return the assumptions of the answers, one sentence each."""
    held_values: dict[str, Any] = {}
    sentences = dict.fromkeys(assumed(subject.problem.happens))  # of the built-in questions
    for result in results:
        held_values |= dict(result.answer.held)
        sentences |= dict.fromkeys(result.answer.assumed)
    bounds = subject.problem.bounds
    spacing = f"scans are {bounds.low_ms:,} to {bounds.high_ms:,} ms apart{bounds.steps_text}"
    if bounds.high_ms < LATEST_MS:
        spacing += f"; scan_ms = [{max(1, bounds.low_ms)}, {LATEST_MS}] also covers later scans"
    lines = [spacing, *subject.assumed, *sentences]
    return [*lines, held_text(held_values)] if held_values else lines


def held_text(held: Mapping[str, Any]) -> str:
    """Return the numbers that are assumed constant as one line, by name; at most `HELD_SHOWN` of them."""
    texts = [f"{name} = {value}" for name, value in sorted(held.items())]
    if len(texts) > HELD_SHOWN:
        texts[HELD_SHOWN:] = [f"and {len(texts) - HELD_SHOWN:,} more (--json lists all)"]
    return f"constant, because nothing writes them: {', '.join(texts)}"


def as_json(subject: ProofSubject, results: Sequence[Result], answers: Questions) -> dict[str, Any]:
    """Return the answers as JSON values, with times in ns and scans numbered from 1."""
    return {
        "properties": [_row(result) for result in results],
        "found": [_found(answer) for answer in answers.found],
        "asked": dict(sorted(answers.counts.items())),
        "open": dict(sorted(answers.open.items())),
        "scan_ms": [subject.problem.bounds.low_ms, subject.problem.bounds.high_ms],
        "modules": list(subject.assumed),
        "assumed": list(assumed(subject.problem.happens)),
    }


def _row(result: Result) -> dict[str, Any]:
    """Return the result of a claim as JSON values."""
    answer, verdict, site = result.answer, result.answer.verdict, result.answer.claim.site
    return {
        "name": result.name,
        "claim": answer.claim.sentence,
        "routine": site.routine,
        "number": site.rung,
        "verdict": result.word,
        "spent_ns": result.spent_ns,
        "k": verdict.k,
        "values": answer.deciding,
        "tags": answer.tags,
        "invariants": list(verdict.invariants),
        "held": dict(answer.held),
        "assumed": list(answer.assumed),
        "blame": list(verdict.blame),
        "advice": answer.advice,
        "scans": scans_of(answer.steps),
        "end": list(answer.end),
        "scenario": None if result.scenario is None else str(result.scenario),
        "rack": None if result.rack is None else result.rack.to_json(),
        "at_own_time": None if result.at_own_time is None else result.at_own_time.verdict.kind,
        "proof": None if result.proof is None else str(result.proof),
        "opinions": [opinion._asdict() for opinion in result.opinions],
    }


def scans_of(steps: Iterable[ScenarioStep]) -> list[dict[str, Any]]:
    """Return the scans of a scenario as JSON values."""
    return [
        {
            "ms": step.ms,
            "set": dict(step.changes),
            **({"key": "program"} if step.turned else {}),
            **({"start": "retained"} if step.again else {}),
        }
        for step in steps
    ]


def _found(answer: FoundAnswer) -> dict[str, Any]:
    """Return a finding of the built-in questions as JSON values."""
    finding = answer.finding
    site = finding.site
    return {
        "rule": finding.rule,
        "file": site.file,
        "line": site.line,
        "routine": site.routine,
        "number": site.rung,
        "text": finding.text,
        "scans": scans_of(answer.steps),
        "scenario": None if answer.scenario is None else str(answer.scenario),
        "rack": answer.rack or None,
        "proof": None if answer.proof is None else str(answer.proof),
        "opinions": [opinion._asdict() for opinion in answer.opinions],
    }
