"""Explains why a value of a Python program has not changed: a line could write it, but a condition is false.

The last scan is run again on a copy. When the copy reaches a condition around one of these lines, or the line
itself, the parts of the condition are evaluated, and the inputs that each false part reads are noted.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import field
from pathlib import Path
from types import FrameType
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site
from scanrack.ladder.debug import CauseLink, linked

from ..bits import read_bits
from ..source.conditions import names_read, source_line
from ..source.input_reads import Reads
from ..source.lines import Line
from .python_chain import PythonChain

DEEPEST = 6
"""Maximum number of program values in a chain."""

Masks = dict[tuple[int, int], int]


@dataclass(frozen=True, slots=True)
class Writer:
    """A statement that could write a value, with the conditions around it, outermost first."""

    line: int
    function: str
    value: ast.expr
    tests: tuple[tuple[ast.expr, bool], ...]  # each with the truth that it must have


@dataclass(frozen=True, slots=True)
class FalsePart:
    """A part of a condition that does not have the required truth value."""

    text: str
    masks: Masks  # the inputs that it reads
    names: tuple[str, ...]  # the program's values that it names


@dataclass(slots=True)
class ConditionLooker:
    """Evaluates the conditions of writers when the traced scan reaches them.

    Attributes:
        false_parts: the false parts of the first false condition of each writer.
    """

    writers: Sequence[Writer]
    false_parts: dict[Writer, list[FalsePart]] = field(default_factory=dict)

    def __call__(self, line: Line, frame: FrameType, reads: Reads) -> None:
        """Evaluate the conditions that begin at a line."""
        for writer in self.writers:
            if writer in self.false_parts or writer.function != line.function:
                continue
            for test, expected in writer.tests:
                if test.lineno == line.number:
                    parts = list(_false_parts(test, expected, frame, reads))
                    if parts:
                        self.false_parts[writer] = parts
                        break
            else:
                if writer.line == line.number:
                    self.false_parts[writer] = list(
                        _false_parts(writer.value, expected=True, frame=frame, reads=reads)
                    )


def explain_unwritten(
    chain: PythonChain, text: str, row: int, present: Any, depth: int = 0
) -> CauseLink | None:
    """Return the link of a value that has not changed up to a scan.

    The link names a line of a sequence that has not been reached, or the false condition with the fewest
    parts.

    Args:
        depth: number of values already followed to reach this one.

    Returns:
        None if no line could write the value, no false condition is found, or the chain is too long.
    """
    writers = [
        candidate
        for candidate in _writers_of(chain.load.program, text)
        if not _is_constant(candidate.value, present)
    ]
    if not writers or depth > DEEPEST:
        return None
    program = str(chain.load.program)
    fields: dict[str, Any] = {"kind": "never", "name": text, "value": plain(present)}
    fields |= {"scan": 0, "now_ns": chain.recording.times[0]}
    writer = next((candidate for candidate in writers if candidate.function in chain.names.sequences), None)
    if writer is not None:
        wait = chain.of_sequence(writer.function, row)
        causes = [(wait,)] if wait else []
        line = Line(program, writer.line, writer.function)
        reason = f"{source_line(program, writer.line)} has not been reached"
        return linked(causes, **fields, text=reason, site=site_of(line))
    looker = ConditionLooker(writers)
    chain.look(looker, row)
    stopped_writers = [candidate for candidate in writers if looker.false_parts.get(candidate)]
    if not stopped_writers:
        return None
    writer = min(stopped_writers, key=lambda candidate: len(looker.false_parts[candidate]))
    false_parts = looker.false_parts[writer]
    causes = [(link,) for part in false_parts for link in _links_of_part(chain, part, row, text, depth)]
    reason = f"{' and '.join(part.text for part in false_parts)} is false"
    return linked(causes, **fields, text=reason, site=site_of(Line(program, writer.line, writer.function)))


def _links_of_part(
    chain: PythonChain, part: FalsePart, row: int, text: str, depth: int
) -> Iterator[CauseLink]:
    """Yield the inputs that a false part reads or, without inputs, the program values in it."""
    inputs = list(read_bits(part.masks.items()))
    links = [chain.of_bits(bits, chain.name(bits), row) for bits in inputs]
    if not inputs:
        names = (chain.full(name) for name in part.names)
        links = [chain.of_value(name, row, depth + 1) for name in names if name != text]
    yield from (link for link in links if link is not None)


def site_of(line: Line) -> Site:
    """Return the site of a line of Python."""
    code = source_line(line.file, line.number)
    return Site(file=Path(line.file).name, line=line.number, routine="", instruction=code)


def _writers_of(program: Path, text: str) -> list[Writer]:
    """Return the statements in functions of a program's file that assign to a value."""
    try:
        tree = ast.parse(program.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return []
    return list(_writers_in(tree, text, function="", tests=()))


def _writers_in(
    node: ast.AST, name: str, function: str, tests: tuple[tuple[ast.expr, bool], ...]
) -> Iterator[Writer]:
    """Yield the statements in a node that assign to a name; `function` and `tests` enclose the node."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from _writers_in(child, name, child.name, ())
        elif isinstance(child, ast.If | ast.While):
            for branch, truth in ((child.body, True), (child.orelse, False)):
                body = ast.Module(branch, [])
                yield from _writers_in(body, name, function, (*tests, (child.test, truth)))
        elif (
            function
            and isinstance(child, ast.Assign | ast.AugAssign | ast.AnnAssign)
            and child.value is not None
        ):
            targets = child.targets if isinstance(child, ast.Assign) else [child.target]
            if any(_is_target(target, name) for target in targets):
                yield Writer(child.lineno, function, child.value, tests)
        else:
            yield from _writers_in(child, name, function, tests)


def _is_target(target: ast.expr, full_name: str) -> bool:
    """Return whether a target is a name such as `step` or `line.step`, or `self.step` for it."""
    owner, _, name = full_name.rpartition(".")
    if isinstance(target, ast.Name):
        return not owner and target.id == name
    if not isinstance(target, ast.Attribute) or target.attr != name:
        return False
    return ast.unparse(target.value) in (owner, "self")


def _is_constant(value: ast.expr, present: Any) -> bool:
    """Return whether an expression is a constant equal to the current value."""
    return isinstance(value, ast.Constant) and type(value.value) is type(present) and value.value == present


def _false_parts(test: ast.expr, expected: bool, frame: FrameType, reads: Reads) -> Iterator[FalsePart]:
    """Yield the parts of an expression that keep it from having the expected truth value."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        yield from _false_parts(test.operand, not expected, frame, reads)
    elif isinstance(test, ast.BoolOp):
        parts_of_operands = [list(_false_parts(operand, expected, frame, reads)) for operand in test.values]
        if isinstance(test.op, ast.And) is expected:  # every operand must have the expected truth
            for parts in parts_of_operands:
                yield from parts
        elif all(parts_of_operands):  # one operand would be enough
            yield from min(parts_of_operands, key=len)
    else:
        value, masks = _evaluate(_assigned_expression(test, frame), frame, reads)
        if value is not None and value is not expected:
            text = ast.unparse(test)
            yield FalsePart(text if expected else f"not {text}", masks, tuple(names_read(test)))


def _assigned_expression(test: ast.expr, frame: FrameType) -> ast.expr:
    """Return the expression that was assigned to a local name, so that its inputs are read again.

    Any other expression is returned unchanged.
    """
    if not isinstance(test, ast.Name) or test.id not in frame.f_locals or frame.f_locals is frame.f_globals:
        return test
    try:
        tree = ast.parse(Path(frame.f_code.co_filename).read_bytes())
    except (OSError, SyntaxError, ValueError):
        return test
    assignments = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign)
        and frame.f_code.co_firstlineno <= node.lineno < test.lineno
        and any(isinstance(target, ast.Name) and target.id == test.id for target in node.targets)
    ]
    return assignments[-1] if assignments else test


def _evaluate(expression: ast.expr, frame: FrameType, reads: Reads) -> tuple[bool | None, Masks]:
    """Return whether an expression is true on the traced copy, and which inputs it reads."""
    masks_before, counts = dict(reads.masks), reads.counts
    reads.masks.clear()
    reads.counts = lambda: True
    try:
        code = compile(ast.Expression(expression), "<why>", "eval")
        value = bool(eval(code, frame.f_globals, dict(frame.f_locals)))
        return value, {key: mask for key, mask in reads.masks.items() if mask}
    except Exception:  # this runs the program's own code; an expression that raises has no value
        return None, {}
    finally:
        reads.counts = counts
        reads.masks.clear()
        reads.masks.update(masks_before)


def plain(value: Any) -> Any:
    """Return a value in a form that a recording can contain; other values become text."""
    return value if isinstance(value, (bool, int, float, str, type(None))) else repr(value)
