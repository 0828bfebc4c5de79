"""No pattern of the product keeps memory for each repeat of a group.

A backtracking repeat of a group, `(?:a|b)*`, keeps some 150 bytes for each time that it matched: a text of
some megabytes takes gigabytes. A possessive one, `(?:a|b)*+`, keeps none and never tries a repeat again.
A repeat of one character or of one class, `[ab]*`, keeps none either way.
"""

from __future__ import annotations

import ast
import importlib
import pkgutil
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from re import _constants as kinds
from re import _parser as parser
from typing import Any

import pytest
import scanrack
from house import ROOMS

ROOT = Path(__file__).parents[3]
OF_ONE_CHARACTER = {kinds.LITERAL, kinds.NOT_LITERAL, kinds.ANY, kinds.IN}
BOUNDED = 5_000
"""A repeat of at most so many times is bounded: the matched names and numbers are short."""


def backtracking(tree: Iterable[tuple[Any, Any]]) -> Iterator[str]:
    """Yield the unbounded repeats of groups in a parsed pattern that are not possessive."""
    for kind, of in tree:
        if kind in (kinds.MAX_REPEAT, kinds.MIN_REPEAT):
            _, most, body = of
            if most > BOUNDED and not of_one_character(body):
                yield str(body)
        if isinstance(of, list | tuple | parser.SubPattern):
            yield from backtracking(subtrees(of))


def of_one_character(body: Any) -> bool:
    if len(body) != 1:
        return False
    (kind, of) = body[0]
    return kind in OF_ONE_CHARACTER or (
        kind is kinds.SUBPATTERN and of[0] is None and of_one_character(of[-1])
    )


def subtrees(of: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the items of all parsed patterns inside of an operand."""
    for each in of:
        if isinstance(each, parser.SubPattern):
            yield from each
        elif isinstance(each, list | tuple):
            yield from subtrees(each)


def compiled(value: object, depth: int = 0) -> Iterator[re.Pattern[Any]]:
    """Yield the patterns of a value of a module: itself, or in a table."""
    if isinstance(value, re.Pattern):
        yield value
    elif depth < 3 and isinstance(value, dict | list | tuple):
        for each in value.values() if isinstance(value, dict) else value:
            yield from compiled(each, depth + 1)


def patterns() -> Iterator[tuple[str, str | bytes, int]]:
    """Yield the place, the text and the flags of every pattern of the product."""
    for module in pkgutil.walk_packages(scanrack.__path__, "scanrack."):
        for name, value in attributes(module.name):
            for each in compiled(value):
                yield f"{module.name}.{name}", each.pattern, each.flags
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text("utf-8"))):
                if (text := pattern_of(node)) is not None:
                    yield path.relative_to(ROOT).as_posix(), text, 0


def attributes(module: str) -> list[tuple[str, object]]:
    """Return the names and values of a module; none where a package that it needs is not installed."""
    if module.endswith("__main__"):
        return []
    try:
        return list(vars(importlib.import_module(module)).items())
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("scanrack"):
            raise
        return []


def pattern_of(node: ast.AST) -> str | bytes | None:
    """Return the pattern that a call of a function of `re` writes out; None for all else."""
    if (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and isinstance(node.func.value, ast.Name)
        and node.func.value.id == "re"
        and node.args
        and isinstance(node.args[0], ast.Constant)
        and isinstance(node.args[0].value, str | bytes)
    ):
        return node.args[0].value
    return None


@pytest.mark.slow
def test_every_repeat_of_a_group_is_possessive() -> None:
    found = dict.fromkeys(
        (place, text) for place, text, flags in patterns() if any(backtracking(parser.parse(text, flags)))
    )
    assert list(found) == []


@pytest.mark.parametrize(
    ("pattern", "how_many"),
    [
        (r'"(?:\\.|[^"])*"', 1),
        (r'"(?:\\.|[^"])*+"', 0),
        (r"a(?:bc)+?d", 1),
        (r"(?:(?:ab|c)*|d)+", 2),
        (r"(?P<all>x(?:ab|c)*)|y", 1),
        (r"(?=(?:ab|c)*)", 1),
        (r"[^\n]*(?:a)*(?:ab){0,9}.*?", 0),
    ],
)
def test_a_repeat_is_found_wherever_it_stands(pattern: str, how_many: int) -> None:
    assert len(list(backtracking(parser.parse(pattern)))) == how_many
