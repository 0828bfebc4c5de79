"""Finds which expressions of a function are the scan, its slots or images, and what is missing in them.

scan.now                                     the scan has no `now`
scan.slot[3].outputs.set_bit(0, 17, True)    a word has 16 bits
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence

from scanrack.io_images.image import WORDS, Image
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.rack import Slot
from scanrack.runtime.loop.scan import LogicScan

from ..groups import grouped
from .nodes import Function, last_name, nodes_in, parameters_of
from .reader import Reader, functions_in

KINDS: Mapping[str, type] = {"scan": LogicScan, "slot": Slot, "inputs": Image, "outputs": Image}
"""Classes of the objects that a function of the scan uses."""

PARTS = {("scan", "slot"): "slots", ("slot", "inputs"): "inputs", ("slot", "outputs"): "outputs"}
"""What each attribute of these objects is."""

BITS = 16
"""Bits of a word."""

What = tuple[str, int | None]
"""What an expression is, and its slot if that is known."""

NOTHING: What = ("", None)


class Images:
    """Notes attributes, words and bits that the scan or its slots do not have."""

    def __init__(self, reader: Reader, spec: RackSpec) -> None:
        self._reader = reader
        self._words = {slot.number: slot.words for slot in spec.slot}
        self._functions = [function for function, _ in functions_in(reader.tree)]
        self._given: dict[tuple[str, str], set[What]] = {
            (function.name, "scan"): {("scan", None)} for function in self._functions
        }

    def note(self) -> None:
        """Note the mistakes of all functions."""
        for function in (*self._functions, *self._functions):  # twice: a call may pass a parameter on
            for call in nodes_in(function, ast.Call):
                self._note_arguments(call, self.locals_of(function))
        for function in self._functions:
            local = self.locals_of(function)
            for node in ast.walk(function):
                self._node(node, local)

    def _node(self, node: ast.AST, local: Mapping[str, What]) -> None:
        match node:
            case ast.Attribute(value=owner):
                kind = KINDS.get(self.what(owner, local)[0])
                if kind is not None:
                    self._reader.remark_unless_in(_names_of(kind), node)
            case ast.Subscript(value=image, slice=index):
                self._place(image, [index], node, local)
            case ast.Call(func=ast.Attribute(value=image, attr="bit" | "set_bit"), args=args):
                self._place(image, args[:2], node, local)

    def _place(
        self, image: ast.expr, given: Sequence[ast.expr], node: ast.expr, local: Mapping[str, What]
    ) -> None:
        """Note a word or a bit that an image does not have."""
        kind, slot = self.what(image, local)
        numbers = [number for number in map(self._number, given) if number is not None]
        if kind not in ("inputs", "outputs") or not numbers or len(numbers) < len(given):
            return
        text = self._lacks(kind[0].upper(), slot, *numbers)
        if text:
            self._reader.remark("no-place", node, f"`{ast.unparse(node)}`: {text}")

    def _lacks(self, image: str, slot: int | None, word: int, bit: int | None = None) -> str:
        """Return a message about a missing word or bit of an image; "" if it exists, or if unknown."""
        slot_words = [self._words[slot]] if slot in self._words else self._words.values()
        words = max((len(words_of.named(image)) for words_of in slot_words), default=WORDS)
        if not -words <= word < words:
            return f"the image has words 0 to {words - 1}"
        if bit is not None and not 0 <= bit < BITS:
            return f"a word has bits 0 to {BITS - 1}"
        alternative = (
            self._words[slot].terminals_instead(image, word % words, bit or 0) if slot in self._words else ""
        )
        is_lacking = alternative.startswith("no ") if bit is None else bool(alternative)
        return f"the card in slot {slot} has {alternative}" if is_lacking else ""

    def _number(self, node: ast.expr) -> int | None:
        number = self._reader.number(node)
        return number if isinstance(number, int) else None

    # --- what names are

    def _note_arguments(self, call: ast.Call, local: Mapping[str, What]) -> None:
        """Note the arguments that a call passes to a function in this text."""
        name = last_name(call.func)
        for function in self._functions:
            if function.name == name:
                for parameter, node in zip(parameters_of(function), call.args, strict=False):
                    content = self.what(node, local)
                    if content[0]:
                        self._given.setdefault((name, parameter), set()).add(content)

    def locals_of(self, function: Function) -> dict[str, What]:
        """Return the kinds of the local names of a function, as far as each name has a single kind."""
        contents: dict[str, What] = {
            name: next(iter(kinds))
            for (owner, name), kinds in self._given.items()
            if owner == function.name and len(kinds) == 1
        }
        for name, values in grouped(_assigned(function), lambda pair: pair[0]).items():
            kinds_found = {NOTHING if value is None else self.what(value, contents) for _, value in values}
            contents[name] = next(iter(kinds_found)) if len(kinds_found) == 1 else NOTHING
        return contents

    def what(self, node: ast.expr, local: Mapping[str, What]) -> What:
        """Return the kind of an expression, "scan", "slot", "inputs", "outputs" or "", and its slot."""
        match node:
            case ast.Name(id=name):
                return local.get(name, NOTHING)
            case ast.Attribute(value=owner, attr=name):
                kind, slot = self.what(owner, local)
                return PARTS.get((kind, name), ""), slot
            case ast.Subscript(value=slots, slice=index) if self.what(slots, local)[0] == "slots":
                return "slot", self._number(index)
        return NOTHING


def _assigned(function: Function) -> Iterator[tuple[str, ast.expr | None]]:
    """Yield the assignments of a function as target and value; the value is None for a loop variable."""
    for node in ast.walk(function):
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                yield name, value
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                yield from zip(map(ast.unparse, names), values, strict=False)
            case ast.For(target=target):
                yield ast.unparse(target), None


def _names_of(kind: type) -> set[str]:
    """Return the attributes of a class and of its instances."""
    return {*dir(kind), *getattr(kind, "__slots__", ()), *getattr(kind, "__annotations__", ())}
