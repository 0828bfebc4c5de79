"""Each question of `tests/support/why_questions.py` ends in the planted cause, in at most six lines."""

from __future__ import annotations

import pytest
from scanrack.ladder.debug.answer_text import LONGEST, MOST_LINES, answer_text
from why_questions import QUESTIONS, Question, do, make

pytestmark = pytest.mark.slow  # together they take seconds


def cause_line(text: str) -> str:
    """Return the last line of an answer with what is wrapped behind it."""
    return " ".join(text[max(0, text.rfind("Cause: ")) :].split())


@pytest.mark.parametrize("row", QUESTIONS, ids=lambda row: f"{row.world}: {row.done}: {row.asked}")
def test_an_answer_ends_in_the_planted_cause(tmp_path, row: Question):
    bench = make(tmp_path, row.world)
    do(bench, row.done)
    link = bench.chain(row.asked)
    said = answer_text(link)
    assert link.end.kind == row.kind, said
    assert [word for word in row.words if word not in cause_line(said)] == [], said
    assert len(said.splitlines()) <= MOST_LINES
    assert max(map(len, said.splitlines())) <= LONGEST


def test_there_are_sixty_of_all_kinds():
    assert len(QUESTIONS) >= 60
    groups = {
        group: sum(row.group == group for row in QUESTIONS) for group in {row.group for row in QUESTIONS}
    }
    assert {"never on", "outranked", "block"} <= {group for group, count in groups.items() if count >= 5}
