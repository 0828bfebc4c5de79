"""Counters that never count, and subscripts that count without a bound.

if self.parts >= 10:             but the class sets parts to 0, and nothing else assigns it
if self.full:                    with `full = Counter(10)`, but nothing calls self.full(...)
WEIGHTS[self.next]               after `self.next += 1`, but nothing compares or resets next
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from .nodes import (
    assignments_in,
    is_loaded,
    is_stored,
    last_name,
    names_in,
    nodes_in,
    parents_in,
    stored_attributes,
)
from .reader import Reader

FAILS: Mapping[type[ast.cmpop], Callable[[Any], bool]] = {
    ast.Gt: lambda number: number >= 0,
    ast.GtE: lambda number: number > 0,
    ast.Eq: lambda number: number != 0,
}
"""By comparison: returns whether 0 never satisfies the comparison with a number."""

_TESTS = (
    *(ast.Attribute, ast.BoolOp, ast.UnaryOp, ast.Compare, ast.If, ast.While, ast.IfExp, ast.Lambda),
    ast.Return,
)


def note_counting(reader: Reader, recorded: Collection[str] = ()) -> None:
    """Note counters that never count, and subscripts without a bound.

    Args:
        recorded: fields that people read and can write.
    """
    if not {"setattr", "vars", "globals"}.isdisjoint(names_in(reader.tree)):
        return
    _never_counted(reader, recorded)
    _never_set(reader)
    tables = _Tables(reader)
    _unbounded(reader, tables)
    for loop in nodes_in(reader.tree, ast.While):
        if isinstance(loop.test, ast.Constant) and loop.test.value:
            _unbounded_in(loop, reader, tables)


def never_called(reader: Reader, blocks: Collection[str]) -> None:
    """Note blocks that are never called but whose result is read.

    Args:
        blocks: names of fields that are timers, edges and counters.
    """
    parents = parents_in(reader.tree)
    loads = list(filter(is_loaded, nodes_in(reader.tree, ast.Attribute)))
    for name in blocks:
        uses = [node for node in loads if node.attr == name]
        if uses and all(_is_test(node, parents.get(id(node))) for node in uses):
            text = f"{ast.unparse(uses[0])} is read, but nothing calls it"
            reader.remark("never-run", uses[0], text)


def _is_test(node: ast.expr, parent: ast.AST | None) -> bool:
    """Whether a use of a block only tests it or reads its result, without calling it or passing it on."""
    return isinstance(parent, _TESTS) or (isinstance(parent, ast.Assign) and parent.value is node)


def _never_counted(reader: Reader, recorded: Collection[str]) -> None:
    """Note comparisons of a field that stays 0: its class and all assignments set it to 0."""
    zero = _zero_fields(reader.tree) - set(recorded)
    for node in nodes_in(reader.tree, ast.Compare):
        left, right = node.left, node.comparators[0]
        number = right.value if isinstance(right, ast.Constant) and len(node.ops) == 1 else None
        fails = FAILS.get(type(node.ops[0]))
        is_zero = isinstance(left, ast.Attribute) and left.attr in zero
        if is_zero and fails is not None and type(number) in (int, float) and fails(number):
            text = f"`{ast.unparse(node)}`: nothing counts {ast.unparse(left)}"
            reader.remark("never-run", node, text)


def _zero_fields(tree: ast.Module) -> set[str]:
    """Return the fields that classes and assignments set only to 0."""
    zero: dict[str, bool] = dict(_declared(tree))
    values = {
        id(target): _is_zero(node.value) for node in nodes_in(tree, ast.Assign) for target in node.targets
    }
    for node in filter(is_stored, nodes_in(tree, ast.Attribute)):
        zero[node.attr] = zero.get(node.attr, True) and values.get(id(node), False)
    return {name for name, is_zero in zero.items() if is_zero}


def _never_set(reader: Reader) -> None:
    """Note each bit of a global object that its class declares as False and that nothing assigns."""
    classes = {
        name: type(value)
        for name, value in reader.names.items()
        if name not in reader.local and type(value).__module__ == reader.names.get("__name__")
    }
    done = stored_attributes(reader.tree)  # attributes that are assigned, or that are already noted
    for node in nodes_in(reader.tree, ast.Attribute):
        kind = classes.get(node.value.id) if isinstance(node.value, ast.Name) else None
        if kind is not None and vars(kind).get(node.attr) is False and node.attr not in done:
            done.add(node.attr)
            text = f"{ast.unparse(node)} is read, but nothing writes it: it is always False"
            reader.remark("never-written", node, text)


def _declared(tree: ast.Module) -> Iterator[tuple[str, bool]]:
    """Yield the fields that classes declare, and whether the value of each is 0."""
    for kind in tree.body:
        if isinstance(kind, ast.ClassDef):
            for target, value in assignments_in(kind.body):
                if isinstance(target, ast.Name):
                    yield target.id, _is_zero(value)


def _is_zero(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) is int and not node.value


def _unbounded(reader: Reader, tables: _Tables) -> None:
    """Note fields that are used as subscripts, only count, and are never compared."""
    if any(nodes_in(reader.tree, ast.ExceptHandler)):
        return  # the program may expect an IndexError
    counted = list(_counted(reader.tree))
    fields = {ast.unparse(node): node.attr for node in counted if isinstance(node, ast.Attribute)}
    for text, name in fields.items():
        uses = [node for node in nodes_in(reader.tree, ast.Attribute) if node.attr == name]
        if _only_counts(uses, counted):
            _note_unbounded(text, uses, tables.elements(reader.tree, text), reader)


def _unbounded_in(loop: ast.While, reader: Reader, tables: _Tables) -> None:
    """Note a local subscript that counts in an endless loop, if nothing in the loop limits it."""
    if any(nodes_in(loop.body, ast.Break, ast.Return, ast.ExceptHandler)):
        return
    counted = [node.target for node in nodes_in(loop.body, ast.AugAssign)]
    for name in sorted({node.id for node in _counted(loop.body) if isinstance(node, ast.Name)}):
        uses = [node for node in nodes_in(loop.body, ast.Name) if node.id == name]
        if _only_counts(uses, counted):
            _note_unbounded(name, uses, tables.elements(loop.body, name), reader)


def _only_counts(uses: Iterable[ast.expr], counted: Iterable[ast.expr]) -> bool:
    """Whether all assignments of a number increment or decrement it."""
    return {id(node) for node in uses if is_stored(node)} <= {id(node) for node in counted}


def _note_unbounded(
    text: str, uses: Collection[ast.expr], elements: Sequence[ast.Subscript], reader: Reader
) -> None:
    """Note a number that is read only as a subscript of tables.

    Args:
        uses: the expressions that read or assign the number.
        elements: the elements of tables with this subscript.
    """
    if elements and len(elements) == len([node for node in uses if not is_stored(node)]):
        problem = f"{text} counts, but nothing keeps it within the table"
        reader.remark("subscript", elements[0], f"`{ast.unparse(elements[0])}`: {problem}")


def _counted(tree: ast.AST | Iterable[ast.AST]) -> Iterator[ast.expr]:
    """Yield the targets that a text increments or decrements by a constant."""
    for node in nodes_in(tree, ast.AugAssign):
        if isinstance(node.op, ast.Add | ast.Sub) and isinstance(node.value, ast.Constant):
            yield node.target


class _Tables:
    """The lists and tuples in a text: globals of the module, and fields."""

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._values: dict[str, list[ast.expr | None]] = {}  # None for a declaration without value
        for node in nodes_in(reader.tree, ast.Assign, ast.AnnAssign):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                self._values.setdefault(last_name(target), []).append(node.value)

    def elements(self, tree: ast.AST | Iterable[ast.AST], index: str) -> list[ast.Subscript]:
        """Return the elements of tables with this index text."""
        subscripts = (node for node in nodes_in(tree, ast.Subscript) if ast.unparse(node.slice) == index)
        return [node for node in subscripts if self._is_table(node.value)]

    def _is_table(self, node: ast.expr) -> bool:
        """Return whether a name or attribute is always a list or a tuple."""
        if isinstance(node, ast.Name):
            is_row = isinstance(self._reader.names.get(node.id), list | tuple)
            return is_row and node.id not in self._reader.local
        values = self._values.get(node.attr, []) if isinstance(node, ast.Attribute) else []
        return bool(values) and all(map(_is_row, values))


def _is_row(node: ast.expr | None) -> bool:
    """Whether an expression is a list, a tuple, or a list or tuple times a number."""
    first = node.left if isinstance(node, ast.BinOp) else node
    return isinstance(first, ast.List | ast.Tuple)
