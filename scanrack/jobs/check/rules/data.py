"""Rules about reads and writes of variables, in any language."""

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
        for latch in (access for access in accesses if access.use in (Touch.LATCH, Touch.UNLATCH)):
            coil = _coil_of(latch, coils, variable)
            if coil is not None and not _is_default(coil, latch):
                line = f"line {coil.place.line} writes it in every scan"
                text = f"{_name(latch, variable)} is latched or unlatched here, but {line}"
                yield Violation(latch.place, text)
                break


def _coil_of(latch: Access, coils: Sequence[Access], variable: Variable) -> Access | None:
    """Return the coil of a latched bit; None if it has none.

    If people also use the variable, only a coil in the same routine counts.
    """
    for coil in coils:
        if coil.part == latch.part and (not variable.shown or coil.unit == latch.unit):
            return coil
    return None


def _name(access: Access, variable: Variable) -> str:
    return access.text or variable.name


def _is_default(coil: Access, latch: Access) -> bool:
    """Whether a coil is a default that a later latch overrides, as in structured text and Python."""
    return coil.default and coil.place.file == latch.place.file and coil.place.line < latch.place.line


def overwritten(subject: Subject) -> Iterator[Violation]:
    """Find values that every scan overwrites before they are read."""
    for variable, accesses in subject.by_variable:
        unread: Access | None = None  # the last write, until something may use its value
        for access in accesses:
            is_default = access.use is Touch.COIL and access.default
            if unread is not None and is_default and _is_same_part(access, unread):
                text = f"{_name(access, variable)} is written here in every scan"
                yield Violation(access.place, f"{text}, but line {unread.place.line} already writes it")
                break
            if is_default:
                unread = access
            elif unread is not None and (access.unit != unread.unit or overlap(access.part, unread.part)):
                unread = None


def _is_same_part(access: Access, earlier: Access) -> bool:
    """Whether a different statement in the same routine writes the same part."""
    is_same = access.part == earlier.part and access.unit == earlier.unit
    return is_same and access.place != earlier.place


def move_over_coil(subject: Subject) -> Iterator[Violation]:
    """Find words that are written both as a whole and bit by bit."""
    for variable, accesses in subject.by_variable:
        bits = [access for access in accesses if access.use is Touch.COIL and access.part]
        for move in accesses if variable.role is not Role.BLOCK else ():
            is_move = move.use is Touch.WRITE and not move.once
            bit = _bit_under(move, bits) if is_move else None
            if bit is not None:
                part = f"line {bit.place.line} writes its bit {_name(bit, variable)}"
                yield Violation(move.place, f"this writes all of {_name(move, variable)}, but {part}")


def _bit_under(move: Access, bits: Sequence[Access]) -> Access | None:
    """Return the first bit that a move may overwrite."""
    for bit in bits:
        if _contains(move.part, bit.part) and not _exclude(move, bit):
            return bit
    return None


def _contains(whole: str, part: str) -> bool:
    return whole != part and "?" not in whole + part and (part.startswith((f"{whole}.", f"{whole}[")))


def _exclude(first: Access, second: Access) -> bool:
    """Whether one access needs a bit to be on that the other access needs to be off."""
    needed = {base_of(bit.name): bit.on for bit in first.needs}
    return any(needed.get(base_of(bit.name), bit.on) != bit.on for bit in second.needs)


def never_written(subject: Subject) -> Iterator[Violation]:
    """Find variables that the program reads but that are never written."""
    for variable, accesses in _own_without_value(subject):
        if not any(access.writes for access in accesses):
            text = f"{variable.name} is read, but nothing writes it: it is always {_zero(variable)}"
            yield from _at_first_read(accesses, text)


def never_set(subject: Subject) -> Iterator[Violation]:
    """Find bits that the program reads and clears but that are never set."""
    for variable, accesses in _own_without_value(subject):
        writes = [access for access in accesses if access.writes]
        if writes and all(write.use is Touch.UNLATCH and not write.part for write in writes):
            text = f"{variable.name} is read but only cleared: it is always {_zero(variable)}"
            yield from _at_first_read(accesses, text)


def _own_without_value(subject: Subject) -> Iterator[tuple[Variable, list[Access]]]:
    """Yield the variables that start at 0 and that only the program writes."""
    for variable, accesses in subject.own_variables:
        if variable.role is Role.PLAIN and not variable.set and not variable.shown:
            yield variable, accesses


def _at_first_read(accesses: Sequence[Access], text: str) -> Iterator[Violation]:
    """Yield a violation at the first read, if there is one."""
    return islice((Violation(access.place, text) for access in accesses if access.reads), 1)


def _zero(variable: Variable) -> str:
    return "False" if variable.type == "bool" else "0"


INTERNAL = ("TIMER", "FBD_TIMER")
"""Types of blocks that are useful only if the program reads their result."""


def never_read(subject: Subject) -> Iterator[Violation]:
    """Find variables that the program writes but that are never read."""
    for variable, accesses in subject.own_variables:
        is_timer = variable.type in INTERNAL
        reading = (Touch.READ,) if is_timer else (Touch.READ, Touch.BOTH)
        is_of_program = (variable.role is Role.PLAIN or is_timer) and not variable.shown
        if is_of_program and not any(access.use in reading for access in accesses):
            for first_write in islice(filter(attrgetter("writes"), accesses), 1):
                if not first_write.parameter:
                    yield Violation(first_write.place, f"{variable.name} is written, but nothing reads it")


def parameters_never_read(subject: Subject) -> Iterator[Violation]:
    """Find tags that SBR receives but that are never read."""
    for variable, accesses in subject.by_variable:
        if not variable.shown and not any(access.reads for access in accesses):
            for access in accesses:
                if access.parameter:
                    text = f"{access.unit} receives {variable.name}, but nothing reads it"
                    yield Violation(access.place, text)


CLEARING = (Touch.UNLATCH, Touch.WRITE, Touch.BOTH, Touch.COIL)
"""Uses that may write 0 to a bit."""


def latch_never_cleared(subject: Subject) -> Iterator[Violation]:
    """Find bits that are set but never cleared."""
    for variable, accesses in subject.own_variables:
        for latch in _latches(accesses):
            is_cleared = any(
                access.use in CLEARING and overlap(access.part, latch.part) for access in accesses
            )
            key = f"{variable.name}{latch.part}".upper()
            needs_itself_off = any(not bit.on and base_of(bit.name).upper() == key for bit in latch.needs)
            if not is_cleared and not needs_itself_off:
                yield Violation(latch.place, f"{_name(latch, variable)} is set here, but nothing clears it")


def _latches(accesses: Iterable[Access]) -> Iterable[Access]:
    """Return the first latch of each bit, except latches that are meant to stay on."""
    latches: dict[str, Access] = {}
    for access in accesses:
        if access.use is Touch.LATCH and not access.once and not access.steady:
            latches.setdefault(access.part, access)
    return latches.values()


def several_tasks(subject: Subject) -> Iterator[Violation]:
    """Find variables that several tasks write."""
    for variable, accesses in subject.by_variable:
        yield from _two_owners(variable, [access for access in accesses if access.task], "task")


def several_writers(subject: Subject) -> Iterator[Violation]:
    """Find outputs written by two sequences, or by a sequence and a statement of every scan."""
    for variable, accesses in subject.by_variable:
        if variable.role is Role.OUTPUT:
            of_sequences = [access for access in accesses if not access.task]
            yield from _two_owners(variable, of_sequences, "sequence")
            yield from _sequence_and_scan(variable, of_sequences)


def _sequence_and_scan(variable: Variable, accesses: Sequence[Access]) -> Iterator[Violation]:
    """Find the first write in a sequence to an output that is also written in every scan."""
    in_scan = [access for access in accesses if access.use is Touch.COIL and not access.owner]
    in_sequence = [access for access in accesses if access.writes and access.owner]
    if in_scan and in_sequence:
        line, write = in_scan[0].place.line, in_sequence[0]
        text = f"sequence {write.owner} writes {variable.name}, but line {line} writes it in every scan"
        yield Violation(write.place, text)


def _two_owners(variable: Variable, accesses: list[Access], kind: str) -> Iterator[Violation]:
    """Find the first write by a task or sequence other than the first writer."""
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
