"""Mistakes that show in one function of a Python program: its conditions, lines, numbers and names."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..facts import Facts, FileLine
from ..logic import TRUE, UNKNOWN, AllOf, Condition, FixedTruth, always, leaves, negated, never
from .conditions import ConditionNames, condition
from .reader import Reader, UnknownError

Function = ast.FunctionDef | ast.AsyncFunctionDef

CHANCE = frozenset(
    {
        "random",
        "secrets",
        "uuid",
        "time",
        "datetime",
        "asyncio",
        "threading",
        "socket",
        "subprocess",
        "multiprocessing",
    }
)
"""Modules whose results differ from run to run, or that wait on the wall clock."""

CHANCE_OF = frozenset({("os", "urandom"), ("os", "getpid"), ("os", "times"), ("numpy", "random")})
"""Functions of other modules that do so."""

_LEAVES = (ast.Return, ast.Raise, ast.Break, ast.Continue)
_USUAL = frozenset(
    ["id", "input", "type", "help", "exit", "quit", "license", "format", "dir", "vars", "object", "property"]
)
"""Names of built-in functions that many programs use for something else."""

_HIDING = frozenset(name for name in vars(builtins) if name.islower() and name[0] != "_") - _USUAL
"""Built-in functions that a name should not hide."""


class Flow:
    """Notes the mistakes of the functions in a text."""

    def __init__(self, reader: Reader, facts: Facts) -> None:
        self._reader, self._facts = reader, facts
        self._names = ConditionNames()
        self._globals = {name for node in reader.tree.body for name in _declared(node)}

    def note(self) -> None:
        """Note them all."""
        for function, owner in functions_in(self._reader.tree):
            self._names.forget()
            self._body(function.body, TRUE)
            self._parameters(function, owner)
            self._shadows(function)
            self._unread(function)
        for statement in self._reader.tree.body:
            if isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test):
                continue  # no part of the logic
            for node in ast.walk(statement):
                if isinstance(node, ast.expr):
                    self._number(node)
                if isinstance(node, ast.Call):
                    self._chance(node)
        self._recursion()

    def _remark(self, rule: str, node: ast.AST, text: str) -> None:
        self._facts.remark(rule, FileLine(self._reader.file, getattr(node, "lineno", 1)), text)

    # --- conditions and lines

    def _body(self, body: Sequence[ast.stmt], reached: Condition) -> None:
        for at, each in enumerate(body):
            self._statement(each, reached)
            if at + 1 < len(body) and _never_ends(each):
                text = f"line {each.lineno} never goes on to this line"
                self._remark("unreachable", body[at + 1], text)
                return
            if isinstance(each, ast.If) and not each.orelse and _leaves(each.body):
                reached = _both(reached, negated(condition(each.test, self._names)))

    def _statement(self, node: ast.stmt, reached: Condition) -> None:
        match node:
            case ast.If(test, body, orelse):
                own = self._test(test, reached)
                turn = self._names.turn
                self._body(body, _both(reached, own))
                self._names.turn, after = turn, self._names.turn
                self._body(orelse, _both(reached, negated(own)))
                if after != turn:
                    self._names.forget()
            case ast.While(test, body, orelse):
                self._names.forget()
                if not isinstance(test, ast.Constant) or not test.value:
                    self._test(test, TRUE)
                self._body(body, TRUE)
                self._names.forget()
                self._body(orelse, TRUE)
            case ast.For(body=body, orelse=orelse) | ast.AsyncFor(body=body, orelse=orelse):
                self._names.forget()
                self._body(body, TRUE)
                self._names.forget()
                self._body(orelse, TRUE)
            case ast.With(body=body) | ast.AsyncWith(body=body):
                self._names.forget()
                self._body(body, TRUE)
            case ast.Try():
                for block in (node.body, *(each.body for each in node.handlers), node.orelse, node.finalbody):
                    self._names.forget()
                    self._body(block, TRUE)
            case ast.Match(cases=cases):
                for each in cases:
                    self._names.forget()
                    self._body(each.body, TRUE)
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                return
            case _:
                self._expressions(node)
                self._names.forget()

    def _test(self, test: ast.expr, reached: Condition) -> Condition:
        """Note a test that never holds, or always does; return its condition."""
        own = condition(test, self._names)
        text = ast.unparse(test)
        if never(own):
            rule = "contradiction" if len(list(leaves(own))) > 1 else "constant-condition"
            self._remark(rule, test, f"`{text}` never holds")
        elif always(own):
            self._remark("constant-condition", test, f"`{text}` always holds")
        elif own != UNKNOWN and never(AllOf((reached, own))) and not never(reached):
            self._remark(
                "contradiction", test, f"`{text}` never holds here: the conditions before it exclude it"
            )
        else:
            self._expressions(test)
            return own
        return UNKNOWN

    def _expressions(self, node: ast.AST) -> None:
        """Note the conditions in the expressions of a statement, such as those of `until` and `and`."""
        outer: set[int] = set()
        for each in ast.walk(node):
            if id(each) in outer or not isinstance(each, ast.BoolOp | ast.IfExp | ast.Compare):
                continue
            tested = each.test if isinstance(each, ast.IfExp) else each
            own = condition(tested, self._names)
            outer |= {id(inner) for inner in ast.walk(each)}
            several = len(list(leaves(own))) > 1
            if own == UNKNOWN or (isinstance(own, FixedTruth) and not isinstance(each, ast.Compare)):
                continue
            text = ast.unparse(tested)
            if never(own):
                self._remark(
                    "contradiction" if several else "constant-condition", each, f"`{text}` never holds"
                )
            elif always(own):
                self._remark("constant-condition", each, f"`{text}` always holds")

    # --- numbers and chance

    def _number(self, node: ast.expr) -> None:
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div | ast.FloorDiv | ast.Mod):
            try:
                divisor = self._reader.value(node.right)
            except UnknownError:
                return
            if isinstance(divisor, int | float) and divisor == 0:
                self._remark("division-by-zero", node, f"`{ast.unparse(node)}` divides by 0")

    def _chance(self, call: ast.Call) -> None:
        name = ast.unparse(call.func)
        found = _resolved(call.func, self._reader.names)
        module = getattr(found, "__module__", None) or _module_of(found)
        first = (module or "").partition(".")[0].lstrip("_")
        root = self._reader.names.get(name.partition(".")[0])
        root_module = getattr(root, "__name__", "") if _is_module(root) else ""
        last = name.rpartition(".")[2]
        of_class = str(getattr(root, "__module__", "")) if isinstance(root, type) else ""
        is_wall = first in CHANCE or of_class in CHANCE or root_module.partition(".")[0] in CHANCE
        if is_wall or (root_module, last) in CHANCE_OF or name in ("open", "input"):
            self._remark("not-deterministic", call, f"`{name}()`: two runs of the logic would differ")

    # --- names

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


def functions_in(tree: ast.Module) -> Iterator[tuple[Function, ast.ClassDef | None]]:
    """Yield the functions of a module and the methods of its classes, with their class."""
    for node in tree.body:
        if isinstance(node, Function):
            yield node, None
        if isinstance(node, ast.ClassDef):
            for each in node.body:
                if isinstance(each, Function):
                    yield each, node


def _is_own(called: ast.expr, *, method: bool) -> bool:
    """Whether a call is one of `self.name()`, in a function one of `name()`."""
    if isinstance(called, ast.Attribute):
        return method and isinstance(called.value, ast.Name) and called.value.id == "self"
    return isinstance(called, ast.Name)


def _both(one: Condition, other: Condition) -> Condition:
    return other if one == TRUE else one if other in (TRUE, UNKNOWN) else AllOf((one, other))


def _leaves(body: Sequence[ast.stmt]) -> bool:
    return bool(body) and (isinstance(body[-1], _LEAVES) or _never_ends(body[-1]))


def _never_ends(node: ast.stmt) -> bool:
    """Whether what follows a statement is never reached."""
    if isinstance(node, _LEAVES):
        return True
    if isinstance(node, ast.While) and isinstance(node.test, ast.Constant) and node.test.value:
        return not any(_breaks(each) for each in node.body)
    if isinstance(node, ast.If):
        return bool(node.orelse) and _leaves(node.body) and _leaves(node.orelse)
    return False


def _breaks(node: ast.AST) -> bool:
    """Whether a statement leaves the loop that it is directly in."""
    if isinstance(node, ast.Break):
        return True
    if isinstance(node, ast.For | ast.While | ast.AsyncFor):
        return any(map(_breaks, node.orelse))
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef | ast.Lambda):
        return False
    return any(map(_breaks, ast.iter_child_nodes(node)))


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


def _resolved(node: ast.expr, names: Mapping[str, Any]) -> object:
    """Return what a name, or attributes of it, mean in the module; None if that is unknown."""
    if isinstance(node, ast.Name):
        return names.get(node.id)
    if isinstance(node, ast.Attribute):
        owner = _resolved(node.value, names)
        is_readable = _is_module(owner) or isinstance(owner, type)
        return getattr(owner, node.attr, None) if is_readable else None
    return None


def _module_of(found: object) -> str:
    return getattr(type(getattr(found, "__self__", None)), "__module__", "") if found is not None else ""


def _is_module(found: object) -> bool:
    return type(found).__name__ == "module"
