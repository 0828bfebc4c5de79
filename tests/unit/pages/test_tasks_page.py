"""docs/tasks.md: questions reach their answer from the first page with two clicks; links lead to headings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[3] / "docs"
LINK = re.compile(r"\]\(([\w./-]+\.md(?:#[\w-]+)?)\)")
TASKS = (DOCS / "tasks.md").read_text(encoding="utf-8")

ANSWERS = {
    "set acceleration": "units.md#set-acceleration-and-speed",
    "my move does not start": "debugging.md#my-move-does-not-start",
    "see the registers": "units.md#see-the-words",
    "what MSW and LSW are": "units.md#msw-and-lsw",
    "jog from a button": "sequences.md#five-programs",
    "normally closed stop": "cards.md#wiring",
    "Node-RED": "hmi.md#node-red",
    "faster than real time": "run.md",
    "RS-485": "clients.md",
    "units of speed": "units.md#units",
    "Windows": "windows.md",
    "use it in CI": "ci.md",
    "put my Studio 5000 program in": "l5x.md#from-an-export-to-a-rack",
    "get the data into pandas": "notebook.md#numbers",
    "what happens when the link is lost": "axis.md#a-lost-link",
}
"""Questions as the page has them, and the heading with the answer."""


def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings of a page, as its site has them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    found = set()
    for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE):
        found.add(re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-"))
    return found


def test_the_first_page_leads_to_the_tasks() -> None:
    assert "tasks.md" in LINK.findall((DOCS / "index.md").read_text(encoding="utf-8"))


@pytest.mark.parametrize("question", ANSWERS)
def test_a_question_is_a_row_whose_link_is_the_answer(question: str) -> None:
    rows = [row for row in TASKS.splitlines() if row.startswith("| ") and question in row]
    assert [ANSWERS[question] in LINK.findall(row) for row in rows] == [True]


def test_forty_tasks_whose_links_lead_to_headings() -> None:
    rows = [row for row in TASKS.splitlines() if row.startswith("| ") and "](" in row]
    assert len(rows) >= 40
    for link in LINK.findall(TASKS):
        page, _, anchor = link.partition("#")
        assert (DOCS / page).is_file(), link
        assert not anchor or anchor in anchors(DOCS / page), link
