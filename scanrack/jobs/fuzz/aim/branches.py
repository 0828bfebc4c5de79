"""Records the branches that Python programs take. An extra statement in each branch sets a byte.

    if status.MODULE_OK:          if status.MODULE_OK:
                                      __branches__[4] = 1
        out.load(WORDS)               out.load(WORDS)

Each extra statement has the line number of the next statement, so errors and traces show the original lines.
The code of a file is compiled once. Each run executes it again.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from types import CodeType
from typing import TypeVar

from scanrack.ladder.python.line_marks import after_the_head, located

from ...load.program import COMPILER

NAME = "__branches__"
"""Name of the global variable with the bytes, one for each branch."""

Branching = TypeVar("Branching", ast.If, ast.For, ast.AsyncFor, ast.While, ast.ExceptHandler)


@contextmanager
def branches_noted() -> Iterator[None]:
    """Instrument the branches of Python programs that are loaded in this context."""
    token = COMPILER.set(_compiled)
    try:
        yield
    finally:
        COMPILER.reset(token)


@lru_cache(maxsize=16)
def _compiled(data: bytes, file: str) -> CodeType:
    """Return the code of a file with a mark in each branch, and a global array of bytes for the marks."""
    tree = ast.parse(data, file)
    marks = _Marks()
    marks.visit(tree)
    declaration = ast.parse(f"{NAME} = bytearray({len(marks.lines)})").body
    insert_at = after_the_head(tree)
    tree.body[insert_at:insert_at] = declaration
    return compile(ast.fix_missing_locations(tree), file, "exec")


def branch_lines(data: bytes, file: str) -> list[int]:
    """Return the first line of each branch of a program, in the order of the bytes."""
    marks = _Marks()
    marks.visit(ast.parse(data, file))
    return marks.lines


class _Marks(ast.NodeTransformer):
    """Puts a mark at the beginning of each branch. Adds missing `else` branches for their marks."""

    def __init__(self) -> None:
        self.lines: list[int] = []  # line of each mark

    def visit_If(self, node: ast.If) -> ast.If:
        """Mark both branches."""
        is_elif_next = len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If)
        self._branch(node)
        if not is_elif_next:  # else the next `if` marks its own branches
            node.orelse = self._marked(node.orelse, node)
        return node

    def visit_For(self, node: ast.For) -> ast.For:
        """Mark the body."""
        return self._branch(node)

    def visit_While(self, node: ast.While) -> ast.While:
        """Mark the body."""
        return self._branch(node)

    def visit_match_case(self, node: ast.match_case) -> ast.match_case:
        """Mark the case."""
        self.generic_visit(node)
        node.body = self._marked(node.body, node.body[0])
        return node

    def visit_ExceptHandler(self, node: ast.ExceptHandler) -> ast.ExceptHandler:
        """Mark the handler."""
        return self._branch(node)

    def _branch(self, node: Branching) -> Branching:
        self.generic_visit(node)
        node.body = self._marked(node.body, node)
        return node

    def _marked(self, body: list[ast.stmt], owner: ast.AST) -> list[ast.stmt]:
        """Return a branch with a mark. The mark of an empty branch has the line of its owner."""
        first = body[0] if body else owner
        mark = located(f"{NAME}[{len(self.lines)}] = 1", first)
        self.lines.append(getattr(first, "lineno", 0))
        return [mark, *body]
