"""Times in a Python program that are meant in another unit.

if scan.now_ns - line.since > 500:     500 ns: over in the next scan
await dwell("500 us")                  shorter than a scan
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping

from .reader import Function, Reader, UnknownError, functions_in

CLOCK = "now_ns"
"""The attribute of the scan that counts nanoseconds."""


def waits_below_one_scan(reader: Reader, scan_ns: int) -> Iterator[tuple[ast.expr, str]]:
    """Yield comparisons of times by the scan's clock with less than a scan: expression, and problem."""
    for function, _ in functions_in(reader.tree):
        names = _names(function)
        for node in ast.walk(function):
            if isinstance(node, ast.Compare) and len(node.comparators) == 1:
                for one, other in ((node.left, node.comparators[0]), (node.comparators[0], node.left)):
                    unit = _unit(one, names, reader)
                    limit = _number(other, reader)
                    if unit is not None and limit is not None and 0 < limit * unit < scan_ns:
                        text = (
                            f"`{ast.unparse(node)}` is a time of {limit * unit:,g} ns, "
                            f"and a scan takes {scan_ns:,} ns"
                        )
                        yield node, text


def _names(function: Function) -> dict[str, ast.expr]:
    """Return the local names that a function assigns once, with their values."""
    stored = [
        node.targets[0].id
        for node in ast.walk(function)
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
    ]
    return {
        node.targets[0].id: node.value
        for node in ast.walk(function)
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and stored.count(node.targets[0].id) == 1
    }


def _unit(node: ast.expr, names: Mapping[str, ast.expr], reader: Reader, depth: int = 4) -> float | None:
    """Return the nanoseconds in one of an elapsed time; None for another expression."""
    if depth == 0:
        return None
    if isinstance(node, ast.Name) and node.id in names:
        return _unit(names[node.id], names, reader, depth - 1)
    if not isinstance(node, ast.BinOp):
        return None
    if isinstance(node.op, ast.Div | ast.FloorDiv):
        inner, by = _unit(node.left, names, reader, depth - 1), _number(node.right, reader)
        return inner * by if inner is not None and by else None
    is_elapsed = isinstance(node.op, ast.Sub) and _is_clock(node.left, names)
    return 1.0 if is_elapsed else None


def _is_clock(node: ast.expr, names: Mapping[str, ast.expr]) -> bool:
    node = names.get(node.id, node) if isinstance(node, ast.Name) else node
    return isinstance(node, ast.Attribute) and node.attr == CLOCK


def _number(node: ast.expr, reader: Reader) -> float | None:
    try:
        found = reader.value(node)
    except UnknownError:
        return None
    return found if isinstance(found, int | float) and not isinstance(found, bool) else None
