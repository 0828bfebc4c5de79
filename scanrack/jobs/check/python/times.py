"""Times in a Python program that are probably in the wrong unit.

if scan.now_ns - line.since > 500:     500 ns: true in the next scan
await dwell("500 us")                  shorter than a scan
"""

from __future__ import annotations

import ast
from collections.abc import Mapping

from .nodes import Function, nodes_in
from .reader import Reader, functions_in

CLOCK = "now_ns"
"""The attribute of the scan that counts nanoseconds."""


def note_short_times(reader: Reader, scan_ns: int) -> None:
    """Note comparisons of an elapsed time with a time shorter than a scan."""
    for function, _ in functions_in(reader.tree):
        names = _names(function)
        for node in nodes_in(function, ast.Compare):
            sides = (node.left, node.comparators[0])
            for elapsed, limit_node in (sides, sides[::-1]) if len(node.comparators) == 1 else ():
                unit_ns, limit = _unit_ns(elapsed, names, reader), _number(limit_node, reader)
                if unit_ns is not None and limit is not None and 0 < limit * unit_ns < scan_ns:
                    times = f"{limit * unit_ns:,g} ns, but a scan takes {scan_ns:,} ns"
                    reader.remark("preset-unit", node, f"`{ast.unparse(node)}`: the limit is {times}")


def _names(function: Function) -> dict[str, ast.expr]:
    """Return the local names that a function assigns only once, with their values."""
    assignments: dict[str, list[ast.expr]] = {}
    for node in nodes_in(function, ast.Assign):
        if isinstance(node.targets[0], ast.Name):
            assignments.setdefault(node.targets[0].id, []).append(node.value)
    return {name: values[0] for name, values in assignments.items() if len(values) == 1}


def _unit_ns(node: ast.expr, names: Mapping[str, ast.expr], reader: Reader, depth: int = 4) -> float | None:
    """Return the unit of an elapsed time in ns; None for any other expression."""
    if depth == 0:
        return None
    if isinstance(node, ast.Name) and node.id in names:
        return _unit_ns(names[node.id], names, reader, depth - 1)
    if not isinstance(node, ast.BinOp):
        return None
    if isinstance(node.op, ast.Div | ast.FloorDiv):
        unit_ns, divisor = _unit_ns(node.left, names, reader, depth - 1), _number(node.right, reader)
        return unit_ns * divisor if unit_ns is not None and divisor else None
    is_elapsed = isinstance(node.op, ast.Sub) and _is_clock(node.left, names)
    return 1.0 if is_elapsed else None


def _is_clock(node: ast.expr, names: Mapping[str, ast.expr]) -> bool:
    node = names.get(node.id, node) if isinstance(node, ast.Name) else node
    return isinstance(node, ast.Attribute) and node.attr == CLOCK


def _number(node: ast.expr, reader: Reader) -> float | None:
    number = reader.number(node)
    return None if isinstance(number, bool) else number
