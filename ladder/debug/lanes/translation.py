"""Translates the Python code of a compiled program to code that works on arrays, see `vectors`."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from typing import Any

from ...compiler import source_of
from ...state.lowered import LoweredProgram
from .vectors import WITH_MASK


def code_of(lowered: LoweredProgram, loaded: Set[str]) -> Any:
    """Return a program as code that works on arrays, for `Vectors`; None if it can't run on arrays.

    Only ordinary routines can run on arrays, not tasks, Python routines, axes or messages.

    Args:
        loaded: identifiers of the variables whose values are available as arrays.
    """
    if any((lowered.schedule, lowered.functions, lowered.opening, lowered.closing)):
        return None
    (program,) = ast.parse(source_of(lowered)).body
    assert isinstance(program, ast.FunctionDef)
    used = {argument.arg for argument in program.args.args}
    routines = [statement for statement in program.body if isinstance(statement, ast.FunctionDef)]
    assigned = {function.name: {*filter(None, map(_assigned, ast.walk(function)))} for function in routines}
    if "scan" not in assigned:
        return None
    constants = _constant_arguments(routines, assigned)
    lines: list[str] = []
    for routine in routines:
        tables = assigned[routine.name], assigned.keys(), constants[routine.name]
        lines += _Translator(routine, used, loaded, *tables).lines()
    return compile("\n".join(lines), "<lanes>", "exec")


def _constant_arguments(
    routines: Sequence[ast.FunctionDef], assigned: Mapping[str, Set[str]]
) -> dict[str, dict[str, int]]:
    """Return the arguments of each routine that are the same whole number in all calls.

    Most of them are offsets of tags.
    """
    calls = _calls(routines)
    constants: dict[str, dict[str, int]] = {function.name: {} for function in routines}
    size = -1
    while size < sum(map(len, constants.values())):  # a routine may pass its own arguments to another
        size = sum(map(len, constants.values()))
        for routine in routines:
            for place, argument in enumerate(routine.args.args):
                values = {_whole(call, place, constants[caller]) for caller, call in calls[routine.name]}
                if argument.arg not in assigned[routine.name] and len(values) == 1 and None not in values:
                    constants[routine.name][argument.arg] = values.pop()  # type: ignore[assignment]
    return constants


def _calls(routines: Sequence[ast.FunctionDef]) -> dict[str, list[tuple[str, ast.Call]]]:
    """Return the calls of each routine, with the names of the callers."""
    calls: dict[str, list[tuple[str, ast.Call]]] = {function.name: [] for function in routines}
    for routine in routines:
        for node in ast.walk(routine):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in calls:
                calls[node.func.id].append((routine.name, node))
    return calls


def _whole(call: ast.Call, place: int, constants: Mapping[str, int]) -> int | None:
    """Return an argument of a call if it is a constant whole number; otherwise None."""
    argument = call.args[place] if place < len(call.args) else None
    if isinstance(argument, ast.Constant) and type(argument.value) is int:
        return argument.value
    return constants.get(argument.id) if isinstance(argument, ast.Name) else None


class _Translator:
    """Translates one function.

    Args:
        used: the variables of the program.
        loaded: the variables whose values are available as arrays.
        assigned: the names that the function assigns.
        routines: the names of the program's functions.
        constants: the arguments that are the same number in all calls.
    """

    def __init__(
        self,
        function: ast.FunctionDef,
        used: Set[str],
        loaded: Set[str],
        assigned: Set[str],
        routines: Set[str],
        constants: Mapping[str, int],
    ) -> None:
        self._function, self._routines, self._constants = function, routines, constants
        self._given = [argument.arg for argument in function.args.args]
        self._shared = sorted(used & loaded - {*self._given})
        self._locals = sorted(assigned - used)
        self._known = {*self._shared, *self._given, *self._locals}
        self._masks = 0  # names of masks so far

    def lines(self) -> Iterator[str]:
        """Yield the lines of the function."""
        default = "=()" if "given" in self._given else ""
        yield f"def {self._function.name}(m0, {', '.join(self._given)}{default}):"
        if self._shared:
            yield f"    global {', '.join(self._shared)}"
        yield f"    {' = '.join([*self._locals, 'unused'])} = None"
        body = self._function.body
        if isinstance(body[-1], ast.Return) and body[-1].value is None:
            body = body[:-1]
        yield from ("    " + line for line in self._body(body, "m0"))

    def _body(self, body: Sequence[ast.stmt], mask: str) -> Iterator[str]:
        """Yield the lines of statements; lanes that reach a statement without a translation are lost."""
        yield "pass"
        for statement in body:
            try:
                yield from list(self._statement(statement, mask))
            except NotTranslatedError:
                yield f"lose({mask})"

    def _statement(self, node: ast.stmt, mask: str) -> Iterator[str]:
        """Yield the lines of a statement; raise a NotTranslatedError if there is no translation."""
        if isinstance(node, (ast.Nonlocal, ast.Global, ast.Pass)):
            return
        if isinstance(node, ast.Try):
            yield from self._body(node.body, mask)
        elif isinstance(node, ast.If):
            yield from self._if(node, mask)
        elif isinstance(node, ast.While):
            yield from self._while(node, mask)
        elif isinstance(node, ast.Expr):
            yield self._expression(node.value, mask)
        elif isinstance(node, ast.Assign) and len(node.targets) == 1:
            yield self._assignment(node.targets[0], node.value, mask)
        else:
            raise NotTranslatedError

    def _new_mask(self) -> str:
        self._masks += 1
        return f"m{self._masks}"

    def _if(self, node: ast.If, mask: str) -> Iterator[str]:
        """Yield both arms of an IF, each under the mask of its own lanes."""
        met, lanes = self._new_mask(), self._new_mask()
        yield f"{met} = {self._truth(node.test, mask)}"
        yield f"{lanes} = both({mask}, {met})"
        yield f"if some({lanes}):"
        yield from ("    " + line for line in self._body(node.body, lanes))
        if node.orelse:
            yield f"{lanes} = less({mask}, {met})"
            yield f"if some({lanes}):"
            yield from ("    " + line for line in self._body(node.orelse, lanes))

    def _while(self, node: ast.While, mask: str) -> Iterator[str]:
        """Yield a loop; lanes leave it when their test fails."""
        inner, passes = self._new_mask(), self._new_mask()
        test = f"{inner} = both({inner}, {self._truth(node.test, inner)})"
        yield from (f"{inner} = {mask}", test, f"{passes} = 0", f"while loop({inner}, {passes}):")
        yield from ("    " + line for line in (*self._body(node.body, inner), f"{passes} += 1", test))

    def _assignment(self, target: ast.expr, value: ast.expr, mask: str) -> str:
        """Return the line that assigns to a name, an element or a slice in the lanes of a mask."""
        if isinstance(target, ast.Name):
            self._expression(target, mask)  # check that it is known
            if _is_copy(value):
                return f"{target.id} = list({self._expression(value.func.value, mask)})"  # type: ignore[attr-defined]
            return f"{target.id} = put({mask}, {self._expression(value, mask)}, {target.id})"
        if not isinstance(target, ast.Subscript):
            raise NotTranslatedError
        rows = self._expression(target.value, mask)
        if isinstance(target.slice, ast.Slice):
            first, end = self._bounds(target.slice, mask)
            return f"put_rows({mask}, {rows}, {first}, {end}, {self._many(value, mask)})"
        index, new = self._expression(target.slice, mask), self._expression(value, mask)
        if index.isdigit():
            return f"{rows}[{index}] = put({mask}, {new}, {rows}[{index}])"
        return f"store({mask}, {rows}, {index}, {new})"

    def _bounds(self, node: ast.Slice, mask: str) -> tuple[str, str]:
        """Return the bounds of a slice, which must have both and no step."""
        if node.lower is None or node.upper is None or node.step is not None:
            raise NotTranslatedError
        return self._expression(node.lower, mask), self._expression(node.upper, mask)

    def _many(self, node: ast.expr, mask: str) -> str:
        """Return the expression of a list: a slice of another list, or a repeated value."""
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice):
            first, end = self._bounds(node.slice, mask)
            return f"rows({mask}, {self._expression(node.value, mask)}, {first}, {end})"
        if isinstance(node, ast.BinOp) and isinstance(node.left, ast.List) and len(node.left.elts) == 1:
            (value,) = node.left.elts
            return f"[{self._expression(value, mask)}] * {self._expression(node.right, mask)}"
        raise NotTranslatedError

    def _expression(self, node: ast.expr, mask: str) -> str:
        """Return an expression; raise a NotTranslatedError if there is no translation."""
        written = self._WRITTEN.get(type(node))
        if written is None:
            raise NotTranslatedError
        return written(self, node, mask)

    def _truth(self, node: ast.expr, mask: str) -> str:
        """Return an expression for a bool or an array of bools."""
        text = self._expression(node, mask)
        return text if text.startswith(("and_(", "or_(", "not_(")) else f"truth({text})"

    def _number(self, node: ast.expr, mask: str) -> str:
        """Return an expression for a number or an array of numbers."""
        text = self._expression(node, mask)
        is_number = _WHOLE.fullmatch(text) or (isinstance(node, ast.BinOp) and type(node.op) not in _BITWISE)
        return text if is_number else f"number({text})"

    def _constant(self, node: ast.Constant, _mask: str) -> str:
        return repr(node.value)

    def _tuple(self, node: ast.Tuple, _mask: str) -> str:
        """Return the empty tuple, the only tuple with a translation."""
        if node.elts:
            raise NotTranslatedError
        return "()"

    def _name(self, node: ast.Name, _mask: str) -> str:
        """Return a known variable; an argument that is the same in all calls is a number."""
        if node.id not in self._known:
            raise NotTranslatedError
        return str(self._constants[node.id]) if node.id in self._constants else node.id

    def _subscript(self, node: ast.Subscript, mask: str) -> str:
        """Return an element of a list; its index may differ between lanes."""
        if isinstance(node.slice, ast.Slice):
            raise NotTranslatedError
        rows, index = self._expression(node.value, mask), self._expression(node.slice, mask)
        return f"{rows}[{index}]" if index.isdigit() else f"at({mask}, {rows}, {index})"

    def _bool_op(self, node: ast.BoolOp, mask: str) -> str:
        if any(isinstance(inner, ast.Call) for value in node.values[1:] for inner in ast.walk(value)):
            raise NotTranslatedError  # whether it is evaluated depends on the previous operand
        name = "and_" if isinstance(node.op, ast.And) else "or_"
        return f"{name}({', '.join(self._expression(value, mask) for value in node.values)})"

    def _unary_op(self, node: ast.UnaryOp, mask: str) -> str:
        if isinstance(node.op, ast.Not):
            return f"not_({self._expression(node.operand, mask)})"
        sign = "-" if isinstance(node.op, ast.USub) else "~"
        return f"({sign}{self._number(node.operand, mask)})"

    def _bin_op(self, node: ast.BinOp, mask: str) -> str:
        """Return a calculation; only a constant can be a divisor or a shift count."""
        bitwise = _BITWISE.get(type(node.op))
        if bitwise is not None:
            return f"({self._expression(node.left, mask)} {bitwise} {self._expression(node.right, mask)})"
        left, right = self._number(node.left, mask), self._number(node.right, mask)
        if isinstance(node.op, ast.Mult):
            return f"times({mask}, {left}, {right})"
        sign = _SIGNS.get(type(node.op))
        if sign is None or (sign in _CONSTANT_RIGHT and not isinstance(node.right, ast.Constant)):
            raise NotTranslatedError
        if sign == "+" and left.isdigit() and right.isdigit():
            return str(int(left) + int(right))
        return f"({left} {sign} {right})"

    def _compare(self, node: ast.Compare, mask: str) -> str:
        """Return a comparison; a chained comparison is a conjunction."""
        values = [self._expression(operand, mask) for operand in (node.left, *node.comparators)]
        if not all(type(op) in _RELATIONS for op in node.ops):
            raise NotTranslatedError
        signs = [_RELATIONS[type(op)] for op in node.ops]
        pairs = [
            f"({left} {sign} {right})" for left, sign, right in zip(values, signs, values[1:], strict=False)
        ]
        return pairs[0] if len(pairs) == 1 else f"and_({', '.join(pairs)})"

    def _if_exp(self, node: ast.IfExp, mask: str) -> str:
        """Return a conditional expression, whose branches are functions of the mask of their lanes."""
        inner = self._new_mask()
        when_true = f"lambda {inner}: {self._or_lose(node.body, inner)}"
        when_false = f"lambda {inner}: {self._or_lose(node.orelse, inner)}"
        return f"pick({mask}, {self._expression(node.test, mask)}, {when_true}, {when_false})"

    def _or_lose(self, node: ast.expr, mask: str) -> str:
        """Return an expression; without a translation, a call that loses its lanes."""
        try:
            return self._expression(node, mask)
        except NotTranslatedError:
            return f"lose({mask})"

    def _call(self, node: ast.Call, mask: str) -> str:
        """Return a call of a routine or a service; a call that records a fault loses its lanes."""
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if node.keywords:
            raise NotTranslatedError
        if name == "jumped_back":
            return "None"
        if name in ("narrow", "outside"):  # they fault
            return f"lose({mask})"
        arguments = [self._expression(argument, mask) for argument in node.args]
        if name in self._routines or name in WITH_MASK:
            return f"{name}({', '.join([mask, *arguments])})"
        if name in _RENAMED:
            return f"{_RENAMED[name]}({', '.join(arguments)})"
        raise NotTranslatedError

    _WRITTEN: Mapping[type[ast.expr], Callable[[Any, Any, str], str]] = {
        ast.Constant: _constant,
        ast.Tuple: _tuple,
        ast.Name: _name,
        ast.Subscript: _subscript,
        ast.BoolOp: _bool_op,
        ast.UnaryOp: _unary_op,
        ast.BinOp: _bin_op,
        ast.Compare: _compare,
        ast.IfExp: _if_exp,
        ast.Call: _call,
    }


class NotTranslatedError(Exception):
    """A line has no translation."""


def _assigned(node: ast.AST) -> str:
    """Return the name that a node assigns to; "" if it does not assign to a name."""
    return node.id if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) else ""


def _is_copy(node: ast.expr) -> bool:
    """Return whether an expression is `image.tolist()`."""
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "tolist"


_SIGNS: Mapping[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.RShift: ">>",
}
_BITWISE: Mapping[type[ast.operator], str] = {ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^"}
_WHOLE = re.compile(r"\d+|\(-\d+\)")
_CONSTANT_RIGHT = ("//", "%", ">>")
_RELATIONS: Mapping[type[ast.cmpop], str] = {
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
}
_RENAMED = {"min": "least", "max": "greatest"}
