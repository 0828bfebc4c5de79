"""The output of `scanrack fuzz`: failures, and the summary of the campaign."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterator, Set
from dataclasses import asdict
from pathlib import Path
from textwrap import wrap

from scanrack.io_images.installing import how_to_install
from scanrack.jobs.fuzz import Counterexample, Invariant
from scanrack.jobs.fuzz.campaign.recipes import Origin, Recipe
from scanrack.jobs.fuzz.campaign.state import State
from scanrack.jobs.fuzz.explain.unfired import WORDS, ErrorRules, UnfiredRule
from scanrack.jobs.fuzz.reached import reached
from scanrack.jobs.fuzz.run import NO_FAULT
from scanrack.jobs.fuzz.scenarios.words import described
from scanrack.jobs.fuzz.search import SPENT
from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.prove.serving.stuck import PATIENCE, SolverStep
from scanrack.ladder import LadderLogic
from scanrack.terminal.status import reason

from .fuzz_budget import Spending

WIDTH = 100


def failure(example: Counterexample) -> str:
    """Return a failure in a few lines: the broken invariant, the scenario, and its evidence.

    The first line names the invariant and the time; the others are indented.
    """
    broken = example.broken
    lines = [*described(example.scenario), *broken.shows, *broken.rules]
    return "\n  ".join([str(broken), *lines])


def not_kept(error: OSError, failures: Collection[Counterexample], origin: Origin) -> str:
    """Return the message for a full disk; it contains the new failures as recipes."""
    recipes = [
        Recipe(counterexample.scenario, origin, counterexample.broken.invariant).text().rstrip()
        for counterexample in failures
    ]
    heading = "these failures could not be saved; each is a file for --scenario:" if recipes else ""
    return "\n".join([f"{reason(error)}; {heading or 'no failure is lost'}", *recipes])


def failure_row(example: Counterexample, folder: Path | None = None) -> dict[str, object]:
    """Return a failure for --json.

    Args:
        folder: folder with the failure's files; None if the failure was only repeated.
    """
    row = {**asdict(example.broken), "scenario": described(example.scenario)}
    return row if folder is None else {**row, "after_runs": example.after, "folder": str(folder)}


def summary_row(
    state: State,
    before: State,
    others: Set[str],
    searched: Collection[Invariant],
    never: Collection[UnfiredRule],
) -> dict[str, object]:
    """Return the figures of a campaign for --json.

    Args:
        before: the state at the beginning of the session.
        others: names of the invariants that were not broken.
        searched: the goals of the search.
        never: the error rules that never fired.
    """
    return {
        "runs": state.runs - before.runs,
        "scans": state.scans - before.scans,
        "runs_in_all": state.runs,
        "scans_in_all": state.scans,
        "processor_s": state.processor_ns / 1e9,
        "steps": state.steps,
        "held": sorted(others - _untried(others, state)),
        "never_tested": sorted(_untried(others, state)),
        "goals": {goal.name: state.greatest.get(goal.name, goal.name in state.applied) for goal in searched},
        "rules": dict(state.rules),
        "rules_never_fired": {unfired.rule.id: unfired.sentence for unfired in never},
    }


def summary(state: State, before: State, seconds: float, rules: ErrorRules) -> str:
    """Return the summary of a campaign as text."""
    return "\n".join([*_figures(state, before, seconds), *_rules(state, rules)])


def _figures(state: State, before: State, seconds: float) -> Iterator[str]:
    """Yield lines with the runs of the session and of the campaign, and the shares of the time spent."""
    runs, scans = state.runs - before.runs, state.scans - before.scans
    rate = f" ({runs / seconds:,.0f} runs and {scans / seconds:,.0f} scans per second)" if runs else ""
    yield f"runs          {runs:,}{rate}"
    if state.shrinking:
        yield f"              {state.shrinking:,} of them to shrink failures"
    if before.runs:
        yield f"in all        {state.runs:,} runs, {state.scans:,} scans"
    if state.printed:
        yield f"printed       {state.printed:,} lines by the program, not shown"
    total = state.spent.total()
    if total:
        shares = ", ".join(f"{activity} {state.spent[activity] / total:.0%}" for activity in SPENT)
        yield f"time          {shares}"


def left_over(state: State, spending: Spending) -> str:
    """Return a line about work that was unfinished when time ran out; "" if none was."""
    rests = []
    if state.unshrunk:
        rests.append(f"{state.unshrunk:,} failures not shrunk completely")
    if spending.not_explained:
        rests.append(f"{spending.not_explained:,} failures without a point of no return")
    return f"time is over  {', '.join(rests)}" if rests else ""


def _rules(state: State, rules: ErrorRules) -> Iterator[str]:
    fired = [rule for rule in rules.ids if state.rules[rule]]
    yield f"error rules   {len(fired)} of {len(rules.ids)} of {rules.owners} fired"
    yield from (f"  {rule:<9} {state.rules[rule]:>9,} times" for rule in fired)


def never_fired(never: Collection[UnfiredRule]) -> str:
    """Return the error rules that never fired, by reason; the coverage page has the reason for each."""
    lines = []
    for why, words in WORDS.items():
        rules = [unfired.rule.id for unfired in never if unfired.reason is why]
        if rules:
            text = f"{words}: {', '.join(rules)}"
            lines += wrap(text, WIDTH, initial_indent="  never     ", subsequent_indent=" " * 12)
    return "\n".join(lines)


def held(names: Collection[str], state: State) -> str:
    """Return a line with the unbroken invariants; untested invariants are marked."""
    untried = _untried(names, state)
    marked = [f"{name} (its clock never started)" if name in untried else name for name in sorted(names)]
    return f"held          {', '.join(marked) or 'nothing'}"


def goals(searched: Collection[Invariant], state: State) -> list[str]:
    """Return a line for each goal: whether it was seen, or its greatest value."""
    lines = [f"{'':<14}{_goal(goal, state)}" for goal in searched]
    return [line.replace(" " * 5, "goals", 1) for line in lines[:1]] + lines[1:]


def _goal(goal: Invariant, state: State) -> str:
    sentence = f"{goal.sentence.rstrip('.')} [{goal.name}]"
    if goal.name in state.greatest:
        return f"{sentence}: at most {state.greatest[goal.name]:g}"
    return f"{sentence}: {'seen' if goal.name in state.applied else 'never seen'}"


MOST_GAPS = 3
"""Maximum number of gaps named in the closing lines."""


def closing(job: LoadedRack, state: State, solver: SolverStep, scans: int) -> str:
    """Return three lines: the covered parts, the parts that were not reached, and the next step.

    Args:
        scans: number of scans per run.
    """
    coverage = reached(job, state.kept.seen)
    gaps = solver.gaps(coverage)
    count, seconds = coverage.total - len(coverage.gaps), scans * job.spec.scan_ns / 1e9
    dead = len(coverage.gaps) - len(gaps)
    shown = "; ".join(gap.text for gap in gaps[:MOST_GAPS])
    unlisted = f"; and {len(gaps) - MOST_GAPS:,} more" if len(gaps) > MOST_GAPS else ""
    proved = f" ({dead:,} proved never to be)" if dead else ""
    covered = f"{count:,} of {coverage.total:,} {coverage.unit}"
    return (
        f"looked at     {state.runs:,} runs of {seconds:g} s; {covered}\n"
        f"not reached   {shown or 'nothing'}{unlisted}{proved}\n"
        f"next          {_next(job, state, solver, is_open=bool(gaps))}"
    )


def _next(job: LoadedRack, state: State, solver: SolverStep, *, is_open: bool) -> str:
    """Return the next step: fix the failures, search longer, prove, or add invariants."""
    rack = shlex.quote(str(job.rack_file))
    if state.found:
        return f"fix the failures, then run scanrack fuzz {rack} again: it repeats them first"
    if state.stale < PATIENCE:
        return f'scanrack fuzz {rack} --budget "10 min": runs still reach new states'
    if solver.can_ask:
        return f"scanrack prove {rack}: {state.stale:,} runs reached no new state; a proof covers all runs"
    if isinstance(job.logic, LadderLogic):
        return f"{how_to_install('prove')}: the solver then finds runs that reach the rest"
    if is_open:
        return "find in the program what leads to the lines that are not reached; runs reach no new state"
    return "add invariants: runs reach no new state"


def _untried(names: Collection[str], state: State) -> set[str]:
    """Return the invariants whose clock never started."""
    return {name for name in names if name not in state.applied and name != NO_FAULT and state.runs}
