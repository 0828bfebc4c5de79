"""Names in a text: unused parameters and variables, names that hide others, and recursion."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterator

from ..groups import reached
from .nodes import Function, field_of, is_stored, names_in, nodes_in, outer_names
from .reader import Reader, functions_in

_USUAL = frozenset(
    ["id", "input", "type", "help", "exit", "quit", "license", "format", "dir", "vars", "object", "property"]
)
"""Built-in names that many programs reuse."""

_HIDING = frozenset(name for name in vars(builtins) if name.islower() and name[0] != "_") - _USUAL
"""Built-in functions whose names should not be hidden."""


class Scopes:
    """Notes mistakes with names in a text."""

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._globals = {name for node in reader.tree.body for name in _declared(node)}

    def note(self) -> None:
        """Note the mistakes of all functions, including recursion."""
        for function, owner in functions_in(self._reader.tree):
            self._parameters(function, owner)
            self._shadows(function)
            self._unread(function)
        self._recursion()

    def _parameters(self, function: Function, owner: ast.ClassDef | None) -> None:
        """Note unused parameters."""
        arguments = function.args
        parameters = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
        is_entry = owner is None and not self._is_called(function.name)
        if is_entry or function.decorator_list or function.name.startswith("__") or _is_stub(function):
            return
        used = set(names_in(function))
        for parameter in parameters if owner is None else parameters[1:]:  # without self
            if parameter.arg not in used and not parameter.arg.startswith("_"):
                text = f"{function.name} does not use its parameter {parameter.arg}"
                self._reader.remark("unused-parameter", parameter, text)

    def _is_called(self, name: str) -> bool:
        calls = (node.func for node in nodes_in(self._reader.tree, ast.Call))
        return any(isinstance(call, ast.Name) and call.id == name for call in calls)

    def _shadows(self, function: Function) -> None:
        """Note local names that hide a global name or a built-in function."""
        done = outer_names(function)  # names that are allowed, or that are already noted
        for name, node in _bound_in(function):
            hidden = f"{name} of the module" if name in self._globals else f"the built-in {name}"
            if name not in done and name in self._globals | _HIDING:
                self._reader.remark("shadowed-name", node, f"{name} in {function.name} hides {hidden}")
            done.add(name)
        for loop in nodes_in(function, ast.For):
            outer = set(names_in(loop.target)) - {"_"}
            for inner in nodes_in(loop.body, ast.For):
                for name in sorted(outer & set(names_in(inner.target))):
                    text = f"this loop uses {name}, as the loop around it does"
                    self._reader.remark("shadowed-name", inner, text)

    def _unread(self, function: Function) -> None:
        """Note local variables that are never read."""
        names = nodes_in(function, ast.Name)
        names_read = {node.id for node in names if not is_stored(node)} | outer_names(function)
        names_read.update(
            name for node in nodes_in(function, ast.AugAssign) for name in names_in(node.target)
        )
        for node in nodes_in(function, ast.Assign):
            target = node.targets[0] if len(node.targets) == 1 else None
            name = target.id if isinstance(target, ast.Name) else "_"
            if name not in names_read and not name.startswith("_"):
                self._reader.remark("never-read", node, f"{name} is assigned, but nothing reads it")

    def _recursion(self) -> None:
        """Note functions that call themselves, directly or through others."""
        functions = list(functions_in(self._reader.tree))
        calls: dict[str, set[str]] = {}
        for function, owner in functions:
            callees = (call.func for call in nodes_in(function, ast.Call))
            calls[function.name] = {
                ast.unparse(callee).removeprefix("self.")
                for callee in callees
                if isinstance(callee, ast.Name) or (owner and field_of(callee))
            }
        for function, _ in functions:
            # `reached` contains the start only if a call leads back to it
            if function.name in reached([function.name], lambda name: calls.get(name, ())):
                text = f"{function.name} calls itself, directly or through others"
                self._reader.remark("recursion", function, text)


def _is_stub(function: Function) -> bool:
    """Whether a function only raises, passes, or contains constants, for another class to implement."""
    for statement in function.body:
        match statement:
            case ast.Pass() | ast.Raise() | ast.Expr(value=ast.Constant()):
                pass
            case _:
                return False
    return True


def _declared(node: ast.stmt) -> Iterator[str]:
    """Yield the names of values, functions and classes that a statement of the module declares."""
    match node:
        case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
            yield name
        case ast.Assign(targets=targets):
            yield from (name for target in targets for name in names_in(target))
        case ast.AnnAssign(target=target):
            yield from names_in(target)
        case ast.Import(names=names) | ast.ImportFrom(names=names):
            yield from ((alias.asname or alias.name).partition(".")[0] for alias in names)


def _bound_in(function: Function) -> Iterator[tuple[str, ast.arg | ast.Name]]:
    """Yield the names that a function binds, each with its node."""
    for node in ast.walk(function):
        if isinstance(node, ast.arg) and node.arg != "self":
            yield node.arg, node
        elif isinstance(node, ast.Name) and is_stored(node):
            yield node.id, node
