"""Proofs for the findings of `scanrack check`, if the solver is installed and decides quickly.

The questions are the same as in `scanrack prove`: does an output of a rung ever have power, is a coil ever
on, can a divisor be zero? Bits that the program only clears, and tags with names of operator controls, count
as set from outside.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from scanrack.ladder import LadderLogic
from scanrack.ladder.model.errors import LadderError

from ...check import FileLine, ProofFinding
from ...check.facts import Facts, Touch
from ...check.rungs.number_ranges import BY_PEOPLE
from ...load.loading import LoadedRack

MOST_LINES = 400
"""Maximum number of rungs and statements in a program that is examined."""

MOST_TERMS = 3_000
"""Maximum number of terms per scan in a program to examine. The proofs take about a second."""

BUDGET = 1_000_000
"""Amount of work for all questions of a rule, in terms."""

RULES: Mapping[str, str] = {
    "dead-rung": "unreachable",
    "never-on": "constant-condition",
    "fault": "division-by-zero",
}
"""Rules of `check` by the question of the proof."""


def verdicts(job: LoadedRack, facts: Facts) -> Iterator[ProofFinding]:
    """Yield proved findings in the user's own lines; nothing if the solver is missing.

    Args:
        facts: the facts of `check` about the program.
    """
    own_lines = facts.sites
    if not isinstance(job.logic, LadderLogic) or len(own_lines) > MOST_LINES:
        return
    from scanrack.ladder.prove.algebra.terms import reach
    from scanrack.ladder.prove.induction import Limits
    from scanrack.ladder.prove.questions import QuestionLimits, ask
    from scanrack.ladder.prove.solving.solver import is_installed
    from scanrack.ladder.prove.system import ProgramSystem

    if not is_installed():
        return
    limits = Limits(scans=2, k=1, work=100_000, fuse=3_200, helped=False)
    written_outside = (*job.spec.prove.written_outside, *set_outside(facts))
    try:
        problem = ProgramSystem(job.logic, free=job.spec.prove.free, written_outside=written_outside)
    except LadderError:
        return  # no proof covers such a program
    if len(reach(problem.next.values())) > MOST_TERMS:
        return
    reported: set[FileLine] = set()
    for finding in ask(problem, tuple(RULES), QuestionLimits(limits, BUDGET, states=0)).findings:
        line = FileLine(finding.site.file, finding.site.line or 1)
        has_rule = finding.rule != "fault" or finding.text.endswith("zero divisor")
        if has_rule and line in own_lines and line not in reported:
            reported.add(line)
            yield ProofFinding(RULES[finding.rule], line, holds=True, text=finding.text)


def set_outside(facts: Facts) -> Iterator[str]:
    """Yield the variables that are set from outside: operator controls, and bits that are only cleared."""
    for variable, accesses in facts.by_variable():
        writes = [access for access in accesses if access.writes]
        only_cleared = all(write.use is Touch.UNLATCH and not write.part for write in writes)
        if writes and (only_cleared or BY_PEOPLE.search(variable.name)):
            yield variable.name
