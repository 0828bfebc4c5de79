"""Checks that a waiting frame has the locals that the edited function would have at the same await.

A local that may be read after the await must exist, and its value must come from unchanged statements.
Otherwise it would have another value in the edited function.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from .points import NESTED, Function, PlacedAwait, Point, end_of

Names = frozenset[str]


class LocalsError(ValueError):
    """A local that does not fit."""


def names_needed(body: list[ast.stmt], point: Point) -> Names:
    """Return the names that may be read after a point before being assigned, and names in its await."""
    needed = set(_Reads().names_in(body))
    target = point.node.items[0] if isinstance(point.node, ast.AsyncWith) else point.node
    needed.update(node.id for node in ast.walk(target) if isinstance(node, ast.Name))
    return frozenset(name for name in needed if not name.startswith("."))


class _Reads:
    """Collects names that may be read before they are assigned."""

    def __init__(self) -> None:
        self._names_read: set[str] = set()

    def names_in(self, body: list[ast.stmt]) -> set[str]:
        """Return the names that statements may read before they assign them."""
        self._block(body, frozenset())
        return self._names_read

    def _block(self, statements: list[ast.stmt], bound: Names) -> Names:
        """Collect the reads of statements; return the names that are bound after them."""
        for statement in statements:
            bound = self._statement(statement, bound)
        return bound

    def _statement(self, node: ast.stmt, bound: Names) -> Names:
        """Collect the reads of a statement; return the names that are certainly bound after it."""
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            self._read(node, bound)
            return bound | {node.name}
        for field, value in ast.iter_fields(node):
            if field not in _BLOCKS:
                self._read(value, bound)
        if isinstance(node, ast.If):
            branches = [self._block(block, bound) for block in (node.body, node.orelse) if not _leaves(block)]
            return frozenset.intersection(*branches) if branches else bound
        if isinstance(node, ast.With | ast.AsyncWith):
            return self._block(node.body, bound | _names(node.items))
        if isinstance(node, ast.For):
            self._block(node.body, bound | _names(node.target))
            return bound & self._block(node.orelse, bound) if node.orelse else bound
        if isinstance(node, ast.Try | ast.While | ast.TryStar | ast.Match):
            return self._visit_blocks(node, bound)
        return (bound | _names(node)) - _names(node, ast.Del)

    def _visit_blocks(self, node: ast.AST, bound: Names) -> Names:
        """Visit the blocks of a statement; the program may leave each block at any point."""
        for field in _BLOCKS:
            value = getattr(node, field, [])
            if field in ("handlers", "cases"):
                for clause in value:
                    head = [
                        child for child in ast.iter_child_nodes(clause) if not isinstance(child, ast.stmt)
                    ]
                    self._read(head, bound)
                    self._block(clause.body, bound | _names_bound(clause))
            else:
                self._block(value, bound)
        return bound

    def _read(self, value: object, bound: Names) -> None:
        """Collect the names in a node or list that are read while not bound; `x += 1` reads `x`."""
        for node in _nodes(value):
            names = (inner for inner in ast.walk(node) if isinstance(inner, ast.Name))
            self._names_read |= {name.id for name in names if not isinstance(name.ctx, ast.Store)} - bound
            if isinstance(node, ast.AugAssign):
                self._names_read |= _names(node.target) - bound


def _leaves(block: list[ast.stmt]) -> bool:
    """Return whether a block ends by leaving the enclosing statements, such as by `return`."""
    return bool(block) and isinstance(block[-1], ast.Return | ast.Raise | ast.Continue | ast.Break)


_BLOCKS = ("body", "handlers", "cases", "orelse", "finalbody")


def _names(value: Any, context: type[ast.expr_context] = ast.Store) -> Names:
    """Return the names in one or more nodes that are stored, or used in another context."""
    names = (inner for node in _nodes(value) for inner in ast.walk(node) if isinstance(inner, ast.Name))
    return frozenset(name.id for name in names if isinstance(name.ctx, context))


def _captured(case: ast.AST) -> Names:
    """Return the names that the patterns of a case capture."""
    return frozenset(
        str(node.name)
        for node in ast.walk(case)
        if isinstance(node, ast.MatchAs | ast.MatchStar) and node.name
    )


# --- where values come from


def check_origins(
    needed: Collection[str],
    old_await: PlacedAwait,
    new_await: PlacedAwait,
    changed: Collection[str],
    loops: Collection[str] = (),
) -> None:
    """Raise a LocalsError for a needed local that would have another value in the edited function.

    Args:
        changed: names that the edit changes; attributes begin with a dot.
        loops: heads of loops whose passes so far are the same.
    """
    old, new = _origins(*old_await), _origins(*new_await)
    checked: set[str] = set()
    waiting = sorted(needed)
    while waiting:
        name = waiting.pop()
        if name in checked:
            continue
        checked.add(name)
        earlier_texts, later_texts = old.get(name, {}), new.get(name, {})
        if earlier_texts.keys() != later_texts.keys():
            changed_texts = [text for text in later_texts if text not in earlier_texts]
            changed_texts += [text for text in earlier_texts if text not in later_texts]
            raise LocalsError(f"its local {name} comes from a line that has changed: `{changed_texts[0]}`")
        for text, read in later_texts.items():
            if text.endswith(tuple(loops)):
                continue
            check_unchanged(f"its local {name} comes from `{text}`", read, changed)
        waiting += sorted(local for names in later_texts.values() for local in names)


def check_unchanged(description: str, read: Collection[str], changed: Collection[str]) -> None:
    """Raise a LocalsError if an expression reads a name that the edit changes."""
    for name in sorted(set(read) & set(changed)):
        raise LocalsError(f"{description}, and {name.lstrip('.')} has changed")


def _origins(function: Function, point: Point) -> dict[str, dict[str, Names]]:
    """For each local at a point, return the statements that may have set it, and the names they read."""
    origins: dict[str, dict[str, Names]] = {}
    head = f"def {function.name}({ast.unparse(function.args)})"
    for argument in function.args.args + function.args.kwonlyargs + function.args.posonlyargs:
        origins.setdefault(argument.arg, {})[head] = frozenset()
    end = end_of(point)
    for text, names, read in _setting(function.body, end, ""):
        for name in names:
            origins.setdefault(name, {})[text] = read
    return origins


def _setting(
    statements: list[ast.stmt], end: tuple[int, int], above: str
) -> Iterator[tuple[str, Names, Names]]:
    """Yield the statements before a position that set names: text, names set, names read."""
    for node in statements:
        if (node.lineno, node.col_offset) >= end:
            continue
        if isinstance(node, NESTED):
            yield f"{above}{ast.unparse(node)}", frozenset({getattr(node, "name", "")}), frozenset()
            continue
        head = f"{above}{ast.unparse(node).splitlines()[0]}"
        names, read = _in_head(node)
        if names:
            yield head, names, read
        yield from _setting_below(node, end, f"{head} " if isinstance(node, ast.If | ast.Match) else above)


def _in_head(node: ast.stmt) -> tuple[Names, Names]:
    """Return the names that a statement sets and reads outside its blocks."""
    heads: list[Any] = [value for field, value in ast.iter_fields(node) if field not in _BLOCKS]
    nodes = [inner for value in heads for inner in _nodes(value)]
    return _names(nodes), _loaded(nodes)


def _setting_below(node: ast.stmt, end: tuple[int, int], above: str) -> Iterator[tuple[str, Names, Names]]:
    """Yield the statements in the blocks of a statement that set names, see `_setting`."""
    for statement in (inner for field in _BLOCKS for inner in getattr(node, field, [])):
        if isinstance(statement, ast.stmt):
            yield from _setting([statement], end, above)
        elif isinstance(statement, ast.ExceptHandler | ast.match_case):
            head = f"{above}{ast.unparse(statement).strip().splitlines()[0]}"
            bound = _names_bound(statement)
            if bound:
                yield head, bound, _loaded([statement])
            yield from _setting(statement.body, end, f"{head} ")


def _names_bound(head: ast.ExceptHandler | ast.match_case) -> Names:
    """Return the names that `except ... as` or a pattern sets."""
    if isinstance(head, ast.match_case):
        return _captured(head)
    return frozenset({head.name} if head.name else ())


def _nodes(value: object) -> list[ast.AST]:
    return [item for item in (value if isinstance(value, list) else [value]) if isinstance(item, ast.AST)]


def _loaded(nodes: list[Any]) -> Names:
    """Return the names that nodes read; attributes begin with a dot."""
    attributes = (inner for node in nodes for inner in ast.walk(node) if isinstance(inner, ast.Attribute))
    return _names(nodes, ast.Load) | {f".{attribute.attr}" for attribute in attributes}


def names_read(node: ast.AST) -> Names:
    """Return the names that an expression reads; attributes begin with a dot."""
    return _loaded([node])


def check_bound(needed: Collection[str], local_names: Collection[str], values: Mapping[str, Any]) -> None:
    """Raise a LocalsError for a local of a function that is needed but missing in the frame."""
    for name in sorted(needed):
        if name in local_names and name not in values:
            raise LocalsError(f"its local {name} has no value; the edited function sets it before this await")
