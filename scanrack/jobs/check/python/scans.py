"""Uses of slots, and of the objects that keep state, in a function of the scan."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.image import UNSIGNED_MAX, WORD_MIN
from scanrack.runtime.config.rackspec import RackSpec

from ..facts import Command, Violation
from ..ranges import ANY, Range, exactly
from .nodes import is_loaded, is_stored, last_name, names_in, nodes_in, stored_attributes
from .reader import Reader

KINDS = {
    "FindHome": "home",
    "Manual": "run",
    "PresetPosition": "set_position",
    "RunBlend": "run_blend",
    "BlendHeader": "program_blend",
    "Configuration": "configure",
}
"""Commands by class. The first argument of a `Move` selects an absolute or a relative move."""

_WRITING = ("load", "set_bit", "clear")
"""Methods that write an image."""


class Scans:
    """Notes how a text uses `scan.slot[...]`."""

    def __init__(self, reader: Reader, spec: RackSpec) -> None:
        self._reader, self._spec, self._facts = reader, spec, reader.facts
        self._aliases = dict(_aliases(reader.tree))
        steppers = [slot.number for slot in spec.slot if is_stepper(slot.words)]
        slots_used = [number for number in steppers if f".slot[{number}]" in ast.unparse(reader.tree)]
        self._slot = slots_used[0] if len(slots_used) == 1 else None  # the only 3601 that the text uses

    def note(self) -> None:
        """Note the mistakes and the commands in the text."""
        for node in ast.walk(self._reader.tree):
            match node:
                case ast.Subscript():
                    self._subscript(node)
                case ast.Call(func=ast.Attribute(value=image, attr=method)) if method in _WRITING:
                    if self._is_image(image, ".inputs"):
                        text = f"`{ast.unparse(node)}` writes an input image"
                        self._reader.remark("input-written", node, text)
                case ast.Assign(targets=targets, value=value):
                    for target in targets:
                        self._assigned(target, value)
        self._attributes()
        self._commands()

    def _subscript(self, node: ast.Subscript) -> None:
        """Note a slot that the rack lacks, and a write to an input."""
        owner, index = node.value, node.slice
        if isinstance(owner, ast.Attribute) and owner.attr == "slot" and isinstance(index, ast.Constant):
            slot_numbers = [slot.number for slot in self._spec.slot]
            if isinstance(index.value, int) and index.value not in slot_numbers:
                slots_text = ", ".join(map(str, slot_numbers))
                text = f"`{ast.unparse(node)}`: the rack has modules in slots {slots_text} only"
                self._reader.remark("no-place", node, text)
        if is_stored(node) and self._is_image(owner, ".inputs"):
            text = f"`{ast.unparse(node)}` is an input: the module writes it"
            self._reader.remark("input-written", node, text)

    def _is_image(self, node: ast.expr, end: str) -> bool:
        """Whether an expression, with aliases replaced, is an attribute of a slot such as ".inputs"."""
        text = ast.unparse(node)
        for _ in self._aliases:
            first, dot, members = text.partition(".")
            text = f"{self._aliases.get(first, first)}{dot}{members}"
        return ".slot[" in text and text.endswith(end)

    def _assigned(self, target: ast.expr, value: ast.expr) -> None:
        """Note a number that does not fit into its word."""
        if not (isinstance(target, ast.Subscript) and self._is_image(target.value, ".outputs")):
            return
        text = word_loss(value, _range(value))
        if text:
            self._reader.remark("lossy-conversion", value, text)

    # --- state

    def _attributes(self) -> None:
        """Note attributes that objects of the module's own classes, or status views, do not have."""
        classes = {node.name: node for node in self._reader.tree.body if isinstance(node, ast.ClassDef)}
        for name, value in self._reader.names.items():
            kind = type(value)
            is_of_program = kind.__module__ == self._reader.names.get("__name__") and kind.__name__ in classes
            if is_of_program and not {"__setattr__", "__getattr__"} & vars(kind).keys():
                attributes = {*dir(value), *_fields(classes[kind.__name__])}
                self._note_missing(self._reader.tree, name, attributes)
        for class_ in classes.values():
            if not [*class_.bases, *class_.keywords]:
                self._note_missing(class_, "self", {*_fields(class_), *dir(object)})
        for name, view in self._views().items():
            self._note_missing(self._reader.tree, name, set(dir(view)))

    def _note_missing(self, tree: ast.AST, name: str, attributes: set[str]) -> None:
        """Note the attributes that an object lacks, in a text that uses the object under this name."""
        for node in nodes_in(tree, ast.Attribute):
            if ast.unparse(node.value) == name:
                self._reader.remark_unless_in(attributes, node)

    def _views(self) -> dict[str, object]:
        """Return the classes of status views by variable name, such as `status`."""
        views: dict[str, object] = {}
        for node in nodes_in(self._reader.tree, ast.Assign):
            if len(node.targets) == 1 and isinstance(node.value, ast.Call):
                callee = self._reader.names.get(ast.unparse(node.value.func))
                if getattr(callee, "__name__", "") == "StatusView":
                    views[ast.unparse(node.targets[0])] = callee
        return views

    # --- commands

    def _commands(self) -> None:
        """Note the commands that the program sends as words."""
        tree = self._reader.tree
        if self._slot is not None:
            zeroed = {id(target) for node in nodes_in(tree, ast.Assign) for target in _zeroed(node)}
            stored = (node for node in nodes_in(tree, ast.Subscript) if is_stored(node))
            if any(self._is_image(node.value, ".outputs") for node in stored if id(node) not in zeroed):
                self._facts.computed.add(self._slot)
            self._facts.commands += self._constructed(self._slot)
        load = next(filter(self._loads_motion, nodes_in(tree, ast.Call)), None)
        if load is not None:
            self._facts.at_once.append(Violation(self._reader.place(load), "load writes all eight words"))

    def _constructed(self, slot: int) -> Iterator[Command]:
        """Yield the commands that the text constructs."""
        for call in nodes_in(self._reader.tree, ast.Call):
            name = last_name(call.func)
            kind = KINDS.get(name, "")
            if name == "Move":
                kind = "move_to" if "ABSOLUTE" in ast.unparse(call) else "move_by"
            if kind and (kind != "configure" or self._is_used(call)):
                yield Command(kind, f"slot {slot}", slot, self._reader.place(call), name, words=True)

    def _loads_motion(self, call: ast.Call) -> bool:
        """Whether a call loads a motion into an output image."""
        match call.func:
            case ast.Attribute(value=image, attr="load"):
                return self._is_image(image, ".outputs") and self._is_motion(call)
        return False

    def _is_motion(self, load: ast.Call) -> bool:
        """Whether a call loads a motion, constructed in place or assigned to a name."""
        loaded = " ".join(map(ast.unparse, load.args))
        name = loaded.partition(".")[0]
        assignments = nodes_in(self._reader.tree, ast.Assign)
        named = [ast.unparse(node.value) for node in assignments if ast.unparse(node.targets[0]) == name]
        return any(f"{kind}(" in text for kind in ("Move", "FindHome", "Manual") for text in (loaded, *named))

    def _is_used(self, configuration: ast.Call) -> bool:
        """Whether a configuration is used, in place or by its global name."""
        globals_ = (node for node in self._reader.tree.body if isinstance(node, ast.Assign))
        assignments = [node for node in globals_ if configuration in ast.walk(node.value)]
        names = {ast.unparse(target) for node in assignments for target in node.targets}
        loads = filter(is_loaded, nodes_in(self._reader.tree, ast.Name))
        return not assignments or any(node.id in names for node in loads)


def _zeroed(node: ast.Assign) -> list[ast.expr]:
    """Return the targets of an assignment of 0."""
    return node.targets if isinstance(node.value, ast.Constant) and node.value.value == 0 else []


def _aliases(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the names assigned to slots and images, with their meaning: `inputs = scan.slot[2].inputs`."""
    for node in nodes_in(tree, ast.Assign):
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=ast.Attribute() | ast.Subscript() as value):
                text = ast.unparse(value)
                if text.partition(".")[0] != name:
                    yield name, text


def _fields(kind: ast.ClassDef) -> Iterator[str]:
    """Yield the names that the body of a class, or its `__init__`, declares."""
    for node in kind.body:
        match node:
            case ast.Assign(targets=targets):
                yield from (name for target in targets for name in names_in(target))
            case ast.AnnAssign(target=ast.Name(id=name)):
                yield name
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                yield name
                if name in ("__init__", "__post_init__"):
                    yield from stored_attributes(node)


def word_loss(value: ast.expr, number: Range) -> str:
    """Return a message about an expression that does not fit into a word; "" if it fits, or if unknown.

    Args:
        number: the range of the expression.
    """
    if isinstance(value, ast.BinOp) and isinstance(value.op, ast.Div):
        return f"`{ast.unparse(value)}` is a fraction; use // for a whole number"
    if number.is_constant and not number.whole:
        return f"{number} loses its fraction"
    if not number.outside(WORD_MIN, UNSIGNED_MAX):
        return ""
    return f"the value is {number}: must be {WORD_MIN} to {UNSIGNED_MAX}"


def _range(node: ast.expr) -> Range:
    """Return the range of a literal number; ANY for any other expression."""
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError):
        return ANY
    return exactly(value) if isinstance(value, int | float) else ANY
