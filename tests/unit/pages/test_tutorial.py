"""docs/tutorial: who does what it says sees what it says. And docs/index.md: the site has every page."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from tutorial_pages import PAGES, ROOT, follow


def test_the_contents_of_the_site_name_pages_that_exist_each_once() -> None:
    docs = ROOT / "docs"
    contents = (docs / "index.md").read_text(encoding="utf-8")
    trees = re.findall(r"```\{toctree\}\n(.*?)```", contents, re.DOTALL)
    named = [line for tree in trees for line in tree.splitlines() if line and not line.startswith(":")]
    assert len(named) == len(set(named)) > 40
    assert [name for name in named if not (docs / f"{name}.md").exists()] == []
    assert {f"tutorial/{page.stem}" for page in PAGES} <= set(named)


def test_the_tutorial_has_eight_parts_each_with_its_head() -> None:
    for number, page in enumerate(PAGES, start=1):
        text = page.read_text(encoding="utf-8")
        assert re.match(rf"# {number}\. .*\n\n\*For: .*\. Minutes: \d+\.\*\n", text), page.name
    assert len(PAGES) == 8


@pytest.mark.slow
def test_a_reader_sees_what_the_tutorial_says(request: pytest.FixtureRequest, tmp_path: Path) -> None:
    for each in follow(tmp_path, search=request.config.getoption("--long")):
        assert each.same, f"{each.page.name}: $ {each.command}\n{each.printed}"
