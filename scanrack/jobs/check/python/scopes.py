"""Names in a text: parameters and variables that nothing reads, names that hide others, recursion."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterator

from ..facts import Facts, FileLine
from .reader import Function, Reader, functions_in

_USUAL = frozenset(
    ["id", "input", "type", "help", "exit", "quit", "license", "format", "dir", "vars", "object", "property"]
)
"""Names of built-in functions that many programs use for something else."""

_HIDING = frozenset(name for name in vars(builtins) if name.islower() and name[0] != "_") - _USUAL
"""Built-in functions that a name should not hide."""


class Scopes:
    """Notes the mistakes with names in a text."""

    def __init__(self, reader: Reader, facts: Facts) -> None:
        self._reader, self._facts = reader, facts
        self._globals = {name for node in reader.tree.body for name in _declared(node)}

    def note(self) -> None:
        """Note them all."""
        for function, owner in functions_in(self._reader.tree):
            self._parameters(function, owner)
            self._shadows(function)
            self._unread(function)
        self._recursion()

    def _remark(self, rule: str, node: ast.AST, text: str) -> None:
        self._facts.remark(rule, FileLine(self._reader.file, getattr(node, "lineno", 1)), text)

    def _parameters(self, function: Function, owner: ast.ClassDef | None) -> None:
        """Note parameters that nothing uses."""
        arguments = function.args
        every = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
        is_entry = owner is None and not self._is_called(function.name)
        if is_entry or function.decorator_list or function.name.startswith("__") or _is_stub(function):
            return
        used = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)}
        for each in every[1 if owner is not None else 0 :]:
            if each.arg not in used and not each.arg.startswith("_"):
                self._remark(
                    "unused-parameter", each, f"{function.name} does not use its parameter {each.arg}"
                )

    def _is_called(self, name: str) -> bool:
        calls = (node.func for node in ast.walk(self._reader.tree) if isinstance(node, ast.Call))
        return any(isinstance(each, ast.Name) and each.id == name for each in calls)

    def _shadows(self, function: Function) -> None:
        """Note local names that hide a name of the module, or a built-in function."""
        declared = {
            name
            for node in ast.walk(function)
            if isinstance(node, ast.Global | ast.Nonlocal)
            for name in node.names
        }
        seen = set()
        for name, node in _bound_in(function):
            if name in seen or name in declared:
                continue
            seen.add(name)
            if name in self._globals:
                self._remark("shadowed-name", node, f"{name} in {function.name} hides {name} of the module")
            elif name in _HIDING:
                self._remark("shadowed-name", node, f"{name} in {function.name} hides the built-in {name}")
        for loop in ast.walk(function):
            if isinstance(loop, ast.For):
                own = {each.id for each in ast.walk(loop.target) if isinstance(each, ast.Name)}
                for inner in (each for part in loop.body for each in ast.walk(part)):
                    if isinstance(inner, ast.For):
                        again = own & {
                            each.id for each in ast.walk(inner.target) if isinstance(each, ast.Name)
                        }
                        for name in sorted(again - {"_"}):
                            self._remark(
                                "shadowed-name", inner, f"this loop uses {name}, as the loop around it does"
                            )

    def _unread(self, function: Function) -> None:
        """Note local variables that nothing reads."""
        names = [node for node in ast.walk(function) if isinstance(node, ast.Name)]
        read = {node.id for node in names if isinstance(node.ctx, ast.Load | ast.Del)}
        outside = {
            name
            for node in ast.walk(function)
            if isinstance(node, ast.Global | ast.Nonlocal)
            for name in node.names
        }
        read |= {
            node.target.id
            for node in ast.walk(function)
            if isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name)
        }
        for node in ast.walk(function):
            target = node.targets[0] if isinstance(node, ast.Assign) and len(node.targets) == 1 else None
            if (
                isinstance(target, ast.Name)
                and target.id not in read | outside
                and not target.id.startswith("_")
            ):
                self._remark("never-read", node, f"{target.id} is assigned, and nothing reads it")

    def _recursion(self) -> None:
        """Note functions that call themselves, directly or through others."""
        calls: dict[str, set[str]] = {}
        for function, owner in functions_in(self._reader.tree):
            called = [node.func for node in ast.walk(function) if isinstance(node, ast.Call)]
            own = (each for each in called if _is_own(each, method=owner is not None))
            calls[function.name] = {ast.unparse(each).removeprefix("self.") for each in own}
        for function, _ in functions_in(self._reader.tree):
            reached: set[str] = set()
            todo = [*calls[function.name]]
            while todo:
                name = todo.pop()
                if name not in reached and name in calls:
                    reached.add(name)
                    todo += calls[name]
            if function.name in reached:
                self._remark(
                    "recursion", function, f"{function.name} calls itself, directly or through others"
                )


def _is_own(called: ast.expr, *, method: bool) -> bool:
    """Whether a call is one of `self.name()`, in a function one of `name()`."""
    if isinstance(called, ast.Attribute):
        return method and isinstance(called.value, ast.Name) and called.value.id == "self"
    return isinstance(called, ast.Name)


def _is_stub(function: Function) -> bool:
    """Whether a function only raises, passes, or returns a constant: another class fills it in."""
    body = [
        each
        for each in function.body
        if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))
    ]
    return all(isinstance(each, ast.Pass | ast.Raise) for each in body)


def _declared(node: ast.stmt) -> Iterator[str]:
    """Yield the names of values that a statement of the module declares, and of functions and classes."""
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield node.name
    elif isinstance(node, ast.Assign | ast.AnnAssign):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        yield from (each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name))
    elif isinstance(node, ast.Import | ast.ImportFrom):
        yield from ((each.asname or each.name).partition(".")[0] for each in node.names)


def _bound_in(function: Function) -> Iterator[tuple[str, ast.AST]]:
    for node in ast.walk(function):
        if isinstance(node, ast.arg) and node.arg != "self":
            yield node.arg, node
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id, node
