"""No function of the product branches in more ways than a reader keeps in mind."""

import ast
from collections.abc import Iterator

import pytest
from house import ROOMS, ROOT

MOST = 15

WAYS = (
    *(ast.If, ast.For, ast.While, ast.AsyncFor, ast.ExceptHandler),
    *(ast.IfExp, ast.comprehension, ast.match_case, ast.Assert),
)
"""Nodes that add a way each; a comprehension adds its conditions, `and` and `or` their operands but one."""

APART = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)
"""What a function contains and counts by itself."""


def ways_of(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the number of ways through a function, without those of functions inside it."""
    return 1 + sum(map(_ways, _own_nodes(function)))


def _own_nodes(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[ast.AST]:
    left: list[ast.AST] = list(function.body)
    while left:
        node = left.pop()
        if not isinstance(node, APART):
            yield node
            left.extend(ast.iter_child_nodes(node))


def _ways(node: ast.AST) -> int:
    if isinstance(node, ast.BoolOp):
        return len(node.values) - 1
    return isinstance(node, WAYS) + (len(node.ifs) if isinstance(node, ast.comprehension) else 0)


@pytest.mark.slow  # reads all modules
def test_a_function_branches_in_few_ways() -> None:
    many = {
        f"{path.relative_to(ROOT)}: {node.name}": ways
        for room in ROOMS
        for path in (ROOT / room).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and (ways := ways_of(node)) > MOST
    }
    assert not many


def test_each_kind_of_branch_counts() -> None:
    """By hand: 1, the loop, its if with `and`, the conditional value, the comprehension, the handler."""
    text = """
def f(a, b):
    def inner():
        if a: pass
    for each in a:
        if each and b:
            c = 1 if b else 2
    try:
        return [x for x in a if x]
    except OSError:
        return []
"""
    [function] = ast.parse(text).body
    assert isinstance(function, ast.FunctionDef)
    assert ways_of(function) == 1 + 1 + 2 + 1 + 2 + 1
