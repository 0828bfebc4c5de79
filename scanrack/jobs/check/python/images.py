"""What expressions in a function of the scan are: the scan, its slots, their images; and what these lack.

scan.now                                     the scan has no `now`
scan.slot[3].outputs.set_bit(0, 17, True)    a word has 16 bits
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence

from scanrack.io_images.image import WORDS, Image
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.rack import Slot
from scanrack.runtime.loop.scan import LogicScan

from ..facts import Facts, FileLine
from .reader import Function, Reader, UnknownError, functions_in
from .scans import missing

KINDS: Mapping[str, type] = {"scan": LogicScan, "slot": Slot, "inputs": Image, "outputs": Image}
"""Classes of what a function of the scan works with."""

PARTS = {("scan", "slot"): "slots", ("slot", "inputs"): "inputs", ("slot", "outputs"): "outputs"}
"""What an attribute of one of them is."""

BITS = 16
"""Bits of a word."""

What = tuple[str, int | None]
"""What an expression is, and the slot that it belongs to if that is known."""


class Images:
    """Notes attributes, words and bits that the scan and its slots do not have."""

    def __init__(self, reader: Reader, spec: RackSpec, facts: Facts) -> None:
        self._reader, self._facts = reader, facts
        self._words = {slot.number: slot.words for slot in spec.slot}
        self._functions = [function for function, _ in functions_in(reader.tree)]
        self._given: dict[tuple[str, str], set[What]] = {
            (each.name, "scan"): {("scan", None)} for each in self._functions
        }

    def note(self) -> None:
        """Note them all."""
        for function in (*self._functions, *self._functions):  # what a call hands on, and what it is then
            for node in ast.walk(function):
                if isinstance(node, ast.Call):
                    self._hand_on(node, self.locals_of(function))
        for function in self._functions:
            local = self.locals_of(function)
            for node in ast.walk(function):
                self._node(node, local)

    def _node(self, node: ast.AST, local: Mapping[str, What]) -> None:
        if isinstance(node, ast.Attribute):
            kind, _ = self.what(node.value, local)
            if kind in KINDS and not hasattr(KINDS[kind], node.attr) and node.attr not in _slots(KINDS[kind]):
                names = {*dir(KINDS[kind]), *_slots(KINDS[kind])}
                text = missing(ast.unparse(node), node.attr, names)
                self._remark("unknown-attribute", node, text)
        elif isinstance(node, ast.Subscript):
            self._place(node.value, [node.slice], node, local)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            given = node.args[:2] if node.func.attr in ("bit", "set_bit") else []
            self._place(node.func.value, given, node, local)

    def _place(
        self, image: ast.expr, given: Sequence[ast.expr], node: ast.expr, local: Mapping[str, What]
    ) -> None:
        """Note a word or a bit that an image does not have."""
        kind, slot = self.what(image, local)
        numbers = [self._number(each) for each in given]
        if kind not in ("inputs", "outputs") or None in numbers or not numbers:
            return
        word, *bits = (each for each in numbers if each is not None)
        text = ast.unparse(node)
        known = [self._words[slot]] if slot in self._words else self._words.values()
        words = max((len(each.named(kind[0].upper())) for each in known), default=WORDS)
        if not -words <= word < words:
            self._remark("no-place", node, f"`{text}`: the image has words 0 to {words - 1}")
        elif bits and not 0 <= bits[0] < BITS:
            self._remark("no-place", node, f"`{text}`: a word has bits 0 to {BITS - 1}")
        elif slot in self._words:
            there = self._words[slot].terminals_instead(kind[0].upper(), word % words, bits[0] if bits else 0)
            if there and (bits or there.startswith("no ")):
                self._remark("no-place", node, f"`{text}`: the card in slot {slot} has {there}")

    def _number(self, node: ast.expr) -> int | None:
        try:
            found = self._reader.value(node)
        except UnknownError:
            return None
        return found if isinstance(found, int) else None

    def _remark(self, rule: str, node: ast.expr, text: str) -> None:
        self._facts.remark(rule, FileLine(self._reader.file, node.lineno), text)

    # --- what names are

    def _hand_on(self, call: ast.Call, local: Mapping[str, What]) -> None:
        """Note what a call of a function of this text gets."""
        name = ast.unparse(call.func).rpartition(".")[2]
        for function in self._functions:
            if function.name == name:
                names = [each.arg for each in function.args.args if each.arg != "self"]
                for parameter, node in zip(names, call.args, strict=False):
                    what = self.what(node, local)
                    if what[0]:
                        self._given.setdefault((name, parameter), set()).add(what)

    def locals_of(self, function: Function) -> dict[str, What]:
        """Return what the names of a function are, as far as each is one thing."""
        found: dict[str, What] = {
            name: next(iter(kinds))
            for (owner, name), kinds in self._given.items()
            if owner == function.name and len(kinds) == 1
        }
        assigned: dict[str, list[ast.expr | None]] = {}
        for node in ast.walk(function):
            match node:
                case ast.Assign(targets=[ast.Name(id=name)], value=value):
                    assigned.setdefault(name, []).append(value)
                case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                    for target, value in zip(names, values, strict=False):
                        assigned.setdefault(ast.unparse(target), []).append(value)
                case ast.For(target=target):
                    assigned.setdefault(ast.unparse(target), []).append(None)
        for name, several in assigned.items():
            whats = {("", None) if value is None else self.what(value, found) for value in several}
            found[name] = next(iter(whats)) if len(whats) == 1 else ("", None)
        return found

    def what(self, node: ast.expr, local: Mapping[str, What]) -> What:
        """Return what an expression is: "scan", "slot", "inputs", "outputs" or ""; and of which slot."""
        if isinstance(node, ast.Name):
            return local.get(node.id, ("", None))
        if isinstance(node, ast.Attribute):
            kind, slot = self.what(node.value, local)
            return PARTS.get((kind, node.attr), ""), slot
        if isinstance(node, ast.Subscript) and self.what(node.value, local)[0] == "slots":
            return "slot", self._number(node.slice)
        return "", None


def _slots(kind: type) -> Sequence[str]:
    """Return the names of a class's own instance attributes."""
    return (*getattr(kind, "__slots__", ()), *getattr(kind, "__annotations__", ()))
