"""Names, attributes and calls in a text that fail when they are reached.

scan.now                        the scan has no `now`
scan.slot[3].outputs.set_bit(0, 17, True)    a word has 16 bits
Direction.LEFT                  the class has no LEFT
FindHome(Direction.CW, 800)     arguments are missing
knive = not knife               there is no name `knife`
"""

from __future__ import annotations

import ast
import builtins
import difflib
from collections.abc import Iterator
from enum import EnumMeta
from inspect import isfunction, signature
from types import ModuleType

from ..facts import Facts, FileLine
from .chance import resolved
from .reader import Function, Reader, functions_in
from .scans import missing


def note_names(reader: Reader, facts: Facts) -> None:
    """Note names that do not exist, attributes of modules and classes, and calls that do not fit."""
    known = {*reader.names, *vars(builtins), "__class__", "__file__", "__name__"}
    for function, owner in functions_in(reader.tree):
        own = {*known, *_bound(function), *([] if owner is None else ["super"])}
        for node in ast.walk(function):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id not in own:
                near = difflib.get_close_matches(node.id, own, n=1)
                hint = f"; did you mean {near[0]}?" if near else ""
                _remark(facts, "unknown-attribute", reader, node, f"there is no name `{node.id}`{hint}")
            elif isinstance(node, ast.Attribute):
                _dotted(node, reader, own - {*reader.names, *vars(builtins)}, facts)
            elif isinstance(node, ast.Call):
                _call(node, reader, owner, facts)
            elif isinstance(node, ast.For) and _is_set(node.iter):
                text = f"`for ... in {ast.unparse(node.iter)}`: the order of a set differs from run to run"
                _remark(facts, "not-deterministic", reader, node, text)


def _remark(facts: Facts, rule: str, reader: Reader, node: ast.expr | ast.stmt, text: str) -> None:
    facts.remark(rule, FileLine(reader.file, node.lineno), text)


def _bound(function: Function) -> Iterator[str]:
    """Yield all names that a function binds, in functions within it, too."""
    for node in ast.walk(function):
        match node:
            case ast.arg(arg=name) | ast.Name(id=name, ctx=ast.Store()):
                yield name
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                yield name
            case ast.Import(names=names) | ast.ImportFrom(names=names):
                yield from ((each.asname or each.name).partition(".")[0] for each in names)
            case (
                ast.ExceptHandler(name=str(name))
                | ast.MatchAs(name=str(name))
                | ast.MatchStar(name=str(name))
            ):
                yield name
            case ast.MatchMapping(rest=str(name)):
                yield name


def _dotted(node: ast.Attribute, reader: Reader, local: set[str], facts: Facts) -> None:
    """Note an attribute that a module or a class does not have."""
    root = ast.unparse(node).partition(".")[0]
    owner = None if root in local else resolved(node.value, reader.names)
    if (
        isinstance(owner, ModuleType | type)
        and isinstance(node.ctx, ast.Load)
        and not hasattr(owner, node.attr)
    ):
        is_open = "__getattr__" in vars(type(owner)) or hasattr(owner, "__getattr__")
        if isinstance(owner, EnumMeta) or not is_open:
            _remark(
                facts, "unknown-attribute", reader, node, missing(ast.unparse(node), node.attr, dir(owner))
            )


def _call(call: ast.Call, reader: Reader, owner: ast.ClassDef | None, facts: Facts) -> None:
    """Note a call whose arguments do not fit."""
    own, skipped = _called(call, reader, owner)
    is_open = any(isinstance(each, ast.Starred) for each in call.args) or None in (
        each.arg for each in call.keywords
    )
    if own is None or is_open:
        return
    try:
        parameters = signature(own)  # type: ignore[arg-type]  # a class or a function
    except (TypeError, ValueError):
        return
    try:
        parameters.bind(
            *[None] * (len(call.args) + skipped), **{str(each.arg): None for each in call.keywords}
        )
    except TypeError as error:
        _remark(facts, "bad-call", reader, call, f"`{ast.unparse(call.func)}()`: {error}")


def _called(call: ast.Call, reader: Reader, owner: ast.ClassDef | None) -> tuple[object, int]:
    """Return the function or class of a call, and how many arguments come by themselves; None if unknown."""
    if isinstance(call.func, ast.Attribute) and ast.unparse(call.func.value) == "self" and owner is not None:
        kind = reader.names.get(owner.name)
        found = vars(kind).get(call.func.attr) if isinstance(kind, type) else None
        return (found, 1) if isfunction(found) else (None, 0)
    root = ast.unparse(call.func).partition(".")[0]
    found = None if root in reader.local else resolved(call.func, reader.names)
    module = str(getattr(found, "__module__", ""))
    is_ours = module.startswith("scanrack") or module == reader.names.get("__name__")
    return (found, 0) if is_ours and (isfunction(found) or isinstance(found, type)) else (None, 0)


def _is_set(node: ast.expr) -> bool:
    is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    return isinstance(node, ast.Set) or (is_call and ast.unparse(node).startswith(("set(", "frozenset(")))
