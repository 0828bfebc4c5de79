"""docs/tasks.md: questions reach their answer from the first page with two clicks; links lead to headings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from site_search import ANSWERS

DOCS = Path(__file__).parents[3] / "docs"
LINK = re.compile(r"\]\(([\w./-]+\.md(?:#[\w-]+)?)\)")
TASKS = (DOCS / "tasks.md").read_text(encoding="utf-8")


def slug(heading: str) -> str:
    """Return the anchor of a heading, as its site has it."""
    return re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-")


def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings of a page, as its site has them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return {slug(heading) for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE)}


def test_the_first_page_leads_to_the_tasks() -> None:
    assert "tasks.md" in LINK.findall((DOCS / "index.md").read_text(encoding="utf-8"))


@pytest.mark.parametrize("question", ANSWERS)
def test_a_question_is_a_row_whose_link_is_the_answer(question: str) -> None:
    answer = ANSWERS[question]
    rows = [row for row in TASKS.splitlines() if row.startswith("| ") and answer.row in row]
    assert [answer.place in LINK.findall(row) for row in rows] == [True]


@pytest.mark.parametrize("question", ANSWERS)
def test_the_section_has_the_answer(question: str) -> None:
    page, _, anchor = ANSWERS[question].place.partition("#")
    text = (DOCS / page).read_text(encoding="utf-8")
    parts = re.split(r"^#+ (.*)$", text, flags=re.MULTILINE)
    sections = dict(zip(map(slug, parts[1::2]), parts[2::2], strict=True))
    assert ANSWERS[question].names in (sections[anchor] if anchor else text)


def test_forty_tasks_whose_links_lead_to_headings() -> None:
    rows = [row for row in TASKS.splitlines() if row.startswith("| ") and "](" in row]
    assert len(rows) >= 40
    for link in LINK.findall(TASKS):
        page, _, anchor = link.partition("#")
        assert (DOCS / page).is_file(), link
        assert not anchor or anchor in anchors(DOCS / page), link
