"""The individual values that an expression in a Python program can have: constants, tables, helpers.

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
        function: lambda *arguments, function=function: tuple(function(*arguments))
        for function in (range, enumerate, zip, tuple, list)
    },
}
"""Functions with a result that depends only on their arguments."""

CHANGING = ("append", "pop", "extend", "insert", "update", "clear", "remove", "sort")
"""Methods that change a table."""

PLAIN = (int, float, str, bool, Enum)


Names = Mapping[str, "ast.expr | Choices | None"]
"""The meaning of local names: an expression of outer names, options, or None if unknown."""


class _ReturnedError(Exception):
    """Ends the interpretation of a helper at its `return`."""

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
        self._evaluators: dict[type[ast.expr], Callable[[Any, Names, int], Choices]] = {
            ast.IfExp: self._branch,
            ast.Subscript: self._element,
            ast.Attribute: self._attribute,
            ast.Call: self._call,
        }

    def evaluate(self, node: ast.expr, names: Names, depth: int = DEPTH) -> Choices:
        """Return the options of an expression; raise UnknownError if the text does not determine them."""
        if depth == 0:
            raise UnknownError
        match node:
            case ast.Constant(value):
                return Choices((value,))
            case ast.Name(name):
                return self._name(name, names, depth)
            case ast.Tuple(parts) | ast.List(parts):
                return _apply(
                    lambda *elements: elements, [self.evaluate(part, names, depth) for part in parts]
                )
            case ast.UnaryOp(op, operand):
                return _apply(OPERATORS[type(op)], [self.evaluate(operand, names, depth)])
            case ast.BinOp(left, op, right) | ast.Compare(left, [op], [right]) if type(op) in OPERATORS:
                sides = [self.evaluate(side, names, depth) for side in (left, right)]
                return _apply(OPERATORS[type(op)], sides)
        if type(node) not in self._evaluators:
            raise UnknownError
        return self._evaluators[type(node)](node, names, depth)

    # --- names and tables

    def _name(self, name: str, names: Names, depth: int) -> Choices:
        """Return the options of a local name, or the value of an unchanging global name."""
        if name in names:
            choices = names[name]
            if choices is None:
                raise UnknownError
            return choices if isinstance(choices, Choices) else self.evaluate(choices, {}, depth - 1)
        if name in self._reader.local or name in self._changed or name not in self._reader.names:
            raise UnknownError
        return Choices((_unchanging(self._reader.names[name]),))

    def _branch(self, node: ast.IfExp, names: Names, depth: int) -> Choices:
        """Return the options of the branch that a test selects; of both branches if the test is unknown."""
        try:
            test = self.evaluate(node.test, names, depth)
        except UnknownError:
            branches = [self.evaluate(branch, names, depth) for branch in (node.body, node.orelse)]
            options = tuple(option for branch in branches for option in branch.options)
            return Choices(options[:MOST], ast.unparse(node))
        results = {bool(option) for option in test.options}
        if len(results) > 1:
            raise UnknownError
        return self.evaluate(node.body if results.pop() else node.orelse, names, depth)

    def _element(self, node: ast.Subscript, names: Names, depth: int) -> Choices:
        """Return the elements of a table for each option of the index, or all if the index is unknown."""
        table = self.evaluate(node.value, names, depth)
        try:
            index = self.evaluate(node.slice, names, depth)
        except UnknownError:
            return self._any_element(node, table)
        return _apply(operator.getitem, [table, index])

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
        """Return the values assigned to an attribute in the text, or its value in the program or a class."""
        text = ast.unparse(node)
        if text in self._stored:
            return self._assigned(text, depth)
        field = node.attr if getattr(node.value, "id", "") == "self" else ""
        if field in self._reader.fields:
            return Choices((_unchanging(self._reader.fields[field]),))
        owner = self.evaluate(node.value, names, depth).options[0]
        is_readable = isinstance(owner, type) or is_dataclass(owner)
        if not is_readable or node.attr.startswith("_") or not hasattr(owner, node.attr):
            raise UnknownError
        return Choices((_unchanging(getattr(owner, node.attr)),))

    def _assigned(self, text: str, depth: int) -> Choices:
        """Return the known options that a text assigns to an attribute."""
        options: list[Any] = []
        names: list[str] = []
        for value in self._stored[text]:
            try:
                choices = self.evaluate(value, {}, depth - 1)
            except UnknownError:
                continue
            options += choices.options
            names += choices.names or [f"{text} = {option}" for option in choices.options]
        if not options:
            raise UnknownError
        return Choices(tuple(options[:MOST]), text if len(options) > 1 else "", tuple(names[:MOST]))

    # --- calls

    def _call(self, call: ast.Call, names: Names, depth: int) -> Choices:
        """Return the result of calling a helper, a pure function or `to_image`, for each option."""
        if unpacks(call):
            raise UnknownError
        nodes = [*call.args, *(keyword.value for keyword in call.keywords)]
        arguments = [self.evaluate(node, names, depth) for node in nodes]
        if isinstance(call.func, ast.Attribute) and call.func.attr == "to_image" and not arguments:
            command = self.evaluate(call.func.value, names, depth)
            return _apply(lambda built: tuple(built.to_image()), [command])
        function = self._function(ast.unparse(call.func), depth)
        keys = [str(keyword.arg) for keyword in call.keywords]
        count = len(call.args)  # of positional arguments

        def call_with(*values: Any) -> Any:
            return function(*values[:count], **dict(zip(keys, values[count:], strict=True)))

        return _apply(call_with, arguments)

    def _function(self, name: str, depth: int) -> Callable[..., Any]:
        """Return the function of a name; raise UnknownError if its result may depend on other values."""
        helper = self._functions.get(name)
        if isinstance(helper, ast.FunctionDef):
            return lambda *arguments, **keywords: self._run(helper, arguments, keywords, depth - 1)
        value = self._reader.names.get(name, _BUILT_IN.get(name))
        command_class = getattr(amci3601, name.rpartition(".")[2], None)
        if isinstance(command_class, type) and (value is command_class or name not in self._reader.names):
            return cast("Callable[..., Any]", command_class)
        function = PURE.get(value) if isinstance(value, Hashable) else None
        if function is None:
            raise UnknownError
        return function

    def _run(
        self, helper: ast.FunctionDef, arguments: Sequence[Any], keywords: Mapping[str, Any], depth: int
    ) -> object:
        """Return the result of a helper for the values of its arguments."""
        parameters = parameters_of(helper)
        if len(arguments) > len(parameters):
            raise UnknownError
        values = {**dict(zip(parameters, arguments, strict=False)), **keywords}
        local: dict[str, ast.expr | Choices | None] = {
            name: Choices((value,)) for name, value in values.items()
        }
        try:
            self._run_body(helper.body, local, depth)
        except _ReturnedError as returned:
            return returned.value
        raise UnknownError

    def _run_body(
        self, body: Sequence[ast.stmt], local: dict[str, ast.expr | Choices | None], depth: int
    ) -> None:
        """Interpret statements; raise _ReturnedError at `return`, UnknownError at an unsupported one."""
        for node in body:
            match node:
                case ast.Return(value=ast.expr() as value):
                    raise _ReturnedError(self._only_value(value, local, depth))
                case ast.Assign(targets=[target], value=value):
                    self._bind(target, self._only_value(value, local, depth), local)
                case ast.If(test, then, otherwise):
                    is_true = self._only_value(test, local, depth)
                    self._run_body(then if is_true else otherwise, local, depth)
                case ast.Expr(value=ast.Constant()):
                    pass
                case _:
                    raise UnknownError

    def _only_value(self, node: ast.expr, local: Names, depth: int) -> Any:
        """Return the value of an expression; raise UnknownError if it has several options."""
        choices = self.evaluate(node, local, depth)
        if len(choices.options) > 1:
            raise UnknownError
        return choices.options[0]

    @staticmethod
    def _bind(target: ast.expr, value: Any, local: dict[str, ast.expr | Choices | None]) -> None:
        """Bind a name to its value, or each name of a tuple to its part."""
        targets = target.elts if isinstance(target, ast.Tuple) else [target]
        values = value if isinstance(target, ast.Tuple) else [value]
        for element, part in zip(targets, values, strict=True):
            if not isinstance(element, ast.Name):
                raise UnknownError
            local[element.id] = Choices((part,))


_BUILT_IN: Mapping[str, object] = {str(getattr(function, "__name__", "")): function for function in PURE}


def _apply(function: Callable[..., Any], arguments: Sequence[Choices]) -> Choices:
    """Return a function's result for each option; raise UnknownError if sources differ or a call fails."""
    choices = combined(arguments, function)
    if not choices.options:
        raise UnknownError
    return choices


def _unchanging(value: Any) -> Any:
    """Return a value from the module if it is immutable; otherwise raise UnknownError."""
    is_row = isinstance(value, tuple | list) and all(map(_is_unchanging, value))
    is_table = isinstance(value, dict) and all(map(_is_unchanging, value.values()))
    if is_row or is_table or _is_unchanging(value):
        return value
    raise UnknownError


def _is_unchanging(value: Any) -> bool:
    """Whether a value is immutable: a plain value, a class, or a frozen object."""
    if isinstance(value, tuple):
        return all(map(_is_unchanging, value))
    if isinstance(value, (*PLAIN, type)) or type(value).__module__.startswith("scanrack.io_images"):
        return True
    kind: Any = type(value)
    return is_dataclass(value) and bool(kind.__dataclass_params__.frozen)


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
