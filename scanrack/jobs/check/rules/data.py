"""Rules about what reads and writes variables, in any language."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from operator import attrgetter

from ..facts import Access, Role, Touch, Variable, Violation, overlap
from ..logic import base_of
from ..subject import Subject


def coil_and_latch(subject: Subject) -> Iterator[Violation]:
    """Find bits that a coil writes in every scan and that OTL or OTU also write."""
    for variable, accesses in subject.by_variable:
        coils = [access for access in accesses if access.use is Touch.COIL]
        for latch_access in accesses:
            coil = (
                _coil_of(latch_access, coils, variable)
                if latch_access.use in (Touch.LATCH, Touch.UNLATCH)
                else None
            )
            if coil is not None and not _is_before(latch_access, coil):
                where = f"line {coil.place.line} writes it in every scan"
                text = f"{_name(latch_access, variable)} is latched or unlatched here, and {where}"
                yield Violation(latch_access.place, text)
                break


def _coil_of(latch: Access, coils: Sequence[Access], variable: Variable) -> Access | None:
    """Return the coil of a latched bit; if others also use the variable, only a coil in the same routine."""
    own = (coil for coil in coils if coil.part == latch.part)
    return next((access for access in own if not variable.shown or access.unit == latch.unit), None)


def _name(access: Access, variable: Variable) -> str:
    return access.text or variable.name


def _is_before(latch: Access, coil: Access) -> bool:
    """Whether a statement is a default that a later one overrides, as in structured text and Python."""
    return coil.default and coil.place.file == latch.place.file and coil.place.line < latch.place.line


def overwritten(subject: Subject) -> Iterator[Violation]:
    """Find values that every scan overwrites before anything reads them."""
    for variable, accesses in subject.by_variable:
        before: Access | None = None
        for access in accesses:
            if before is not None and _overwrites(access, before):
                where = f"in line {before.place.line} already"
                text = f"{_name(access, variable)} is written here in every scan, and {where}"
                yield Violation(access.place, text)
                break
            if access.use is Touch.COIL and access.default:
                before = access
            elif before is not None and _may_use(access, before):
                before = None


def _may_use(later: Access, before: Access) -> bool:
    """Whether an access may read or replace a value, or is in another routine."""
    return later.unit != before.unit or overlap(later.part, before.part)


def _overwrites(later: Access, before: Access) -> bool:
    same = later.part == before.part and later.unit == before.unit
    return same and later.use is Touch.COIL and later.default and later.place != before.place


def move_over_coil(subject: Subject) -> Iterator[Violation]:
    """Find words that are written both as a whole and bit by bit."""
    for variable, accesses in subject.by_variable:
        bits = [access for access in accesses if access.use is Touch.COIL and access.part]
        for move in accesses if variable.role is not Role.BLOCK else ():
            is_move = move.use is Touch.WRITE and not move.once
            bit = _bit_under(move, bits) if is_move else None
            if bit is not None:
                part = f"line {bit.place.line} its bit {_name(bit, variable)}"
                yield Violation(move.place, f"this writes all of {_name(move, variable)}, and {part}")


def _bit_under(move: Access, bits: Sequence[Access]) -> Access | None:
    """Return the first bit that a move may overwrite."""
    covered = (bit for bit in bits if _contains(move.part, bit.part) and not _exclude(move, bit))
    return next(covered, None)


def _contains(whole: str, part: str) -> bool:
    return whole != part and "?" not in whole + part and (part.startswith((f"{whole}.", f"{whole}[")))


def _exclude(one: Access, other: Access) -> bool:
    """Whether one access needs a bit to be on that the other needs to be off."""
    bits = {base_of(need.name): need.on for need in one.needs}
    return any(bits.get(base_of(need.name), need.on) != need.on for need in other.needs)


def never_written(subject: Subject) -> Iterator[Violation]:
    """Find variables that the program reads but nothing writes."""
    for variable, accesses in _own_without_value(subject):
        if not any(access.writes for access in accesses):
            text = f"{variable.name} is read, and nothing writes it: it is always {_zero(variable)}"
            yield from _at_first_read(accesses, text)


def never_set(subject: Subject) -> Iterator[Violation]:
    """Find bits that the program reads and clears but nothing sets."""
    for variable, accesses in _own_without_value(subject):
        writes = [access for access in accesses if access.writes]
        if writes and all(write.use is Touch.UNLATCH and not write.part for write in writes):
            text = f"{variable.name} is read, and only cleared: it is always {_zero(variable)}"
            yield from _at_first_read(accesses, text)


def _own_without_value(subject: Subject) -> Iterator[tuple[Variable, list[Access]]]:
    """Yield the variables that start at 0 and that only the program writes."""
    for variable, accesses in subject.own_variables:
        if variable.role is Role.PLAIN and not variable.set and not variable.shown:
            yield variable, accesses


def _at_first_read(accesses: Sequence[Access], text: str) -> Iterator[Violation]:
    return islice((Violation(access.place, text) for access in accesses if access.reads), 1)


def _zero(variable: Variable) -> str:
    return "False" if variable.type == "bool" else "0"


INTERNAL = ("TIMER", "FBD_TIMER")
"""Types of blocks whose result is meant to be read."""


def never_read(subject: Subject) -> Iterator[Violation]:
    """Find variables that the program writes but nothing reads."""
    for variable, accesses in subject.own_variables:
        is_timer = variable.type in INTERNAL
        reading = (Touch.READ,) if is_timer else (Touch.READ, Touch.BOTH)
        is_own = variable.role is Role.PLAIN or is_timer
        if is_own and not variable.shown and not any(access.use in reading for access in accesses):
            first = next(filter(attrgetter("writes"), accesses), None)
            if first is not None and not first.parameter:
                yield Violation(first.place, f"{variable.name} is written, and nothing reads it")


def parameters_never_read(subject: Subject) -> Iterator[Violation]:
    """Find tags that SBR receives but nothing reads."""
    for variable, accesses in subject.by_variable:
        if not variable.shown and not any(access.reads for access in accesses):
            for parameter_access in accesses:
                if parameter_access.parameter:
                    yield Violation(
                        parameter_access.place,
                        f"{parameter_access.unit} takes {variable.name}, and nothing reads it",
                    )


CLEARING = (Touch.UNLATCH, Touch.WRITE, Touch.BOTH, Touch.COIL)
"""Uses that may write 0 to a bit."""


def latch_never_cleared(subject: Subject) -> Iterator[Violation]:
    """Find bits that are set but never cleared."""
    for variable, accesses in subject.own_variables:
        for latch in _latches(accesses):
            clearing = (other.part for other in accesses if other.use in CLEARING)
            clears = any(overlap(part, latch.part) for part in clearing)
            is_guarded = any(not bit.on and _is_of(bit.name, variable, latch) for bit in latch.needs)
            if not clears and not is_guarded:
                yield Violation(latch.place, f"{_name(latch, variable)} is set here, and nothing clears it")


def _latches(accesses: Iterable[Access]) -> Iterable[Access]:
    """Return the first latch of each bit, except latches that are meant to stay."""
    latches: dict[str, Access] = {}
    for access in accesses:
        if access.use is Touch.LATCH and not access.once and not access.steady:
            latches.setdefault(access.part, access)
    return latches.values()


def _is_of(name: str, variable: Variable, access: Access) -> bool:
    return base_of(name).upper() == f"{variable.name}{access.part}".upper()


def several_tasks(subject: Subject) -> Iterator[Violation]:
    """Find variables that several tasks write."""
    for variable, accesses in subject.by_variable:
        yield from _two_owners(variable, [access for access in accesses if access.task], "task")


def several_writers(subject: Subject) -> Iterator[Violation]:
    """Find outputs that two sequences write, or a sequence and a statement of every scan."""
    for variable, accesses in subject.by_variable:
        if variable.role is Role.OUTPUT:
            own = [access for access in accesses if not access.task]
            yield from _two_owners(variable, own, "sequence")
            yield from _sequence_and_scan(variable, own)


def _sequence_and_scan(variable: Variable, accesses: Sequence[Access]) -> Iterator[Violation]:
    """Find the first write in a sequence to an output that is also written in every scan."""
    always = next((access for access in accesses if access.use is Touch.COIL and not access.owner), None)
    other = next((access for access in accesses if access.writes and access.owner), None)
    if always is not None and other is not None:
        line = always.place.line
        text = f"sequence {other.owner} writes {variable.name}, and line {line} does in every scan"
        yield Violation(other.place, text)


def _two_owners(variable: Variable, accesses: list[Access], kind: str) -> Iterator[Violation]:
    owned_writes = [access for access in accesses if access.writes and access.owner and not access.once]
    for write in owned_writes:
        first = owned_writes[0]
        if write.owner != first.owner and overlap(write.part, first.part):
            text = (
                f"{kind} {write.owner} writes {_name(write, variable)}, "
                f"which {kind} {first.owner} writes in line {first.place.line}"
            )
            yield Violation(write.place, text)
            return
