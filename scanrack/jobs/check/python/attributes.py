"""Names, attributes and calls in a text that fail when they are reached.

scan.now                        the scan has no `now`
scan.slot[3].outputs.set_bit(0, 17, True)    a word has 16 bits
Direction.LEFT                  the class has no LEFT
FindHome(Direction.CW, 800)     arguments are missing
knive = not knife               no name `knife`
"""

from __future__ import annotations

import ast
import builtins
import difflib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import EnumMeta
from inspect import isfunction, signature
from types import ModuleType

from ..facts import Facts, FileLine
from .chance import resolved
from .reader import Function, Reader, functions_in
from .scans import missing


def note_names(reader: Reader, facts: Facts) -> None:
    """Note names that do not exist, attributes of modules and classes, and calls that do not fit."""
    if not reader.names:
        return  # the program is no function of its file
    known = {*reader.names, *vars(builtins), "__class__", "__file__", "__name__"}
    for function, owner in functions_in(reader.tree):
        own = {*known, *_bound(function), *([] if owner is None else ["super"])}
        for node in ast.walk(function):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id not in own:
                near = difflib.get_close_matches(node.id, own, n=1)
                hint = f"; did you mean {near[0]}?" if near else ""
                _remark(facts, "unknown-attribute", reader, node, f"no name `{node.id}`{hint}")
            elif isinstance(node, ast.Attribute):
                _dotted(node, reader, own - {*reader.names, *vars(builtins)}, facts)
                _of_parameter(node, function, reader, facts)
            elif isinstance(node, ast.Subscript):
                _element(node, reader, facts)
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


def _of_parameter(node: ast.Attribute, function: Function, reader: Reader, facts: Facts) -> None:
    """Note an attribute that a parameter of a data class does not have."""
    arguments = [each for each in function.args.args if each.arg == getattr(node.value, "id", "")]
    kind = resolved(arguments[0].annotation, reader.names) if arguments and arguments[0].annotation else None
    stored = any(
        isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store) and each.id == arguments[0].arg
        for each in ast.walk(function)
        if arguments
    )
    if not is_dataclass(kind) or stored:
        return
    names = {*dir(kind), *(each.name for each in fields(kind))}
    if node.attr not in names:
        _remark(facts, "unknown-attribute", reader, node, missing(ast.unparse(node), node.attr, names))


def _element(node: ast.Subscript, reader: Reader, facts: Facts) -> None:
    """Note a constant key, or index, that a table of the module does not have."""
    is_table = isinstance(node.value, ast.Name) and node.value.id not in reader.local
    table = resolved(node.value, reader.names) if is_table else None
    keys = (node.slice.body, node.slice.orelse) if isinstance(node.slice, ast.IfExp) else (node.slice,)
    for each in keys:
        key = each.value if isinstance(each, ast.Constant) else None
        if isinstance(table, tuple) and isinstance(key, int) and not -len(table) <= key < len(table):
            text = f"`{ast.unparse(node.value)}` has {len(table)} elements, and no [{key}]"
            _remark(facts, "subscript", reader, node, text)
        elif isinstance(table, dict) and table and key is not None:
            known = _keys(ast.unparse(node.value), table, reader.tree)
            if known is not None and key not in known:
                text = (
                    f"`{ast.unparse(node.value)}` has no {key!r}: it has {', '.join(map(repr, table))[:80]}"
                )
                _remark(facts, "subscript", reader, node, text)


def _keys(name: str, table: Mapping[object, object], tree: ast.Module) -> set[object] | None:
    """Return the keys that a table may have; None if something else may add others."""
    nodes = list(ast.walk(tree))
    used = [each for each in nodes if isinstance(each, ast.Subscript) and ast.unparse(each.value) == name]
    names = [each for each in nodes if isinstance(each, ast.Name) and each.id == name]
    changed = {id(each.target) for each in nodes if isinstance(each, ast.AugAssign)}
    stored = [each.slice for each in used if isinstance(each.ctx, ast.Store) and id(each) not in changed]
    if len(names) - 1 > len(used) or not all(isinstance(each, ast.Constant) for each in stored):
        return None
    return {*table, *(each.value for each in stored if isinstance(each, ast.Constant))}


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
