"""The possible values of an expression in a Python program, one by one: constants, tables, helpers.

target = STOPS[line.at]                  each element of STOPS
outputs[2] = target // 1000              the thousands of each element
outputs[2], outputs[3] = split(target)   what the helper `split` returns for each element

No code of the program is called. Helpers are interpreted statement by statement.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import is_dataclass
from enum import Enum
from typing import Any, cast

from scanrack.io_images import amci3601
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import split_thousands

from ..choices import Choices, combined
from .nodes import Function, parameters_of, unpacks
from .reader import Reader, UnknownError

DEPTH = 8
"""Maximum depth of helpers and names that are followed."""

MOST = 64
"""Maximum number of options."""

OPERATORS: Mapping[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv,
    ast.Div: operator.truediv,
    ast.Mod: operator.mod,
    ast.BitOr: operator.or_,
    ast.BitAnd: operator.and_,
    ast.BitXor: operator.xor,
    ast.RShift: operator.rshift,
    ast.LShift: lambda one, other: one * 2 ** min(other, 64),
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
    ast.Not: operator.not_,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}

PURE: Mapping[object, Callable[..., Any]] = {
    **{
        function: function
        for function in (abs, int, round, min, max, divmod, bool, len, sum, split_thousands, Image)
    },
    **{
        function: lambda *given, of=function: tuple(of(*given))
        for function in (range, enumerate, zip, tuple, list)
    },
}
"""Functions whose result depends only on their arguments."""

CHANGING = ("append", "pop", "extend", "insert", "update", "clear", "remove", "sort")
"""Methods that change a table."""

PLAIN = (int, float, str, bool, Enum)


Names = Mapping[str, "ast.expr | Choices | None"]
"""The meaning of local names: an expression of outer names, values, or unknown."""


class _ReturnedError(Exception):
    """A helper returns a value."""

    def __init__(self, value: object) -> None:
        self.value = value


class Options:
    """The possible values of the expressions in a text.

    Args:
        functions: functions by name; those that are helpers are interpreted.
        stored: expressions that the text assigns, by target.
    """

    def __init__(
        self, reader: Reader, functions: Mapping[str, Function], stored: Mapping[str, Sequence[ast.expr]]
    ) -> None:
        self._reader, self._functions, self._stored = reader, functions, stored
        self._changed = set(_changed(reader.tree))
        self._ways: dict[type[ast.expr], Callable[[Any, Names, int], Choices]] = {
            ast.IfExp: self._chosen,
            ast.Subscript: self._element,
            ast.Attribute: self._attribute,
            ast.Call: self._called,
        }

    def of(self, node: ast.expr, names: Names, depth: int = DEPTH) -> Choices:
        """Return the options of an expression; UnknownError if the text does not determine them."""
        if depth == 0:
            raise UnknownError
        match node:
            case ast.Constant(value):
                return Choices((value,))
            case ast.Name(name):
                return self._named(name, names, depth)
            case ast.Tuple(parts) | ast.List(parts):
                return _each([self.of(part, names, depth) for part in parts], lambda *given: given)
            case ast.UnaryOp(op, operand):
                return _each([self.of(operand, names, depth)], OPERATORS[type(op)])
            case ast.BinOp(left, op, right) | ast.Compare(left, [op], [right]) if type(op) in OPERATORS:
                return _each([self.of(side, names, depth) for side in (left, right)], OPERATORS[type(op)])
        if type(node) not in self._ways:
            raise UnknownError
        return self._ways[type(node)](node, names, depth)

    # --- names and tables

    def _named(self, name: str, names: Names, depth: int) -> Choices:
        if name in names:
            choices = names[name]
            if choices is None:
                raise UnknownError
            return choices if isinstance(choices, Choices) else self.of(choices, {}, depth - 1)
        if name in self._reader.local or name in self._changed or name not in self._reader.names:
            raise UnknownError
        return Choices((_plain(self._reader.names[name]),))

    def _chosen(self, node: ast.IfExp, names: Names, depth: int) -> Choices:
        try:
            tested = self.of(node.test, names, depth)
        except UnknownError:
            parts = [self.of(branch, names, depth) for branch in (node.body, node.orelse)]
            options = tuple(option for part in parts for option in part.options)
            return Choices(options[:MOST], ast.unparse(node))
        ways = {bool(option) for option in tested.options}
        if len(ways) > 1:
            raise UnknownError
        return self.of(node.body if ways.pop() else node.orelse, names, depth)

    def _element(self, node: ast.Subscript, names: Names, depth: int) -> Choices:
        table = self.of(node.value, names, depth)
        try:
            index = self.of(node.slice, names, depth)
        except UnknownError:
            return self._any_element(node, table)
        return _each([table, index], lambda found, at: found[at])

    def _any_element(self, node: ast.Subscript, table: Choices) -> Choices:
        """Return the elements of a table, for an unknown index."""
        elements = table.options[0]
        if len(table.options) > 1 or not isinstance(elements, tuple | list | dict) or not elements:
            raise UnknownError
        pairs = list(elements.items() if isinstance(elements, dict) else enumerate(elements))[:MOST]
        text = ast.unparse(node.value)
        names = tuple(f"{text}[{key!r}] = {value}" for key, value in pairs)
        return Choices(tuple(value for _, value in pairs), ast.unparse(node), names)

    def _attribute(self, node: ast.Attribute, names: Names, depth: int) -> Choices:
        text = ast.unparse(node)
        if text in self._stored:
            return self._assigned(text, depth)
        field = node.attr if getattr(node.value, "id", "") == "self" else ""
        if field in self._reader.fields:
            return Choices((_plain(self._reader.fields[field]),))
        owner = self.of(node.value, names, depth).options[0]
        is_ours = isinstance(owner, type) or is_dataclass(owner)
        if not is_ours or node.attr.startswith("_") or not hasattr(owner, node.attr):
            raise UnknownError
        return Choices((_plain(getattr(owner, node.attr)),))

    def _assigned(self, text: str, depth: int) -> Choices:
        """Return the options that a text assigns to an attribute, as far as they are known."""
        options: list[Any] = []
        names: list[str] = []
        for value in self._stored[text]:
            try:
                choices = self.of(value, {}, depth - 1)
            except UnknownError:
                continue
            options += choices.options
            names += choices.names or [f"{text} = {option}" for option in choices.options]
        if not options:
            raise UnknownError
        return Choices(tuple(options[:MOST]), text if len(options) > 1 else "", tuple(names[:MOST]))

    # --- calls

    def _called(self, call: ast.Call, names: Names, depth: int) -> Choices:
        if unpacks(call):
            raise UnknownError
        keys = [str(keyword.arg) for keyword in call.keywords]
        nodes = [*call.args, *(keyword.value for keyword in call.keywords)]
        arguments = [self.of(node, names, depth) for node in nodes]
        if isinstance(call.func, ast.Attribute) and call.func.attr == "to_image" and not arguments:
            built = self.of(call.func.value, names, depth)
            return _each([built], lambda each: tuple(each.to_image()))
        function = self._function(ast.unparse(call.func), depth)
        count = len(call.args)
        return _each(arguments, lambda *a: function(*a[:count], **dict(zip(keys, a[count:], strict=True))))

    def _function(self, name: str, depth: int) -> Callable[..., Any]:
        """Return the function of a name; UnknownError if its result may depend on more than its arguments."""
        helper = self._functions.get(name)
        if isinstance(helper, ast.FunctionDef):
            own = helper
            return lambda *given, **named: self._run(own, given, named, depth - 1)
        known = self._reader.names.get(name, _BUILT_IN.get(name))
        kind = getattr(amci3601, name.rpartition(".")[2], None)
        is_made = isinstance(kind, type) and (known is kind or name not in self._reader.names)
        function = kind if is_made else PURE.get(known) if isinstance(known, Hashable) else None
        if function is None:
            raise UnknownError
        return cast("Callable[..., Any]", function)

    def _run(
        self, helper: ast.FunctionDef, given: Sequence[Any], named: Mapping[str, Any], depth: int
    ) -> object:
        """Return the result of a helper for given values."""
        parameters = parameters_of(helper)
        if len(given) > len(parameters):
            raise UnknownError
        values = {**dict(zip(parameters, given, strict=False)), **named}
        local: dict[str, ast.expr | Choices | None] = {
            name: Choices((value,)) for name, value in values.items()
        }
        try:
            self._body(helper.body, local, depth)
        except _ReturnedError as returned:
            return returned.value
        raise UnknownError

    def _body(
        self, body: Sequence[ast.stmt], local: dict[str, ast.expr | Choices | None], depth: int
    ) -> None:
        for node in body:
            match node:
                case ast.Return(value=ast.expr() as value):
                    raise _ReturnedError(self._one(value, local, depth))
                case ast.Assign(targets=[target], value=value):
                    self._bind(target, self._one(value, local, depth), local)
                case ast.If(test, then, otherwise):
                    self._body(then if self._one(test, local, depth) else otherwise, local, depth)
                case ast.Expr(value=ast.Constant()):
                    pass
                case _:
                    raise UnknownError

    def _one(self, node: ast.expr, local: Names, depth: int) -> Any:
        choices = self.of(node, local, depth)
        if len(choices.options) > 1:
            raise UnknownError
        return choices.options[0]

    @staticmethod
    def _bind(target: ast.expr, value: Any, local: dict[str, ast.expr | Choices | None]) -> None:
        targets = target.elts if isinstance(target, ast.Tuple) else [target]
        values = value if isinstance(target, ast.Tuple) else [value]
        for target_name, part in zip(targets, values, strict=True):
            if not isinstance(target_name, ast.Name):
                raise UnknownError
            local[target_name.id] = Choices((part,))


_BUILT_IN: Mapping[str, object] = {str(getattr(function, "__name__", "")): function for function in PURE}


def _each(parts: Sequence[Choices], of: Callable[..., Any]) -> Choices:
    """Apply a function to options; UnknownError if sources differ or the call fails."""
    choices = combined(parts, of)
    if not choices.options:
        raise UnknownError
    return choices


def _plain(value: Any) -> Any:
    """Return a value of the module if nothing can change it; otherwise raise UnknownError."""
    is_row = isinstance(value, tuple | list) and all(map(_is_plain, value))
    is_table = isinstance(value, dict) and all(map(_is_plain, value.values()))
    if is_row or is_table or _is_plain(value):
        return value
    raise UnknownError


def _is_plain(value: Any) -> bool:
    if isinstance(value, tuple):
        return all(map(_is_plain, value))
    is_made = type(value).__module__.startswith("scanrack.io_images")
    return isinstance(value, (*PLAIN, type)) or is_made or (is_dataclass(value) and _is_frozen(value))


def _is_frozen(value: Any) -> bool:
    return bool(type(value).__dataclass_params__.frozen)


def _changed(tree: ast.Module) -> Sequence[str]:
    """Return the names of tables that the text changes, and of globals that its functions assign."""
    tables = []
    for node in ast.walk(tree):
        match node:
            case ast.Subscript(value=table, ctx=ast.Store() | ast.Del()):
                tables.append(ast.unparse(table))
            case ast.Global(names=names):
                tables += names
            case ast.Call(func=ast.Attribute(value=table, attr=method)) if method in CHANGING:
                tables.append(ast.unparse(table))
    return tables
