"""Retired words in docs, help and messages may only get fewer. Code, decisions and changes are exempt."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import typer
from commands_page import commands
from house import ROOMS
from scanrack.commands import build

ROOT = Path(__file__).parents[3]
CODE = re.compile(r"```.*?```|^ {4}.*?$|`[^`\n]*`|\]\([^)]*\)", re.DOTALL | re.MULTILINE)


class Retired(NamedTuple):
    """What replaces a word, and how many are left: lower a number when you have replaced one."""

    instead: str
    docs: int
    help: int
    messages: int


RETIRED = {
    r"surroundings": Retired("conditions, scenario", 0, 0, 0),
    r"incidents?": Retired("injected fault", 2, 0, 0),
    r"readings?": Retired("interpretation", 104, 0, 6),
    r"(?:any|no|every|some)body": Retired("you, anyone, no one", 0, 0, 0),
    r"any more": Retired("no longer", 0, 0, 0),
    r"allowed (?:is|are)": Retired("must be", 1, 0, 0),
    r"there (?:is|are) no": Retired("no ...", 0, 0, 0),
    r"mend\w*": Retired("fix", 0, 0, 0),
    r"dear": Retired("slow, expensive", 0, 0, 0),
    r"told": Retired("reported, event", 0, 0, 1),
    r"to and fro": Retired("back and forth", 0, 0, 0),
    r"(?:look|search)(?:s|es|ing|ed)? for home": Retired("home", 2, 0, 9),
    r"as it is": Retired("unchanged", 3, 0, 0),
    r"anew": Retired("again, restart", 0, 0, 0),
    r"laws?": Retired("invariant", 0, 0, 0),
    r"claims?": Retired("property", 0, 0, 4),
    r"whatever the": Retired("in every case", 2, 0, 1),
    r"of (?:ours|yours|its own|their own|one's own)": Retired("own, your", 0, 0, 4),
    r"go(?:es)? on": Retired("continue", 15, 0, 11),
    r"none of (?:them|these|its)": Retired("no", 1, 0, 3),
    r"room": Retired("package, space", 1, 0, 2),
    r"house": Retired("package", 0, 0, 0),
    r"deeds?": Retired("response, completion", 0, 0, 0),
    r"bolted": Retired("in a slot", 0, 0, 2),
    r"troubles?": Retired("error, fault", 0, 0, 4),
    r"CPU": Retired("controller", 29, 1, 24),
    r"frozen": Retired("held in last state", 0, 0, 1),
    r"session files?|recording for the file": Retired("trace", 0, 0, 0),
    r"(?:handed|taken) over": Retired("accepted, assembled", 0, 0, 3),
    r"what must hold": Retired("property, invariant", 2, 0, 0),
    r"broken scenarios?": Retired("counterexample", 0, 0, 0),
    r"Most (?:rows|records|that)": Retired("maximum", 0, 0, 2),
    r"(?:de-)?energi[s]\w*|behaviours?|colou\w*|licence|neighbo[u]r\w*|\w+[bdt]elled|towards": Retired(
        "American spelling", 1, 0, 6
    ),
}
"""The words that a native engineer would not use here, as patterns of whole words."""

FINDERS = {word: re.compile(rf"\b(?:{word})\b", re.IGNORECASE) for word in RETIRED}
ANY = re.compile(rf"\b(?:{'|'.join(RETIRED)})\b", re.IGNORECASE)


@cache
def docs() -> str:
    """Return the prose of the book, without code and targets of links."""
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]
    return "\n".join(
        CODE.sub("", page.read_text(encoding="utf-8"))
        for page in sorted(pages)
        if not {"decisions", "changes"} & set(page.parts)
    )


@cache
def helps() -> str:
    """Return what `--help` prints of all commands: their texts, and those of their options."""
    found = []
    for _, command in commands(typer.main.get_command(build())):
        found += [command.help or "", *(each.help or "" for each in command.params if hasattr(each, "help"))]
    return "\n".join(found)


def docstrings(tree: ast.AST) -> Iterator[Any]:
    """Yield the strings that stand as statements."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield node.value


def texts(source: str) -> Iterator[str]:
    """Yield the strings of several words in a source, except docstrings; an f-string in its parts."""
    tree = ast.parse(source)
    aside = {id(each) for each in docstrings(tree)}
    for node in ast.walk(tree):
        value = node.value if isinstance(node, ast.Constant) and id(node) not in aside else None
        if isinstance(value, str) and " " in value:
            yield value


@cache
def messages() -> str:
    """Return the strings of the product's sources that say something."""
    sources = (
        path.read_text(encoding="utf-8") for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))
    )
    return "\n".join(text for source in sources if ANY.search(source) for text in texts(source))


def grown(text: str, place: Callable[[Retired], int]) -> list[str]:
    """Return the words that are more than were left, each with what to write instead and where it stands."""
    found = []
    sentences = text.splitlines(keepends=True)
    text = "".join(each for each in sentences if ANY.search(each))  # few have one of many words
    for word, retired in RETIRED.items():
        hits = [text[max(0, hit.start() - 40) : hit.end() + 30] for hit in FINDERS[word].finditer(text)]
        if len(hits) > place(retired):
            lines = "".join(f"\n    ...{' '.join(each.split())}..." for each in hits)
            found.append(f"{word}: {len(hits)}, at most {place(retired)}; write {retired.instead}{lines}")
    return found


def test_docs_have_no_more_retired_words() -> None:
    assert "\n".join(grown(docs(), lambda left: left.docs)) == ""


def test_help_has_no_more_retired_words() -> None:
    assert "\n".join(grown(helps(), lambda left: left.help)) == ""


@pytest.mark.slow  # it parses the sources
def test_messages_have_no_more_retired_words() -> None:
    assert "\n".join(grown(messages(), lambda left: left.messages)) == ""


def test_code_is_exempt_and_a_new_word_is_named() -> None:
    prose = CODE.sub("", "Mend it:\n\n    $ mend --dear\n\n```\nmend\n```\nand `mend` or [that](mend.md)\n")
    assert [len(FINDERS[word].findall(prose)) for word in (r"mend\w*", "dear")] == [1, 0]
    (mended,) = grown("It is dear." * (RETIRED["dear"].docs + 1), lambda left: left.docs)
    assert mended.startswith(f"dear: {RETIRED['dear'].docs + 1}, at most")
    assert "write slow, expensive" in mended
    assert list(texts('"""Is no text."""\nX = "a word"\nY = f"so {X} many"\n')) == ["a word", "so ", " many"]
