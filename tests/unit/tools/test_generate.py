"""`python -m tests.tools.generate`: it writes what is stale, and knows every generator."""

from __future__ import annotations

from pathlib import Path

import generate
import pytest
import rule_proofs
from scanrack.io_images.amci3601 import RULES

PROVED = {rule.id: ["test_a.py::test_x"] for rule in RULES.values() if rule.testable}
BY_HAND = {"rules_page", "tutorial_pages"}
"""Called by another one, and by itself: it runs what the tutorial says."""


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The page of rules, elsewhere and stale, of tests that prove all."""
    file = tmp_path / "rules.md"
    file.write_text("| old |\n", encoding="utf-8")
    monkeypatch.setattr(generate, "ROOT", tmp_path)
    monkeypatch.setattr(rule_proofs, "PAGE", file)
    monkeypatch.setattr(rule_proofs, "collect", lambda: PROVED)
    return file


def test_a_stale_page_is_named_with_its_lines_and_written_on_demand(page: Path, capsys) -> None:
    assert generate.main(["--check", "rules"]) == 1
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "rules.md: python -m tests.tools.generate rules"
    assert "  - | old |" in said
    assert page.read_text(encoding="utf-8") == "| old |\n"
    assert generate.main(["rules"]) == 0
    assert generate.main(["rules", "--check"]) == 0
    assert "test_a.py<br>· test_x" in page.read_text(encoding="utf-8")
    assert capsys.readouterr() == ("rules.md\n", "")


def test_a_page_with_mistakes_is_written_and_they_are_reported(page: Path, monkeypatch, capsys) -> None:
    monkeypatch.setattr(rule_proofs, "collect", dict)
    assert generate.main(["rules"]) == 1
    assert "CMD-03 has no test\n" in capsys.readouterr().err
    assert "CMD-03" in page.read_text(encoding="utf-8")


def test_an_unknown_word_is_refused(capsys) -> None:
    assert generate.main(["cars"]) == 2
    assert "cars is not generated: answers, cards, " in capsys.readouterr().err


def test_every_generator_is_known() -> None:
    pages = {file.stem for file in Path(generate.__file__).parent.glob("*_page*.py")}
    assert pages - BY_HAND == {name for name in vars(generate) if name.endswith("_page")}
    assert {name.removesuffix("_page") for name in pages - BY_HAND} <= set(generate.GENERATORS)
