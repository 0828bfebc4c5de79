"""Identifies the awaits of a function by their path in the syntax tree and their text.

    while True:                              ("while",)
        for station in self.stations:        ("for station in self.stations",)
            await dwell("2 s")               the first await of this text at this path

The path includes the condition of an `if`, but not the test of a `while`, which is evaluated again.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any, NamedTuple

from scanrack.io_images.dataclass import dataclass

from .suspended import BlockKind, Range

Function = ast.AsyncFunctionDef

NESTED = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)
"""Nodes with their own scope."""

_COMPOUND = (ast.If, ast.While, ast.For, ast.Match, ast.With, ast.AsyncWith)
"""Statements with a head that may contain an await."""


@dataclass(frozen=True, slots=True)
class BlockStep:
    """A compound statement around an await."""

    node: ast.AST
    field: str  # its part, such as body, test or orelse
    head: str  # its text
    inner: ast.AST | None = None  # the handler or case


@dataclass(frozen=True, slots=True)
class Point:
    """An await, or the entry of an `async with`."""

    node: ast.Await | ast.AsyncWith
    steps: tuple[BlockStep, ...]  # outermost first
    statement: ast.stmt
    text: str

    @property
    def key(self) -> tuple[str, ...]:
        """Its path and its text."""
        return (*(f"{step.field}: {step.head}" for step in self.steps), self.text)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Its path with the kinds of statements instead of their text, and its own text."""
        return (*(f"{step.field} {type(step.node).__name__}" for step in self.steps), self.text)

    @property
    def block_kinds(self) -> list[BlockKind]:
        """The kinds of its open blocks that keep objects on the stack, outermost first."""
        block_kinds: list[BlockKind] = []
        for step in self.steps:
            if isinstance(step.node, ast.For) and step.field == "body":
                block_kinds.append(BlockKind.ITERATOR)
            elif isinstance(step.node, ast.With | ast.AsyncWith) and step.field == "body":
                block_kinds += [BlockKind.EXIT] * len(step.node.items)
            elif step.field == "handlers":
                block_kinds.append(BlockKind.HANDLER)
        if isinstance(self.node, ast.AsyncWith):
            block_kinds.append(BlockKind.EXIT)
        return block_kinds

    def is_at(self, position: Range) -> bool:
        """Return whether a source position, as Python reports it, is the position of this point."""
        if isinstance(self.node, ast.AsyncWith):
            return position in (_range(self.node), _range(self.node.items[0].context_expr))
        return position == _range(self.node)


class PlacedAwait(NamedTuple):
    """A point and its function."""

    function: Function
    point: Point


def points_of(function: Function) -> list[Point]:
    """Return all points of a function, in order."""
    return [point for statement in function.body for point in _points(statement, ())]


def _points(node: ast.stmt, steps: tuple[BlockStep, ...]) -> Iterator[Point]:
    """Yield the points of a statement in order; `steps` are the blocks around it, outermost first."""
    if isinstance(node, NESTED):
        return
    if isinstance(node, ast.AsyncWith):
        yield Point(node, steps, node, _head(node))
    for field, value in ast.iter_fields(node):
        head = _head(node)
        if isinstance(value, list) and value and isinstance(value[0], ast.stmt):
            for child in value:
                yield from _points(child, (*steps, BlockStep(node, field, head)))
        elif field in ("handlers", "cases"):
            for child in value:
                clause = BlockStep(node, field, f"{head} {_inner_head(child)}", child)
                for statement in child.body:
                    yield from _points(statement, (*steps, clause))
        else:
            is_compound = isinstance(
                node, ast.If | ast.While | ast.For | ast.Match | ast.With | ast.AsyncWith
            )
            head_steps = (*steps, BlockStep(node, field, "")) if is_compound else steps
            for awaited in _awaits(value):
                yield Point(awaited, head_steps, node, ast.unparse(awaited))


def _awaits(value: object) -> Iterator[ast.Await]:
    """Yield the awaits in a node or list in order of evaluation, inner ones first."""
    nodes = value if isinstance(value, list) else [value]
    for node in nodes:
        if not isinstance(node, ast.AST) or isinstance(node, NESTED):
            continue
        for _, child in ast.iter_fields(node):
            yield from _awaits(child)
        if isinstance(node, ast.Await):
            yield node


def _head(node: ast.stmt) -> str:
    """Return the text of the condition or head that leads into a statement."""
    match node:
        case ast.If():
            return f"if {ast.unparse(node.test)}"
        case ast.For():
            return f"for {ast.unparse(node.target)} in {ast.unparse(node.iter)}"
        case ast.With() | ast.AsyncWith():
            word = "async with" if isinstance(node, ast.AsyncWith) else "with"
            return f"{word} {', '.join(map(ast.unparse, node.items))}"
        case ast.Match():
            return f"match {ast.unparse(node.subject)}"
        case _:
            return type(node).__name__.lower()


def _inner_head(node: ast.AST) -> str:
    """Return the text of an `except` or `case`; "" for other nodes."""
    if isinstance(node, ast.ExceptHandler):
        kind = "" if node.type is None else f" {ast.unparse(node.type)}"
        return f"except{kind}" + (f" as {node.name}" if node.name else "")
    if isinstance(node, ast.match_case):
        guard = "" if node.guard is None else f" if {ast.unparse(node.guard)}"
        return f"case {ast.unparse(node.pattern)}{guard}"
    return ""


def _range(node: ast.expr | ast.stmt) -> Range:
    return (node.lineno, node.end_lineno or 0, node.col_offset, node.end_col_offset or 0)


class NoCounterpartError(ValueError):
    """An await has no certain counterpart in the edited function."""


def end_of(point: Point) -> tuple[int, int]:
    """Return the end of the code that may have run before a point: its outermost loop's end, or its own."""
    loops = [step.node for step in point.steps if isinstance(step.node, ast.For | ast.While)]
    node: Any = loops[0] if loops else point.node
    return (node.end_lineno, node.end_col_offset) if loops else (node.lineno, node.col_offset + 1)


def counterpart(point: Point, old_points: list[Point], new_points: list[Point]) -> Point:
    """Return the point of an edited function that matches a point of the original function.

    Raises:
        NoCounterpartError: there is no match, or several points could match.
    """
    old_matches = [candidate for candidate in old_points if candidate.key == point.key]
    new_matches = [candidate for candidate in new_points if candidate.key == point.key]
    if len(old_matches) == len(new_matches):
        match = new_matches[old_matches.index(point)]
        old_count, new_count = (_count_reached(*pair) for pair in ((point, old_points), (match, new_points)))
        if old_count == new_count:
            return match
        old_matches, new_matches = [point] * old_count, [match] * new_count  # only counted, in the message
    if new_matches:
        raise NoCounterpartError(
            f"`{point.text}` occurs {_times(len(new_matches))}, before {_times(len(old_matches))}; "
            "the matching one is not certain"
        )
    moved = next((candidate for candidate in new_points if candidate.kinds == point.kinds), None)
    if moved is not None:
        pairs = zip(point.steps, moved.steps, strict=True)
        old, new = next(
            (original.head, edited.head) for original, edited in pairs if original.head != edited.head
        )
        raise NoCounterpartError(f"the statement around it, `{old}`, is now `{new}`")
    raise NoCounterpartError(f"`{point.text}` is no longer at its place")


def _count_reached(point: Point, points: list[Point]) -> int:
    """Return the number of points with the same text that may have been reached before a point."""
    end = end_of(point)
    reached = (other.node for other in points if other.text == point.text)
    return sum((node.lineno, node.col_offset) < end for node in reached)


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
