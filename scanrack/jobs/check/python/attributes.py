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
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import EnumMeta
from inspect import isfunction, signature
from types import FunctionType, ModuleType

from .chance import resolved
from .nodes import Function, field_of, is_loaded, is_stored, missing, names_in, nearest, nodes_in, unpacks
from .reader import Reader, functions_in


def note_names(reader: Reader) -> None:
    """Note names and attributes that do not exist, and calls whose arguments do not fit."""
    if not reader.names:
        return  # the program is not a function in its own file
    global_names = {*reader.names, *vars(builtins)}
    for function, owner in functions_in(reader.tree):
        names = {*global_names, *_bound_names(function), "__class__", "__file__", "__name__"}
        if owner is not None:
            names.add("super")
        for node in ast.walk(function):
            match node:
                case ast.Name(id=name, ctx=ast.Load()) if name not in names:
                    reader.remark("unknown-attribute", node, f"no name `{name}`{nearest(name, names)}")
                case ast.Attribute():
                    _note_missing_member(node, reader, names - global_names)
                    _note_missing_field(node, function, reader)
                case ast.Subscript():
                    _note_missing_element(node, reader)
                case ast.Call():
                    _note_bad_call(node, reader, owner)
                case ast.For(iter=iterable) if _is_set(iterable):
                    order = "the order of a set differs from run to run"
                    text = f"`for ... in {ast.unparse(iterable)}`: {order}"
                    reader.remark("not-deterministic", node, text)


def _bound_names(function: Function) -> Iterator[str]:
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


def _note_missing_member(node: ast.Attribute, reader: Reader, local_names: set[str]) -> None:
    """Note an attribute that its module or class does not have."""
    root = ast.unparse(node).partition(".")[0]
    owner = None if root in local_names else resolved(node.value, reader.names)
    if isinstance(owner, ModuleType | type) and is_loaded(node) and not hasattr(owner, node.attr):
        is_open = "__getattr__" in vars(type(owner)) or hasattr(owner, "__getattr__")
        if isinstance(owner, EnumMeta) or not is_open:
            text = missing(ast.unparse(node), node.attr, dir(owner))
            reader.remark("unknown-attribute", node, text)


def _note_missing_field(node: ast.Attribute, function: Function, reader: Reader) -> None:
    """Note an attribute that a parameter's dataclass does not have."""
    name = node.value.id if isinstance(node.value, ast.Name) else ""
    annotation = next((arg.annotation for arg in function.args.args if arg.arg == name), None)
    kind = None if annotation is None else resolved(annotation, reader.names)
    names = nodes_in(function, ast.Name)
    if not is_dataclass(kind) or any(occurrence.id == name and is_stored(occurrence) for occurrence in names):
        return
    reader.remark_unless_in({*dir(kind), *(field.name for field in fields(kind))}, node)


def _note_missing_element(node: ast.Subscript, reader: Reader) -> None:
    """Note a constant key or index that a table of the module does not have."""
    is_table = isinstance(node.value, ast.Name) and node.value.id not in reader.local
    table = resolved(node.value, reader.names) if is_table else None
    keys = (node.slice.body, node.slice.orelse) if isinstance(node.slice, ast.IfExp) else (node.slice,)
    for key in (constant.value for constant in keys if isinstance(constant, ast.Constant)):
        text = _missing_key(ast.unparse(node.value), table, key, reader.tree)
        if text:
            reader.remark("subscript", node, text)


def _missing_key(name: str, table: object, key: object, tree: ast.Module) -> str:
    """Return a message about a missing key or index of a table; "" if the table may have it."""
    if isinstance(table, tuple) and isinstance(key, int) and not -len(table) <= key < len(table):
        return f"`{name}` has {len(table)} elements: no [{key}]"
    if isinstance(table, dict) and table and key is not None:
        keys = _possible_keys(name, table, tree)
        if keys is not None and key not in keys:
            return f"`{name}` has no {key!r}: it has {', '.join(map(repr, table))[:80]}"
    return ""


def _possible_keys(name: str, table: Mapping[object, object], tree: ast.Module) -> set[object] | None:
    """Return the keys that a table may have; None if other code may add keys."""
    elements = [node for node in nodes_in(tree, ast.Subscript) if ast.unparse(node.value) == name]
    changed_ids = {id(node.target) for node in nodes_in(tree, ast.AugAssign)}
    stored_keys = [node.slice for node in filter(is_stored, elements) if id(node) not in changed_ids]
    constants = [node.value for node in stored_keys if isinstance(node, ast.Constant)]
    # one use of the name is its assignment
    is_passed_on = list(names_in(tree)).count(name) - 1 > len(elements)
    return None if is_passed_on or len(constants) < len(stored_keys) else {*table, *constants}


def _note_bad_call(call: ast.Call, reader: Reader, owner: ast.ClassDef | None) -> None:
    """Note a call whose arguments do not fit its parameters."""
    function, arguments_added = _called_function(call, reader, owner)
    if function is None or unpacks(call):
        return
    try:
        parameters = signature(function)  # type: ignore[arg-type]  # a class or a function
    except (TypeError, ValueError):
        return
    keywords = {str(keyword.arg): None for keyword in call.keywords}
    try:
        parameters.bind(*[None] * (len(call.args) + arguments_added), **keywords)
    except TypeError as error:
        reader.remark("bad-call", call, f"`{ast.unparse(call.func)}()`: {error}")


def _called_function(call: ast.Call, reader: Reader, owner: ast.ClassDef | None) -> tuple[object, int]:
    """Return the called function or class, None if unknown, and how many arguments Python adds (`self`)."""
    method_name = field_of(call.func)
    if method_name and owner is not None:
        kind = reader.names.get(owner.name)
        method = vars(kind).get(method_name) if isinstance(kind, type) else None
        return (method, 1) if isfunction(method) else (None, 0)
    root = ast.unparse(call.func).partition(".")[0]
    function = None if root in reader.local else resolved(call.func, reader.names)
    is_known = isinstance(function, FunctionType | type) and _is_ours(function, reader)
    return (function if is_known else None), 0


def _is_ours(function: object, reader: Reader) -> bool:
    """Whether a function or class belongs to this program or to scanrack."""
    module = str(getattr(function, "__module__", ""))
    return module.startswith("scanrack") or module == reader.names.get("__name__")


def _is_set(node: ast.expr) -> bool:
    is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    return isinstance(node, ast.Set) or (is_call and ast.unparse(node).startswith(("set(", "frozenset(")))
