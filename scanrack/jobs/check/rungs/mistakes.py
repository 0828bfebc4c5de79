"""Mistakes that show in one rung or statement: conditions, divisions, conversions, presets."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved, is_integer
from scanrack.ladder.model.spec import InstructionKind
from scanrack.ladder.model.types import FBD_TIMER, TIMER
from scanrack.ladder.state.lowered import ADD_ON, LoweredLine, LoweredProgram, LoweredStep, Node, Parallel

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
    leaves,
    negated,
    never,
    plain,
)
from ..ranges import Range
from .conditions import Conditions, key_of
from .number_ranges import COPIES, Values, is_whole, target_of, type_range, written_value
from .walk import Point

TIMERS = ("TON", "TOF", "RTO")
COUNTERS = ("CTU", "CTD")
FBD_TIMERS = ("TONR", "TOFR", "RTOR")

SHORT_MS, FEW = 10, 5
"""A preset of fewer milliseconds, and of so few scans, is meant in another unit."""

LOOPS = ("WHILE", "UNTIL", "FOR")
"""Statements whose condition may be constant: EXIT ends the loop."""


class Mistakes:
    """Notes the mistakes of instructions.

    Args:
        read: paths in capitals that the program reads, such as COUNT.DN.
        scan_ms: time from scan to scan.
        made: whether Python has made the rungs.
    """

    def __init__(
        self,
        lowered: LoweredProgram,
        values: Values,
        facts: Facts,
        read: frozenset[str],
        *,
        made: bool,
        scan_ms: float,
    ) -> None:
        self._scan_ms = scan_ms
        self._lowered, self._values, self._facts, self._read = lowered, values, facts, read
        self._presets = {path.upper(): value for (path, _), value in lowered.presets.items()}
        self._dead: FileLine | None = None
        self._is_made = made  # Python has made the rungs: their numbers have lost their radix

    def note(self, point: Point, place: FileLine) -> None:
        """Note the mistakes of an instruction."""
        self._condition(point, place)
        if point.value not in (TRUE, UNKNOWN) and not isinstance(point.value, FixedTruth):
            text = self._text(point.step)
            if point.argument:
                text = f"what goes to {point.step.operands[0].text}"
            self._decided(replace(point, condition=TRUE), point.value, text, place)
        self._divisions(point.step, place)
        self._conversion(point.step, place)
        self._preset(point.step, place)

    # --- conditions

    def _condition(self, point: Point, place: FileLine) -> None:
        own, text = point.own, self._text(point.step)
        if point.step.name == "AFI":
            self._facts.remark("unreachable", place, "AFI: the rung never acts")
            self._dead = place
        elif own not in (TRUE, UNKNOWN) and self._dead != place:
            is_loop = isinstance(own, FixedTruth) and text.upper().startswith(LOOPS)
            if not is_loop:
                self._decided(point, own, text, place)
        elif not point.is_rung and own == TRUE and never(point.condition):
            if self._dead is None and not point.guards:
                self._facts.remark("unreachable", place, f"{text} is never reached")
                self._dead = place
            return
        if own == TRUE and not point.is_rung and not never(point.condition):
            self._dead = None

    def _decided(self, point: Point, own: Condition, text: str, place: FileLine) -> None:
        """Note a condition that never holds, or always does."""
        if never(own):
            rule = "contradiction" if len(list(leaves(own))) > 1 else "constant-condition"
            self._facts.remark(rule, place, f"{text} never holds")
        elif always(own):
            self._facts.remark("constant-condition", place, f"{text} always holds")
        elif _meet(point.condition, own) and never(AllOf((point.condition, own))):
            if never(point.condition):
                return
            self._facts.remark(
                "contradiction", place, f"{text} never holds here: the conditions before it exclude it"
            )
        else:
            return
        self._dead = place

    def branches(self, line: LoweredLine, conditions: Conditions, place: FileLine) -> None:
        """Note the branches of a rung that are shorted, or of which a leg always has power."""
        for node in _parallels(line.nodes):
            if not all(_decides(leg) for leg in node.legs):
                continue
            open_legs = [leg for leg in node.legs if all(each.name == "NOP" for each in _steps(leg))]
            if open_legs:
                other = next((leg for leg in node.legs if leg not in open_legs), ())
                if other:
                    text = f"an empty leg shorts the branch of {self._first(other)}, which decides nothing"
                    self._facts.remark("shorted-branch", place, text)
                continue
            legs = tuple(AllOf(tuple(conditions.decided(each) for each in _steps(leg))) for leg in node.legs)
            plain = all(isinstance(each, LoweredStep) for leg in node.legs for each in leg)
            if plain and not any(map(always, legs)) and always(AnyOf(legs)):
                text = (
                    f"the branch of {self._first(node.legs[0])} always has power: one leg or the other holds"
                )
                self._facts.remark("constant-condition", place, text)

    def _first(self, leg: tuple[Node, ...]) -> str:
        steps = _steps(leg)
        return self._text(steps[0]) if steps else "nothing"

    def _text(self, step: LoweredStep) -> str:
        return self._lowered.sites[step.site].instruction

    # --- numbers

    def _divisions(self, step: LoweredStep, place: FileLine) -> None:
        if (step.name in ("DIV", "MOD") and self._is_zero(step.operands[1])) or any(
            self._is_zero(each) for operand in step.operands for each in _divisors(operand)
        ):
            self._facts.remark("division-by-zero", place, f"{self._text(step)} divides by 0")

        written = written_value(step)
        for each in (*step.operands, *([written] if step.name == "DIV" and written is not None else [])):
            for quotient in _quotients(each):
                if self._is_always_zero(quotient, target_of(step)):
                    text = f"{self._text(step)}: the quotient of two integers is cut to 0 here"
                    self._facts.remark("integer-zero", place, text)

    def _is_always_zero(self, quotient: Calculation, target: Place | None) -> bool:
        """Whether a division of integers only gives 0, though it does not divide 0."""
        dividend, divisor = quotient.operands
        is_real = target is not None and not target.type.is_integer and isinstance(dividend, Place)
        is_split = isinstance(divisor, Constant) and divisor.value == 1000 and isinstance(dividend, Place)
        if is_real or is_split or not is_whole(quotient):
            return False
        found, cut = self._values.of(dividend), self._values.of(quotient)
        return cut.is_constant and cut.least == 0 and not (found.is_constant and found.least == 0)

    def _is_zero(self, operand: Resolved) -> bool:
        found = self._values.of(operand)
        return found.is_constant and found.least == 0

    def _conversion(self, step: LoweredStep, place: FileLine) -> None:
        """Note a number that its target can't hold."""
        target, source = target_of(step), written_value(step)
        if target is None or source is None or not target.type.is_integer or target.type.is_bool:
            return
        found, limits = self._values.of(source), type_range(target.type)
        text = ""
        if found.is_constant and isinstance(source, Constant):
            is_pattern = "#" in self._text(step) or target.leaf.slot is not None or self._is_made
            text = _constant_lost(source, limits, is_pattern=is_pattern)
        elif step.name == ":=" and isinstance(source, Calculation) and not _is_rounded(source):
            text = "the expression is a REAL: its fraction is lost"
        elif found.is_known and found.outside(limits.least, limits.most):
            text = f"it is {found}"
        elif _is_copy(step) and isinstance(source, Place):
            text = self._copy_lost(source, target, found, limits)
        if text:
            kind = target.type.name
            self._facts.remark(
                "lossy-conversion", place, f"{self._text(step)}: {target.text} is of type {kind}, and {text}"
            )

    def _copy_lost(self, source: Place, target: Place, found: Range, limits: Range) -> str:
        """Return what a copy to a smaller type may lose."""
        if not is_integer(source):
            return f"{source.text} is a {source.type.name}: its fraction is lost"
        if source.type.bits <= target.type.bits or found.within(limits.least, limits.most):
            return ""
        return f"{source.text} is a {source.type.name}: its high bits are lost"

    # --- presets

    def _preset(self, step: LoweredStep, place: FileLine) -> None:
        first = step.operands[0] if step.operands else None
        if not isinstance(first, Group) or first.frame or step.name not in (*TIMERS, *COUNTERS, *FBD_TIMERS):
            return
        path = first.path.upper()
        if self._values.is_written(f"{path}.PRE") or any(
            not isinstance(each, Constant) for each in first.indices
        ):
            return
        found = self._values.initial(first.member("PRE"))
        if found is not None and found.most != 0:
            self._short(step, first, found, place)
        if found is None or found.most != 0:
            return
        if step.name in COUNTERS and f"{path}.DN" not in self._read:
            return  # it counts for people
        self._facts.remark(
            "preset-zero",
            place,
            f"{self._text(step)}: the preset of {first.text} is 0, so it is done at once",
        )

    def _short(self, step: LoweredStep, timer: Group, preset: Range, place: FileLine) -> None:
        """Note a preset in another unit than milliseconds: it is over within a few scans."""
        scans = preset.most / self._scan_ms
        is_short = preset.least > 0 and (scans <= 1 or (preset.most < SHORT_MS and scans <= FEW))
        if is_short and step.name not in COUNTERS and timer.type in (TIMER, FBD_TIMER):
            text = (
                f"{self._text(step)}: the preset of {timer.text} is {preset} ms, and a scan takes "
                f"{self._scan_ms:g} ms"
            )
            self._facts.remark("preset-unit", place, text)


def sealed(
    points: Sequence[tuple[Point, FileLine]],
    places: Mapping[str, Place],
    facts: Facts,
    written: Callable[[LoweredStep], str],
) -> None:
    """Note coils that an input switches on, and that hold themselves without a way off.

    Args:
        places: operands by their keys.
        written: returns an instruction as it is written.
    """
    writes = [each for each in facts.accesses if each.writes]
    for point, place in points:
        target = point.step.operands[0] if point.step.name in ("OTE", ":=") else None
        if not isinstance(target, Place) or not target.type.is_bool:
            continue
        whole = plain(AllOf((point.condition, point.value)))
        own = Bit(key_of(target))
        bits = [each for each in leaves(whole) if isinstance(each, Bit) and each.on]
        if own not in bits or not never(AllOf((own, negated(whole)))) or always(whole):
            continue
        starts = (places.get(each.name) for each in bits if each != own)
        is_input = any(
            each is not None and each.leaf.slot is not None and not each.leaf.output for each in starts
        )
        if not is_input:
            continue
        own_write = next((each for each in writes if each.place == place and each.text == target.text), None)
        if own_write is not None and not _others(own_write, writes):
            text = f"{written(point.step)} holds itself: nothing switches {target.text} off"
            facts.remark("latch-never-cleared", place, text)


def _others(own: Access, writes: Sequence[Access]) -> bool:
    """Whether something else writes what an instruction writes."""
    return any(
        each is not own and each.variable == own.variable and overlap(each.part, own.part) for each in writes
    )


def _is_copy(step: LoweredStep) -> bool:
    return (step.name in COPIES and step.name != "TRN") or step.name in (":=", "[:=]")


def _is_rounded(source: Resolved) -> bool:
    """Whether an expression is an integer: it has no REAL, or a function makes one of it."""
    if isinstance(source, Calculation):
        return source.name in ("TRUNC", "TRN") or all(map(_is_rounded, source.operands))
    return is_integer(source)


def _constant_lost(source: Constant, limits: Range, *, is_pattern: bool) -> str:
    """Return what is lost of a constant; a bit pattern such as 16#8000 is not."""
    value = source.value
    if value != int(value):
        return f"{value:g} loses its fraction"
    width = limits.most - limits.least if is_pattern else limits.most
    return "" if limits.least <= value <= width else f"{value:g} is out of its range, {limits}"


def _divisors(operand: object) -> Iterator[Resolved]:
    if isinstance(operand, Calculation):
        if operand.name in ("/", "MOD"):
            yield operand.operands[1]
        for each in operand.operands:
            yield from _divisors(each)


def _quotients(operand: object) -> Iterator[Calculation]:
    if isinstance(operand, Calculation):
        if operand.name == "/":
            yield operand
        for each in operand.operands:
            yield from _quotients(each)


def _meet(before: Condition, own: Condition) -> bool:
    """Whether two conditions are of the same values."""
    names = set(map(_value_name, leaves(before))) - {""}
    return any(_value_name(each) in names for each in leaves(own))


def _value_name(part: Condition) -> str:
    """Return the name of the value in a condition, the same for TT and DN of a timer; "" if it has none."""
    return str(getattr(part, "name", "")).replace(".TT#", ".DN#")


def _parallels(nodes: tuple[Node, ...]) -> Iterator[Parallel]:
    for node in nodes:
        if isinstance(node, Parallel):
            yield node
            for leg in node.legs:
                yield from _parallels(leg)


def _steps(leg: tuple[Node, ...]) -> list[LoweredStep]:
    found: list[LoweredStep] = []
    for node in leg:
        if isinstance(node, LoweredStep):
            found.append(node)
        else:
            found += [step for each in node.legs for step in _steps(each)]
    return found


def _decides(leg: tuple[Node, ...]) -> bool:
    """Whether a leg has conditions only."""
    return all(each.kind is InstructionKind.INPUT and each.name != ADD_ON for each in _steps(leg))
