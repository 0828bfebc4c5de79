"""Monitors: lines that run after a program's scan and set a bit for each claim that the state breaks.

A claim becomes a line of structured text, compiled with the program:

    Prove__1 := 1; Prove__1 := Fwd AND Rev;              never Fwd AND Rev
    Prove__2 := 1; Prove__2 := NOT (Valve OR Idle);      always Valve OR Idle
    Prove__3 := 0; Prove__3 := Done;                     reachable Done
    Old__1 := Count;                                     after all claims, for old(Count)

If the condition can't be computed because a subscript is out of range, the line ends there. A claim is then
broken, and a `reachable` condition is not reached. Claims are also checked after the scan of a major fault,
on the state at the fault.

A routine named `NEVER` is also a monitor. Controllers don't run it, because no routine calls it. Each of its
rungs is a claim that power never reaches the end of the rung. In structured text, each bit that a statement
sets is a claim that the bit is never 1. The routine can have timers and one-shots. A rung that only prepares
values for other rungs ends with `AFI()`.

    XIC(Valve)XIO(Open)TON(Late,2000,0)XIC(Late.DN)NOP();

The machine of terms, the interpreter and the compiled program all run `LoweredProgram.monitors` after a scan.
They run the same instructions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from typing import Any

from scanrack.io_images.site import Site
from scanrack.io_images.tag_names import normal

from ..instructions import BY_NAME
from ..lowering.checks import calls_of
from ..lowering.rungs import Lowering
from ..lowering.runnable import LadderLogic
from ..model.errors import BuildError, LadderError, LadderFault
from ..model.expressions import parse_address, parse_expression
from ..model.operands import Constant, Place
from ..model.resolver import AddressError
from ..model.routine import Routine
from ..model.statements import Assignment
from ..model.tags import OVERRIDE, STATUS_FLAGS, SlotAlias, Tag, program_of, scoped
from ..model.tree import Address, Instruction, Operand, Operation, Rung, number
from ..model.types import BOOL
from ..run.engine import Engine
from ..st import parse_statements
from .claims import NEVER, Claim, ClaimKind, claims_in, named_apart
from .relation.places import Key


@dataclass(frozen=True, slots=True)
class WatchedClaim:
    """A claim, and a bit that is true after a scan that breaks or reaches the claim."""

    claim: Claim
    bit: Key
    assume: tuple[Key, ...] = ()  # bits of the claim's own assumptions

    def holds(self, engine: Engine) -> bool:
        """Return whether the bit is false after the last scan of an engine."""
        return not engine.memory.read(engine.lowered.layout.leaf(self.bit[0]), self.bit[1])


@dataclass(frozen=True, slots=True)
class MonitoredProgram:
    """A program with its monitors.

    Attributes:
        program: a copy of the program; its engines run the monitors after each scan.
        properties: its claims, except the assumptions.
        assume: bits of its assumptions; proofs consider only runs that set them in each scan.
        assumptions: the claims of these bits.
    """

    program: LadderLogic
    properties: tuple[WatchedClaim, ...]
    assume: tuple[Key, ...]
    assumptions: tuple[Claim, ...]


class ClaimWatch:
    """Watches a run for the scan that breaks a claim, until an assumption fails."""

    def __init__(self, program: MonitoredProgram, watched: WatchedClaim) -> None:
        self._assumed = [name for name, _ in (*program.assume, *watched.assume)]
        self._bit = watched.bit[0]
        self._is_kept = True  # whether all assumptions have held so far

    def is_broken(self, tags: Any) -> bool:
        """Return whether the latest scan breaks the claim; call it once per scan, with the program's tags."""
        self._is_kept = self._is_kept and all(tags[name] for name in self._assumed)
        return self._is_kept and bool(tags[self._bit])


def monitored(
    program: LadderLogic, claims: Sequence[Claim] = (), slots: Sequence[int] = ()
) -> MonitoredProgram:
    """Return a copy of a program with monitors for NEVER routines, claims in comments, and other claims.

    Args:
        claims: other claims, which come first.
        slots: slots of the rack, so conditions can contain names such as `slot1.status.IN_ESTOP`.

    Raises:
        LadderError: a condition can't be used (the message names the claim), or a routine NEVER is called.
    """
    built = program.build()
    named_claims = named_apart([*claims, *claims_in(built)])
    maker = _Maker(named_claims, never_routines(program), slots)
    watched_program = _copy(program, slots)
    watched_program.monitors = maker.lower
    try:
        lowered = watched_program.build()
    except BuildError as error:
        raise maker.refusal(error) from None
    lowered.monitors = tuple(maker.routines)
    lowered.closing = (*lowered.closing, run_monitors)
    maker.keep_initials(watched_program)
    properties = [monitor for monitor in maker.watched if monitor.claim.kind is not ClaimKind.ASSUME]
    assumed = [monitor for monitor in maker.watched if monitor.claim.kind is ClaimKind.ASSUME]
    return MonitoredProgram(
        watched_program,
        tuple(properties),
        tuple(monitor.bit for monitor in assumed),
        tuple(monitor.claim for monitor in assumed),
    )


def run_monitors(engine: Engine) -> None:
    """Run the monitors of a program after a scan."""
    with monitoring(engine.interpreter):
        for name in engine.lowered.monitors:
            with suppress(LadderFault) if is_claims(name) else nullcontext():
                engine.call_routine(name, ())


def run_claims(engine: Engine) -> None:
    """Run the monitors of claims after a scan that a major fault has ended."""
    with monitoring(engine.interpreter):
        for name in filter(is_claims, engine.lowered.monitors):
            with suppress(LadderFault):
                engine.call_routine(name, ())


def why_broken(engine: Engine, bit: Key) -> str:
    """Return the reason why the condition of a claim can't be computed after the latest scan, or "".

    Args:
        bit: the claim's bit.
    """
    with monitoring(engine.interpreter):
        for name in engine.lowered.monitors:
            try:
                if _short(name) == bit[0]:
                    engine.call_routine(name, ())
            except LadderFault as fault:
                return f"{fault.tag}: {fault.text}"
    return ""


def is_claims(routine: str) -> bool:
    """Return whether a monitor checks claims, and is not a NEVER routine. Its name is in capitals."""
    return is_monitors_own(_short(routine))


@contextmanager
def monitoring(machine: Any) -> Iterator[None]:
    """Return a context that turns first scan and MCR zone off, and restores the status flags afterward.

    Args:
        machine: an interpreter, or the machine of terms.
    """
    saved = [(name, machine.status(name)) for name in STATUS_FLAGS if name != "S:FS"]
    machine.set_status("S:FS", False)
    if machine.lowered.override:
        machine.set_status(OVERRIDE, False)
    yield
    for name, value in saved:
        machine.set_status(name, value)


def is_monitors_own(path: str) -> bool:
    """Return whether a leaf, by its path in capitals, belongs to the monitors rather than the program.

    >>> is_monitors_own("PROVE__3"), is_monitors_own("FWD")
    (True, False)
    """
    return path.startswith(("PROVE__", "OLD__"))


def _copy(program: LadderLogic, slots: Sequence[int]) -> LadderLogic:
    """Return an unbuilt copy of a program, with names for the slots."""
    result = program.copied()
    declared_names = {declaration.name.upper() for declaration in program.declarations}
    aliases = [SlotAlias(f"slot{slot}", slot) for slot in slots if f"SLOT{slot}" not in declared_names]
    result.declarations += aliases
    return result


def never_routines(program: LadderLogic) -> list[Routine]:
    """Return a program's NEVER routines; raise a LadderError if one can't be a monitor."""
    monitors = [candidate for candidate in program.routines if _short(candidate.name).upper() == NEVER]
    built = program.build()
    called = {name for routine in built.routines.values() for name in calls_of(routine)}
    for monitor in monitors:
        if monitor.name.upper() in called | built.roots:
            raise LadderError(
                f"routine {monitor.name} is called: a routine {NEVER} is a monitor of `scanrack prove`, "
                "which no controller runs; give it another name"
            )
        if monitor.chart is not None:
            raise LadderError(f"routine {monitor.name} is a chart: a monitor is rungs or structured text")
    return monitors


@dataclass(slots=True)
class _Maker:
    """Lowers monitors after the routines of a program."""

    claims: Sequence[Claim]
    never: Sequence[Routine]
    slots: Sequence[int]
    watched: list[WatchedClaim] = field(default_factory=list)
    routines: list[str] = field(default_factory=list)  # full names of the monitors in capitals, in order
    _old: dict[tuple[str, str], tuple[str, Place]] = field(default_factory=dict)  # tags by scope and text
    _claims: dict[str, Claim] = field(default_factory=dict)  # the claim of a monitor, by its full name
    _bits: int = 0
    _lowering: Lowering = field(init=False)

    def lower(self, lowering: Lowering) -> None:
        """Lower all monitors; lay out both images of each slot in use, so contracts can use them."""
        self._lowering, layout = lowering, lowering.lowered.layout
        used = {leaf.slot for leaf in (*layout.images, *layout.faults)}
        for slot in self.slots:
            if slot in used:
                layout.image(slot, output=False)
                layout.image(slot, output=True)
        for routine in self.never:
            self._never(routine)
        for claim in self.claims:
            self._claim(claim)
        latches: dict[str, list[Assignment]] = {}
        for (scope, text), (name, _) in self._old.items():
            latches.setdefault(scope, []).append(Assignment(Address(name), parse_address(text)))
        for scope, statements in latches.items():
            self._statements(scope, "Old__0", statements)

    # --- routines NEVER

    def _never(self, routine: Routine) -> None:
        """Lower a NEVER routine as a monitor; watch the end of each rung, or each bit that it assigns."""
        scope = program_of(routine.name)
        if routine.statements is not None:
            self._add(scope, replace(routine, name=f"{_short(routine.name)}__"))
            for statement in routine.statements:
                if isinstance(statement, Assignment) and _is_bit(self._lowering, statement.target):
                    site = Site(scope, routine.name, statement.line, unit="line", file=statement.origin.file)
                    name = f"{_short(routine.name)} line {statement.line}"
                    claim = Claim(name, ClaimKind.NEVER, str(statement.target), scope=scope, site=site)
                    self._claim(claim)
            return
        bits, rungs = [], []
        for index, rung in enumerate(routine.rungs):
            bits.append(self._new_bit())
            coil = Instruction("OTE", (Address(bits[-1]),))
            rungs.append(replace(rung, series=(*rung.series, coil)))
            self.watched.append(WatchedClaim(_claim_of(routine, index, rung), (bits[-1].upper(), 0)))
        cleared = [Assignment(Address(bit), number(0)) for bit in bits]
        self._statements(scope, "Never__0", cleared)  # a jump may skip rungs
        self._add(scope, replace(routine, name=f"{_short(routine.name)}__", rungs=tuple(rungs)))

    # --- claims

    def _claim(self, claim: Claim) -> None:
        """Lower the condition of a claim and the conditions that it assumes; watch it."""
        conditions = tuple(self._condition(claim, text, broken=False) for text in claim.assume)
        negated, broken = claim.kind is ClaimKind.ALWAYS, claim.kind in (ClaimKind.ALWAYS, ClaimKind.NEVER)
        bit = self._condition(claim, claim.text, broken=broken, negated=negated)
        self.watched.append(WatchedClaim(claim, bit, conditions))

    def _condition(self, claim: Claim, text: str, *, broken: bool, negated: bool = False) -> Key:
        """Lower a condition to a separate monitor; return its bit.

        Args:
            broken: the value of the bit if the condition can't be computed.
        """
        self._lowering.enter(claim.scope)
        value = self._parsed(claim, text)
        name = self._new_bit()
        if negated:
            value = Operation("NOT", (value,))
        statements = [Assignment(Address(name), constant) for constant in (number(int(broken)), value)]
        self._claims[self._statements(claim.scope, name, statements)] = claim
        return name.upper(), 0

    def _parsed(self, claim: Claim, text: str) -> Operand:
        """Return a condition as an operand, with a tag in place of each `old(...)`."""
        try:
            is_slc = self._lowering.lowered.layout.files
            text = _FILE_BIT.sub(lambda found: normal(found[0]), text) if is_slc else text
            plain = _with_latches(text, lambda inner: self._latch(claim.scope, inner))
            if is_slc:  # structured text has no addresses of data files
                return parse_expression(plain)
            block = parse_statements(f"Claim := ({plain}\n);", specs=BY_NAME)
        except LadderError as error:
            raise LadderError(f"{_claim_name(claim)}: {text}: {error.reason}", claim.site) from None
        if len(block) != 1 or not isinstance(block[0], Assignment):
            raise LadderError(f"{_claim_name(claim)}: {text}: must be one condition", claim.site)
        return block[0].value

    def _latch(self, scope: str, text: str) -> str:
        """Return the name of the tag for `old(text)`; declare the tag at the first use."""
        existing = self._old.get((scope, text))
        if existing is not None:
            return existing[0]
        try:
            place = self._lowering.resolver.address(parse_address(text))
        except AddressError as error:
            raise LadderError(f"{error}; {error.remedy}") from None
        if not isinstance(place, Place) or place.fixed_index is None or not _is_fixed_bit(place):
            raise LadderError(f"old({text}): must be one value at a fixed place")
        name = f"Old__{len(self._old) + 1}"
        kind = BOOL if place.bit is not None else place.type
        self._lowering.lowered.layout.declare(Tag(name, kind))
        self._old[scope, text] = name, place
        return name

    def keep_initials(self, program: LadderLogic) -> None:
        """Set the initial value of each `old(...)` to the initial value of its tag."""
        if not self._old:
            return
        memory = program.interpret().memory
        presets = program.build().presets
        for name, place in self._old.values():
            value = memory.read(place.leaf, place.fixed_index or 0)
            if place.bit is not None:
                value = int(value) >> int(place.bit.value) & 1  # type: ignore[union-attr]
            presets[name, 0] = bool(value) if place.bit is not None or place.type.is_bool else value

    # --- lowering

    def _new_bit(self) -> str:
        """Declare a bit for a monitor; return its name."""
        self._bits += 1
        name = f"Prove__{self._bits}"
        self._lowering.lowered.layout.declare(Tag(name, BOOL))
        return name

    def _statements(self, scope: str, name: str, statements: Sequence[Assignment]) -> str:
        """Lower statements as the next monitor; return its full name in capitals."""
        return self._add(scope, Routine(name, (), statements=tuple(statements)))

    def _add(self, scope: str, routine: Routine) -> str:
        """Lower a routine as the next monitor; return its full name in capitals."""
        self._lowering.enter(scope)
        self._lowering.routine(routine)
        full = scoped(scope, routine.name).upper()
        self.routines.append(full)
        return full

    def refusal(self, error: BuildError) -> LadderError:
        """Return the error for a program that can't be built with its monitors; it names the claims."""
        lines = []
        for problem in error.problems:
            claim = self._claims.get(problem.site.routine.upper())
            place = _claim_name(claim) + f": {claim.text}" if claim else problem.where
            lines.append(f"{place}: {problem.text}; {problem.remedy}")
        return LadderError("\n".join(lines), *(mistake.site for mistake in error.problems))


def _with_latches(text: str, latch: Callable[[str], str]) -> str:
    """Replace each `old(...)` in a condition with the result of `latch` for its content."""
    pieces, begin = [], 0
    for match in _OLD.finditer(text):
        if match.start() < begin:
            raise LadderError("old(...) in old(...): name one value")
        end = text.find(")", match.end())
        if end < 0:
            raise LadderError("old( has no closing parenthesis")
        pieces += [text[begin : match.start()], latch(text[match.end() : end].strip())]
        begin = end + 1
    return "".join([*pieces, text[begin:]])


_FILE_BIT = re.compile(r"(?<![\w:.])[A-Za-z]{1,2}\d{0,3}/\d+", re.ASCII)
"""A bit numbered within a whole data file, such as `B3/17`."""

_OLD = re.compile(r"\bold\s*\(", re.IGNORECASE)


def _claim_name(claim: Claim) -> str:
    """Return the name of a claim for errors, with its location if it is in the program."""
    place = f"{claim.site.where}: " if claim.site.routine else ""
    return f"{place}property {claim.name!r}" if claim.name != claim.sentence else f"{place}prove"


def _claim_of(routine: Routine, index: int, rung: Rung) -> Claim:
    """Return the claim of one rung in a NEVER routine."""
    origin = rung.origin
    site = Site(program_of(routine.name), routine.name, index, file=origin.file, line=origin.line or None)
    lines = rung.comment.splitlines()
    name = lines[0].strip() if lines else f"{_short(routine.name)} rung {index}"
    return Claim(name, ClaimKind.NEVER, str(rung), scope=program_of(routine.name), site=site)


def _short(routine: str) -> str:
    """Return a routine's name without the program's name."""
    return routine.rpartition(".")[2]


def _is_bit(lowering: Lowering, address: Address) -> bool:
    """Return whether an address is a bit or a BOOL; False if it can't be resolved."""
    try:
        place = lowering.resolver.address(address)
    except AddressError:
        return False  # the problem is in the routine itself
    return isinstance(place, Place) and (place.bit is not None or place.type.is_bool)


def _is_fixed_bit(place: Place) -> bool:
    return place.bit is None or isinstance(place.bit, Constant)
