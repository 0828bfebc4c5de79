"""Writes to output words of 3601s in a function of the scan.

axis.outputs.load(MOVE.to_image())                all eight words
axis.outputs[2], axis.outputs[3] = split(target)  two words from the same source
axis.outputs.set_bit(0, 7, plus and not minus)    a bit, with its condition
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from scanrack.io_images.amci3601 import CommandMsw
from scanrack.io_images.image import UNSIGNED_MAX, WORD_MIN, WORDS, signed_word

from ..choices import UNKNOWN_CHOICES, Choices
from ..facts import OutputWrite, StepAction, Violation
from ..logic import FALSE, TRUE, UNKNOWN, AllOf, Bit, Condition, leaves, negated
from ..written import WordWrite
from .conditions import ConditionNames, condition
from .expression_options import Options
from .local_names import LocalNames
from .nodes import Function, nodes_in
from .reader import Reader, UnknownError, functions_in
from .steps import BITS, PythonSteps, callee_of

_WORD = 0xFFFF
LOOP = 16
"""Maximum number of loop passes that are followed one by one."""


@dataclass(frozen=True, slots=True)
class _WalkPlace:
    """The state of a walk: its condition as the steps see it, and the same in terms of inputs and fields."""

    when: Condition = TRUE
    free: Condition = TRUE
    depth: int = 4

    def where(self, own: Condition, free: Condition) -> _WalkPlace:
        """Return the state inside a condition."""
        return _WalkPlace(AllOf((self.when, own)), AllOf((self.free, free)), self.depth)


class HandWrites:
    """The writes in a text.

    Args:
        slots: slots with 3601s.
    """

    def __init__(self, reader: Reader, steps: PythonSteps, slots: Sequence[int]) -> None:
        self._reader, self._steps, self._slots = reader, steps, slots
        self._functions = {function.name: function for function, _ in functions_in(reader.tree)}
        self._options = Options(reader, self._functions, steps.values)
        self._names = LocalNames(self._options)
        self.actions: list[StepAction] = []  # writes of command words
        self.outputs: list[OutputWrite] = []
        self.remarks: list[Violation] = []  # numbers that do not fit into their word

    def writes(self) -> Iterator[WordWrite]:
        """Yield the writes of all functions that no other function calls."""
        called = set(map(callee_of, nodes_in(self._reader.tree, ast.Call)))
        for name, function in self._functions.items():
            if name not in called:
                self._names.begin()
                self._steps.function = function
                yield from self._body(function.body, _WalkPlace())

    # --- statements

    def _body(self, body: Sequence[ast.stmt], place: _WalkPlace) -> Iterator[WordWrite]:
        for node in body:
            yield from self._statement(node, place)
            if isinstance(node, ast.If) and not node.orelse and isinstance(node.body[-1], ast.Return):
                place = place.where(negated(self._own(node.test)), negated(self._free(node.test)))

    def _statement(self, node: ast.stmt, place: _WalkPlace) -> Iterator[WordWrite]:
        match node:
            case ast.If(test=test, body=body, orelse=orelse):
                own, free = self._own(test), self._free(test)
                before = self._names.copy()
                yield from self._body(body, place.where(own, free))
                after = self._names.swap(before)
                yield from self._body(orelse, place.where(negated(own), negated(free)))
                self._names.join(after, test)
            case ast.Match(subject=subject, cases=cases):
                for each in cases:
                    chosen = self._steps.chosen(subject, each)
                    before = self._names.copy()
                    yield from self._body(each.body, place.where(chosen, TRUE))
                    self._names.swap(before)
            case ast.For():
                yield from self._loop(node, place)
            case ast.While(body=body) | ast.With(body=body) | ast.Try(body=body):
                yield from self._body(body, place)
            case ast.Assign(targets=targets, value=value):
                for target in targets:
                    yield from self._assigned(target, value, place)
            case ast.AugAssign():
                yield from self._changed(node, place)
            case ast.Expr(value=ast.Call() as call):
                yield from self._called(call, place)

    def _loop(self, node: ast.For, place: _WalkPlace) -> Iterator[WordWrite]:
        for values in self._passes(node.iter):
            self._names.bind(node.target, None if values is None else values)
            yield from self._body(node.body, place)

    def _passes(self, iterable: ast.expr) -> Sequence[ast.expr | None]:
        try:
            found = self._options.of(self._names.closed(iterable), {})
        except UnknownError:
            return [None]
        rows = list(found.options[0]) if len(found.options) == 1 and _is_row(found.options[0]) else []
        if not 0 < len(rows) <= LOOP:
            return [None]
        indices = (ast.Constant(at) for at in range(len(rows)))
        return [ast.Subscript(self._names.closed(iterable), at, ast.Load()) for at in indices]

    # --- writes

    def _assigned(self, target: ast.expr, value: ast.expr, place: _WalkPlace) -> Iterator[WordWrite]:
        if isinstance(target, ast.Tuple | ast.List):
            for each, part in zip(target.elts, self._names.parts(value, len(target.elts)), strict=True):
                yield from self._assigned(each, part, place)
        elif isinstance(target, ast.Subscript):
            slot, word = self._output_word(target)
            if slot is not None and word is not None:
                yield self._word(target, slot, word, self._value(value, target), place)
        else:
            self._names.bind(target, value)

    def _changed(self, node: ast.AugAssign, place: _WalkPlace) -> Iterator[WordWrite]:
        """Yield a write of bits, such as `outputs[0] |= 1` or `outputs[0] &= ~1`."""
        target = node.target
        if isinstance(target, ast.Name):
            self._names.forget(target.id)
        slot, word = self._output_word(target)
        if slot is None or word is None:
            return
        mask = self._number(node.value)
        sets = mask & _WORD if mask is not None and isinstance(node.op, ast.BitOr) else 0
        clears = ~mask & _WORD if mask is not None and isinstance(node.op, ast.BitAnd) else 0
        if sets or clears:
            yield self._bits(target, slot, word, sets, clears, place)
        else:
            yield self._word(target, slot, word, UNKNOWN_CHOICES, place)

    def _called(self, call: ast.Call, place: _WalkPlace) -> Iterator[WordWrite]:
        inner = self._functions.get(callee_of(call))
        if inner is not None and place.depth:
            yield from self._within(inner, call, place)
            return
        slot = self._outputs(call.func.value) if isinstance(call.func, ast.Attribute) else None
        if slot is not None:
            yield from self._method(call, slot, place)

    def _method(self, call: ast.Call, slot: int, place: _WalkPlace) -> Iterator[WordWrite]:
        """Yield the writes that a method of an output image makes."""
        match callee_of(call), call.args:
            case "clear", _:
                yield from (self._word(call, slot, word, Choices((0,)), place) for word in range(WORDS))
            case "load", [image, *_]:
                yield from self._loaded(call, image, slot, place)
            case "set_bit", [at, bit, on]:
                word, number = self._number(at), self._number(bit)
                if word is not None and number is not None:
                    yield self._bit(call, slot, word, 1 << number, on, place)

    def _within(self, inner: Function, call: ast.Call, place: _WalkPlace) -> Iterator[WordWrite]:
        """Yield the writes of a called function."""
        outer, caller = self._names.enter(inner, call), self._steps.function
        self._steps.function = inner
        yield from self._body(inner.body, _WalkPlace(place.when, place.free, place.depth - 1))
        self._steps.function = caller
        self._names.swap(outer)

    def _loaded(self, call: ast.Call, image: ast.expr, slot: int, place: _WalkPlace) -> Iterator[WordWrite]:
        """Yield the writes that load a whole image."""
        try:
            found = self._options.of(self._names.closed(image), {})
            images = [tuple(each) for each in found.options if len(tuple(each)) == WORDS]
        except (UnknownError, TypeError):
            found, images = UNKNOWN_CHOICES, []
        for word in range(WORDS):
            value = Choices(tuple(each[word] for each in images), found.source, found.names)
            if len(set(value.options)) == 1:
                value = Choices(value.options[:1])
            yield self._word(call, slot, word, value, place)
            if word == 0 and len(value.options) != 1:
                bits = int(BITS.get(self._steps.kind(image), 0))
                self._act(call, slot, bits, ~bits & _WORD, place)
                yield self._bits(call, slot, 0, bits if bits & (bits - 1) == 0 else 0, 0, place)

    def _bit(
        self, call: ast.Call, slot: int, word: int, mask: int, on: ast.expr, place: _WalkPlace
    ) -> WordWrite:
        free = self._free(on)
        if free in (TRUE, FALSE):
            sets, clears = (mask, 0) if free == TRUE else (0, mask)
            return self._bits(call, slot, word, sets, clears, place)
        is_known = UNKNOWN not in leaves(free)
        if word == 0:
            at, both = self._reader.place(call), place.where(free, free).free
            name = str(CommandMsw(mask).name)
            self.outputs.append(OutputWrite(at, name, f"{slot} {name}", both, f"slot {slot}"))
        own = free if is_known else Bit(f"{ast.unparse(call)} in line {call.lineno}")
        return self._bits(call, slot, word, mask, mask, place.where(own, free))

    def _word(self, node: ast.expr, slot: int, word: int, value: Choices, place: _WalkPlace) -> WordWrite:
        known = len(value.options) == 1 and word == 0
        if known:
            self._act(node, slot, value.options[0] & _WORD, ~value.options[0] & _WORD, place)
        bits = value.options[0] & _WORD if known else 0
        return self._write(node, slot, word, value, bits, ~bits & _WORD, place)

    def _bits(
        self, node: ast.expr, slot: int, word: int, sets: int, clears: int, place: _WalkPlace
    ) -> WordWrite:
        if word == 0 and sets | clears:
            self._act(node, slot, sets, clears, place)
        return self._write(node, slot, word, None, sets, clears, place)

    def _act(self, node: ast.expr, slot: int, sets: int, clears: int, place: _WalkPlace) -> None:
        """Note a write of the command word."""
        self.actions += self._steps.commanding(node, place.when, f"slot {slot}", sets, clears)

    def _write(
        self,
        node: ast.expr,
        slot: int,
        word: int,
        value: Choices | None,
        sets: int,
        clears: int,
        place: _WalkPlace,
    ) -> WordWrite:
        at = self._reader.place(node)
        steps, text = self._steps.where(place.when), ast.unparse(node)
        return WordWrite(at, slot, word, value, sets, clears, place.when, steps, text)

    # --- what expressions are

    def _outputs(self, node: ast.expr) -> int | None:
        """Return the slot of a 3601 if an expression is its output image; None for another one."""
        found = self._names.closed(node)
        if not isinstance(found, ast.Attribute) or found.attr != "outputs":
            return None
        is_slot = isinstance(found.value, ast.Subscript) and ast.unparse(found.value.value).endswith("slot")
        slot = self._number(found.value.slice) if is_slot and isinstance(found.value, ast.Subscript) else None
        if slot is None and len(self._slots) == 1:
            slot = self._slots[0]
        return slot if slot in self._slots else None

    def _output_word(self, node: ast.expr) -> tuple[int | None, int | None]:
        """Return the slot and word of an output element; None for each that is unknown or does not exist."""
        if not isinstance(node, ast.Subscript):
            return None, None
        word = self._number(node.slice)
        return self._outputs(node.value), word if word is not None and 0 <= word < WORDS else None

    def _value(self, node: ast.expr, target: ast.expr) -> Choices:
        try:
            found = self._options.of(self._names.closed(node), {})
        except UnknownError:
            return UNKNOWN_CHOICES
        options = [each for each in found.options if isinstance(each, int)]
        wrong = [at for at, each in enumerate(options) if not WORD_MIN <= each <= UNSIGNED_MAX]
        if len(options) < len(found.options):
            return UNKNOWN_CHOICES
        if not wrong:
            return Choices(tuple(map(signed_word, options)), found.source, found.names)
        if found.source:
            name = (*found.names, *[found.source] * len(options))[wrong[0]]
            text = f"with {name} it is {options[wrong[0]]}, and a word holds {WORD_MIN} to {UNSIGNED_MAX}"
            self.remarks.append(Violation(self._reader.place(target), text))
        return UNKNOWN_CHOICES

    def _number(self, node: ast.expr) -> int | None:
        try:
            found = self._options.of(self._names.closed(node), {}).options
        except UnknownError:
            return None
        return found[0] if len(found) == 1 and isinstance(found[0], int) else None

    def _own(self, test: ast.expr) -> Condition:
        return condition(test, self._steps.names)

    def _free(self, test: ast.expr) -> Condition:
        """Return an expression as a condition on inputs and fields."""
        return condition(self._names.inputs(test), ConditionNames())


def _is_row(value: object) -> bool:
    return isinstance(value, tuple | list)
