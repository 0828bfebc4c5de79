"""docs/images: each picture is on a page, and as new as the program that it shows."""

from __future__ import annotations

import pytest
from picture_sources import IMAGES, PICTURES, REMEDY, ROOT, outdated

PAGES = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").rglob("*.md")]


def test_each_picture_names_its_source_and_is_on_a_page() -> None:
    there = {file.name for file in IMAGES.iterdir() if file.suffix in (".png", ".svg", ".gif")}
    assert there == set(PICTURES)
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    assert [name for name in there if f"images/{name})" not in text] == []


def test_no_program_behind_a_picture_has_changed() -> None:
    assert list(outdated()) == [], REMEDY


def test_a_changed_program_names_the_picture_and_how_to_draw_it(monkeypatch: pytest.MonkeyPatch) -> None:
    changed = PICTURES["watch.png"]._replace(files=("examples/feeder/feeder.toml",))
    monkeypatch.setitem(PICTURES, "watch.png", changed)
    (line,) = outdated()
    assert line == ("watch.png: examples/feeder/feeder.toml changed: python tests/tools/watch_pictures.py")
