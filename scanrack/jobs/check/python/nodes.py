"""Walks over the syntax tree of a Python program, tests of its nodes, and sentences about its names."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import TypeVar, overload

One = TypeVar("One", bound=ast.AST)
Two = TypeVar("Two", bound=ast.AST)
Three = TypeVar("Three", bound=ast.AST)

Trees = ast.AST | Iterable[ast.AST]

Function = ast.FunctionDef | ast.AsyncFunctionDef

FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


@overload
def nodes_in(tree: Trees, kind: type[One], /) -> Iterator[One]: ...


@overload
def nodes_in(tree: Trees, kind: type[One], other: type[Two], /) -> Iterator[One | Two]: ...


@overload
def nodes_in(
    tree: Trees, kind: type[One], other: type[Two], third: type[Three], /
) -> Iterator[One | Two | Three]: ...


@overload
def nodes_in(tree: Trees, *kinds: type[ast.AST]) -> Iterator[ast.AST]: ...


def nodes_in(tree: Trees, *kinds: type[ast.AST]) -> Iterator[ast.AST]:
    """Yield the nodes of the given kinds in a tree, or in the trees of several statements."""
    for root in [tree] if isinstance(tree, ast.AST) else tree:
        for node in ast.walk(root):
            if isinstance(node, kinds):
                yield node


def names_in(tree: ast.AST) -> Iterator[str]:
    """Yield the names in a tree, without attributes."""
    return (node.id for node in nodes_in(tree, ast.Name))


def is_stored(node: ast.AST) -> bool:
    """Whether a node is a name, attribute or element that is assigned."""
    return isinstance(getattr(node, "ctx", None), ast.Store)


def is_loaded(node: ast.AST) -> bool:
    """Whether a node is a name, attribute or element that is read."""
    return isinstance(getattr(node, "ctx", None), ast.Load)


def stored_attributes(tree: Trees) -> set[str]:
    """Return the attributes, of any object, that a text assigns."""
    return {node.attr for node in nodes_in(tree, ast.Attribute) if is_stored(node)}


def targets_of(node: ast.AST) -> Sequence[ast.expr]:
    """Return the targets of an assignment with a value; none for other statements."""
    if isinstance(node, ast.Assign):
        return node.targets
    return [node.target] if isinstance(node, ast.AnnAssign) and node.value is not None else []


def assignments_in(nodes: Trees) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Yield the targets of assignments with their values.

    Args:
        nodes: a tree, or statements; statements inside these are ignored.
    """
    for node in ast.walk(nodes) if isinstance(nodes, ast.AST) else nodes:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            for target in targets_of(node):
                yield target, node.value


def outer_names(tree: ast.AST) -> set[str]:
    """Return the names that functions declare as global or nonlocal."""
    return {name for node in nodes_in(tree, ast.Global, ast.Nonlocal) for name in node.names}


def bodies_of(statement: ast.stmt) -> Iterator[list[ast.stmt]]:
    """Yield the bodies of a compound statement in order, including those of its handlers and cases."""
    for name in statement._fields:
        if name in ("body", "orelse", "finalbody"):
            yield getattr(statement, name)
        elif name in ("handlers", "cases"):
            yield from (child.body for child in getattr(statement, name))


def parents_in(tree: ast.AST) -> dict[int, ast.AST]:
    """Return the parent of each node, by the node's `id`."""
    return {id(child): node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}


def unpacks(call: ast.Call) -> bool:
    """Whether a call unpacks arguments, so that their parameters are unknown."""
    is_starred = any(isinstance(arg, ast.Starred) for arg in call.args)
    return is_starred or any(keyword.arg is None for keyword in call.keywords)


def given_to(parameters: Iterable[str], call: ast.Call) -> dict[str, ast.expr]:
    """Return the arguments of a call by parameter name, without unpacked arguments."""
    named = {keyword.arg: keyword.value for keyword in call.keywords if keyword.arg is not None}
    return {**dict(zip(parameters, call.args, strict=False)), **named}


def parameters_of(function: Function) -> list[str]:
    """Return the names of the parameters that positional arguments fill, without `self`."""
    return [arg.arg for arg in function.args.args if arg.arg != "self"]


def is_self(node: ast.AST) -> bool:
    """Whether an expression is `self`."""
    return isinstance(node, ast.Name) and node.id == "self"


def field_of(node: ast.AST) -> str:
    """Return `name` for `self.name`; "" for any other expression."""
    return node.attr if isinstance(node, ast.Attribute) and is_self(node.value) else ""


def last_name(node: ast.AST) -> str:
    """Return the last part of a dotted name."""
    return ast.unparse(node).rpartition(".")[2]


def missing(text: str, name: str, names: Collection[str]) -> str:
    """Return a message that an attribute does not exist, with the closest existing name."""
    return f"no {text}{nearest(name, [known for known in names if not known.startswith('_')])}"


def nearest(name: str, names: Collection[str]) -> str:
    """Return a question about the closest existing name, to end a message; "" if no name is close."""
    closest = difflib.get_close_matches(name, names, n=1)
    return f"; did you mean {closest[0]}?" if closest else ""
