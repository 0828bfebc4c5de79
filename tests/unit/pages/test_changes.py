"""The pages of changes are current, and name every module, command and format of export."""

from __future__ import annotations

import re
from pathlib import Path

import changes_page
import pytest
import typer
from scanrack.commands import build
from scanrack.runtime.modules.registry import MODULES
from scanrack.traces.export.formats import FORMATS


def test_the_pages_are_current() -> None:
    assert list(changes_page.mistakes()) == []
    assert list(changes_page.written_by_hand()) == []
    assert changes_page.NEXT.read_text("utf-8") == changes_page.page()
    assert changes_page.CHANGELOG.read_text("utf-8") == changes_page.changelog()


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("module", MODULES),
        ("command", typer.main.get_command(build()).list_commands(None)),  # type: ignore[attr-defined]
        ("format", [each.name for each in FORMATS]),
    ],
    ids=lambda each: each if isinstance(each, str) else "",
)
def test_changes_name_what_there_is(kind: str, names: list[str]) -> None:
    """In full, or a card after another of its kind: 1762-OB8, -OB16."""
    pages = [page.read_text("utf-8") for page in changes_page.PAGES.glob("*.md")]
    text = "\n".join([*changes_page.changes().values(), *pages])
    missing = [name for name in names if not named(name).search(text)]
    assert missing == [], f"no file in changes/ names the {kind}"


def named(name: str) -> re.Pattern[str]:
    """Return what finds a name."""
    return re.compile(rf"(?<!\w){name}\b|(?<= )-{name.partition('-')[2] or name}\b", re.IGNORECASE)


HAND = """\
# Changelog

## Unreleased

### Added

- Known
  already
- Plots have
  [colors](docs/plot.md)

### Fixed

- Plots have [colors](docs/plot.md) again.
- Plots have [colors](examples/plot.md) again!

## 0.1.0

- Old, see [run](docs/run.md)
"""
PAGE = """\
# Unreleased

## Added

- Known already

## Fixed

- Plots have [colors](../plot.md) again.
- Plots have [colors](../../examples/plot.md) again!
"""


def test_a_line_in_the_changelog_becomes_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, pages, log = tmp_path / "changes", tmp_path / "docs/changes", tmp_path / "CHANGELOG.md"
    folder.mkdir()
    pages.mkdir(parents=True)
    for name, path in {"FOLDER": folder, "PAGES": pages, "CHANGELOG": log}.items():
        monkeypatch.setattr(changes_page, name, path)
    (pages / "0.1.0.md").write_text("# 0.1.0 - 2026-01-02\n\n- Old, see [run](../run.md)\n", encoding="utf-8")
    (pages / "0.10.0.md").write_text("# 0.10.0\n", encoding="utf-8")
    (folder / "known.added.md").write_text("Known already\n", encoding="utf-8")
    log.write_text(HAND, encoding="utf-8")
    found = {file.name: line for file, line in changes_page.written_by_hand()}
    assert found == {
        "plots-have-colors.added.md": "Plots have [colors](../docs/plot.md)",
        "plots-have-colors-again.fixed.md": "Plots have [colors](../docs/plot.md) again.",
        "plots-have-colors-again-2.fixed.md": "Plots have [colors](../examples/plot.md) again!",
    }
    (folder / "colors.fixed.md").write_text(found["plots-have-colors-again.fixed.md"], encoding="utf-8")
    (folder / "more.fixed.md").write_text(found["plots-have-colors-again-2.fixed.md"], encoding="utf-8")
    assert changes_page.page() == PAGE
    rows = "* [0.10.0](docs/changes/0.10.0.md)\n* [0.1.0](docs/changes/0.1.0.md), 2026-01-02\n"
    assert changes_page.changelog().endswith(rows)


def test_a_wrong_file_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(changes_page, "FOLDER", tmp_path)
    (tmp_path / "colors.new.md").write_text("one\ntwo\n", encoding="utf-8")
    assert list(changes_page.mistakes()) == [
        "colors.new.md: must end with .added.md, .changed.md, .fixed.md",
        "colors.new.md: must be one line of text",
    ]
