"""Rebuilds a function to begin at one of its awaits.

    async def cycle(self):                 async def cycle(self, station, .wait, .1, .once1):
        while True:                            while .once1 or True:
            lamp = True                            if first:
            for station in STOPS:                      for .turn in .1:
                await move(station)                        if first: await .wait
                await dwell("2 s")                         else: station = .turn; await move(station)
                                                           await dwell("2 s")
                                                   else:
                                                       lamp = True; for station in STOPS: ...

Statements before the await run only in later passes. Positions are taken from the source, so the lines of
waits, faults and breakpoints are correct. User code can't contain names that begin with a dot.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from types import CellType, CodeType, FunctionType
from typing import Any, TypeVar

from scanrack.io_images.dataclass import dataclass

from ..line_marks import LINES, mark
from .held import Entering, OpenBlock, RemainingPasses
from .points import NESTED, BlockStep, Function, Point
from .suspended import BlockKind

Node = TypeVar("Node", bound=ast.AST)

WAIT = ".wait"
"""Name of the parameter for the awaitable at the point."""

_VALUE_OF = (ast.Expr, ast.Assign, ast.AnnAssign, ast.Return)


class CannotBeginError(ValueError):
    """A function can't begin at this await."""


@dataclass(slots=True)
class ResumptionBody:
    """The body of a function after one of its awaits, and its additional parameters."""

    body: list[ast.stmt] = field(default_factory=list)
    blocks: list[str] = field(
        default_factory=list
    )  # parameters for the objects of open blocks, outermost first
    once: list[str] = field(default_factory=list)  # parameters that mark the first pass of a loop


def resume(function: Function, point: Point) -> ResumptionBody:
    """Return the body of a function that begins at a point.

    Raises:
        CannotBeginError: a function can't begin at this await.
    """
    body = ResumptionBody()
    body.body = _Writer(body, point).block(function.body, 0)
    return body


class _Writer:
    """Writes the statements from a point on."""

    def __init__(self, resumption: ResumptionBody, point: Point) -> None:
        self._resumption, self._point = resumption, point
        self._entry = isinstance(point.node, ast.AsyncWith)

    def block(self, statements: Sequence[ast.stmt], depth: int) -> list[ast.stmt]:
        """Return the rest of a block, starting with the statement that contains the point."""
        steps = self._point.steps
        target = steps[depth].node if depth < len(steps) else self._point.statement
        index = next(index for index, statement in enumerate(statements) if statement is target)
        return [*self._statement(statements[index], depth), *statements[index + 1 :]]

    def _statement(self, node: ast.stmt, depth: int) -> list[ast.stmt]:
        """Return the statements that do the rest of the statement with the point."""
        if depth >= len(self._point.steps):
            return [self._entered(node)] if self._entry else [self._simple(node)]
        step = self._point.steps[depth]
        write = _WRITERS.get(type(node))
        if write is None:
            raise CannotBeginError(f"the await is in a `{type(node).__name__.lower()}`")
        return write(self, node, step, depth)

    # --- statements that contain the await

    def _simple(self, node: ast.stmt) -> ast.stmt:
        """Return a simple statement with its await replaced by the continued await."""
        if not isinstance(node, _VALUE_OF) or node.value is None:
            raise CannotBeginError(_PARTLY_COMPUTED)
        return _with(node, value=self._first(node.value))

    def _first(self, node: ast.expr) -> ast.expr:
        """Return an expression with the await replaced; the expression must evaluate the await first."""
        if node is self._point.node:
            return _at(ast.Await(_at(ast.Name(WAIT, ast.Load()), node)), node)
        for kinds, name in _FIRST:
            if isinstance(node, kinds):
                value = getattr(node, name)
                if isinstance(value, list):
                    result: ast.expr = _with(node, **{name: [self._first(value[0]), *value[1:]]})
                else:
                    result = _with(node, **{name: self._first(value)})
                return result
        raise CannotBeginError(_PARTLY_COMPUTED)

    def _entered(self, node: Any) -> ast.stmt:
        """Return an `async with` for an object whose entry is already waiting."""
        if len(node.items) != 1:
            raise CannotBeginError("an `async with` has several objects")
        held = self._block(BlockKind.EXIT, node)
        entered: ast.stmt = _with(node, items=[ast.withitem(held, node.items[0].optional_vars)])
        return entered

    # --- statements around the await

    def _if(self, node: Any, step: BlockStep, depth: int) -> list[ast.stmt]:
        """Return the rest of the branch with the point, or the whole `if` for a point in its condition."""
        if step.field == "test":
            return [_with(node, test=self._first(node.test))]
        return self.block(getattr(node, step.field), depth + 1)

    def _while(self, node: Any, step: BlockStep, depth: int) -> list[ast.stmt]:
        """Write a loop whose first pass begins at the point; later passes begin at its top."""
        if step.field == "orelse":
            return self.block(node.orelse, depth + 1)
        first = self._once(node)
        if step.field == "test":
            condition = _at(ast.IfExp(first(), self._first(node.test), node.test), node)
            return [_with(node, test=condition)]
        body = _at(ast.If(first(), self.block(node.body, depth + 1), node.body), node.body[0])
        first_test = self._once(node)  # another mark, because each expression is evaluated once per pass
        test = _at(ast.BoolOp(ast.Or(), [first_test(), node.test]), node.test)
        return [_with(node, test=test, body=[body])]

    def _for(self, node: Any, step: BlockStep, depth: int) -> list[ast.stmt]:
        """Write a loop whose first item represents the current pass, so the target keeps its value."""
        if step.field == "orelse":
            return self.block(node.orelse, depth + 1)
        if step.field != "body":
            return [_with(node, iter=self._first(node.iter))]
        iterator, first = self._block(BlockKind.ITERATOR, node), self._once(node)
        turn = f".turn{len(self._resumption.blocks)}"
        item = _at(ast.Assign([node.target], _at(ast.Name(turn, ast.Load()), node.target)), node.target)
        resumed = self.block(node.body, depth + 1)
        body = _at(ast.If(first(), resumed, [item, *node.body]), node.body[0])
        return [_with(node, target=_at(ast.Name(turn, ast.Store()), node), iter=iterator, body=[body])]

    def _try(self, node: Any, step: BlockStep, depth: int) -> list[ast.stmt]:
        """Write the rest of a `try`; handlers still cover its body, and `finally` covers every part."""
        if step.field == "finalbody":
            raise CannotBeginError("the await is in a `finally`")
        if step.field == "body":
            return [_with(node, body=self.block(node.body, depth + 1))]
        if step.field == "handlers":
            return self._finally(node, [self._handler(node, step, depth)])
        return self._finally(node, self.block(node.orelse, depth + 1))

    def _handler(self, node: Any, step: BlockStep, depth: int) -> ast.stmt:
        """Write a running handler: its exception is raised again, and only this handler catches it."""
        inner: Any = step.inner
        error = self._block(BlockKind.HANDLER, inner)
        body = self.block(inner.body, depth + 1)
        everything = _at(ast.Name(".everything", ast.Load()), inner)
        handler = _at(ast.ExceptHandler(everything, inner.name, body), inner)
        return _at(ast.Try([_at(ast.Raise(error, None), inner)], [handler], [], []), inner)

    def _finally(self, node: Any, body: list[ast.stmt]) -> list[ast.stmt]:
        """Return a body in a `try` with the statement's `finally`, or the body itself if there is none."""
        if not node.finalbody:
            return body
        return [_at(ast.Try(body, [], [], node.finalbody), node)]

    def _with_block(self, node: Any, step: BlockStep, depth: int) -> list[ast.stmt]:
        """Write a `with` whose objects are already open."""
        if step.field != "body":
            raise CannotBeginError(_PARTLY_COMPUTED)
        items = [ast.withitem(self._block(BlockKind.EXIT, node), None) for _ in node.items]
        return [_with(node, items=items, body=self.block(node.body, depth + 1))]

    def _match(self, node: Any, step: BlockStep, depth: int) -> list[ast.stmt]:
        """Return the rest of the case with the point, or the whole `match` for a point in its subject."""
        if step.field == "subject":
            return [_with(node, subject=self._first(node.subject))]
        inner: Any = step.inner
        return self.block(inner.body, depth + 1)

    # --- parameters

    def _block(self, kind: BlockKind, node: Any) -> ast.Name:
        """Add a parameter for the object of an open block; return the parameter as an expression."""
        name = f".{kind.value}{len(self._resumption.blocks)}"
        self._resumption.blocks.append(name)
        return _at(ast.Name(name, ast.Load()), node)

    def _once(self, node: Any) -> Callable[[], ast.expr]:
        """Return a function that creates an expression that is true when first evaluated, then false."""
        name = f".once{len(self._resumption.once)}"
        self._resumption.once.append(name)

        def first() -> ast.expr:
            pop = ast.Call(ast.Attribute(ast.Name(name, ast.Load()), "pop", ast.Load()), [], [])
            return _at(ast.BoolOp(ast.And(), [ast.Name(name, ast.Load()), pop]), node)

        return first


_PARTLY_COMPUTED = "the expression around the await is partly computed"

_FIRST: Sequence[tuple[Any, str]] = (
    (ast.Compare | ast.BinOp, "left"),
    (ast.BoolOp, "values"),
    (ast.UnaryOp, "operand"),
    (ast.Attribute | ast.Subscript | ast.NamedExpr | ast.Await, "value"),
    (ast.Call, "func"),
    (ast.IfExp, "test"),
    (ast.Tuple | ast.List, "elts"),
)
"""The operand that Python evaluates first, by kind of expression."""

_WRITERS: Mapping[type[ast.stmt], Callable[[_Writer, Any, BlockStep, int], list[ast.stmt]]] = {
    ast.If: _Writer._if,
    ast.While: _Writer._while,
    ast.For: _Writer._for,
    ast.Try: _Writer._try,
    ast.With: _Writer._with_block,
    ast.AsyncWith: _Writer._with_block,
    ast.Match: _Writer._match,
}


def _with(node: Node, **fields: Any) -> Node:
    """Return a copy of a node with other fields."""
    result = copy.copy(node)
    for name, value in fields.items():
        setattr(result, name, value)
    return result


def _at(node: Node, origin: Any) -> Node:
    """Set the position of a node and of all nodes inside it that have none."""
    ast.copy_location(node, origin)
    return ast.fix_missing_locations(node)


# --- the function


def compiled(
    function: Function, resumed: ResumptionBody, values: Sequence[str], original: FunctionType
) -> FunctionType:
    """Compile a function that begins at a point.

    Args:
        values: names of the kept locals, which become parameters with the same names.
        original: the edited function, for its globals, names and cells.

    Raises:
        CannotBeginError: the function uses variables of an outer function.
    """
    code = original.__code__
    if set(code.co_freevars) - {"__class__"}:
        raise CannotBeginError(f"it uses {', '.join(code.co_freevars)} of an outer function")
    names = [*values, WAIT, *resumed.blocks, *resumed.once, ".everything"]
    outside = [node for node in _own_nodes(function) if isinstance(node, ast.Global)]
    # `super()` without arguments needs the cell of `__class__`
    tree = ast.parse("def outer(__class__):\n async def inner(): pass")
    outer: Any = tree.body[0]
    resumed_function = outer.body[0]
    resumed_function.name, resumed_function.args.args = function.name, [ast.arg(name) for name in names]
    resumed_function.body = [*outside, *resumed.body]
    owner = code.co_qualname.rpartition(".")[0].rpartition(".")[2]
    outer.body = [_Private(owner).visit(copy.deepcopy(resumed_function))]
    if LINES in original.__globals__:
        mark(outer.body[0])
    for copied in (outer, outer.body[0]):
        ast.copy_location(copied, function)
    ast.fix_missing_locations(tree)
    inner = _code_in(_code_in(compile(tree, code.co_filename, "exec")))
    inner = _renamed(inner, inner.co_qualname, code.co_qualname)
    cells = tuple(_cell(original, name) for name in inner.co_freevars)
    return FunctionType(inner, original.__globals__, function.name, None, cells)


def _own_nodes(function: ast.AST) -> list[ast.AST]:
    """Return the nodes of a function, without nodes of inner functions."""
    nodes: list[ast.AST] = []
    for child in ast.iter_child_nodes(function):
        nodes.append(child)
        if not isinstance(child, NESTED):
            nodes += _own_nodes(child)
    return nodes


def _cell(original: FunctionType, name: str) -> CellType:
    """Return the cell of a variable in a function, or an empty cell."""
    cells = dict(zip(original.__code__.co_freevars, original.__closure__ or (), strict=True))
    return cells[name] if name in cells else CellType()


def _code_in(code: CodeType) -> CodeType:
    return next(constant for constant in code.co_consts if isinstance(constant, CodeType))


def _renamed(code: CodeType, old: str, new: str) -> CodeType:
    """Give a code object and its inner code objects the qualified names of the original."""
    constants = tuple(
        _renamed(constant, old, new) if isinstance(constant, CodeType) else constant
        for constant in code.co_consts
    )
    return code.replace(co_qualname=new + code.co_qualname.removeprefix(old), co_consts=constants)


class _Private(ast.NodeTransformer):
    """Mangles the private names of a class, as Python does."""

    def __init__(self, owner: str) -> None:
        self._owner = owner.lstrip("_")

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        node.attr = self._mangled(node.attr)
        return self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> ast.AST:
        node.id = self._mangled(node.id)
        return node

    def _mangled(self, name: str) -> str:
        """Return a private name as Python stores it in the class."""
        private = name.startswith("__") and not name.endswith("__") and self._owner
        return f"_{self._owner}{name}" if private else name


def arguments_of(
    resumed: ResumptionBody, kinds: Sequence[BlockKind], held: Sequence[Any], awaited: Any, *, entry: bool
) -> dict[str, Any]:
    """Return the additional arguments of a resumed function.

    Args:
        held: the objects of open blocks, outermost first.
        awaited: an awaitable that continues the wait.
        entry: whether the wait is the entry of the last block.
    """
    wrap: Mapping[BlockKind, Callable[[Any], Any]] = {
        BlockKind.ITERATOR: RemainingPasses,
        BlockKind.EXIT: OpenBlock,
        BlockKind.HANDLER: lambda error: error,
    }
    arguments = [wrap[kind](value) for kind, value in zip(kinds, held, strict=True)]
    if entry:
        arguments[-1] = Entering(awaited, held[-1])
    once = {name: [True] for name in resumed.once}
    blocks = dict(zip(resumed.blocks, arguments, strict=True))
    return {WAIT: awaited, ".everything": BaseException, **blocks, **once}
