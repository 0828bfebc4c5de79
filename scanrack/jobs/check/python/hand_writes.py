"""Writes to output words of 3601s in a function of the scan.

axis.outputs.load(MOVE.to_image())                all eight words
axis.outputs[2], axis.outputs[3] = split(target)  two words from one source
axis.outputs.set_bit(0, 7, plus and not minus)    a bit with its condition
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

from scanrack.io_images.amci3601 import CommandMsw
from scanrack.io_images.image import UNSIGNED_MAX, WORD_MIN, WORDS, signed_word

from ..choices import UNKNOWN_CHOICES, Choices
from ..facts import OutputWrite, StepAction, Violation
from ..logic import FALSE, TRUE, UNKNOWN, Bit, leaves
from ..module_kinds import bits_of
from ..written import WordWrite
from .images import BITS
from .reader import UnknownError
from .steps import PythonSteps
from .walk import Walk, WalkPlace, callee_of


class HandWrites:
    """The writes in a text.

    Args:
        slots: slots with 3601s.
    """

    def __init__(self, walk: Walk, steps: PythonSteps, slots: Sequence[int]) -> None:
        self._walk, self._steps, self._slots = walk, steps, slots
        self.actions: list[StepAction] = []  # writes of command words
        self.outputs: list[OutputWrite] = []
        self.remarks: list[Violation] = []  # numbers that do not fit into their word

    def writes(self) -> Iterator[WordWrite]:
        """Yield the writes of all functions, and note the changes of steps."""
        for node, place in self._walk.statements():
            match node:
                case ast.Assign(targets=targets, value=value):
                    self._steps.note(node, place)
                    for target in targets:
                        yield from self._assigned(target, value, place)
                case ast.AugAssign():
                    yield from self._changed(node, place)
                case ast.Call():
                    yield from self._method(node, place)

    # --- writes

    def _assigned(self, target: ast.expr, value: ast.expr, place: WalkPlace) -> Iterator[WordWrite]:
        """Yield the writes of an assignment to output words; bind a local name to its new value instead."""
        if isinstance(target, ast.Tuple | ast.List):
            parts = self._walk.local.parts(value, len(target.elts))
            for element, part in zip(target.elts, parts, strict=True):
                yield from self._assigned(element, part, place)
        elif isinstance(target, ast.Subscript):
            slot, word = self._output_word(target)
            if slot is not None and word is not None:
                yield self._word(target, slot, word, self._value(value, target), place)
        else:
            self._walk.local.bind(target, value)

    def _changed(self, node: ast.AugAssign, place: WalkPlace) -> Iterator[WordWrite]:
        """Yield a write of bits, such as `outputs[0] |= 1` or `outputs[0] &= ~1`.

        The value of a local name becomes unknown.
        """
        target = node.target
        if isinstance(target, ast.Name):
            self._walk.local.forget(target.id)
        slot, word = self._output_word(target)
        if slot is None or word is None:
            return
        mask = self._number(node.value)
        sets = mask & UNSIGNED_MAX if mask is not None and isinstance(node.op, ast.BitOr) else 0
        clears = ~mask & UNSIGNED_MAX if mask is not None and isinstance(node.op, ast.BitAnd) else 0
        if sets or clears:
            yield self._bits(target, slot, word, place, sets=sets, clears=clears)
        else:
            yield self._word(target, slot, word, UNKNOWN_CHOICES, place)

    def _method(self, call: ast.Call, place: WalkPlace) -> Iterator[WordWrite]:
        """Yield the writes that a method of an output image makes."""
        slot = self._output_slot(call.func.value) if isinstance(call.func, ast.Attribute) else None
        if slot is None:
            return
        match callee_of(call), call.args:
            case "clear", _:
                yield from (self._word(call, slot, word, Choices((0,)), place) for word in range(WORDS))
            case "load", [image, *_]:
                yield from self._loaded(call, image, slot, place)
            case "set_bit", [word_node, bit_node, value]:
                word, bit = self._number(word_node), self._number(bit_node)
                if word is not None and bit is not None and 0 <= word < WORDS and 0 <= bit < BITS:
                    yield self._bit(call, slot, word, 1 << bit, value, place)

    def _loaded(self, call: ast.Call, image: ast.expr, slot: int, place: WalkPlace) -> Iterator[WordWrite]:
        """Yield the writes that load a whole image, and note its command."""
        try:
            choices = self._walk.options.evaluate(self._walk.local.closed(image), {})
            images = [tuple(option) for option in choices.options if len(tuple(option)) == WORDS]
        except (UnknownError, TypeError):
            choices, images = UNKNOWN_CHOICES, []
        for word in range(WORDS):
            value = Choices(tuple(words[word] for words in images), choices.source, choices.names)
            if len(set(value.options)) == 1:
                value = Choices(value.options[:1])
            yield self._word(call, slot, word, value, place)
            if word == 0 and len(value.options) != 1:
                # the class of the command still shows its bits, although maybe not its direction
                bits = bits_of(self._steps.kind(image))
                self._note_action(call, slot, place, sets=bits, clears=~bits & UNSIGNED_MAX)
                is_one_bit = bits & (bits - 1) == 0
                yield self._bits(call, slot, 0, place, sets=bits if is_one_bit else 0, clears=0)

    def _bit(
        self, call: ast.Call, slot: int, word: int, mask: int, value: ast.expr, place: WalkPlace
    ) -> WordWrite:
        """Return the write of an expression's value to a bit.

        Note the condition that sets a command bit.
        """
        free = self._walk.free(value)
        if free in (TRUE, FALSE):
            sets, clears = (mask, 0) if free == TRUE else (0, mask)
            return self._bits(call, slot, word, place, sets=sets, clears=clears)
        if word == 0:
            line, reached = self._walk.reader.place(call), place.inside(free, free).free
            name = str(CommandMsw(mask).name)
            self.outputs.append(OutputWrite(line, name, f"{slot} {name}", reached, f"slot {slot}"))
        is_known = UNKNOWN not in leaves(free)
        condition = free if is_known else Bit(f"{ast.unparse(call)} in line {call.lineno}")
        return self._bits(call, slot, word, place.inside(condition, free), sets=mask, clears=mask)

    def _word(self, node: ast.expr, slot: int, word: int, value: Choices, place: WalkPlace) -> WordWrite:
        """Return the write of a whole word; note the command in a constant command word."""
        if word or len(value.options) != 1:
            return self._write(node, slot, word, place, value=value, sets=0, clears=UNSIGNED_MAX)
        sets = value.options[0] & UNSIGNED_MAX
        clears = ~sets & UNSIGNED_MAX
        self._note_action(node, slot, place, sets=sets, clears=clears)
        return self._write(node, slot, word, place, value=value, sets=sets, clears=clears)

    def _bits(
        self, node: ast.expr, slot: int, word: int, place: WalkPlace, *, sets: int, clears: int
    ) -> WordWrite:
        """Return the write of single bits; note the command bits among them."""
        if word == 0 and sets | clears:
            self._note_action(node, slot, place, sets=sets, clears=clears)
        return self._write(node, slot, word, place, value=None, sets=sets, clears=clears)

    def _note_action(self, node: ast.expr, slot: int, place: WalkPlace, *, sets: int, clears: int) -> None:
        """Note a write of the command word."""
        self.actions += self._steps.commanding(node, place.when, f"slot {slot}", sets, clears)

    def _write(
        self,
        node: ast.expr,
        slot: int,
        word: int,
        place: WalkPlace,
        *,
        value: Choices | None,
        sets: int,
        clears: int,
    ) -> WordWrite:
        line, text = self._walk.reader.place(node), ast.unparse(node)
        steps = self._steps.in_steps(place.when)
        return WordWrite(
            line, slot, word, value=value, sets=sets, clears=clears, when=place.when, steps=steps, text=text
        )

    # --- meaning of expressions

    def _output_slot(self, node: ast.expr) -> int | None:
        """Return the slot of a 3601 if an expression is its output image; None for any other expression."""
        slot = None
        match self._walk.local.closed(node):
            case ast.Attribute(value=owner, attr="outputs"):
                if isinstance(owner, ast.Subscript) and ast.unparse(owner.value).endswith("slot"):
                    slot = self._number(owner.slice)
            case _:
                return None
        if slot is None and len(self._slots) == 1:
            slot = self._slots[0]
        return slot if slot in self._slots else None

    def _output_word(self, node: ast.expr) -> tuple[int | None, int | None]:
        """Return the slot and word of an output element; None for each that is unknown or does not exist."""
        if not isinstance(node, ast.Subscript):
            return None, None
        word = self._number(node.slice)
        is_word = word is not None and 0 <= word < WORDS
        return self._output_slot(node.value), word if is_word else None

    def _value(self, node: ast.expr, target: ast.expr) -> Choices:
        """Return the options of an assigned value, and note an option that does not fit into a word."""
        try:
            choices = self._walk.options.evaluate(self._walk.local.closed(node), {})
        except UnknownError:
            return UNKNOWN_CHOICES
        options = choices.options
        if not all(isinstance(option, int) for option in options):
            return UNKNOWN_CHOICES
        too_large = [row for row, option in enumerate(options) if not WORD_MIN <= option <= UNSIGNED_MAX]
        if not too_large:
            return Choices(tuple(map(signed_word, options)), choices.source, choices.names)
        if choices.source:
            row = too_large[0]
            name = choices.names[row] if row < len(choices.names) else choices.source
            text = f"with {name} the value is {options[row]}: must be {WORD_MIN} to {UNSIGNED_MAX}"
            self.remarks.append(Violation(self._walk.reader.place(target), text))
        return UNKNOWN_CHOICES

    def _number(self, node: ast.expr) -> int | None:
        """Return the only possible value of an expression, an integer; None for any other expression."""
        try:
            options = self._walk.options.evaluate(self._walk.local.closed(node), {}).options
        except UnknownError:
            return None
        return options[0] if len(options) == 1 and isinstance(options[0], int) else None
