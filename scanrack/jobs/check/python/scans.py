"""What a function of the scan does with slots and with the objects that keep its state."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Collection, Iterator
from typing import Any

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.runtime.config.rackspec import RackSpec

from ..facts import Command, Facts, FileLine, LocalFinding
from ..ranges import ANY, Range, exactly
from .reader import Reader

KINDS = {
    "FindHome": "home",
    "Manual": "run",
    "PresetPosition": "set_position",
    "RunBlend": "run_blend",
    "BlendHeader": "program_blend",
    "Configuration": "configure",
}
"""Commands by their class; a `Move` is absolute or relative by its first argument."""

WORD = (-32_768, 65_535)
"""Values that a word takes, signed or unsigned."""

_WRITING = ("load", "set_bit", "clear")
"""Methods that write an image."""


class Scans:
    """Notes what a text does with `scan.slot[...]`."""

    def __init__(self, reader: Reader, spec: RackSpec, facts: Facts) -> None:
        self._reader, self._spec, self._facts = reader, spec, facts
        self._aliases = dict(_aliases(reader.tree))
        steppers = [slot.number for slot in spec.slot if is_stepper(slot.words)]
        used = [number for number in steppers if f".slot[{number}]" in ast.unparse(reader.tree)]
        self._slot = used[0] if len(used) == 1 else None

    def note(self) -> None:
        """Note all of it."""
        for node in ast.walk(self._reader.tree):
            if isinstance(node, ast.Subscript):
                self._subscript(node)
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                if node.func.attr in _WRITING and self._is_image(node.func.value, ".inputs"):
                    self._remark("input-written", node, f"`{ast.unparse(node)}` writes an input image")
            elif isinstance(node, ast.Assign):
                for target in node.targets:
                    self._assigned(target, node.value)
        self._attributes()
        self._commands()

    def _remark(self, rule: str, node: ast.AST, text: str) -> None:
        self._facts.remark(rule, FileLine(self._reader.file, getattr(node, "lineno", 1)), text)

    def _subscript(self, node: ast.Subscript) -> None:
        """Note a slot that the rack lacks, and an input that is written."""
        owner, index = node.value, node.slice
        if isinstance(owner, ast.Attribute) and owner.attr == "slot" and isinstance(index, ast.Constant):
            there = [slot.number for slot in self._spec.slot]
            if isinstance(index.value, int) and index.value not in there:
                listed = ", ".join(map(str, there))
                self._remark(
                    "no-place", node, f"`{ast.unparse(node)}`: the rack has modules in slots {listed} only"
                )
        if isinstance(node.ctx, ast.Store) and self._is_image(owner, ".inputs"):
            self._remark("input-written", node, f"`{ast.unparse(node)}` is an input: the module writes it")

    def _is_image(self, node: ast.expr, end: str) -> bool:
        text = ast.unparse(node)
        for _ in self._aliases:
            first, dot, rest = text.partition(".")
            text = f"{self._aliases.get(first, first)}{dot}{rest}"
        return ".slot[" in text and text.endswith(end)

    def _assigned(self, target: ast.expr, value: ast.expr) -> None:
        """Note a word that is given another number than it can hold."""
        if not (isinstance(target, ast.Subscript) and self._is_image(target.value, ".outputs")):
            return
        text = word_lost(value, _range(value))
        if text:
            self._remark("lossy-conversion", value, text)

    # --- state

    def _attributes(self) -> None:
        """Note attributes that the objects of the module's own classes do not have."""
        classes = {node.name: node for node in self._reader.tree.body if isinstance(node, ast.ClassDef)}
        for name, value in self._reader.names.items():
            kind = classes.get(type(value).__name__)
            if kind is None or type(value).__module__ != self._reader.names.get("__name__"):
                continue
            known = {*dir(value), *_fields(kind)}
            if "__setattr__" in vars(type(value)) or "__getattr__" in vars(type(value)):
                continue
            for node in ast.walk(self._reader.tree):
                is_ours = isinstance(node, ast.Attribute) and ast.unparse(node.value) == name
                if is_ours and isinstance(node, ast.Attribute) and node.attr not in known:
                    text = missing(f"{name}.{node.attr}", node.attr, known)
                    self._remark("unknown-attribute", node, text)
        for kind in classes.values():
            self._own_attributes(kind)
        self._views()

    def _own_attributes(self, kind: ast.ClassDef) -> None:
        if kind.bases or kind.keywords:
            return
        known = {*_fields(kind), *dir(object)}
        for node in ast.walk(kind):
            is_own = (
                isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Name)
                and node.value.id == "self"
            )
            if is_own and isinstance(node, ast.Attribute) and node.attr not in known:
                self._remark("unknown-attribute", node, missing(f"self.{node.attr}", node.attr, known))

    def _views(self) -> None:
        """Note bits that a view of a status does not have: `status.MOVE_COMPLET`."""
        views: dict[str, Any] = {}
        for node in ast.walk(self._reader.tree):
            value = node.value if isinstance(node, ast.Assign) and len(node.targets) == 1 else None
            called = self._reader.names.get(ast.unparse(value.func)) if isinstance(value, ast.Call) else None
            if isinstance(node, ast.Assign) and getattr(called, "__name__", "") == "StatusView":
                views[ast.unparse(node.targets[0])] = called
        for node in ast.walk(self._reader.tree):
            if isinstance(node, ast.Attribute) and ast.unparse(node.value) in views:
                names = set(dir(views[ast.unparse(node.value)]))
                if node.attr not in names:
                    self._remark("unknown-attribute", node, missing(ast.unparse(node), node.attr, names))

    # --- commands

    def _commands(self) -> None:
        """Note the commands, given as words."""
        others = [node for node in ast.walk(self._reader.tree) if isinstance(node, ast.Subscript)]
        writes = [
            node
            for node in others
            if isinstance(node.ctx, ast.Store) and self._is_image(node.value, ".outputs")
        ]
        if (
            len(writes) > len([node for node in writes if _is_zeroed(node, self._reader.tree)])
            and self._slot is not None
        ):
            self._facts.computed.add(self._slot)
        for node in ast.walk(self._reader.tree):
            if not isinstance(node, ast.Call):
                continue
            name = ast.unparse(node.func).rpartition(".")[2]
            kind = KINDS.get(name, "")
            if name == "Move":
                kind = "move_to" if "ABSOLUTE" in ast.unparse(node) else "move_by"
            if kind == "configure" and not self._is_used(node):
                continue
            if kind and self._slot is not None:
                place = FileLine(self._reader.file, node.lineno)
                self._facts.commands.append(
                    Command(kind, f"slot {self._slot}", self._slot, place, name, words=True)
                )
        for node in ast.walk(self._reader.tree):
            called = node.func if isinstance(node, ast.Call) else None
            is_load = isinstance(called, ast.Attribute) and called.attr == "load"
            if not is_load or not isinstance(node, ast.Call) or not isinstance(called, ast.Attribute):
                continue
            if self._is_image(called.value, ".outputs") and self._is_motion(node):
                place = FileLine(self._reader.file, node.lineno)
                self._facts.at_once.append(LocalFinding(place, "load writes all eight words"))
                return

    def _is_motion(self, load: ast.Call) -> bool:
        """Whether a call loads a motion, made there or under the name that it has in the text."""
        text = " ".join(map(ast.unparse, load.args))
        named = [
            ast.unparse(node.value)
            for node in ast.walk(self._reader.tree)
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == text.partition(".")[0]
        ]
        return any(f"{name}(" in each for name in ("Move", "FindHome", "Manual") for each in (text, *named))

    def _is_used(self, made: ast.Call) -> bool:
        """Whether a configuration is used: in place, or by the name that it has in the module."""
        for node in self._reader.tree.body:
            if isinstance(node, ast.Assign) and any(each is made for each in ast.walk(node.value)):
                names = {ast.unparse(each) for each in node.targets}
                loads = (each for each in ast.walk(self._reader.tree) if isinstance(each, ast.Name))
                return any(each.id in names and isinstance(each.ctx, ast.Load) for each in loads)
        return True


def _is_zeroed(target: ast.Subscript, tree: ast.Module) -> bool:
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and any(each is target for each in node.targets):
            return isinstance(node.value, ast.Constant) and node.value.value == 0
    return False


def _aliases(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield names of slots and images with what they stand for: `inputs = scan.slot[2].inputs`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
            text = ast.unparse(node.value)
            if (
                isinstance(node.value, ast.Attribute | ast.Subscript)
                and text.partition(".")[0] != node.targets[0].id
            ):
                yield node.targets[0].id, text


def _fields(kind: ast.ClassDef) -> Iterator[str]:
    """Yield the names that the body of a class, and its `__init__`, declare."""
    for node in kind.body:
        if isinstance(node, ast.Assign):
            yield from (
                each.id for target in node.targets for each in ast.walk(target) if isinstance(each, ast.Name)
            )
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield node.target.id
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name
            if node.name in ("__init__", "__post_init__"):
                stored = (each for each in ast.walk(node) if isinstance(each, ast.Attribute))
                yield from (each.attr for each in stored if isinstance(each.ctx, ast.Store))


def missing(text: str, name: str, names: Collection[str]) -> str:
    """Return that the attribute does not exist, with the closest name."""
    near = difflib.get_close_matches(name, [each for each in names if not each.startswith("_")], n=1)
    return f"no {text}" + (f"; did you mean {near[0]}?" if near else "")


def word_lost(value: ast.expr, found: Range) -> str:
    """Return what is lost when an expression is assigned to a word; "" if it fits, or is unknown."""
    if isinstance(value, ast.BinOp) and isinstance(value.op, ast.Div):
        return f"`{ast.unparse(value)}` is a fraction, and a word is an integer: write //"
    if found.is_constant and not found.whole:
        return f"{found} loses its fraction"
    return f"it is {found}, and a word holds {WORD[0]} to {WORD[1]}" if found.outside(*WORD) else ""


def _range(node: ast.expr) -> Range:
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError):
        return ANY
    return exactly(value) if isinstance(value, int | float) else ANY
