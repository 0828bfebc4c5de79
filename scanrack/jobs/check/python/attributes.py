"""Names, attributes and calls in a program text that fail when they run.

scan.now                        the scan has no `now`
scan.slot[3].outputs.set_bit(0, 17, True)    a word has 16 bits
Direction.LEFT                  the class has no LEFT
FindHome(Direction.CW, 800)     arguments are missing
knive = not knife               no name `knife`
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import EnumMeta
from inspect import isfunction, signature
from types import FunctionType, ModuleType

from .chance import resolved
from .nodes import Function, field_of, is_loaded, is_stored, missing, names_in, nearest, nodes_in, unpacks
from .reader import Reader, functions_in


def note_names(reader: Reader) -> None:
    """Note names that do not exist, attributes of modules and classes, and calls that do not fit."""
    if not reader.names:
        return  # the program is not a function in its own file
    known = {*reader.names, *vars(builtins), "__class__", "__file__", "__name__"}
    for function, owner in functions_in(reader.tree):
        own = {*known, *_bound(function), *([] if owner is None else ["super"])}
        local = own - {*reader.names, *vars(builtins)}
        for node in ast.walk(function):
            match node:
                case ast.Name(id=name, ctx=ast.Load()) if name not in own:
                    _unknown_name(node, own, reader)
                case ast.Attribute():
                    _dotted(node, reader, local)
                    _of_parameter(node, function, reader)
                case ast.Subscript():
                    _element(node, reader)
                case ast.Call():
                    _call(node, reader, owner)
                case ast.For(iter=iterable) if _is_set(iterable):
                    order = "the order of a set differs from run to run"
                    text = f"`for ... in {ast.unparse(iterable)}`: {order}"
                    reader.remark("not-deterministic", node, text)


def _unknown_name(node: ast.Name, known: Collection[str], reader: Reader) -> None:
    reader.remark("unknown-attribute", node, f"no name `{node.id}`{nearest(node.id, known)}")


def _bound(function: Function) -> Iterator[str]:
    """Yield all names that a function and its inner functions bind."""
    for node in ast.walk(function):
        match node:
            case ast.arg(arg=name) | ast.Name(id=name, ctx=ast.Store()):
                yield name
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                yield node.name
            case ast.alias():
                yield (node.asname or node.name).partition(".")[0]
            case ast.ExceptHandler(name=str(name)) | ast.MatchAs(name=str(name)):
                yield name
            case ast.MatchStar(name=str(name)) | ast.MatchMapping(rest=str(name)):
                yield name


def _dotted(node: ast.Attribute, reader: Reader, local: set[str]) -> None:
    """Note an attribute that its module or class does not have."""
    root = ast.unparse(node).partition(".")[0]
    owner = None if root in local else resolved(node.value, reader.names)
    if isinstance(owner, ModuleType | type) and is_loaded(node) and not hasattr(owner, node.attr):
        is_open = "__getattr__" in vars(type(owner)) or hasattr(owner, "__getattr__")
        if isinstance(owner, EnumMeta) or not is_open:
            text = missing(ast.unparse(node), node.attr, dir(owner))
            reader.remark("unknown-attribute", node, text)


def _of_parameter(node: ast.Attribute, function: Function, reader: Reader) -> None:
    """Note an attribute that a parameter's dataclass does not have."""
    name = node.value.id if isinstance(node.value, ast.Name) else ""
    annotation = next((arg.annotation for arg in function.args.args if arg.arg == name), None)
    kind = None if annotation is None else resolved(annotation, reader.names)
    names = nodes_in(function, ast.Name)
    if not is_dataclass(kind) or any(occurrence.id == name and is_stored(occurrence) for occurrence in names):
        return
    reader.remark_unless_in({*dir(kind), *(field.name for field in fields(kind))}, node)


def _element(node: ast.Subscript, reader: Reader) -> None:
    """Note a constant key or index that a table of the module does not have."""
    is_table = isinstance(node.value, ast.Name) and node.value.id not in reader.local
    table = resolved(node.value, reader.names) if is_table else None
    keys = (node.slice.body, node.slice.orelse) if isinstance(node.slice, ast.IfExp) else (node.slice,)
    for key in (constant.value for constant in keys if isinstance(constant, ast.Constant)):
        text = _no_key(ast.unparse(node.value), table, key, reader.tree)
        if text:
            reader.remark("subscript", node, text)


def _no_key(name: str, table: object, key: object, tree: ast.Module) -> str:
    """Return a message about a missing key or index of a table; "" if the table may have it."""
    if isinstance(table, tuple) and isinstance(key, int) and not -len(table) <= key < len(table):
        return f"`{name}` has {len(table)} elements, and no [{key}]"
    if isinstance(table, dict) and table and key is not None:
        known = _keys(name, table, tree)
        if known is not None and key not in known:
            return f"`{name}` has no {key!r}: it has {', '.join(map(repr, table))[:80]}"
    return ""


def _keys(name: str, table: Mapping[object, object], tree: ast.Module) -> set[object] | None:
    """Return the keys that a table may have; None if other code may add keys."""
    subscripted = [node for node in nodes_in(tree, ast.Subscript) if ast.unparse(node.value) == name]
    changed_ids = {id(node.target) for node in nodes_in(tree, ast.AugAssign)}
    stored = [node.slice for node in filter(is_stored, subscripted) if id(node) not in changed_ids]
    constants = [node.value for node in stored if isinstance(node, ast.Constant)]
    is_handed_on = list(names_in(tree)).count(name) - 1 > len(subscripted)
    return None if is_handed_on or len(constants) < len(stored) else {*table, *constants}


def _call(call: ast.Call, reader: Reader, owner: ast.ClassDef | None) -> None:
    """Note a call whose arguments do not fit its parameters."""
    own, skipped = _called(call, reader, owner)
    if own is None or unpacks(call):
        return
    try:
        parameters = signature(own)  # type: ignore[arg-type]  # a class or a function
    except (TypeError, ValueError):
        return
    named = {str(keyword.arg): None for keyword in call.keywords}
    try:
        parameters.bind(*[None] * (len(call.args) + skipped), **named)
    except TypeError as error:
        reader.remark("bad-call", call, f"`{ast.unparse(call.func)}()`: {error}")


def _called(call: ast.Call, reader: Reader, owner: ast.ClassDef | None) -> tuple[object, int]:
    """Return the called function or class, None if unknown, and how many arguments Python adds (`self`)."""
    method = field_of(call.func)
    if method and owner is not None:
        kind = reader.names.get(owner.name)
        attribute = vars(kind).get(method) if isinstance(kind, type) else None
        return (attribute, 1) if isfunction(attribute) else (None, 0)
    root = ast.unparse(call.func).partition(".")[0]
    attribute = None if root in reader.local else resolved(call.func, reader.names)
    return (
        (attribute, 0)
        if isinstance(attribute, FunctionType | type) and _is_ours(attribute, reader)
        else (None, 0)
    )


def _is_ours(found: object, reader: Reader) -> bool:
    """Whether a function or class belongs to this program or to scanrack."""
    module = str(getattr(found, "__module__", ""))
    return module.startswith("scanrack") or module == reader.names.get("__name__")


def _is_set(node: ast.expr) -> bool:
    is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    return isinstance(node, ast.Set) or (is_call and ast.unparse(node).startswith(("set(", "frozenset(")))
