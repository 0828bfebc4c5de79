"""Versions of distributions are those that `importlib.metadata` finds."""

import sys
from importlib.metadata import version
from pathlib import Path

import pytest
import scanrack
from scanrack.io_images.versions import distribution_version, own_project


def test_they_are_those_of_the_standard_library() -> None:
    for name in ("mcap", "pydantic-core", "Typing_Extensions", "scanrack"):
        assert distribution_version(name) == version(name)


def test_the_first_folder_of_the_search_path_decides(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number, head in enumerate(("Name: So.Named\nVersion: 1.5\n\nVersion: 9\n", "Version: 2\n")):
        info = tmp_path / f"{number}" / "so_named-1.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(head, encoding="utf-8")
        monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "none"), str(info.parent)])
    assert distribution_version("so-named") == version("so-named") == "1.5"


def test_a_checkout_has_its_own_version(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "scanrack"\nversion = "9.8"\n', "utf-8")
    monkeypatch.setattr(scanrack, "__path__", [*scanrack.__path__[:1], str(tmp_path)])
    monkeypatch.setitem(vars(scanrack), "__version__", None)  # which keeps what is found
    assert distribution_version("scanrack") == scanrack.__getattr__("__version__") == "9.8"


def test_installed_files_have_the_version_of_the_distribution(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scanrack, "__path__", scanrack.__path__[:1])
    assert own_project() is None
