"""Built-in questions about a program: is any part dead, stuck, in conflict or never done, and can it fault?

| rule | reported if |
|---|---|
| `dead-rung` | proved: no output of a rung ever has power |
| `dead-leg` | proved: a contact never passes power, or always does; a leg is redundant |
| `never-on` | proved: a coil's bit is never 1 after a scan |
| `stuck` | proved: a coil's bit, once 1, stays 1 after every later scan |
| `conflict` | refuted, by a run: two OTE of one bit write different values in one scan |
| `never-done` | proved: DN of a timer or counter is never 1 after a scan |
| `fault` | refuted, by a run: a major fault, a zero divisor or an overflow |
| `endless` | refuted, by a run: a loop does not end within the controller's watchdog |

| file | content |
|---|---|
| `of_program` | these questions about a program |
| `points` | questions for a search: which states of contacts and coils can be reached, and by which run |
| `asking` | answers questions, in rounds |
| `deciding` | decides conditions |
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from ..system import ProgramSystem
from .asking import LIMITS, RULES, Answers, Finding, Listener, Question, Questioning
from .deciding import KnownRun, QuestionLimits
from .of_program import questions_of

__all__ = ["LIMITS", "RULES", "Answers", "Finding", "Listener", "Question", "QuestionLimits", "ask"]


def ask(
    problem: ProgramSystem,
    rules: Sequence[str] = RULES,
    limits: QuestionLimits = LIMITS,
    routines: Collection[str] | None = None,
    known_run: KnownRun | None = None,
    listener: Listener[Finding] | None = None,
) -> Answers:
    """Answer the questions of the given rules; return the findings in program order.

    Args:
        problem: a program.
        rules: ids of rules.
        routines: see `questions_of`.
        limits: work limits; questions that need more work stay open.
        known_run: returns the conditions that a known run, such as the rack's scenario, makes true.
        listener: receives the findings as they are made.
    """
    questions = [question for question in questions_of(problem, routines) if question.rule in rules]
    return Questioning(problem, questions, limits, listener or Listener()).answers(known_run)
