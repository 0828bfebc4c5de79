"""Explains why a Python program's value has not changed: a line could write it, but a condition is false.

The last scan runs once more on a copy. When it reaches a condition around such a line, or the line itself,
the parts of the condition are evaluated, and the inputs that each false part reads are noted.
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
    tests: tuple[tuple[ast.expr, bool], ...]  # each with the truth it must have


@dataclass(frozen=True, slots=True)
class FalsePart:
    """A part of a condition that does not have the required truth."""

    text: str
    masks: Masks  # the inputs that it reads
    names: tuple[str, ...]  # the program's values that it names


@dataclass(slots=True)
class Looker:
    """Evaluates the conditions of given writers when the traced scan reaches them.

    Attributes:
        lacks: the false parts of each writer's first false condition.
    """

    writers: Sequence[Writer]
    lacks: dict[Writer, list[FalsePart]] = field(default_factory=dict)

    def __call__(self, line: Line, frame: FrameType, reads: Reads) -> None:
        """Evaluate the conditions that begin at a line."""
        for writer in self.writers:
            if writer in self.lacks or writer.function != line.function:
                continue
            for test, expected in writer.tests:
                if test.lineno == line.number:
                    parts = list(_false_parts(test, expected, frame, reads))
                    if parts:
                        self.lacks[writer] = parts
                        break
            else:
                if writer.line == line.number:
                    self.lacks[writer] = list(_false_parts(writer.value, True, frame, reads))


def never(chain: PythonChain, text: str, row: int, present: Any, depth: int = 0) -> CauseLink | None:
    """Return the link of a value that has not changed before a scan; None if no line writes it."""
    writers = [
        candidate
        for candidate in writers_of(chain.load.program, text)
        if not _is_constant(candidate.value, present)
    ]
    if not writers or depth > DEEPEST:
        return None
    parts = {
        "kind": "never",
        "name": text,
        "value": plain(present),
        "scan": 0,
        "now_ns": chain.recording.times[0],
    }
    sequence = next((candidate for candidate in writers if candidate.function in chain.names.sequences), None)
    if sequence is not None:
        wait = chain.of_sequence(sequence.function, row)
        shown_text = f"{source_line(str(chain.load.program), sequence.line)} has not been reached"
        return linked([(wait,)] if wait else [], **parts, text=shown_text, site=_site(chain, sequence.line))
    looker = Looker(writers)
    chain.look(looker, row)
    lacking = [
        (assignment, looker.lacks[assignment]) for assignment in writers if looker.lacks.get(assignment)
    ]
    if not lacking:
        return None
    writer, lacks = min(lacking, key=lambda pair: len(pair[1]))
    causes = [(link,) for part in lacks for link in _links_of_part(chain, part, row, text, depth)]
    shown_text = f"{' and '.join(part.text for part in lacks)} is false"
    return linked(causes, **parts, text=shown_text, site=_site(chain, writer.line))


def _links_of_part(
    chain: PythonChain, part: FalsePart, row: int, text: str, depth: int
) -> Iterator[CauseLink]:
    """Yield the inputs that a false part reads; if there are none, its values."""
    inputs = list(read_bits(part.masks.items()))
    links = [chain.of_bits(bits, chain.name(bits), row) for bits in inputs]
    if not inputs:
        names = (chain.full(name) for name in part.names)
        links = [chain.of_value(name, row, depth + 1) for name in names if name != text]
    yield from (link for link in links if link is not None)


def _site(chain: PythonChain, line: int) -> Site:
    file = chain.load.program
    return Site(file=file.name, line=line, routine="", instruction=source_line(str(file), line))


def writers_of(program: Path, text: str) -> list[Writer]:
    """Return the statements in functions of a program's file that assign to a value."""
    try:
        tree = ast.parse(program.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return []
    return list(_writers(tree, text.rpartition("."), "", ()))


def _writers(
    node: ast.AST, expected: tuple[str, str, str], function: str, tests: tuple[tuple[ast.expr, bool], ...]
) -> Iterator[Writer]:
    for part in ast.iter_child_nodes(node):
        if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef):
            yield from _writers(part, expected, part.name, ())
        elif isinstance(part, ast.If | ast.While):
            for inner, truth in ((part.body, True), (part.orelse, False)):
                body = ast.Module(inner, [])
                yield from _writers(body, expected, function, (*tests, (part.test, truth)))
        elif (
            function
            and isinstance(part, ast.Assign | ast.AugAssign | ast.AnnAssign)
            and part.value is not None
        ):
            targets = part.targets if isinstance(part, ast.Assign) else [part.target]
            if any(_is_target(target, expected) for target in targets):
                yield Writer(part.lineno, function, part.value, tests)
        else:
            yield from _writers(part, expected, function, tests)


def _is_target(target: ast.expr, expected: tuple[str, str, str]) -> bool:
    owner, _, name = expected
    if isinstance(target, ast.Name):
        return not owner and target.id == name
    if not isinstance(target, ast.Attribute) or target.attr != name:
        return False
    return ast.unparse(target.value) in (owner, "self")


def _is_constant(value: ast.expr, present: Any) -> bool:
    """Whether an expression is a constant equal to the present value."""
    return isinstance(value, ast.Constant) and type(value.value) is type(present) and value.value == present


def _false_parts(test: ast.expr, expected: bool, frame: FrameType, reads: Reads) -> Iterator[FalsePart]:
    """Yield the parts of an expression that keep it from having the expected truth."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        yield from _false_parts(test.operand, not expected, frame, reads)
    elif isinstance(test, ast.BoolOp):
        parts = [list(_false_parts(part, expected, frame, reads)) for part in test.values]
        if isinstance(test.op, ast.And) is expected:
            yield from (part for parts_of in parts for part in parts_of)
        elif all(parts):
            yield from min(parts, key=len)
    else:
        value, masks = _evaluated(_meant(test, frame), frame, reads)
        if value is not None and value is not expected:
            text = ast.unparse(test)
            yield FalsePart(text if expected else f"not {text}", masks, tuple(names_read(test)))


def _meant(test: ast.expr, frame: FrameType) -> ast.expr:
    """Return the expression that was assigned to a local name, so that its inputs are read again."""
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


def _evaluated(expression: ast.expr, frame: FrameType, reads: Reads) -> tuple[bool | None, Masks]:
    """Return whether an expression is true on the traced copy, and which inputs it reads."""
    before, counts = dict(reads.masks), reads.counts
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
        reads.masks.update(before)


def plain(value: Any) -> Any:
    """Return a value in a form that a recording may contain; other values become text."""
    return value if isinstance(value, (bool, int, float, str)) else None if value is None else repr(value)
