"""Finds the expressions of a function that are the scan, a slot or an image, and notes missing members.

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
"""The kind of each attribute of these objects."""

BITS = 16
"""Number of bits in a word."""

Kind = tuple[str, int | None]
"""The kind of an expression, "scan", "slots", "slot", "inputs", "outputs" or "", and its slot if known."""

OTHER: Kind = ("", None)


class Images:
    """Notes attributes, words and bits that the scan or its slots do not have."""

    def __init__(self, reader: Reader, spec: RackSpec) -> None:
        self._reader = reader
        self._words = {slot.number: slot.words for slot in spec.slot}
        self._functions = [function for function, _ in functions_in(reader.tree)]
        # by function and parameter: the kinds of the arguments that calls pass
        self._arguments: dict[tuple[str, str], set[Kind]] = {
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
                self._note_missing(node, local)

    def _note_missing(self, node: ast.AST, local: Mapping[str, Kind]) -> None:
        """Note an attribute, word or bit that does not exist."""
        match node:
            case ast.Attribute(value=owner):
                owner_class = KINDS.get(self.kind_of(owner, local)[0])
                if owner_class is not None:
                    self._reader.remark_unless_in(_names_of(owner_class), node)
            case ast.Subscript(value=image, slice=index):
                self._note_missing_place(image, [index], node, local)
            case ast.Call(func=ast.Attribute(value=image, attr="bit" | "set_bit"), args=args):
                self._note_missing_place(image, args[:2], node, local)

    def _note_missing_place(
        self, image: ast.expr, position: Sequence[ast.expr], node: ast.expr, local: Mapping[str, Kind]
    ) -> None:
        """Note a word or a bit that an image does not have.

        Args:
            position: the word, and possibly the bit.
        """
        kind, slot = self.kind_of(image, local)
        numbers = [number for number in map(self._number, position) if number is not None]
        if kind not in ("inputs", "outputs") or not numbers or len(numbers) < len(position):
            return
        text = self._missing_place(kind[0].upper(), slot, *numbers)
        if text:
            self._reader.remark("no-place", node, f"`{ast.unparse(node)}`: {text}")

    def _missing_place(self, image: str, slot: int | None, word: int, bit: int | None = None) -> str:
        """Return a message about a missing word or bit of an image; "" if it exists, or if unknown."""
        words_of_slot = None if slot is None else self._words.get(slot)
        candidates = self._words.values() if words_of_slot is None else [words_of_slot]
        size = max((len(words.named(image)) for words in candidates), default=WORDS)
        if not -size <= word < size:
            return f"the image has words 0 to {size - 1}"
        if bit is not None and not 0 <= bit < BITS:
            return f"a word has bits 0 to {BITS - 1}"
        if words_of_slot is None:
            return ""
        alternative = words_of_slot.terminals_instead(image, word % size, bit or 0)
        is_lacking = alternative.startswith("no ") if bit is None else bool(alternative)
        return f"the card in slot {slot} has {alternative}" if is_lacking else ""

    def _number(self, node: ast.expr) -> int | None:
        number = self._reader.number(node)
        return number if isinstance(number, int) else None

    # --- meaning of names

    def _note_arguments(self, call: ast.Call, local: Mapping[str, Kind]) -> None:
        """Note the arguments that a call passes to a function in this text."""
        name = last_name(call.func)
        for function in self._functions:
            if function.name == name:
                for parameter, node in zip(parameters_of(function), call.args, strict=False):
                    kind = self.kind_of(node, local)
                    if kind[0]:
                        self._arguments.setdefault((name, parameter), set()).add(kind)

    def locals_of(self, function: Function) -> dict[str, Kind]:
        """Return the kind of each local name in a function, if the name has only one kind."""
        local: dict[str, Kind] = {
            name: next(iter(kinds))
            for (owner, name), kinds in self._arguments.items()
            if owner == function.name and len(kinds) == 1
        }
        for name, pairs in grouped(_assigned(function), lambda pair: pair[0]).items():
            kinds = {OTHER if value is None else self.kind_of(value, local) for _, value in pairs}
            local[name] = kinds.pop() if len(kinds) == 1 else OTHER
        return local

    def kind_of(self, node: ast.expr, local: Mapping[str, Kind]) -> Kind:
        """Return the kind of an expression, and its slot.

        Args:
            local: kinds of the function's local names.
        """
        match node:
            case ast.Name(id=name):
                return local.get(name, OTHER)
            case ast.Attribute(value=owner, attr=name):
                kind, slot = self.kind_of(owner, local)
                return PARTS.get((kind, name), ""), slot
            case ast.Subscript(value=slots, slice=index) if self.kind_of(slots, local)[0] == "slots":
                return "slot", self._number(index)
        return OTHER


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
