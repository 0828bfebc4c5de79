"""Scanrack is not published: what pages and messages say installs it from a checkout, and from one place."""

from __future__ import annotations

import re
from importlib.metadata import metadata
from pathlib import Path

import pytest
from house import ROOMS
from install_lines import MENTION, ROOT, installed_as_today, pages
from scanrack.io_images import installing

OTHER_FORM = re.compile(
    r"""scanrack\[|pypi\.org/project/scanrack|\b(?:pipx?|tool) install (?:-\S+ )*["']?scanrack\b"""
)
HINT = re.compile(r"scanrack\[|pypi\.org|install ")
"""What every match of `OTHER_FORM` and `MENTION` has: it is found sooner."""


def mentions() -> list[str]:
    return [each[0] for page in pages() for each in MENTION.finditer(page.read_text("utf-8"))]


def test_the_pages_say_what_works_today() -> None:
    for page in pages():
        text = page.read_text("utf-8")
        assert installed_as_today(text) == text, f"{page}: python -m tests.tools.generate install"
    assert len(mentions()) > 12


def test_no_page_names_the_distribution_in_another_form() -> None:
    found = [
        f"{page}: {each[0]}" for page in pages() for each in OTHER_FORM.finditer(page.read_text("utf-8"))
    ]
    assert found == []


def test_no_message_has_a_command_of_its_own() -> None:
    files = {
        file: file.read_text("utf-8")
        for room in ROOMS
        for file in (ROOT / room).rglob("*.py")
        if file != Path(installing.__file__)
    }
    hinted = {file: text for file, text in files.items() if HINT.search(text)}
    own = [file for file, text in hinted.items() if file.name != "installing.py" and MENTION.search(text)]
    other = [file for file, text in hinted.items() if OTHER_FORM.search(text)]
    assert (own, other) == ([], [])


def test_each_extra_that_a_page_names_exists() -> None:
    extras = {match["extra"] for each in mentions() if (match := MENTION.fullmatch(each))} - {None}
    assert extras
    assert extras <= set(metadata("scanrack").get_all("Provides-Extra") or ())


def test_publication_changes_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installing, "SOURCE", "scanrack")
    assert installing.how_to_install("plot") == 'pip install "scanrack[plot]"'
    for tool in ("pip", "pipx", "uv tool"):
        assert installed_as_today(f"`{tool} install .`") == f"`{tool} install scanrack`"
