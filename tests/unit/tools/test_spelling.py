"""Parts of names are spelled as in American English; codespell sees whole words of a text only."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from importlib import resources

import pytest
from house import ROOMS, ROOT

pytest.importorskip("codespell_lib", reason="codespell is not installed")

PARTS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
OF_LIBRARIES = frozenset({"acknowledgement", "acknowledgements"})
"""Parts of OPC UA's names. A whole name of ours is never one of them."""
NOT_LISTED = frozenset({"energise", "energised", "energises", "energising", "unlabelled", "unmodelled"})
"""British spellings that codespell's list lacks."""


def british() -> frozenset[str]:
    """Return the British spellings that codespell refuses in this project."""
    name = "dictionary_en-GB_to_en-US.txt"
    lines = (resources.files("codespell_lib") / "data" / name).read_text(encoding="utf-8").splitlines()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    ignored = {word.strip() for word in project["tool"]["codespell"]["ignore-words-list"].split(",")}
    return frozenset(line.partition("->")[0] for line in lines) - ignored | NOT_LISTED


def identifiers(tree: ast.AST) -> Iterator[str]:
    """Yield the names that a file defines, reads or passes."""
    for node in ast.walk(tree):
        for field in ("id", "name", "attr", "arg", "asname"):
            if isinstance(name := getattr(node, field, None), str):
                yield name


def found_in(text: str, words: frozenset[str]) -> set[str]:
    """Return the names of a source that are in `words`, or have a part there that is not of a library."""
    names = set(identifiers(ast.parse(text)))
    parts = words - OF_LIBRARIES
    return {name for name in names if name in words or parts & {part.lower() for part in PARTS.findall(name)}}


@pytest.mark.slow
def test_identifiers_are_american() -> None:
    words = british()
    folders = (*ROOMS, "tests", "benchmarks", "examples")
    files = (path for folder in folders for path in (ROOT / folder).rglob("*.py"))
    found = {str(path.relative_to(ROOT)): found_in(path.read_text("utf-8"), words) for path in files}
    assert {path: names for path, names in found.items() if names} == {}


def test_a_part_of_a_name_is_found() -> None:
    source = "class UnmodelledError(Exception):\n    de_energised = grey_level = 1\n"
    assert found_in(source, british()) == {"UnmodelledError", "de_energised", "grey_level"}


def test_a_word_of_a_library_is_a_part_only() -> None:
    assert found_in("acknowledgement = SubscriptionAcknowledgements()\n", british()) == {"acknowledgement"}
