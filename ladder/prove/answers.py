"""Decide claims. An answer has the verdict, and the scans that break the claim.

>>> from scanrack.ladder import BOOL, OTE, XIC, Program
>>> motor = Program("motor")
>>> left, right, fwd, rev = motor.declare("Left Right Fwd Rev", BOOL)
>>> @motor.routine
... def Main(rung):
...     rung(left, OTE(fwd))
...     rung(right, OTE(rev))
>>> print(motor.prove(never="Fwd AND Rev"))
refuted: never Fwd AND Rev
  scan 1: Left = 1, Right = 1
>>> bool(motor.prove(never="Fwd AND Rev", assume=["NOT (Left AND Right)"]))
True
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from ..lowering.runnable import LadderLogic
from ..model.errors import LadderError
from ..model.tags import Layout
from ..state.memory import element_text
from .advice import advice
from .algebra.meaning import BOOL
from .algebra.terms import T, and_
from .claims import Claim, ClaimKind
from .contracts import KeptBy
from .induction import Limits, Verdict, VerdictKind, prove
from .monitors import MonitoredProgram, WatchedClaim, monitored, why_broken
from .replaying import ScanOf, done_by
from .smallest import smallest
from .system import Key, ProgramSystem, ScanBounds
from .system.events import PROGRAM_MODE, assumed

LIMITS = Limits()

KEY_TEXT = "the key was turned to program and back to run"
"""Scenario text for a scan that follows a change to program mode and back to run."""

AGAIN_TEXT = "the run ended, and the next run began with its tags"
"""Scenario text for the first scan of a run with retained tags."""

REACHED = "reached"
"""The verdict on a `reachable` claim whose condition becomes true in some run."""


@dataclass(frozen=True, slots=True)
class ScenarioStep:
    """A scan of a scenario; for `turned` and `again`, see `ScanOf`."""

    ms: float  # time since the previous scan
    changes: tuple[tuple[str, Any], ...]  # inputs that change before it: tag and value
    turned: bool = False
    again: bool = False

    def __str__(self) -> str:
        return self.text([value_text(name, value) for name, value in self.changes])

    def text(self, changes: Sequence[str]) -> str:
        """Return the scan as text; `changes` describes the inputs that change."""
        phrases = [f"{self.ms:,} ms later"] if self.ms else []
        phrases += [KEY_TEXT] * self.turned + [AGAIN_TEXT] * self.again
        return ", ".join([*phrases, *changes]) or "power-up"


@dataclass(frozen=True)
class Answer:
    """The answer to a claim. It is true if the claim is proved or reached.

    Attributes:
        claim: the claim.
        verdict: the verdict on the claim's condition (see `induction`); for `reachable`, refuted means
            reached.
        scans: the run that breaks or reaches the claim, confirmed on the compiled program; see `smallest`.
        steps: the same scans with tag names in place of keys.
        end: reasons why the run ends, such as a major fault or a condition that can't be computed.
        held: numbers that nothing writes, with the values that the proof assumes.
        assumed: the other assumptions, one sentence each.
        deciding: number of values on which the claim depends.
        tags: number of values of the program.
    """

    claim: Claim
    verdict: Verdict
    scans: tuple[ScanOf, ...]
    steps: tuple[ScenarioStep, ...]
    held: tuple[tuple[str, Any], ...]
    assumed: tuple[str, ...]
    deciding: int
    tags: int
    advice: str = ""  # advice if the verdict is unknown
    end: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return self.word in (VerdictKind.PROVED, REACHED)

    @property
    def word(self) -> str:
        """The verdict as a word: proved (for `reachable`, reached), refuted or unknown."""
        kind = self.verdict.kind
        if self.claim.kind is not ClaimKind.REACHABLE or kind is VerdictKind.UNKNOWN:
            return kind
        return REACHED if kind is VerdictKind.REFUTED else VerdictKind.REFUTED

    def __str__(self) -> str:
        lines = [f"{self.word}: {self.claim.sentence}"]
        lines += [f"  scan {number}: {step}" for number, step in enumerate(self.steps, start=1)]
        lines += [f"  {line}" for line in (*self.end, *self.verdict.blame)]
        lines += [f"  to do: {self.advice}"] if self.advice else []
        return "\n".join(lines)

    __repr__ = __str__


def answer(
    problem: ProgramSystem, program: MonitoredProgram, watched: WatchedClaim, limits: Limits = LIMITS
) -> Answer:
    """Decide a watched claim about a program. Any run in the answer is confirmed; see `smallest`."""
    with _assuming(problem, watched.assume):
        bad = problem.after(watched.bit)
        cone = problem.cone([bad, problem.narrowed([bad])])
        verdict = prove(problem, watched.bit, limits)
        bits = problem.assume
    modules = [contract for contract in problem.settings["contracts"] if isinstance(contract, KeptBy)]
    scans = verdict.scans and smallest(program.program, verdict.scans, watched.bit, bits, modules)
    assumed_claims = [Claim("", ClaimKind.ASSUME, text) for text in watched.claim.assume]
    layout = problem.lowered.layout
    held_values = sorted(
        (number.named(tag_text(layout, number.key)), number.value) for number in verdict.held
    )
    assumptions = [assumption.text for assumption in (*program.assumptions, *assumed_claims)]
    return Answer(
        watched.claim,
        verdict,
        scans,
        steps=tuple(steps_of(layout, scans)),
        held=tuple(held_values),
        assumed=(*assumed(problem.happens), *assumptions),
        deciding=sum(name in problem.key_of for name in cone),
        tags=len(problem.machine.vars),
        advice=advice(verdict.blame, _numbers_in(problem, cone)),
        end=tuple(_end_of(program.program, scans, watched.bit)),
    )


def _end_of(program: LadderLogic, scans: Sequence[ScanOf], bit: Key) -> Iterator[str]:
    """Yield a sentence if a run ends with a fault or a condition that can't be computed."""
    if not scans:
        return
    engine, fault = done_by(program, scans)
    if fault is not None:
        yield f"the processor stops in this scan: {fault}"
    if reason := why_broken(engine, bit):
        yield f"the condition can't be computed: {reason}"


def _numbers_in(problem: ProgramSystem, cone: Mapping[str, T]) -> list[str]:
    """Return the tags of the changing numbers that decide a claim, most direct first."""
    layout, numbers = problem.lowered.layout, []
    for name, variable in cone.items():
        key = problem.key_of.get(name)
        if key is not None and variable.kind != BOOL and name in problem.next and "~" not in key[0]:
            numbers.append(tag_text(layout, key))
    return numbers


def ask(
    program: LadderLogic,
    *,
    never: str = "",
    always: str = "",
    reachable: str = "",
    assume: Sequence[str] = (),
    free: Sequence[str] = (),
    written_outside: Sequence[str] = (),
    scan_ms: tuple[float, float] = (1, 1000),
    happens: Sequence[str] = (PROGRAM_MODE,),
    limits: Limits = LIMITS,
) -> Answer:
    """Decide one claim about a program without a rack; see `LadderLogic.prove`."""
    claims = {"never": never, "always": always, "reachable": reachable}
    given_claims = [(ClaimKind(kind), text) for kind, text in claims.items() if text]
    if len(given_claims) != 1:
        raise LadderError(f"give exactly one of {', '.join(claims)}, not {len(given_claims)} of them")
    kind, text = given_claims[0]
    claim = Claim(f"{kind} {text}", kind, text, tuple(assume))
    watched = monitored(program, [claim])
    problem = ProgramSystem(
        watched.program,
        ScanBounds.of(*scan_ms),
        free=free,
        written_outside=written_outside,
        assume=watched.assume,
        happens=happens,
    )
    watched_property = next(entry for entry in watched.properties if entry.claim is claim)
    return answer(problem, watched, watched_property, limits)


@contextmanager
def _assuming(problem: ProgramSystem, bits: Sequence[Key]) -> Iterator[None]:
    """In the body of a `with`, assume that bits are true after each scan."""
    saved = problem.contract, problem.assume
    try:
        for bit in bits:
            problem.contract = and_(problem.contract, problem.after(bit))
        problem.assume = (*problem.assume, *bits)
        yield
    finally:
        problem.contract, problem.assume = saved


def steps_of(layout: Layout, scans: Sequence[ScanOf]) -> Iterator[ScenarioStep]:
    """Yield the scans of a run, with tag names in place of keys."""
    for scan in scans:
        changes = tuple((tag_text(layout, key), value) for key, value in sorted(scan.inputs.items()))
        yield ScenarioStep(scan.ms, changes, scan.turned, scan.again)


def tag_text(layout: Layout, key: Key) -> str:
    """Return the address of a value in the program's notation."""
    leaf = layout.leaf(key[0])
    return element_text(leaf.path, leaf.dims, key[1]) if leaf.dims else leaf.path


def value_text(name: str, value: Any) -> str:
    """Return a value as a scenario shows it.

    >>> value_text("Run", True), value_text("Level", 2.5)
    ('Run = 1', 'Level = 2.5')
    """
    if isinstance(value, float):
        return f"{name} = {value:g}"
    return f"{name} = {int(value) if isinstance(value, bool) else value}"
