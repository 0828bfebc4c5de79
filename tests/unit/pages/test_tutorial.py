"""docs/tutorial: who does what it says sees what it says. And docs/index.md: the site has every page."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from live_sessions import LiveSession
from tutorial_pages import PAGES, ROOT, follow


def test_the_contents_of_the_site_name_pages_that_exist_each_once() -> None:
    docs = ROOT / "docs"
    contents = (docs / "index.md").read_text(encoding="utf-8")
    named = re.findall(r"^\* \[.+\]\((\S+)\.md\)$", contents, re.MULTILINE)
    assert len(named) == len(set(named)) > 40
    assert [name for name in named if not (docs / f"{name}.md").exists()] == []
    assert {f"tutorial/{page.stem}" for page in PAGES} <= set(named)


def test_the_tutorial_has_eight_parts_each_with_its_head() -> None:
    for number, page in enumerate(PAGES, start=1):
        text = page.read_text(encoding="utf-8")
        assert re.match(rf"# {number}\. .*\n\nFor .*\. \d+ minutes\.\n", text), page.name
    assert len(PAGES) == 8


def test_the_reader_of_part_1_presses_start_before_the_rack_does() -> None:
    """The rack's timeline presses it at 0.5 s: a scan is 2 ms, so from scan 250 on."""
    text = PAGES[0].read_text(encoding="utf-8")
    assert re.search(r"^\$ scanrack watch panel/line\.toml .*--paused", text, re.MULTILINE)
    assert "before its first scan. Click *start*, then ▶" in text
    press = {"do": "press", "slot": 2, "name": "start", "on": True}
    rack = ROOT / "examples" / "three_stations_panel" / "line.toml"
    session = LiveSession([(0, press), (0, {"do": "go"})], rack=rack).play(200, paused=True)
    assert session.refusals == []
    assert [session.program.tags[name] for name in ("Run", "Lamp", "Homing")] == [True] * 3


@pytest.mark.slow
def test_a_reader_sees_what_the_tutorial_says(request: pytest.FixtureRequest, tmp_path: Path) -> None:
    for each in follow(tmp_path, search=request.config.getoption("--long")):
        assert each.same, f"{each.page.name}: $ {each.command}\n{each.printed}"
