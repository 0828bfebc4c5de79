"""Versions of distributions are those that `importlib.metadata` finds."""

import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from scanrack.io_images.versions import version_of


def test_they_are_those_of_the_standard_library() -> None:
    for name in ("mcap", "pydantic-core", "Typing_Extensions", "scanrack"):
        assert version_of(name) == version(name)


def test_the_first_folder_of_the_search_path_decides(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number, head in enumerate(("Name: So.Named\nVersion: 1.5\n\nVersion: 9\n", "Version: 2\n")):
        info = tmp_path / f"{number}" / "so_named-1.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(head, encoding="utf-8")
        monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "none"), str(info.parent)])
    assert version_of("so-named") == version("so-named") == "1.5"
