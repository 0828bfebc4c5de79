"""A rack under test."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from collections.abc import Sequence as SequenceOf
from types import TracebackType
from typing import Any, Protocol, Self, runtime_checkable

from ...io_images.addresses import parse_address
from ...ladder.debug import CauseLink, Remedies
from ...ladder.python.online import Fields, edit_logic
from ...ladder.python.sequences import Logic, Sequence
from ...runtime.config.quantities import parse_duration
from ...runtime.config.rackspec import RackSpec
from ...runtime.loop.events import Event
from ...runtime.loop.listeners import ScanListener
from ...runtime.loop.pace import Watchdog
from ...runtime.loop.rack import Rack, Slots
from ...runtime.loop.scan import CpuMode, ScanLogic
from ..load.building import build_cpu, build_rack
from ..record.sequence_watch import WatchesSequences, sequences_in, standing, watching
from ..record.tag_names import named_values, namespace_of
from ..run.editing import tags_in
from ..run.external_tags import tell_cpu
from ..why.answer import Why
from ..why.journal import Journal
from ..why.source.class_names import Names
from ..why.traced_run import Load
from .event_log import EventLog
from .slot import SlotBench


class NotReachedError(AssertionError):
    """A condition that did not come true in time; the message shows the bench.

    Attributes:
        tags: the tags that the condition read.
    """

    def __init__(self, text: str, tags: Iterable[str] = ()) -> None:
        super().__init__(text)
        self.tags = tuple(tags)


@runtime_checkable
class ObservedLogic(Protocol):
    """Logic with a debugger: a ladder program."""

    stops: tuple[Any, ...]
    on_edit: Callable[[Any], object]

    @property
    def tags(self) -> Any:
        """The tags by name."""

    def why(self, tag: str) -> str:
        """Explain the present value of a tag."""

    def force(self, tag: str, value: object) -> None:
        """Hold a tag at a value."""

    def unforce(self, tag: str | None = None) -> None:
        """Release a tag."""


Condition = Callable[["Bench"], Any] | str
"""The condition that ends a run: a function of the bench, or a tag that becomes true; of a rack with a Python
program, a bit of an image.
"""


class Bench:
    """A rack under test.

    Attributes:
        slot: the modules by slot number.
        told: the events, oldest first.
        recorder: what records it, if anything.
        read: the tags that `bench[tag]` was asked for since the latest scan, oldest first.

    Args:
        logic: the program; a ladder program under a debugger for tags, forces and `why`.
        listeners: makes further listeners of the rack, such as a recorder.
        watched: the rack's watchdog ends endless logic. Without it a test can stop at a breakpoint for
            any time.
        load: reloads a Python program, so that `why` can name its lines.
    """

    def __init__(
        self,
        spec: RackSpec,
        logic: ScanLogic,
        *,
        listeners: Callable[[Rack], Iterable[ScanListener]] = lambda _rack: (),
        watched: bool = False,
        load: Load | None = None,
    ) -> None:
        self.spec = spec
        self._load = load
        self.logic: Any = logic
        self._observed = isinstance(logic, ObservedLogic)
        if self._observed:
            self.program.on_edit = self._record_edit
        rack = build_rack(spec)
        self._events = events = EventLog()
        self.told = events.told
        self.recorder: ScanListener | None = None
        self.read: dict[str, None] = {}
        self._journal = Journal(rack)
        given = [*listeners(rack), watching(self._journal, logic)]
        self._followers = [each for each in given if isinstance(each, WatchesSequences)]
        self.cpu = events.cpu = build_cpu(
            spec,
            logic,
            rack,
            listeners=[*given, events],
            watchdog=None if watched else Watchdog(0),
        )
        if self._observed:
            tell_cpu(self.program, self.cpu)
        self.slot = Slots(
            (number, SlotBench(slot, self.run_for, lambda: self.now_ns))
            for number, slot in rack.slots.items()
        )

    # --- time

    @property
    def scans(self) -> int:
        """Number of scans so far."""
        return self.cpu.scan

    @property
    def now_ns(self) -> int:
        """Virtual time of the latest scan, ns since power-up; 0 before the first."""
        return max(self.cpu.now_ns - self.cpu.period_ns, 0)

    @property
    def now_s(self) -> float:
        """Virtual time of the latest scan, s since power-up."""
        return self.now_ns / 1e9

    @property
    def stops(self) -> tuple[Any, ...]:
        """The breakpoints that were met in the latest scan."""
        return self.logic.stops if self._observed else ()

    def scan(self, scans: int = 1) -> None:
        """Run scans; a breakpoint that is met ends the run.

        Raises:
            CpuFault: the program faults the CPU.
        """
        self._run(scans, lambda: self.stops)

    def _run(self, scans: int, over: Callable[[], object]) -> None:
        self._events.over = over
        try:
            self.cpu.run(scans)
        finally:
            self._events.over = bool
            self.read.clear()

    def run_for(self, time: str) -> None:
        """Run for a machine time with its unit, such as "2 s", rounded up to whole scans.

        Raises:
            ValueError: not a time.
            CpuFault: the program faults the CPU.
        """
        self.scan(-(-parse_duration(time) // self.cpu.period_ns))

    def run_until(self, condition: Condition, within: str = "10 s") -> None:
        """Run until a condition holds; do nothing if it already does.

        Args:
            condition: a function of the bench, or the address of a tag.

        Raises:
            NotReachedError: it does not hold in time; the message shows the bench.
            ValueError: `within` is not a time, or the tag is unknown.
            CpuFault: the program faults the CPU.
        """
        scans = -(-parse_duration(within) // self.cpu.period_ns)
        if not self._holds(condition):
            self._run(scans, lambda: self.stops or self._holds(condition))
        if not self.stops and not self._holds(condition):
            wanted = condition if isinstance(condition, str) else _name(condition)
            raise NotReachedError(f"{wanted} has not become true within {within}.\n{self}", self.read)
        self.read.clear()

    def _holds(self, condition: Condition) -> bool:
        return bool(self[condition] if isinstance(condition, str) else condition(self))

    def _in_image(self, address: str) -> int:
        place = parse_address(address, {slot.number: slot.words for slot in self.spec.slot})
        slot = self.slot[place.slot]
        word = (slot.inputs if place.image == "I" else slot.outputs)[place.word]
        return word if place.bit is None else word >> place.bit & 1

    def program_mode(self) -> None:
        """Turn the CPU's key to program: logic rests, outputs are not sent."""
        self.cpu.mode = CpuMode.PROGRAM

    def run_mode(self) -> None:
        """Turn the CPU's key to run."""
        self.cpu.mode = CpuMode.RUN

    # --- the program

    @property
    def program(self) -> Any:
        """The ladder program under its debugger: breakpoints, truth, pictures, cross reference.

        Raises:
            ValueError: the program is a Python function.
        """
        if not self._observed:
            raise ValueError("the program is a Python function: it has no tags and no rungs")
        return self.logic

    def edit(self, program: Any, restart: SequenceOf[str] = ()) -> Any:
        """Continue with an edited program from the next scan on, see `Debugger.edit` and `edit_logic`.

        The next scan is recorded with an event of kind "edit": new, changed and dropped tags or fields.

        Args:
            program: a ladder program, or an instance of a class of `Logic`.
            restart: sequences of a class of `Logic` that begin anew.

        Raises:
            ValueError: the program is a Python function, or it can't continue as the edited one.
        """
        if not isinstance(self.logic, Logic):
            return self.program.edit(program)
        if not isinstance(program, Logic):
            raise ValueError(f"{type(program).__name__} is not allowed: give an instance of a class of Logic")
        done = edit_logic(self.logic, program, restart)
        for each in self._followers:
            each.watch(sequences_in(self.logic))
        self._announce_edit(type(program).__name__, done)
        return done

    def _record_edit(self, edit: Any) -> None:
        self._announce_edit(self.logic.program.name, edit)

    def _announce_edit(self, name: str, edit: Any) -> None:
        self.cpu.announce(Event(self.now_ns, "edit", name, str(edit), {**tags_in(edit)}))

    def __getitem__(self, tag: str) -> Any:
        self.read[tag] = None
        if self._observed:
            return self.program.tags[tag]
        if self._is_image(tag):
            return self._in_image(tag)
        namespace = namespace_of(self.logic)
        (value,) = named_values(namespace, [tag])
        return eval(value.source, namespace)

    def __setitem__(self, tag: str, value: object) -> None:
        self._desk.tags[tag] = value

    @property
    def _desk(self) -> Any:
        """The tags or fields of the program, to be set and forced."""
        return Fields(lambda: self.logic) if isinstance(self.logic, Logic) else self.program

    def check(self, *tags: str) -> None:
        """Check tags and addresses before a run; ValueError for an unknown name."""
        for tag in tags:
            if self._observed and not self._is_image(tag):
                _ = self.program.tags[tag]
            elif not self._is_image(tag) and not self._is_declared(tag):
                named_values(namespace_of(self.logic), [tag])

    def _is_declared(self, name: str) -> bool:
        return Names(self.logic, {slot.number: slot.words for slot in self.spec.slot}).declares(name)

    def why(self, tag: str | None = None) -> str:
        """Explain a value: the scan and the rung or line that set it.

        A Python program is loaded again and runs on its recorded inputs; the scan in question is traced.
        The program on the bench is not touched.

        Args:
            tag: a tag of a ladder program, see `Debugger.why`; an address of an image; a value of a Python
                program, such as `line.step`. Left out: the condition that every module waits for, and the
                latest change of its output words.

        Raises:
            ValueError: an unknown name, or no scan has run.
        """
        if tag is not None and self._observed and (tag in self.program.tags or not self._is_image(tag)):
            return str(self.program.why(tag))
        asked = self._asked()
        return asked.rack() if tag is None else asked.of(tag)

    def chain(self, tag: str, *, deep: bool = False) -> CauseLink:
        """Return the chain of causes of a value, back to the first input, operator, incident or power-up.

        Args:
            tag: see `why`.
            deep: whether rungs of add-on instructions are links, too.

        Raises:
            ValueError: an unknown name, or no scan has run.
        """
        return self._asked().chain(tag, deep=deep)

    def what_would(self, tag: str, wanted: str | None = None, scans: int = 10) -> Remedies:
        """Return the smallest sets of inputs that would give a tag of a ladder program a value.

        Each set is found by running the program with it, on a copy, from the latest scan on.
        """
        return self._asked().what_would(tag, wanted, scans)

    def _asked(self) -> Why:
        recording = self._journal.recording()
        debugger = self.logic if self._observed else None
        return Why(recording, len(recording.scans) - 1, self.spec, self._load, debugger)

    def force(self, address: str, value: int) -> None:
        """Hold a bit or word of an image, a tag, or a field of a class of `Logic`, at a value.

        Forces of images are recorded.

        Raises:
            ValueError: an unknown name, or the value does not fit.
        """
        if self._is_image(address):
            self.cpu.forces.set(address, value)
        else:
            self._desk.force(address, value)

    def unforce(self, address: str) -> None:
        """Release a force; ValueError if it is not forced."""
        if self._is_image(address):
            self.cpu.forces.remove(address)
        else:
            self._desk.unforce(address)

    def _is_image(self, address: str) -> bool:
        try:
            parse_address(address, {slot.number: slot.words for slot in self.spec.slot})
        except ValueError:
            return False
        return True

    @property
    def sequences(self) -> Mapping[str, Sequence]:
        """The sequences of the program by name: `bench.sequences["cycle"].line`."""
        return {each.name: each for each in sequences_in(self.logic)}

    # --- events

    @property
    def rules(self) -> SequenceOf[str]:
        """Ids of the manual's rules that have fired, in their order."""
        return [each.name for each in self.told if each.kind == "rule"]

    def __str__(self) -> str:
        lines = [f"scan {self.scans}, {self.now_s:g} s", *map(str, self.slot.values())]
        lines += [str(standing(each, self.scans)) for each in self.sequences.values()]
        lines += [f"  {each}" for each in self.told[-5:]]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<Bench {self.spec.name!r}: scan {self.scans:,}, {self.now_s:g} s>"

    def _repr_html_(self) -> str:
        from .notebook import as_html

        return as_html(self)

    # --- the end

    def end_recording(self) -> None:
        """Complete the recording; further scans are not in it."""
        if self.recorder is not None:
            self.cpu.dismiss(self.recorder)

    def close(self) -> None:
        """Close all listeners; this completes a recording."""
        self.cpu.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _name(condition: Callable[..., Any]) -> str:
    name = str(getattr(condition, "__name__", "the condition"))
    return "the condition" if name == "<lambda>" else name
