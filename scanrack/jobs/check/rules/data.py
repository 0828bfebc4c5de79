"""Rules about readers and writers of variables, in any language."""

from __future__ import annotations

from collections.abc import Iterator

from ..facts import Access, Role, Touch, Variable, overlap
from ..logic import base_of
from ..subject import Subject, Violation

SET = (Touch.COIL, Touch.LATCH, Touch.WRITE, Touch.BOTH)
"""Uses that may give a bit another value than 0."""


def coil_and_latch(subject: Subject) -> Iterator[Violation]:
    """Find bits that a coil writes in every scan, and that OTL or OTU writes, too."""
    for variable, accesses in subject.by_variable:
        coils = [each for each in accesses if each.use is Touch.COIL]
        for each in accesses:
            own = (other for other in coils if other.part == each.part)
            coil = next((other for other in own if not variable.shown or other.unit == each.unit), None)
            if each.use in (Touch.LATCH, Touch.UNLATCH) and coil is not None and not _is_before(each, coil):
                name = each.text or variable.name
                text = (
                    f"{name} is latched or unlatched here, and line {coil.place.line} writes it in every scan"
                )
                yield Violation(each.place, text)
                break


def _is_before(latch: Access, coil: Access) -> bool:
    """Whether a statement is a default that later ones override, as structured text and Python have it."""
    return coil.default and coil.place.file == latch.place.file and coil.place.line < latch.place.line


def overwritten(subject: Subject) -> Iterator[Violation]:
    """Find values that are written over in every scan before anything reads them."""
    for variable, accesses in subject.by_variable:
        before: Access | None = None
        for each in accesses:
            if before is not None and _overwrites(each, before):
                name = each.text or variable.name
                text = f"{name} is written here in every scan, and in line {before.place.line} already"
                yield Violation(each.place, text)
                break
            if each.use is Touch.COIL and each.default:
                before = each
            elif before is not None and (each.unit != before.unit or overlap(each.part, before.part)):
                before = None


def _overwrites(later: Access, before: Access) -> bool:
    same = later.part == before.part and later.unit == before.unit
    return same and later.use is Touch.COIL and later.default and later.place != before.place


def move_over_coil(subject: Subject) -> Iterator[Violation]:
    """Find words that are written as a whole, and bit by bit."""
    for variable, accesses in subject.by_variable:
        bits = [each for each in accesses if each.use is Touch.COIL and each.part]
        for each in accesses:
            own = (bit for bit in bits if _contains(each.part, bit.part) and not _exclude(each, bit))
            under = next(own, None)
            if (
                each.use is Touch.WRITE
                and not each.once
                and under is not None
                and variable.role is not Role.BLOCK
            ):
                whole, part = each.text or variable.name, under.text or variable.name
                text = f"this writes all of {whole}, and line {under.place.line} its bit {part}"
                yield Violation(each.place, text)


def _contains(whole: str, part: str) -> bool:
    return whole != part and "?" not in whole + part and (part.startswith((f"{whole}.", f"{whole}[")))


def _exclude(one: Access, other: Access) -> bool:
    """Whether a bit that one needs on is one that the other needs off."""
    bits = {base_of(each.name): each.on for each in one.needs}
    return any(bits.get(base_of(each.name), each.on) != each.on for each in other.needs)


def never_written(subject: Subject) -> Iterator[Violation]:
    """Find variables that the program reads, and that nothing gives a value."""
    if subject.facts.reads_all:
        return
    for variable, accesses in subject.by_variable:
        if (
            variable.set
            or variable.shown
            or variable.role is not Role.PLAIN
            or any(each.writes for each in accesses)
        ):
            continue
        first = next((each for each in accesses if each.reads), None)
        if first is not None:
            text = f"{variable.name} is read, and nothing writes it: it is always {_zero(variable)}"
            yield Violation(first.place, text)


def never_set(subject: Subject) -> Iterator[Violation]:
    """Find bits that the program reads and clears, and that nothing sets."""
    if subject.facts.reads_all:
        return
    for variable, accesses in subject.by_variable:
        writes = [each for each in accesses if each.writes]
        is_own = variable.role is Role.PLAIN and not variable.set and not variable.shown
        if is_own and writes and all(each.use is Touch.UNLATCH and not each.part for each in writes):
            first = next((each for each in accesses if each.reads), None)
            if first is not None:
                text = f"{variable.name} is read, and only cleared: it is always {_zero(variable)}"
                yield Violation(first.place, text)


def _zero(variable: Variable) -> str:
    return "False" if variable.type == "bool" else "0"


INTERNAL = ("TIMER", "FBD_TIMER")
"""Types of blocks whose result someone has to read."""


def never_read(subject: Subject) -> Iterator[Violation]:
    """Find variables that the program writes, and that nothing reads."""
    if subject.facts.reads_all:
        return
    for variable, accesses in subject.by_variable:
        is_timer = variable.type in INTERNAL
        if variable.shown or not (variable.role is Role.PLAIN or is_timer) or not accesses:
            continue
        if any(each.use is Touch.READ or (each.use is Touch.BOTH and not is_timer) for each in accesses):
            continue
        first = next((each for each in accesses if each.writes), None)
        if first is not None and not first.parameter:
            yield Violation(first.place, f"{variable.name} is written, and nothing reads it")


def parameters_never_read(subject: Subject) -> Iterator[Violation]:
    """Find tags that SBR takes, and that nothing reads."""
    for variable, accesses in subject.by_variable:
        if (
            not any(each.use is Touch.READ or each.use is Touch.BOTH for each in accesses)
            and not variable.shown
        ):
            for each in accesses:
                if each.parameter:
                    yield Violation(each.place, f"{each.unit} takes {variable.name}, and nothing reads it")


def latch_never_cleared(subject: Subject) -> Iterator[Violation]:
    """Find bits that are set, and that nothing clears."""
    for variable, accesses in subject.by_variable:
        done = set()
        for each in accesses:
            if each.use is not Touch.LATCH or each.part in done or variable.role is Role.INPUT:
                continue
            if each.once or each.steady:
                continue  # it is meant to stay
            done.add(each.part)
            others = [other for other in accesses if overlap(other.part, each.part)]
            clears = any(
                other.use in (Touch.UNLATCH, Touch.WRITE, Touch.BOTH, Touch.COIL) for other in others
            )
            is_guarded = any(not bit.on and _is_of(bit.name, variable, each) for bit in each.needs)
            if not clears and not is_guarded and not subject.facts.reads_all:
                yield Violation(
                    each.place, f"{each.text or variable.name} is set here, and nothing clears it"
                )


def _is_of(name: str, variable: Variable, access: Access) -> bool:
    return name.partition("#")[0].upper() == f"{variable.name}{access.part}".upper()


def several_tasks(subject: Subject) -> Iterator[Violation]:
    """Find variables that several tasks write."""
    for variable, accesses in subject.by_variable:
        yield from _two_owners(variable, [each for each in accesses if each.task], "task")


def several_writers(subject: Subject) -> Iterator[Violation]:
    """Find outputs that two sequences write, or a sequence and every scan."""
    for variable, accesses in subject.by_variable:
        if variable.role is not Role.OUTPUT:
            continue
        own = [each for each in accesses if not each.task]
        yield from _two_owners(variable, own, "sequence")
        always = next((each for each in own if each.use is Touch.COIL and not each.owner), None)
        other = next((each for each in own if each.writes and each.owner), None)
        if always is not None and other is not None:
            line = always.place.line
            text = f"sequence {other.owner} writes {variable.name}, and line {line} does in every scan"
            yield Violation(other.place, text)


def _two_owners(variable: Variable, accesses: list[Access], kind: str) -> Iterator[Violation]:
    written = [each for each in accesses if each.writes and each.owner and not each.once]
    for each in written:
        first = written[0]
        if each.owner != first.owner and overlap(each.part, first.part):
            text = (
                f"{kind} {each.owner} writes {each.text or variable.name}, "
                f"which {kind} {first.owner} writes in line {first.place.line}"
            )
            yield Violation(each.place, text)
            return
