"""Names of classes: nouns of the trade, each once in a room.

A room is a folder at the top of the house; within `scanrack`, a folder below it.
"""

import ast
import re
from collections import Counter
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from house import ROOMS as TOP

HOUSE = Path(__file__).parents[3]
FILES = sorted(path.relative_to(HOUSE) for top in TOP for path in (HOUSE / top).rglob("*.py"))

IRREGULAR = re.compile(
    "begun|bought|bound|broken|brought|built|caught|chosen|done|drawn|driven|felt|found|frozen|given|gone|got|grown|"
    "(?:un)?heard|held|hidden|kept|known|laid|learnt|left|lent|lost|made|meant|met|paid|ran|said|seen|sent|shown|sold|sought|"
    "spent|spoken|stood|struck|sunk|taken|taught|thought|thrown|told|torn|understood|won|worn|written"
)
"""Participles, and forms of the past, that do not end in -ed."""

NOUNS = frozenset(("bed", "feed", "need", "seed", "speed"))
"""Nouns that end in -ed."""

PARTICIPLES_ALLOWED = {
    "CommandAborted": "PLCopen's name of the outcome; it is in the front door and in docs/sequences.md",
}
"""Class names that may be participles, and why."""


def room_of(path: Path) -> str:
    """Return the room of a file.

    >>> room_of(Path("scanrack/jobs/run/build.py")), room_of(Path("ladder/model/tags.py"))
    ('scanrack/jobs', 'ladder')
    """
    parts = path.parts[:-1]
    return "/".join(parts[: 2 if parts[0] == "scanrack" else 1])


def is_participle(name: str) -> bool:
    """Return whether the last word of a class name is a participle.

    >>> [is_participle(name) for name in ("Told", "LinkLost", "ForcedValue", "Speed")]
    [True, True, False, False]
    """
    word = re.findall(r"[A-Z]+[a-z0-9]*|[a-z0-9]+", name)[-1].lower()
    return bool(IRREGULAR.fullmatch(word)) or (word.endswith("ed") and word not in NOUNS)


class NamedClass(NamedTuple):
    """A class of the product."""

    path: Path
    line: int
    name: str


class Names(NamedTuple):
    """What is kept of all sources: their trees would take hundreds of megabytes."""

    classes: list[NamedClass]
    renamed: list[tuple[Path, str, str]]  # imports of names of ours as another: file, name, new name


@cache
def names() -> Names:
    """Return the classes and the renaming imports of the product."""
    found = Names([], [])
    for path in FILES:
        for node in ast.walk(ast.parse((HOUSE / path).read_text("utf-8"))):
            if isinstance(node, ast.ClassDef):
                found.classes.append(NamedClass(path, node.lineno, node.name))
            elif isinstance(node, ast.ImportFrom) and (
                node.level or (node.module or "").startswith("scanrack.")
            ):
                pairs = ((each.name, each.asname) for each in node.names)
                found.renamed.extend((path, old, new) for old, new in pairs if new not in (None, old))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("room", sorted({room_of(path) for path in FILES}))
def test_no_two_classes_of_a_room_have_one_name(room: str) -> None:
    here = [each for each in names().classes if room_of(each.path) == room]
    counts = Counter(each.name for each in here)
    twice = [f"{each.name}: {each.path}:{each.line}" for each in here if counts[each.name] > 1]
    assert not twice, "two classes of one name in a room:\n" + "\n".join(sorted(twice))


@pytest.mark.slow
def test_no_class_is_called_by_a_participle() -> None:
    named = [
        f"{each.name}: {each.path}:{each.line}"
        for each in names().classes
        if is_participle(each.name) and each.name not in PARTICIPLES_ALLOWED
    ]
    assert not named, "a class is a noun; these are participles:\n" + "\n".join(named)


@pytest.mark.slow
def test_what_may_be_a_participle_exists() -> None:
    assert PARTICIPLES_ALLOWED.keys() <= {each.name for each in names().classes}


@pytest.mark.slow
def test_classes_that_meet_have_different_names() -> None:
    ours = {each.name for each in names().classes}
    renamed = [f"{path}: {old} as {new}" for path, old, new in names().renamed if old in ours]
    assert renamed == ALIASES_ALLOWED, "two names meet in a file; give one class another name"


ALIASES_ALLOWED = [
    "scanrack/jobs/fuzz/aim/probe.py: Sequence as LogicSequence",
    "scanrack/jobs/fuzz/run.py: Sequence as LogicSequence",
]
"""`Sequence` is also the name of a type of the standard library."""
