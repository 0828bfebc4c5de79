"""Counters that nothing counts, and subscripts that count without a bound.

if self.parts >= 10:             and parts is 0 in the class, and nothing assigns it
if self.full:                    of `full = Counter(10)`, and nothing calls self.full(...)
WEIGHTS[self.next]               after `self.next += 1`, and nothing compares next, or takes it back
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from ..facts import Facts, FileLine
from .reader import Reader

FAILS: Mapping[type[ast.cmpop], Callable[[Any], bool]] = {
    ast.Gt: lambda number: number >= 0,
    ast.GtE: lambda number: number > 0,
    ast.Eq: lambda number: number != 0,
}
"""Whether 0 never meets a comparison with a number."""

_TESTS = (
    *(ast.Attribute, ast.BoolOp, ast.UnaryOp, ast.Compare, ast.If, ast.While, ast.IfExp, ast.Lambda),
    ast.Return,
)


def note_counting(reader: Reader, facts: Facts, recorded: Collection[str] = ()) -> None:
    """Note counters that nothing counts, and subscripts without a bound.

    Args:
        recorded: fields that people read, and may write.
    """
    nodes = list(ast.walk(reader.tree))
    if any(isinstance(node, ast.Name) and node.id in ("setattr", "vars", "globals") for node in nodes):
        return
    _never_counted(reader, nodes, facts, recorded)
    _never_set(reader, nodes, facts)
    _unbounded(reader, nodes, facts)
    for node in nodes:
        if isinstance(node, ast.While) and isinstance(node.test, ast.Constant) and node.test.value:
            _unbounded_in(node, reader, nodes, facts)


def never_called(reader: Reader, blocks: Collection[str], facts: Facts) -> None:
    """Note blocks whose result is read, and that nothing calls.

    Args:
        blocks: names of fields that are timers, edges and counters.
    """
    parents = {id(child): node for node in ast.walk(reader.tree) for child in ast.iter_child_nodes(node)}
    for name in blocks:
        used = [
            node for node in ast.walk(reader.tree) if isinstance(node, ast.Attribute) and node.attr == name
        ]
        loads = [node for node in used if isinstance(node.ctx, ast.Load)]
        if loads and all(_is_test(node, parents.get(id(node))) for node in loads):
            text = f"{ast.unparse(loads[0])} is read, and nothing calls it"
            facts.remark("never-run", FileLine(reader.file, loads[0].lineno), text)


def _is_test(node: ast.expr, parent: ast.AST | None) -> bool:
    """Whether a block is tested, or its result is read: it is not called, and not handed to anything."""
    return isinstance(parent, _TESTS) or (isinstance(parent, ast.Assign) and parent.value is node)


def _never_counted(reader: Reader, nodes: list[ast.AST], facts: Facts, recorded: Collection[str]) -> None:
    """Note comparisons of a field that stays 0: its class declares 0, and all that is assigned to it is 0."""
    zero: dict[str, bool] = dict(_declared(reader.tree))
    values = {
        id(target): _is_zero(node.value)
        for node in nodes
        if isinstance(node, ast.Assign)
        for target in node.targets
    }
    for node in nodes:
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            zero[node.attr] = zero.get(node.attr, True) and values.get(id(node), False)
    for node in nodes:
        if not isinstance(node, ast.Compare) or len(node.ops) != 1:
            continue
        left, right, fails = node.left, node.comparators[0], FAILS.get(type(node.ops[0]))
        number = right.value if isinstance(right, ast.Constant) else None
        is_own = isinstance(left, ast.Attribute) and zero.get(left.attr, False) and left.attr not in recorded
        if is_own and fails is not None and type(number) in (int, float) and fails(number):
            text = f"`{ast.unparse(node)}`: nothing counts {ast.unparse(left)}"
            facts.remark("never-run", FileLine(reader.file, node.lineno), text)


def _never_set(reader: Reader, nodes: list[ast.AST], facts: Facts) -> None:
    """Note a bit of an object of the module that a class declares as False, and that nothing assigns."""
    objects = {
        name: type(value)
        for name, value in reader.names.items()
        if type(value).__module__ == reader.names.get("__name__") and name not in reader.local
    }
    stored = {
        node.attr for node in nodes if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    }
    seen: set[str] = set()
    for node in nodes:
        if not isinstance(node, ast.Attribute) or not isinstance(node.value, ast.Name):
            continue
        kind = objects.get(node.value.id)
        if kind is not None and vars(kind).get(node.attr) is False and node.attr not in stored | seen:
            seen.add(node.attr)
            text = f"{ast.unparse(node)} is read, and nothing writes it: it is always False"
            facts.remark("never-written", FileLine(reader.file, node.lineno), text)


def _declared(tree: ast.Module) -> Iterator[tuple[str, bool]]:
    """Yield the fields that classes declare, and whether with 0."""
    for kind in tree.body:
        for node in kind.body if isinstance(kind, ast.ClassDef) else ():
            if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
                for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                    if isinstance(target, ast.Name):
                        yield target.id, _is_zero(node.value)


def _is_zero(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) is int and not node.value


def _unbounded(reader: Reader, nodes: list[ast.AST], facts: Facts) -> None:
    """Note subscripts that only count, and that nothing compares."""
    if any(isinstance(node, ast.ExceptHandler) for node in nodes):
        return  # IndexError may be its end
    counting = [
        node
        for node in nodes
        if isinstance(node, ast.AugAssign)
        and isinstance(node.target, ast.Attribute)
        and isinstance(node.op, ast.Add | ast.Sub)
        and isinstance(node.value, ast.Constant)
    ]
    for text, name in {ast.unparse(node.target): node.target.attr for node in counting}.items():  # type: ignore[union-attr]
        mine = [node for node in nodes if isinstance(node, ast.Attribute) and node.attr == name]
        stored = [node for node in mine if isinstance(node.ctx, ast.Store)]
        if any(all(node is not each.target for each in counting) for node in stored):
            continue  # something takes it back
        slices = [
            node
            for node in nodes
            if isinstance(node, ast.Subscript)
            and ast.unparse(node.slice) == text
            and _is_table(node.value, reader, nodes)
        ]
        if slices and len(slices) == len(mine) - len(stored):
            where = f"`{ast.unparse(slices[0])}`: {text} counts, and nothing keeps it within the table"
            facts.remark("subscript", FileLine(reader.file, slices[0].lineno), where)


def _unbounded_in(loop: ast.While, reader: Reader, nodes: list[ast.AST], facts: Facts) -> None:
    """Note a local subscript that counts in a loop without an end, and that nothing in it limits."""
    inner = [node for each in loop.body for node in ast.walk(each)]
    if any(isinstance(node, ast.Break | ast.Return | ast.ExceptHandler) for node in inner):
        return
    names = {
        node.target.id
        for node in inner
        if isinstance(node, ast.AugAssign)
        and isinstance(node.target, ast.Name)
        and isinstance(node.op, ast.Add | ast.Sub)
        and isinstance(node.value, ast.Constant)
    }
    for name in sorted(names):
        mine = [node for node in inner if isinstance(node, ast.Name) and node.id == name]
        stored = [node for node in mine if isinstance(node.ctx, ast.Store)]
        counting = [node.target for node in inner if isinstance(node, ast.AugAssign)]
        slices = [
            node
            for node in inner
            if isinstance(node, ast.Subscript)
            and ast.unparse(node.slice) == name
            and _is_table(node.value, reader, nodes)
        ]
        is_counting = all(any(each is target for target in counting) for each in stored)
        if is_counting and slices and len(slices) == len(mine) - len(stored):
            where = f"`{ast.unparse(slices[0])}`: {name} counts, and nothing keeps it within the table"
            facts.remark("subscript", FileLine(reader.file, slices[0].lineno), where)


def _is_table(node: ast.expr, reader: Reader, nodes: list[ast.AST]) -> bool:
    """Whether an expression is a list or a tuple: of the module, or of a field."""
    if isinstance(node, ast.Name):
        return isinstance(reader.names.get(node.id), list | tuple) and node.id not in reader.local
    if not isinstance(node, ast.Attribute):
        return False
    values = [
        each.value
        for each in nodes
        if isinstance(each, ast.Assign | ast.AnnAssign)
        for target in (each.targets if isinstance(each, ast.Assign) else [each.target])
        if ast.unparse(target).rpartition(".")[2] == node.attr
    ]
    return bool(values) and all(
        isinstance(each, ast.List | ast.Tuple)
        or (isinstance(each, ast.BinOp) and isinstance(each.left, ast.List | ast.Tuple))
        for each in values
    )
