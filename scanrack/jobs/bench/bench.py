"""The bench: a rack under test."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from collections.abc import Sequence as SequenceOf
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol, Self, runtime_checkable

from scanrack.io_images.addresses import Address, parse_address
from scanrack.io_images.times import parse_duration, seconds
from scanrack.ladder.debug import CauseLink, Remedies
from scanrack.ladder.python.online.fields import Fields
from scanrack.ladder.python.sequences import Logic, Sequence
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.actions import Edit, Write, text_of
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.pace import Watchdog
from scanrack.runtime.loop.rack import Rack, Slots
from scanrack.runtime.loop.scan import CpuMode, ScanLogic

from ..load.building import build_cpu, build_rack
from ..load.loading import load_job
from ..record.edits_and_forces import SET
from ..record.program_versions import ProgramVersions, version_of
from ..record.sequence_watch import WatchesSequences, sequences_in, wait_of, watching
from ..record.tag_names import named_values, namespace_of
from ..run.editing import continue_as, tags_in
from ..run.external_tags import report_external_tags
from ..why.answer import Why
from ..why.journal import Journal
from ..why.source.class_names import Names
from ..why.traced_run import Load
from .event_log import EventLog
from .moment import NotReachedError
from .slot import SlotBench


@runtime_checkable
class ObservedLogic(Protocol):
    """Logic with a debugger: a ladder program."""

    stops: tuple[Any, ...]
    on_edit: Callable[[Any], object]

    @property
    def tags(self) -> Any:
        """The tags, by name."""

    def why(self, tag: str) -> str:
        """Explain the current value of a tag."""

    def force(self, tag: str, value: object) -> None:
        """Force a tag to a value."""

    def unforce(self, tag: str | None = None) -> None:
        """Release the force of a tag."""


Condition = Callable[["Bench"], Any] | str
"""The condition that ends a run: a function of the bench, or a name as in `bench[name]`."""


class Bench:
    """A rack under test.

    Attributes:
        slot: the modules, by slot number.
        events: the events, oldest first.
        recorder: the recorder; None without a recording.
        load: reloads a Python program; None without its file.
        read: the tags that `bench[tag]` has read since the latest scan, in order.

    Args:
        logic: the program; a ladder program runs under a debugger for tags, forces and `why`.
        listeners: returns additional listeners of the rack, such as a recorder.
        watched: whether the rack's watchdog ends endless logic. Without it, a test can stay at a breakpoint
            for any length of time.
        load: reloads a Python program, so that `why` can name its lines.
        versions: stores the files of edits for the recording; None without files.
    """

    def __init__(
        self,
        spec: RackSpec,
        logic: ScanLogic,
        *,
        listeners: Callable[[Rack], Iterable[ScanListener]] = lambda _rack: (),
        watched: bool = False,
        load: Load | None = None,
        versions: ProgramVersions | None = None,
    ) -> None:
        self.spec = spec
        self._versions, self._edits = versions, 0
        self._edit_fields: dict[str, str] = {}  # event fields of the edit that runs now, if it has files
        self.load = load
        self.logic: Any = logic
        self._observed = isinstance(logic, ObservedLogic)  # whether it runs under a debugger
        if self._observed:
            self.program.on_edit = self._record_edit
        rack = build_rack(spec)
        self._events = events = EventLog()
        self.events = events.events
        self.recorder: ScanListener | None = None
        self.read: dict[str, None] = {}
        self._journal = Journal(rack)
        recorders = [*listeners(rack), watching(self._journal, logic)]
        self._sequence_watchers = [
            recorder for recorder in recorders if isinstance(recorder, WatchesSequences)
        ]
        self.cpu = events.cpu = build_cpu(
            spec,
            logic,
            rack,
            listeners=[*recorders, events],
            watchdog=None if watched else Watchdog(0),
        )
        self._fields = Fields(lambda: self.logic)  # an edit replaces the logic
        if self._observed or isinstance(logic, Logic):
            report_external_tags(self._settable, self.cpu)
        records = {slot.number: slot.record for slot in spec.slot}
        self.slot = Slots(
            (number, SlotBench(slot, records[number], self.run_for, lambda: self.now_ns))
            for number, slot in rack.slots.items()
        )

    # --- time

    @property
    def scans(self) -> int:
        """Number of completed scans."""
        return self.cpu.scan

    @property
    def now_ns(self) -> int:
        """Virtual time of the latest scan, ns since power-up; 0 before the first scan."""
        return max(self.cpu.now_ns - self.cpu.period_ns, 0)

    @property
    def now_s(self) -> float:
        """Virtual time of the latest scan, s since power-up."""
        return self.now_ns / 1e9

    @property
    def stops(self) -> tuple[Any, ...]:
        """The breakpoints that were hit in the latest scan."""
        return self.logic.stops if self._observed else ()

    def scan(self, scans: int = 1) -> None:
        """Run scans; end early if a breakpoint is hit.

        Raises:
            CpuFault: the program faults the CPU.
        """
        self._run(scans, lambda: self.stops)

    def _run(self, scans: int, is_over: Callable[[], object]) -> None:
        """Run scans until `is_over` returns true after a scan."""
        self._events.is_over = is_over
        try:
            self.cpu.run(scans)
        finally:
            self._events.is_over = bool
            self.read.clear()

    def run_for(self, time: str) -> None:
        """Run for an amount of machine time, such as "2 s", rounded up to whole scans.

        Raises:
            ValueError: `time` is not a time.
            CpuFault: the program faults the CPU.
        """
        self.scan(-(-parse_duration(time) // self.cpu.period_ns))

    def run_until(self, condition: Condition, within: str = "10 s") -> None:
        """Run until a condition is true; do nothing if it is already true.

        Args:
            condition: a function of the bench, or the name of a tag or a bit.

        Raises:
            NotReachedError: the condition does not become true in time; the message shows the bench.
            ValueError: `within` is not a time, or the tag is unknown.
            CpuFault: the program faults the CPU.
        """
        scans = -(-parse_duration(within) // self.cpu.period_ns)
        if not self._is_true(condition):
            self._run(scans, lambda: self.stops or self._is_true(condition))
        if not self.stops and not self._is_true(condition):
            name = condition if isinstance(condition, str) else _name(condition)
            raise NotReachedError(f"{name} has not become true within {within}.\n{self}", self.read)
        self.read.clear()

    def _is_true(self, condition: Condition) -> bool:
        return bool(self[condition] if isinstance(condition, str) else condition(self))

    def _image_value(self, text: str) -> int:
        """Return the value of the word or bit at an address."""
        address = self._address(text)
        slot = self.slot[address.slot]
        word = (slot.inputs if address.image == "I" else slot.outputs)[address.word]
        return word if address.bit is None else word >> address.bit & 1

    def program_mode(self) -> None:
        """Turn the CPU's key to program: the logic does not run, and outputs are not sent."""
        self.cpu.mode = CpuMode.PROGRAM

    def run_mode(self) -> None:
        """Turn the CPU's key to run."""
        self.cpu.mode = CpuMode.RUN

    # --- the program

    @property
    def program(self) -> Any:
        """The debugger of the ladder program, with tags, breakpoints and pictures.

        Raises:
            ValueError: the program is a Python function.
        """
        if not self._observed:
            raise ValueError("the program is a Python function: it has no tags and no rungs")
        return self.logic

    def edit(self, program: Any, restart: SequenceOf[str] = ()) -> Any:
        """Continue with an edited program from the next scan, see `Debugger.edit` and `edit_logic`.

        Edit the program's file, and pass its rack file: `bench.edit("feeder.toml")`. The recording then
        contains the edited files, and `scanrack replay --into session` repeats the edit. A program that a
        test creates, such as `read_program(path)` or an instance of a subclass of `Logic`, has no files. A
        rerun then reports the missing files. The next scan is recorded with an event of kind "edit", which
        lists new, changed and dropped tags or fields.

        Args:
            program: path of the rack file, to reload its program; or a ladder program; or an instance of a
                subclass of `Logic`.
            restart: names of the sequences to restart.

        Raises:
            ValueError: the program is a Python function, can't continue as the edited program, or has
                unusable files.
            OSError: its files can't be read.
        """
        self.__dict__.pop("_names", None)
        if isinstance(program, (str, Path)):
            return self._edit_files(str(program), restart)
        if not isinstance(self.logic, Logic):
            return self.program.edit(program)
        if not isinstance(program, Logic):
            name = type(program).__name__
            raise ValueError(f"{name} is not allowed: must be an instance of a subclass of Logic")
        edit_result = continue_as(self.logic, program, restart, self._fields, self._sequence_watchers)
        self._announce_edit(type(program).__name__, edit_result)
        return edit_result

    def _edit_files(self, rack: str, restart: SequenceOf[str]) -> Any:
        """Continue with the program of a rack file; record its files with the event, as in a session."""
        if self._versions is None:
            raise ValueError(f"{rack}: this bench has no files: pass the program itself")
        self._versions.forget()
        job = load_job(rack)
        version, number = version_of(job), self._edits + 1
        self._versions.keep(number, version, job)
        self._edit_fields = {"order": text_of(Edit(number, version.program, ", ".join(restart)))}
        try:
            edit_result = self.edit(job.logic, restart)
        finally:
            self._edit_fields = {}
        self._edits = number
        return edit_result

    def _record_edit(self, edit: Any) -> None:
        self._announce_edit(self.logic.program.name, edit)

    def _announce_edit(self, name: str, edit: Any) -> None:
        self.cpu.announce(Event(self.now_ns, "edit", name, str(edit), {**tags_in(edit), **self._edit_fields}))

    def __getitem__(self, tag: str) -> Any:
        """Return the current value of a tag, a bit or word of an image, or a value of a Python program.

        Raises:
            ValueError: the name is unknown.
        """
        self.read[tag] = None
        if self._is_image(tag) and not (self._observed and tag in self.program.tags):
            return self._image_value(tag)
        if self._observed:
            return self.program.tags[tag]
        address = self._names.addresses.get(self._names.own(tag))
        if address is not None:
            return self._image_value(address)
        namespace = namespace_of(self.logic)
        (value,) = named_values(namespace, [tag])
        return eval(value.source, namespace)

    def __setitem__(self, tag: str, value: object) -> None:
        """Set a tag of a ladder program, or a field of a `Logic` program, before the next scan.

        A field is recorded with the next scan, as an event of kind "set", so that a replay sets it again.

        Raises:
            ValueError: the name is unknown, or the value does not fit.
        """
        self._settable.tags[tag] = value
        if isinstance(self.logic, Logic):
            field_value = self._fields[tag]
            with suppress(ValueError):  # NaN and infinities are not JSON and are not recorded
                fields = {"order": text_of(Write(tag, field_value))}
                self.cpu.announce(Event(self.now_ns, SET, tag, f"{tag} is set to {field_value!r}", fields))

    @property
    def _settable(self) -> Any:
        """The fields of a `Logic` program, or the ladder program; both can set and force values by name."""
        return self._fields if isinstance(self.logic, Logic) else self.program

    def check(self, *tags: str) -> None:
        """Check tags and addresses before a run; raise ValueError for an unknown name."""
        for tag in tags:
            if self._is_image(tag):
                continue
            if self._observed:
                _ = self.program.tags[tag]
            elif not self._names.declares(tag):
                named_values(namespace_of(self.logic), [tag])

    @cached_property
    def _names(self) -> Names:
        return Names(self.logic, {slot.number: slot.words for slot in self.spec.slot})

    def why(self, tag: str | None = None) -> str:
        """Explain a value in at most six lines: since when, how and why; see `chain`.

        A Python program is loaded again and runs on its recorded inputs, with the lines of the latest scan
        traced. The program on the bench is not affected.

        Args:
            tag: a tag of a ladder program; an address of an image; a value of a Python program, such as
                `line.step`. None = what each module waits for, and the latest change of its output words.

        Raises:
            ValueError: the name is unknown, or no scan has run.
        """
        why = self._why()
        return why.rack() if tag is None else why.explain(tag)[0]

    def answer(self, tag: str, *, deep: bool = False) -> tuple[str, CauseLink]:
        """Return the text of `why` and the chain of causes; with `deep`, the text has the whole chain."""
        return self._why().explain(tag, deep=deep)

    def chain(self, tag: str, *, deep: bool = False) -> CauseLink:
        """Return the chain of causes of a value, back to an input, operator, injected fault or power-up.

        Args:
            tag: see `why`.
            deep: whether to include rungs of Add-On Instructions.

        Raises:
            ValueError: the name is unknown, or no scan has run.
        """
        return self._why().chain(tag, deep=deep)

    def suggest_inputs(self, tag: str, requested: str | None = None, scans: int = 10) -> Remedies:
        """Return the smallest sets of inputs that would set a ladder program's tag to a certain value.

        Each set is tested on a copy of the program, which runs from the latest scan.

        Args:
            requested: the value as text; None = the other value of a bit.
            scans: number of scans within which the value must change.
        """
        return self._why().suggest_inputs(tag, requested, scans)

    def _why(self) -> Why:
        recording = self._journal.recording()
        debugger = self.logic if self._observed else None
        return Why(recording, len(recording.scans) - 1, self.spec, self.load, debugger)

    def force(self, address: str, value: int) -> None:
        """Force a bit or word of an image, a tag, or a field of a `Logic` program to a value.

        An alias of a bit or word forces the image. Forces of images are recorded.

        Raises:
            ValueError: the name is unknown, or the value does not fit.
        """
        image_address = self._image_address(address)
        if image_address is not None:
            self.cpu.forces.set(image_address, value)
        else:
            self._settable.force(address, value)

    def unforce(self, address: str) -> None:
        """Release a force; raise ValueError if the address is not forced."""
        image_address = self._image_address(address)
        if image_address is not None:
            self.cpu.forces.remove(image_address)
        else:
            self._settable.unforce(address)

    def _is_image(self, text: str) -> bool:
        """Return whether a text is the address of an image word or bit."""
        try:
            self._address(text)
        except ValueError:
            return False
        return True

    def _address(self, text: str) -> Address:
        return parse_address(text, {slot.number: slot.words for slot in self.spec.slot})

    def _image_address(self, name: str) -> str | None:
        """Return the address of the image word or bit with a name; None if the name means something else."""
        if self._is_image(name):
            return str(self._address(name))
        if not (self._observed or isinstance(self.logic, Logic)):
            return None
        address: str | None = self._settable.address_of(name)
        return address

    @property
    def sequences(self) -> Mapping[str, Sequence]:
        """The sequences of the program, by name: `bench.sequences["cycle"].line`."""
        return {sequence.name: sequence for sequence in sequences_in(self.logic)}

    # --- events

    @property
    def rules(self) -> SequenceOf[str]:
        """Ids of the manual's rules that have fired, in chronological order."""
        return [event.name for event in self.events if event.kind == "rule"]

    def __str__(self) -> str:
        lines = [f"after {self.scans:,} scans, {seconds(self.now_ns)} s", *map(str, self.slot.values())]
        lines += [str(wait_of(sequence, self.scans)) for sequence in self.sequences.values()]
        lines += [f"  {event}" for event in self.events[-5:]]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<Bench {self.spec.name!r}: after {self.scans:,} scans, {seconds(self.now_ns)} s>"

    def _repr_html_(self) -> str:
        from .notebook import as_html

        words = {slot.number: slot.words for slot in self.spec.slot}
        slots = [(slot, words[number]) for number, slot in self.slot.items()]
        now = f"after {self.scans:,} scans, {seconds(self.now_ns)} s"
        return as_html(self.spec.name, now, slots, self.events, self.logic)

    # --- the end

    def end_recording(self) -> None:
        """Complete the recording; it does not include later scans."""
        if self.recorder is not None:
            self.cpu.dismiss(self.recorder)

    def close(self) -> None:
        """Close all listeners; this completes a recording."""
        self.cpu.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _name(condition: Callable[..., Any]) -> str:
    name = str(getattr(condition, "__name__", "the condition"))
    return "the condition" if name == "<lambda>" else name
