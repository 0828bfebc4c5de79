"""Mistakes within one rung or statement: in conditions, divisions, conversions, presets."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain

from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved, is_integer
from scanrack.ladder.model.spec import InstructionKind
from scanrack.ladder.model.types import FBD_TIMER, TIMER
from scanrack.ladder.state.lowered import (
    ADD_ON,
    LoweredLine,
    LoweredStep,
    Node,
    Parallel,
    steps_of,
)

from ..facts import Access, Facts, FileLine, overlap
from ..logic import (
    TRUE,
    UNKNOWN,
    AllOf,
    AnyOf,
    Bit,
    Condition,
    FixedTruth,
    always,
    constant_condition,
    leaves,
    negated,
    never,
    plain,
)
from ..ranges import Range
from .conditions import Conditions
from .number_ranges import COPIES, is_whole, type_range, written_value
from .operands import (
    calculations_of,
    divisors_of,
    first_of,
    group_of,
    is_fixed,
    is_input,
    key_of,
    path_of,
)
from .subscripts import note_lengths, note_subscripts
from .view import LadderView
from .walk import Point

TIMERS = ("TON", "TOF", "RTO")
COUNTERS = ("CTU", "CTD")
FBD_TIMERS = ("TONR", "TOFR", "RTOR")
WITH_PRESET = frozenset((*TIMERS, *COUNTERS, *FBD_TIMERS))

SHORT_MS, FEW_SCANS = 10, 5
"""A preset below SHORT_MS ms and of at most FEW_SCANS scans is probably in the wrong unit."""

LOOPS = ("WHILE", "UNTIL", "FOR")
"""Statements whose condition may be constant, because EXIT ends the loop."""


THOUSAND = 1000
"""The divisor that splits a number into two words of a 3601; a small quotient is 0 on purpose."""


class Mistakes:
    """Notes the mistakes of instructions."""

    def __init__(self, view: LadderView, facts: Facts) -> None:
        self._view, self._values, self._facts = view, view.values, facts
        self._has_lost_radix = view.path.suffix == ".py"  # a number in a rung may be a bit pattern
        self._dead: FileLine | None = None  # the line that was last noted as never acting

    def note(self) -> None:
        """Note the mistakes in all instructions and branches."""
        noted: set[tuple[str, str]] = set()
        for point in self._view.points:
            self._instruction(point)
            note_subscripts(point, self._view.counts, self._facts, noted)
            note_lengths(point, self._facts)
        for routine in self._view.routines:
            for line in routine.lines if routine.body is None else ():
                self._branches(line)

    def _instruction(self, point: Point) -> None:
        """Note the mistakes in an instruction."""
        self._condition(point)
        if point.value not in (TRUE, UNKNOWN) and not isinstance(point.value, FixedTruth):
            text = f"the argument for {point.step.operands[0].text}" if point.argument else point.text
            self._note_constant(replace(point, condition=TRUE), point.value, text)
        self._divisions(point)
        self._conversion(point)
        self._preset(point)

    # --- conditions

    def _condition(self, point: Point) -> None:
        """Note an instruction that is unreachable, or that has a condition that is always or never true."""
        place = point.place
        if point.step.name == "AFI":
            self._facts.remark("unreachable", place, "AFI: the rung never acts")
            self._dead = place
        elif point.own != TRUE:
            is_loop = isinstance(point.own, FixedTruth) and point.text.upper().startswith(LOOPS)
            if self._dead != place and not is_loop:
                self._note_constant(point, point.own, point.text)
        elif point.is_rung:
            return
        elif not never(point.condition):
            self._dead = None
        elif self._dead is None and not point.guards:
            self._facts.remark("unreachable", place, f"{point.text} is never reached")
            self._dead = place

    def _note_constant(self, point: Point, condition: Condition, text: str) -> None:
        """Note a condition that is never or always true at a point."""
        remark = constant_condition(condition)
        if remark is None and _is_excluded(point.condition, condition) and not never(point.condition):
            remark = "contradiction", "never holds here: the conditions before it exclude it"
        if remark is not None:
            rule, problem = remark
            self._facts.remark(rule, point.place, f"{text} {problem}")
            self._dead = point.place

    def _branches(self, line: LoweredLine) -> None:
        """Note branches of a rung that are shorted, or that always have power through one of their legs."""
        place = self._view.place(line)
        for node in _parallels(line.nodes):
            legs = [steps_of(leg, copies=False) for leg in node.legs]
            deciding = [leg for leg in legs if any(step.name != "NOP" for step in leg)]
            if not all(map(_decides, chain(*legs))) or not deciding:
                continue
            first_step = deciding[0][0]
            branch = f"the branch of {self._view.lowered.sites[first_step.site].instruction}"
            if len(deciding) < len(legs):
                text = f"an empty leg shorts {branch}, which has no effect"
                self._facts.remark("shorted-branch", place, text)
            elif _always_has_power(node, self._view.conditions):
                text = f"{branch} always has power: one leg or the other is true"
                self._facts.remark("constant-condition", place, text)

    # --- numbers

    def _divisions(self, point: Point) -> None:
        """Note a division by 0, and a division of integers that always results in 0."""
        if any(map(self._is_zero, divisors_of(point.step))):
            self._facts.remark("division-by-zero", point.place, f"{point.text} divides by 0")
        quotients: list[Resolved | None] = [*calculations_of(point.step, ("/",))]
        if point.step.name == "DIV":
            quotients.append(written_value(point.step))
        for quotient in quotients:
            if isinstance(quotient, Calculation) and self._is_always_zero(quotient, point.target):
                text = f"{point.text}: the quotient of two integers is truncated to 0 here"
                self._facts.remark("integer-zero", point.place, text)

    def _is_always_zero(self, quotient: Calculation, target: Place | None) -> bool:
        """Whether the result of a division of integers is always 0, although its dividend is not 0."""
        dividend, divisor = quotient.operands
        is_real = target is not None and not target.type.is_integer
        is_split = isinstance(divisor, Constant) and divisor.value == THOUSAND
        if (isinstance(dividend, Place) and (is_real or is_split)) or not is_whole(quotient):
            return False
        return self._is_zero(quotient) and not self._is_zero(dividend)

    def _is_zero(self, operand: Resolved) -> bool:
        value = self._values.range_of(operand)
        return value.is_constant and value.least == 0

    def _conversion(self, point: Point) -> None:
        """Note a number that does not fit into its target."""
        target, source = point.target, written_value(point.step)
        if target is None or source is None or not target.type.is_integer or target.type.is_bool:
            return
        loss = self._loss(point, source, target)
        if loss:
            text = f"{point.text}: {target.text} is of type {target.type.name}, but {loss}"
            self._facts.remark("lossy-conversion", point.place, text)

    def _loss(self, point: Point, source: Resolved, target: Place) -> str:
        """Return a message about the loss when a number is written to its target; "" if there is no loss."""
        value, limits = self._values.range_of(source), type_range(target.type)
        if isinstance(source, Constant):
            return _constant_loss(source, limits, is_pattern=self._is_pattern(point, target))
        if isinstance(source, Calculation) and point.step.name == ":=" and not _is_rounded(source):
            return "the expression is a REAL: its fraction is lost"
        if value.is_known and value.outside(limits.least, limits.most):
            return f"the value is {value}"
        if isinstance(source, Place) and _is_copy(point.step):
            return _copy_loss(source, target, value, limits)
        return ""

    def _is_pattern(self, point: Point, target: Place) -> bool:
        """Whether a constant may be a bit pattern."""
        return "#" in point.text or target.leaf.slot is not None or self._has_lost_radix

    # --- presets

    def _preset(self, point: Point) -> None:
        """Note a preset of 0 or of only a few scans. Presets that the program writes are not checked."""
        group = group_of(point.step, WITH_PRESET)
        if group is None or group.frame or not is_fixed(group):
            return
        path = path_of(group)
        preset = None if self._values.is_written(f"{path}.PRE") else self._values.initial(group.member("PRE"))
        # a counter whose DN is not read needs no preset
        only_counts = point.step.name in COUNTERS and f"{path}.DN" not in self._view.read
        if preset is not None and preset.most != 0:
            self._note_short_preset(point, group, preset)
        elif preset is not None and not only_counts:
            text = f"{point.text}: the preset of {group.text} is 0, so it is done at once"
            self._facts.remark("preset-zero", point.place, text)

    def _note_short_preset(self, point: Point, timer: Group, preset: Range) -> None:
        """Note a preset of only a few scans, which is probably not in milliseconds."""
        scan_ms = float(self._view.spec.scan_ms)
        scans = preset.most / scan_ms
        is_short = preset.least > 0 and (scans <= 1 or (preset.most < SHORT_MS and scans <= FEW_SCANS))
        if is_short and point.step.name not in COUNTERS and timer.type in (TIMER, FBD_TIMER):
            times = f"the preset of {timer.text} is {preset} ms, but a scan takes {scan_ms:g} ms"
            self._facts.remark("preset-unit", point.place, f"{point.text}: {times}")


def sealed(view: LadderView, facts: Facts) -> None:
    """Note coils that an input switches on and that seal in, but that nothing switches off."""
    writes = [access for access in facts.accesses if access.writes]
    first_writes = {(write.place, write.text): write for write in reversed(writes)}
    for point in view.main:
        name = _sealed_bit(point, view.places)
        write = first_writes.get((point.place, name)) if name else None
        if write is not None and not _has_other_write(write, writes):
            text = f"{point.text} seals in: nothing switches {name} off"
            facts.remark("latch-never-cleared", point.place, text)


def _sealed_bit(point: Point, places: Mapping[str, Place]) -> str:
    """Return the bit that an instruction seals in after an input switches it on; "" if it seals none."""
    target = first_of(point.step, ("OTE", ":="))
    is_bit = isinstance(target, Place) and target.type.is_bool
    return target.text if is_bit and _seals_input_in(point, target, places) else ""


def _seals_input_in(point: Point, target: Place, places: Mapping[str, Place]) -> bool:
    """Whether an input switches a bit on, and the bit then stays on even if all other bits are off."""
    power, seal = plain(AllOf((point.condition, point.value))), Bit(key_of(target))
    bits = [leaf for leaf in leaves(power) if isinstance(leaf, Bit) and leaf.on]
    starts = (places.get(bit.name) for bit in bits if bit != seal)
    if seal not in bits or not any(map(is_input, starts)):
        return False
    return never(AllOf((seal, negated(power)))) and not always(power)


def _has_other_write(write: Access, writes: Sequence[Access]) -> bool:
    """Whether any other access writes the same memory."""
    same_variable = (other for other in writes if other is not write and other.variable == write.variable)
    return any(overlap(other.part, write.part) for other in same_variable)


def _is_copy(step: LoweredStep) -> bool:
    return (step.name in COPIES and step.name != "TRN") or step.name in (":=", "[:=]")


def _is_rounded(source: Resolved) -> bool:
    """Whether an expression is an integer: it contains no REAL, or a function rounds it."""
    if isinstance(source, Calculation):
        return source.name in ("TRUNC", "TRN") or all(map(_is_rounded, source.operands))
    return is_integer(source)


def _constant_loss(source: Constant, limits: Range, *, is_pattern: bool) -> str:
    """Return a message about the loss of a constant; "" if nothing is lost, as with bit pattern 16#8000."""
    value = source.value
    if value != int(value):
        return f"{value:g} loses its fraction"
    width = limits.most - limits.least if is_pattern else limits.most
    return "" if limits.least <= value <= width else f"{value:g} is out of its range, {limits}"


def _copy_loss(source: Place, target: Place, value: Range, limits: Range) -> str:
    """Return a message about the possible loss in a copy to a smaller type; "" if nothing is lost."""
    if not is_integer(source):
        return f"{source.text} is a {source.type.name}: its fraction is lost"
    if source.type.bits <= target.type.bits or value.within(limits.least, limits.most):
        return ""
    return f"{source.text} is a {source.type.name}: its high bits are lost"


def _is_excluded(earlier: Condition, condition: Condition) -> bool:
    """Whether a condition contradicts an earlier condition on the same values."""
    names = set(map(_value_name, leaves(earlier))) - {""}
    has_same_value = any(_value_name(leaf) in names for leaf in leaves(condition))
    return has_same_value and never(AllOf((earlier, condition)))


def _value_name(part: Condition) -> str:
    """Return the name of the value in a condition (a timer's TT and DN share one); "" if it has none."""
    return str(getattr(part, "name", "")).replace(".TT#", ".DN#")


def _parallels(nodes: tuple[Node, ...]) -> Iterator[Parallel]:
    """Yield the branches among nodes, each followed by the branches inside it."""
    for node in nodes:
        if isinstance(node, Parallel):
            yield node
            for leg in node.legs:
                yield from _parallels(leg)


def _decides(step: LoweredStep) -> bool:
    return step.kind is InstructionKind.INPUT and step.name != ADD_ON


def _always_has_power(branch: Parallel, conditions: Conditions) -> bool:
    """Whether at least one leg of a branch is always true, although no single leg always is.

    False for a branch with inner branches.
    """
    if not all(isinstance(step, LoweredStep) for leg in branch.legs for step in leg):
        return False
    legs = tuple(
        AllOf(tuple(conditions.decided(step) for step in leg if isinstance(step, LoweredStep)))
        for leg in branch.legs
    )
    return always(AnyOf(legs)) and not any(map(always, legs))
