"""Puts marks into Python code for observers of its lines: each statement of a function has a mark before it.

    state.number += 1        if __lines__ and 12 in __lines__: __lines__(12)
                             state.number += 1

`__lines__` is None while no line of the module is observed; a mark then takes a few nanoseconds. A mark has
the position of its statement, so that errors and waits name the same lines. The head of a loop has another
mark at the end of each pass. A `case` or an `except` counts as run when it is entered.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Container, Sequence
from contextvars import ContextVar
from functools import lru_cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

LINES = "__lines__"
"""The global variable of a module with its `Lines`; None while no line is observed."""


class Observer:
    """An observer, which is called before lines run.

    Attributes:
        lines: the numbers of the lines that it observes; None means all.
    """

    lines: Container[int] | None = None

    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        """Act before a line of a function, or before a step of a list of steps, which has no frame.

        Args:
            file: the file's name without its folder, because a copy of a program is in another folder.
        """


class LineWatch:
    """The modules with marks that are loaded in a context, and the observers of their lines."""

    def __init__(self) -> None:
        self._modules: list[Lines] = []
        self.observers: list[Observer] = []

    def add(self, observer: Observer) -> None:
        """Add an observer, or update an observer whose `lines` have changed."""
        self.only(*(present for present in self.observers if present is not observer), observer)

    def remove(self, observer: Observer) -> None:
        """Remove an observer."""
        self.only(*(present for present in self.observers if present is not observer))

    def only(self, *observers: Observer) -> None:
        """Replace all observers."""
        self.observers = list(observers)
        for module in self._modules:
            module.select()

    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        """Call the observers of a line, see `Observer.begins`."""
        for observer in self.observers:
            if observer.lines is None or line in observer.lines:
                observer.begins(file, line, frame)

    def files(self, folder: Path) -> list[Path]:
        """Return the files of its modules in a folder and its subfolders."""
        paths = dict.fromkeys(Path(module.path).resolve() for module in self._modules)
        return [path for path in paths if path.is_relative_to(folder.resolve())]

    def follow(self, lines: Lines) -> None:
        """Add a module."""
        self._modules.append(lines)
        lines.select()


WATCH: ContextVar[LineWatch] = ContextVar("WATCH", default=LineWatch())  # noqa: B039 - one for a session
"""The watch for modules that are loaded in this context."""


class Lines(set[int]):
    """The observed lines of a module; it is called before each of them runs.

    Args:
        all_lines: all lines with a mark.
        names: the global variables of the module.
    """

    def __init__(self, path: str, all_lines: Sequence[int], names: dict[str, Any]) -> None:
        super().__init__()
        self._names = names
        self.path, self.file, self._all_lines, self._watch = path, Path(path).name, all_lines, WATCH.get()
        self._watch.follow(self)

    def select(self) -> None:
        """Collect the lines of the current observers."""
        self.clear()
        for observer in self._watch.observers:
            lines = observer.lines
            self.update(
                self._all_lines if lines is None else (line for line in self._all_lines if line in lines)
            )
        self._names[LINES] = self or None

    def __call__(self, line: int) -> None:
        """Call the observers of a line."""
        self._watch.begins(self.file, line, sys._getframe(1))


@lru_cache(maxsize=16)
def marked_code(data: bytes, path: str) -> CodeType:
    """Compile a module with a mark before each line; raises a SyntaxError or ValueError as `compile` does."""
    tree = ast.parse(data, path)
    lines = mark(tree)
    head = f"from {__name__} import Lines as {LINES}; {LINES}({path!r}, {(*sorted(lines),)}, globals())"
    index = after_the_head(tree)
    tree.body[index:index] = ast.parse(head).body
    return compile(ast.fix_missing_locations(tree), path, "exec")


@lru_cache(maxsize=16)
def marked_lines(data: bytes) -> Sequence[int]:
    """Return the lines in functions of a module; lines outside functions run only while it is loaded."""
    return sorted(mark(ast.parse(data)))


def mark(tree: ast.AST) -> set[int]:
    """Put marks into the functions of a tree; return their lines."""
    marks = _Marks()
    for child in ast.iter_child_nodes(tree):
        marks.enter(child)
    return marks.lines


class _Marks:
    """Puts marks into functions."""

    def __init__(self) -> None:
        self.lines: set[int] = set()

    def enter(self, node: ast.AST) -> None:
        """Mark the functions in a node that is outside functions."""
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = self._block(node.body, None, None)
        else:
            for child in ast.iter_child_nodes(node):
                self.enter(child)

    def _block(self, body: list[ast.stmt], parent: Any, loop: ast.stmt | None) -> list[ast.stmt]:
        """Return a block of a function with marks.

        Args:
            parent: the node that contains the block, whose line has just run; None for a function.
            loop: the loop that a `continue` in the block continues.
        """
        marked, last_line = list[ast.stmt](), getattr(parent, "lineno", 0)
        for statement in body:
            if statement.lineno != last_line and not _runs_nothing(statement):
                marked.append(self._mark(statement))
            last_line = statement.lineno
            if isinstance(statement, ast.Continue) and loop is not None:
                marked.append(self._mark(loop))
            self._mark_blocks(statement, loop)
            marked.append(statement)
        return marked

    def _mark_blocks(self, node: Any, loop: ast.stmt | None) -> None:
        """Mark the blocks of a statement, a loop's head again after each pass, and each clause's head."""
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            self.enter(node)
            return
        for name in ("body", "orelse", "finalbody"):
            if block := getattr(node, name, None):
                is_loop_body = name == "body" and isinstance(node, ast.For | ast.AsyncFor | ast.While)
                marked = self._block(block, node, node if is_loop_body else loop)
                setattr(node, name, [*marked, self._mark(node)] if is_loop_body else marked)
        for clause in (*getattr(node, "handlers", ()), *getattr(node, "cases", ())):
            head = getattr(clause, "pattern", clause)  # the head of a `case`
            clause.body = [self._mark(head), *self._block(clause.body, head, loop)]

    def _mark(self, node: Any) -> ast.stmt:
        """Return a statement that reports a node's line if that line is watched; record the line."""
        self.lines.add(node.lineno)
        return located(f"if {LINES} and {node.lineno} in {LINES}: {LINES}({node.lineno})", node)


def _runs_nothing(node: ast.stmt) -> bool:
    """Return whether a statement does nothing at which a debugger could stop."""
    constant = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)  # such as a docstring
    return constant or isinstance(node, ast.Global | ast.Nonlocal)


def located(text: str, origin: Any) -> ast.stmt:
    """Return a statement that has the position of a node."""
    statement = ast.parse(text).body[0]
    for node in ast.walk(statement):
        if isinstance(node, ast.expr | ast.stmt):
            ast.copy_location(node, origin)
    return statement


def after_the_head(tree: ast.Module) -> int:
    """Return the index after the docstring and `from __future__` imports."""
    end = 0
    for index, statement in enumerate(tree.body):
        is_constant = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
        is_future = isinstance(statement, ast.ImportFrom) and statement.module == "__future__"
        if is_future or (index == 0 and is_constant):
            end = index + 1
    return end
