"""Built-in questions about a program: is anything dead, stuck, in conflict or never done, and what can fault?

| rule | reported if |
|---|---|
| `dead-rung` | proved: no output of a rung ever has power |
| `dead-leg` | proved: a contact never passes power, or always does; a leg adds nothing to the others |
| `never-on` | proved: a coil's bit is never 1 after a scan |
| `stuck` | proved: a coil's bit, once 1, is 1 after each later scan |
| `conflict` | refuted, by a run: two OTE of one bit write different values in one scan |
| `never-done` | proved: DN of a timer or counter is never 1 after a scan |
| `fault` | refuted, by a run: a major fault, a zero divisor or an overflow |
| `endless` | refuted, by a run: a loop does not end within the controller's watchdog |

| file | does |
|---|---|
| `of_program` | these questions of a program |
| `points` | questions of a search: which states of contacts and coils can't be reached, and a run that
reaches one |
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
    """Answer the questions of some rules; return the findings in the order of the program.

    Args:
        problem: a program.
        rules: ids of rules.
        routines: see `questions_of`.
        limits: questions that need more stay open.
        known_run: returns the conditions that a known run makes true, such as the rack's scenario.
        listener: receives the findings as they are made.
    """
    questions = [question for question in questions_of(problem, routines) if question.rule in rules]
    return Questioning(problem, questions, limits, listener or Listener()).answers(known_run)
