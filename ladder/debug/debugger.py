"""The debugger: breakpoints, forces, rung drawings and causes for a running program."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds

from ..compiler.observed import LineKey
from ..lowering.runnable import LadderLogic
from ..model.errors import LadderError
from ..model.operands import FAULT, Constant, Group, Place
from ..model.resolver import Resolver, address_in
from ..model.routine import Routine
from ..model.tags import program_of
from ..run.edit import Edit, carry_over
from ..run.engine import STEP_MS
from ..run.view import Tags
from ..state.memory import Value, same
from ..state.snapshots import restore
from ..state.tag_images import TagImages
from ..state.values import checked
from .causes import Causes
from .cells import cell_of
from .chains import Chains
from .chart_waits import waits_of
from .crossref import CrossReference
from .executed import TracedEngine
from .forces import Force
from .inquiry import Inquiry
from .journal import MOST, Journal, RecordedPast
from .links import CauseLink
from .remedies import Remedies, of_input
from .replay import Replayer, Truths, image_bytes, input_leaves, repeat
from .rung_values import with_values
from .stretch import ScanInputs, Write
from .trials import Name, Trials, terminal
from .watched import Change, shown
from .watching import WatchedEngine

When = Literal["true", "changes", "executes"]
"""The event that triggers a breakpoint on a rung."""

_MET: Mapping[str, Callable[[bool | None, bool], bool]] = {
    "true": lambda before, now: now and before is False,
    "changes": lambda before, now: before is not None and now != before,
    "executes": lambda _before, now: now,
}
"""Returns whether a breakpoint is met, given the previous (None if unknown) and current truth of its rung."""

Condition = Callable[["Debugger"], Any] | str
"""A condition that ends a run: a function of the debugger, or the address of a bit."""

PICTURED = 100
"""Number of scans after a query that note the power of all rungs: one second in most programs."""


@dataclass(frozen=True, slots=True)
class BreakpointStop:
    """A breakpoint that was met."""

    scan: int  # number of the scan, from 0
    now_ns: int  # virtual time of the scan
    text: str  # the breakpoint and the event

    def __str__(self) -> str:
        return f"scan {self.scan:,}, {seconds(self.now_ns)} s: {self.text}"


class Debugger:
    """A ladder program under observation; like the program itself, it can be called as the logic of a rack.

    It runs compiled, applies forces, and notes the power of rungs with breakpoints. A query about a scan runs
    the scan again, see `journal`. After `truth`, the power of all rungs is noted for `PICTURED` scans. A
    program with Python routines is always interpreted, because these routines can have their own state.
    Breakpoints stop the program after a scan; a scan always runs to its end, as in a controller.

    Attributes:
        interpreted: whether every scan is interpreted, which is true if there are Python routines.
        stops: the breakpoints met in the latest scan.
        ran: always empty; the power of rungs shows which rungs ran.
        latest: the inputs of the latest scan; None before the first scan, or after a scan that was not
            remembered and had no external writes.
        news: number of changes to `latest` and to forces so far.
        edits: online edits, each with the number of the first scan after the edit.
        on_edit: called after each online edit.
        images: the tags as bytes; an edit replaces this object.
        on_outside: called after a tag was set, forced or released between scans.

    Args:
        remembered: maximum snapshots of the memory, one per `journal.EVERY` scans. With 0, scans are
            remembered only while there are breakpoints on rungs.

    Raises:
        BuildError: the program can't be built.
    """

    ran: tuple[int, ...] = ()

    def __init__(self, program: LadderLogic, *, remembered: int = MOST) -> None:
        self.stops: tuple[BreakpointStop, ...] = ()
        self.edits: list[tuple[int, Edit]] = []
        self.on_edit: Callable[[Edit], object] = lambda _edit: None
        self.on_outside: Callable[[], object] = lambda: None
        self._remembered = remembered
        self.latest: ScanInputs | None = None
        self.news = 0
        self._on_rungs: dict[tuple[LineKey, When], bool | None] = {}  # breakpoints: latest truth, if known
        self._on_tags: dict[str, Any] = {}  # breakpoints: latest value
        self._lines: tuple[LineKey, ...] = ()  # lines of `note_lines`
        self._pictured: int | None = None  # scan of the latest `note_power`
        self._attach(program, WatchedEngine(program.build(), program.scanner))
        self._forces: dict[str, tuple[Place, Value]] = {}  # by tag
        self._cross_reference: CrossReference | None = None
        self._truths: Truths = {}  # cached power of all rungs
        self._truths_of: int | None = None  # number of scans at which it was cached

    def _attach(self, program: LadderLogic, engine: WatchedEngine) -> None:
        """Attach to a program; snapshots begin with its next scan."""
        self.program, self._engine = program, engine
        self.interpreted = bool(program.functions)
        self._journal: Journal | RecordedPast = Journal(max(1, self._remembered))
        self._replayer: Replayer | None = None
        self._images = [engine.memory.cells[leaf.ident] for leaf in input_leaves(engine.memory)]
        self._outside: list[Write] = []
        engine.memory.outside = self._outside
        engine.memory.on_outside = lambda: self.on_outside()
        self._journal.begin(engine.memory, engine.scans)
        self._resolver = Resolver(engine.lowered.layout)
        self._cross_reference = None
        self._truths_of = None
        self.images = TagImages(engine.memory)
        self._update_plain()

    def _update_plain(self) -> None:
        """Set `_plain`: whether scans without external writes can run uninstrumented."""
        self.news += 1
        copies = self._engine.lowered.written_inputs
        observed = self._on_rungs or self._on_tags or self._lines or self._pictured is not None
        self._plain = not (self._remembered or self.interpreted or copies or observed)

    def edit(self, program: LadderLogic) -> Edit:
        """Continue with an edited program between two scans, as an online edit; see `carry_over`.

        Breakpoints, forces of removed tags, and remembered scans are cleared.

        Raises:
            BuildError: the edited program can't be built; the current one continues.
        """
        engine = WatchedEngine(program.build(), program.scanner)
        edit = carry_over(self._engine, engine)
        engine.scans = self._engine.scans
        forces, self._forces = self.forces, {}
        self._lines = ()
        self.clear_breakpoints()
        self._attach(program, engine)
        for tag, value in forces.items():
            if tag in self.tags:
                self.force(tag, value)
        if len(self._forces) < len(forces):
            self.on_outside()
        self.edits.append((engine.scans, edit))
        self.on_edit(edit)
        return edit

    # --- running

    @property
    def engine(self) -> WatchedEngine:
        """The current engine; an edit replaces it."""
        return self._engine

    @property
    def tags(self) -> Tags:
        """The tags by name."""
        return self._engine.tags

    @property
    def scans(self) -> int:
        """The number of scans so far."""
        return self._engine.scans

    @property
    def now_ns(self) -> int:
        """Virtual time of the latest scan, ns."""
        return self._engine.now_ns

    def store(self, tag: str, offset: int, data: bytes, keep: bytes = b"") -> None:
        """Set bytes of a tag, except the bits in `keep`, see `TagImage.write`."""
        self.images.write(tag, offset, data, keep)

    def __call__(self, scan: Any) -> None:
        """Run the logic of one scan of a rack, see `Engine`; the scan has the rack's number."""
        engine = self._engine
        engine.attach(scan)
        if scan.number > engine.scans:
            self._rest_until(scan.number)
        self._run_scan(scan.now_ns, scan.first)

    def _rest_until(self, scan: int) -> None:
        """Count scans that did not run the program: in program mode, or before the start of a recording."""
        engine, rests = self._engine, ScanInputs(self._engine.now_ns, False, None)
        keeps = bool(self._remembered or self._on_rungs)
        if not engine.scans or not keeps:
            engine.scans = scan
            self._journal.restart(engine.memory, scan)
            return
        while engine.scans < scan:
            self._journal.note(rests)
            engine.scans += 1
            self._journal.begin(engine.memory, engine.scans)

    def follow(self, scans: Iterable[ScanInputs]) -> Iterator[None]:
        """Run recorded scans without a rack and yield after each scan; forces and breakpoints do not apply.

        A fault ends a scan, as in the recording.
        """
        engine, journal = self._engine, self._journal
        images = image_bytes(engine.memory)
        engine.memory.outside = None
        engine.note(())
        for scan in scans:
            journal.note(scan)
            repeat(engine, images, scan)
            journal.begin(engine.memory, engine.scans)
            yield
        engine.memory.outside = self._outside
        self.news += 1

    def go_to(self, past: RecordedPast, scan: int) -> None:
        """Continue from the snapshot before a scan in a recorded past, which becomes the program's past."""
        restore(self._engine.memory, past.snapshot(scan)[0])
        self._engine.scans, self._journal, self._replayer = scan, past, None

    def start_again(self, values: Mapping[str, Any]) -> None:
        """Set the program to the values before its first scan, and forget all scans."""
        restore(self._engine.memory, values)
        self._engine.scans, self._journal, self._replayer = 0, Journal(max(1, self._remembered)), None
        self._journal.begin(self._engine.memory, 0)

    def scan(self, scans: int = 1, ms: float = STEP_MS) -> tuple[BreakpointStop, ...]:
        """Run at most `scans` scans without a rack, `ms` apart; return the breakpoints that were met."""
        for _ in range(scans):
            first = self.scans == 0
            self._run_scan(0 if first else self.now_ns + round(ms * 1_000_000), first)
            if self.stops:
                break
        return self.stops

    def _run_scan(self, now_ns: int, first: bool) -> None:
        """Run one scan, uninstrumented if nothing is observed and nothing was written from outside."""
        engine, outside = self._engine, self._outside
        if outside or not self._plain:
            self._run_observed_scan(engine, now_ns, first=first)
            return
        memory = engine.memory
        self.latest, self.stops, memory.outside = None, (), None
        try:
            engine.do(now_ns, first)
        finally:
            memory.outside = outside

    def _run_observed_scan(self, engine: WatchedEngine, now_ns: int, *, first: bool) -> None:
        """Run one scan: note power, remember its inputs, and evaluate the breakpoints after it."""
        engine.watching = self.interpreted
        self._note_power(engine)
        writes = tuple(self._outside)
        forces, keeps = engine.memory.forces, bool(self._remembered or self._on_rungs)
        self.news += 1
        images = tuple([bytes(cell.cell_contents) for cell in self._images])
        self.latest = ScanInputs(now_ns, first, images, writes, forces)
        if keeps:
            self._journal.note(self.latest)
        engine.memory.outside = None
        try:
            engine.do(now_ns, first=first)
        finally:
            self._outside.clear()
            engine.memory.outside = self._outside
            if keeps:
                self._journal.begin(engine.memory, engine.scans)
        self._evaluate_breakpoints()

    def _note_power(self, engine: WatchedEngine) -> None:
        """Record the power of rungs with breakpoints, and of all rungs for a while after a query."""
        if self._pictured is not None:
            if self.scans - self._pictured <= PICTURED:
                engine.note_all()
                return
            self._pictured = None
            self._update_plain()
        engine.note(tuple(dict.fromkeys((*self._lines, *(line for line, _when in self._on_rungs)))))

    def run_until(self, condition: Condition, limit: int, ms: float = STEP_MS) -> bool:
        """Run scans without a rack until a condition, breakpoint or limit; return the final condition."""
        for _ in range(limit):
            if self.scan(1, ms) or self._is_met(condition):
                break
        return self._is_met(condition)

    def _is_met(self, condition: Condition) -> bool:
        return bool(self.tags[condition] if isinstance(condition, str) else condition(self))

    # --- breakpoints

    def note_lines(self, lines: Iterable[LineKey]) -> None:
        """Note the power of these lines in every scan until an edit, as with breakpoints."""
        self._lines = tuple(lines)
        self._update_plain()

    def break_at(self, routine: str, rung: int, when: When = "true") -> None:
        """Set a breakpoint on a rung, or on a line of structured text.

        Args:
            rung: number of the rung, or of the line.
            when: `true` stops when power reaches the rung's last instruction and did not in the previous
                scan; for a line, when it runs with a true condition and did not in the previous scan.
                `changes` stops on a change in either direction, and `executes` in every scan that executes
                the rung or line.

        Raises:
            LadderError: the rung does not exist.
        """
        self._routine(routine).numbered(rung)
        if not self._remembered and not self._on_rungs:  # no scan was kept before the first breakpoint
            self._journal.restart(self._engine.memory, self.scans)
        line = routine.upper(), rung
        initial = None if when == "changes" else False  # None: the first value is not a change
        self._on_rungs[line, when] = initial
        self._update_plain()

    def break_on(self, tag: str) -> None:
        """Set a breakpoint on a tag's change between scans; raise a LadderError for an unknown tag."""
        self._on_tags[tag] = self.tags[tag]
        self._update_plain()

    def remove_breakpoint(self, at: str, rung: int | None = None, when: When = "true") -> None:
        """Remove one breakpoint; the others keep their state.

        Args:
            at: the routine of `break_at`, or the tag of `break_on`.
            rung: number of the rung or line; None for a breakpoint on a tag.
            when: as in `break_at`.

        Raises:
            KeyError: the breakpoint does not exist.
        """
        if rung is None:
            del self._on_tags[at]
        else:
            del self._on_rungs[(at.upper(), rung), when]
        self._update_plain()

    def clear_breakpoints(self) -> None:
        """Remove all breakpoints."""
        self._on_rungs.clear()
        self._on_tags.clear()
        self._update_plain()

    def _evaluate_breakpoints(self) -> None:
        """Set `stops` to the breakpoints that the latest scan met; remember its truths and values."""
        if not self._on_rungs and not self._on_tags:
            self.stops = ()
            return
        stops = []
        for (line, when), previous in self._on_rungs.items():
            current = line in self._noted_truths() if when == "executes" else self._is_true(line)
            self._on_rungs[line, when] = current
            if _MET[when](previous, current):
                stops.append(self._stop_text(line, runs=when == "executes", true=current))
        for tag, previous in self._on_tags.items():
            value = self.tags[tag]
            if not same(value, previous):
                self._on_tags[tag] = value
                stops.append(f"{tag} was {shown(previous)} and is {shown(value)}")
        engine = self._engine
        self.stops = tuple([BreakpointStop(engine.scans - 1, engine.now_ns, text) for text in stops])

    def _is_true(self, line: LineKey) -> bool:
        """Return whether power reached the end of a line in the latest scan."""
        engine = self._engine
        if not engine.watching and not engine.broken_off:
            return engine.true_at_end(line)
        truth = self._noted_truths().get(line, ())
        return bool(truth) and truth[-1]

    def _stop_text(self, line: LineKey, *, runs: bool, true: bool) -> str:
        """Return the text of a breakpoint on a rung or line, which says whether it is true or runs."""
        routine, rung = self._routine(line[0]), line[1]
        verb = "is true" if true else "is not true"
        if runs or (true and routine.statements is not None):
            verb = "runs"
        return f"{routine.name}, {routine.unit} {rung} {verb}: {routine.numbered(rung)}"

    # --- forces

    def force(self, tag: str, value: object) -> None:
        """Force a tag to a value, even if the program writes it, until `unforce`.

        Args:
            tag: a single value, or the fault of a connection. Force images at the CPU instead, which records
                the force.
            value: a value of the tag's type.

        Raises:
            ValueError: the tag does not exist, is an image or is not a single value, or the value does not
                fit.
        """
        place = self._single_place(tag)
        forced_value, name = checked(tag, place.type, value), self._forced_name(tag)
        self._forces.pop(name, None)
        self._forces[name] = place, forced_value
        self._apply_forces()
        if place.leaf.slot is None:
            self.tags[tag] = value
        else:
            self._engine.memory.write(place.leaf, 0, self._engine.memory.read(place.leaf))

    def _apply_forces(self) -> None:
        """Set the engine's forces; several forced bits of a value are combined into one force."""
        forces: dict[tuple[str, int], Force] = {}
        for place, value in self._forces.values():
            cell = cell_of(place)
            key, mask = (cell.leaf.ident, cell.index), cell.mask
            if mask is None:
                forces[key] = None, value
            else:
                forced, bits = forces.get(key, (0, 0))
                forces[key] = (forced or 0) | mask, int(bits) & ~mask | (mask if value else 0)
        self.news += 1
        self._engine.hold(forces)

    def unforce(self, tag: str | None = None) -> None:
        """Release one force, or all; tags keep their values. Raise a ValueError if the tag is not forced."""
        if tag is None:
            self._forces.clear()
        else:
            name = self._forced_name(tag) if tag in self.tags else tag
            if name not in self._forces:
                forced = ", ".join(self._forces) or "none"
                raise ValueError(f"{tag} is not forced; current forces: {forced}")
            del self._forces[name]
        self._apply_forces()
        self.on_outside()

    @property
    def forces(self) -> dict[str, Value]:
        """The forced tags and their values."""
        return {name: value for name, (_place, value) in self._forces.items()}

    def _forced_name(self, tag: str) -> str:
        """Return the key of a tag in `_forces`: the address in an image, or the full name."""
        return address_in(self._resolver, tag) or self._resolver.base_name(tag)

    def _single_place(self, tag: str) -> Place:
        """Return the place of a tag to force; raise a ValueError for an image or several values."""
        place = self._resolver.named(tag)
        if isinstance(place, Group) or place.can_fault:
            raise ValueError(f"{tag} is not a single value with constant subscripts; force single values")
        if place.leaf.is_image:
            raise ValueError(f"{tag} is an image; force it at the CPU, which records forces")
        return place

    def address_of(self, tag: str) -> str | None:
        """Return the address of the image word or bit that a tag names; None for any other name."""
        address = address_in(self._resolver, tag)
        return None if address is None or FAULT in address else address

    # --- power and causes

    def truth(self, routine: str) -> list[tuple[bool, ...] | None]:
        """Return the power in a routine's rungs in the latest scan.

        Returns:
            For each rung the power after each instruction, in order of execution; None if the rung was not
            scanned. For each line of structured text, by number, whether it was true; None if it did not run.

        Raises:
            LadderError: the routine does not exist.
        """
        name = self._routine(routine).name.upper()
        truths = self._latest_truths() if self.scans else {}
        numbers = self._routine(routine).numbers
        return [truths.get((name, number)) for number in range(max(numbers, default=-1) + 1)]

    def note_power(self) -> None:
        """Note the power of all rungs in the next `PICTURED` scans, as every call to `truth` does."""
        self._pictured = self.scans

    def _latest_truths(self) -> Truths:
        """Return the power of all rungs in the latest scan; repeat the scan if its power was not noted.

        The power of all rungs is noted in the next `PICTURED` scans.
        """
        self.note_power()
        self._update_plain()
        if self._truths_of != self.scans:
            if self._engine.watching or self._engine.notes_all:
                self._truths = self._noted_truths()
            else:
                self._past.again(self.scans - 1, noted=True)
                self._truths = self._past.truths
            self._truths_of = self.scans
        return self._truths

    def _noted_truths(self) -> Truths:
        """Return the power noted in the latest scan; if a compiled scan faulted, run it again."""
        engine = self._engine
        if not engine.broken_off or engine.watching:
            return engine.truths
        self._past.again(self.scans - 1)
        return self._past.truths

    @property
    def replayer(self) -> Replayer:
        """The replayer, which repeats remembered scans in separate memory."""
        return self._past

    @property
    def _past(self) -> Replayer:
        """The replayer of the remembered scans, created when it is first needed."""
        if self._replayer is None:
            engine = TracedEngine(self._engine.lowered, self.program.scanner)
            engine.variants = self._engine.variants
            self._replayer = Replayer(engine, self._journal)
        return self._replayer

    def picture(self, routine: str, rungs: Sequence[int] | None = None, width: int = 96) -> str:
        """Draw a routine in box characters; wires with power in the latest scan are heavy."""
        from ..draw import captions_of, routine_text  # imported here: most runs draw nothing

        captions = captions_of(self.program)
        return routine_text(self.routine_now(routine), width, self.truth(routine), rungs, captions)

    def svg(self, width: int = 96) -> str:
        """Return all routines as an SVG document, with the power of the latest scan."""
        from ..draw import captions_of, routines_svg  # imported here: most runs draw nothing

        routines = [(self.routine_now(routine.name), routine.numbers) for routine in self.program.routines]
        truths = {routine.name: self.truth(routine.name) for routine in self.program.routines}
        return routines_svg(routines, width, truths, captions_of(self.program))

    def routine_now(self, routine: str) -> Routine:
        """Return a routine with the current PRE and ACC of timers and counters."""
        stored = self._routine(routine)
        return with_values(stored, self._engine.tags_of(program_of(stored.name)), self.program.builtin)

    @property
    def cross_reference(self) -> CrossReference:
        """Return the cross reference of the program."""
        if self._cross_reference is None:
            self._cross_reference = CrossReference(self._engine.lowered)
        return self._cross_reference

    def last_change(self, tag: str) -> Change | None:
        """Return the last remembered change in a tag, see `Inquiry.last_change`."""
        return self._inquiry.last_change(tag)

    def why(self, tag: str) -> str:
        """Return the cause of a tag's value, see `Inquiry.why`."""
        return self._inquiry.why(tag)

    def waits(self, tag: str) -> list[str]:
        """Return the conditions that begin or end a step of a chart; [] for any other tag."""
        return list(waits_of(self._engine.lowered, self.tags, self._resolver.named(tag)))

    def chains(self, *, deep: bool = False, **hooks: Any) -> Chains:
        """Return a builder of chains of causes; `hooks` are other arguments of `Chains`."""
        return Chains(self._engine.lowered, Causes(self._past), deep, **hooks)

    def chain(self, tag: str, *, deep: bool = False) -> CauseLink | None:
        """Return the chain of causes of a tag's value; None if it has not changed, see `Chains.of_tag`."""
        return self.chains(deep=deep).of_tag(tag, self._journal.latest)

    def suggest_inputs(
        self, tag: str, requested: object = None, *, scans: int = 10, name: Name = terminal
    ) -> Remedies:
        """Return the smallest sets of inputs that set a tag to a value within `scans` scans, see `remedies`.

        Args:
            requested: the value, of the tag's type; for a bit, the default is the opposite of its value.
            name: names the terminals of input images.

        Raises:
            ValueError: the tag is unknown or not a single value, or the requested value does not fit.
        """
        place = self._resolver.named(tag)
        if not isinstance(place, Place):
            raise ValueError(f"{tag} is not a single value; ask about one of its members or elements")
        if requested is None and not place.type.is_bool:
            raise ValueError(f"{tag} is of type {place.type.name}; give the value that it should have")
        value = not self.tags[tag] if requested is None else checked(tag, place.type, requested)
        if place.leaf.is_input:
            return of_input(tag, value, _terminal_of(place, name))
        trials = Trials(self._engine, self._past, self.cross_reference, name, scans)
        return trials.remedies_for(tag, cell_of(place), value)

    def cause(self, tag: str) -> tuple[int, str] | None:
        """Return the cause of a tag's last change, see `Inquiry.cause`."""
        return self._inquiry.cause(tag)

    @property
    def _inquiry(self) -> Inquiry:
        return Inquiry(self._engine, self._past, self._journal.latest, self._forces, self.cross_reference)

    def _routine(self, name: str) -> Routine:
        """Return a routine by its name in any case; raise a LadderError if there is none."""
        for routine in self.program.routines:
            if routine.name.upper() == name.upper():
                return routine
        names = ", ".join(routine.name for routine in self.program.routines)
        raise LadderError(f"no routine {name}; choose from {names}")


def _terminal_of(place: Place, name: Name) -> str | None:
    """Return the place of a terminal in the rack; None for other values of a module, such as a fault."""
    word, slot = place.fixed_index, place.leaf.slot
    if not place.leaf.is_image or word is None or slot is None:
        return None
    return name(slot, word, int(place.bit.value) if isinstance(place.bit, Constant) else None)
