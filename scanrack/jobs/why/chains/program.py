"""The chain of causes through a Python program: its lines, the inputs they read, and waits of sequences."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import field, replace
from pathlib import Path
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site
from scanrack.ladder.debug import CauseLink, Operand, linked
from scanrack.ladder.debug.watched import shown
from scanrack.ladder.state.memory import same
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.read.sequence_steps import Step, steps_of

from ...record.tag_names import named_values, namespace_of
from ..bits import Bits, read_bits
from ..outranked import forced, of_cpu
from ..past import ALL_BITS, Past
from ..source.conditions import source_line
from ..source.lines import NOWHERE, Line
from ..traced_run import TracedChange, TracedRun, Watched, fresh, last_changes, run_again, unwatched
from .at_rest import never, plain
from .python_chain import PythonChain
from .waiting import open_wait


@dataclass(slots=True)
class ProgramChain(PythonChain):
    """Makes chains through a recording and its Python program."""

    present: dict[str, Any] = field(default_factory=dict)  # the values after the run for the latest question
    _runs: dict[tuple[int, str], TracedRun] = field(default_factory=dict)

    # --- questions

    def of_value(self, text: str, row: int, depth: int = 0) -> CauseLink | None:
        """See `PythonChain`."""
        scan, changes = self.recording.numbers[row], self._last_changes([text], row)
        if text not in self.present:
            return None
        outranked = forced(self.recording.events, scan, {text}) or of_cpu(self.recording, row)
        stays = outranked is not None and outranked.kind == "fault" and text in changes
        if outranked is not None and not stays:
            return self._outranked(outranked, text, plain(self.present[text]))
        return self._of_value(text, changes[text]) if text in changes else self._never(text, row, depth)

    def _never(self, text: str, row: int, depth: int = 0) -> CauseLink | None:
        return never(self, text, row, self.present.get(text), depth)

    def of_sequence(self, name: str, row: int) -> CauseLink | None:
        """See `PythonChain`."""
        steps = [step for step in self._steps(name) if step.scan <= self.recording.numbers[row]]
        if not steps:
            return None
        cause = open_wait(self, steps, row)
        link = self._of_wait(steps, len(steps) - 1)
        return link if cause is None else replace(link, causes=((cause,),), depth=1 + cause.depth)

    def _of_rest(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Explain unchanged bits of an image; an output by the lines that could write it."""
        link = PythonChain._of_rest(self, bits, name, row)
        if link is not None or bits.image == "in":
            return link
        own = [own_name for own_name, address in self.names.addresses.items() if address == str(bits.address)]
        return never(self, own[0], row, self.value(bits, row)) if own else None

    def _steps(self, sequence: str) -> list[Step]:
        return steps_of(self.recording.events).get(sequence, [])

    # --- lines

    def _of_program(self, bits: Bits, name: str, row: int) -> CauseLink:
        rerun = self._traced(row, "")
        base = self.recording.span((bits.slot, "out")).start + 2 * bits.word
        changes = [change for change in rerun.changes.get(row, ()) if _differs(change, base, bits.mask)]
        values = self.value(bits, row), self.value(bits, row - 1) if row else None
        return self._of_line(bits.slot, name, values, row, rerun, changes)

    def _of_value(self, text: str, row: int) -> CauseLink:
        rerun = self._traced(row, text)
        changes = [
            change for change in rerun.changes.get(row, ()) if not same(change.before[1], change.after[1])
        ]
        values = rerun.value, changes[0].before[1] if changes else None
        return self._of_line(0, text, values, row, rerun, changes)

    def _traced(self, row: int, text: str) -> TracedRun:
        known = self._runs.get((row, text))
        if known is None:
            watched = self.watched(text) if text else unwatched
            known = run_again(self.recording, self.spec, self.load, frozenset({row}), row, watched)
            self._runs[row, text] = known
        return known

    def _of_line(
        self,
        slot: int,
        name: str,
        values: tuple[Any, Any],
        row: int,
        again: TracedRun,
        made: Sequence[TracedChange],
    ) -> CauseLink:
        """Return the link of a change by a line; `values` are the values after and before the scan."""
        slot_senders = [sender for sender in made[-1].senders if sender.slot == slot] if made else []
        line = slot_senders[0].line if slot_senders else made[-1].line if made else NOWHERE
        common = {"name": name, "value": plain(values[0]), "scan": self.recording.numbers[row]}
        common |= {"now_ns": self.recording.times[row], "before": plain(values[1])}
        if not again.explains(row):
            return CauseLink("unknown", **common, text=again.no_line(Past(self.recording, row)))
        if not line.number and forced(self.recording.events, common["scan"], {name}):
            return CauseLink("force", **common, text=f"forced to {shown(common['value'])}")
        if not line.number:
            text = f"sent by {slot_senders[0].text}" if slot_senders else "no line of the program wrote it"
            return CauseLink("line" if slot_senders else "unknown", **common, text=text)
        waited = self._of_sender(line, row) if slot_senders else self._waited(line, row)
        causes = list(zip(waited or self._of_reads(made[-1], row)))
        site = _site(line)
        text = source_line(line.file, line.number)
        return linked(
            causes, **common, kind="line", site=site, text=text, operands=self._operands(made[-1], row)
        )

    def refuse(self, text: str) -> None:
        """Raise ValueError if the program has no such name."""
        with fresh(self.load) as logic:
            named_values(namespace_of(logic), [text])

    def _operands(self, change: TracedChange, row: int) -> tuple[Operand, ...]:
        values = [Operand(name, value, changed=False) for name, value in change.values.items()]
        bits = [
            Operand(self.name(read), self.value(read, row), changed=changed)
            for read, changed in self._read(change, row)
        ]
        return (*values, *bits)

    def _read(self, change: TracedChange, row: int) -> Iterator[tuple[Bits, bool]]:
        """Yield the bits that the program read before a change, and whether each was new in the scan."""
        past = Past(self.recording, row)
        for bits in read_bits(change.masks.items()):
            before = past.words(bits.slot, "in", row - 1)[bits.word] if row else 0
            yield bits, bool((before ^ past.words(bits.slot, "in", row)[bits.word]) & bits.mask)

    def _of_reads(self, change: TracedChange, row: int) -> Iterator[CauseLink]:
        """Yield the inputs that were new; if none was, the value in the conditions that changed last."""
        new = [bits for bits, changed in self._read(change, row) if changed]
        for bits in new:
            yield self._of_change(bits, self.name(bits), row)
        if not new and row:
            names = [name for _, inner in change.stands.inside for name in inner]
            changes = self._last_changes(
                [self.full(name) for name in (*names, *change.stands.names)], row - 1
            )
            last = max(changes.values(), default=None)
            yield from (
                self._of_value(name, change_row) for name, change_row in changes.items() if change_row == last
            )
            if last is None:
                yield from self._of_old_reads(change, row)

    def _of_old_reads(self, change: TracedChange, row: int) -> Iterator[CauseLink]:
        """Of the inputs read, yield the one that changed last."""
        links = [self.of_bits(bits, self.name(bits), row) for bits, _ in self._read(change, row)]
        known_links = [link for link in links if link is not None]
        last = max((link.scan for link in known_links), default=None)
        yield from (link for link in known_links if link.scan == last)

    # --- values

    def watched(self, text: str) -> Watched:
        """Return a function that makes a reader of a program's value."""

        def watched(logic: ScanLogic) -> Callable[[], Any]:
            namespace = namespace_of(logic)
            code = compile(_source(namespace, text), "<watched>", "eval")
            return lambda: eval(code, namespace)

        return watched

    def _last_changes(self, texts: Sequence[str], row: int) -> dict[str, int]:
        """Return the row in which each value of the program last changed, up to a given row."""

        def watched(logic: ScanLogic) -> Callable[[], dict[str, Any]]:
            codes = {}
            with suppress(ValueError):
                namespace = namespace_of(logic)
                for text in texts:
                    with suppress(ValueError):  # a local name, or a value that is not plain
                        codes[text] = compile(_source(namespace, text), "<watched>", "eval")
            return lambda: {text: eval(code, namespace) for text, code in codes.items()}

        changes, self.present = last_changes(self.recording, self.spec, self.load, row, watched)
        return changes

    # --- sequences

    def _waited(self, line: Line, row: int) -> list[CauseLink]:
        """Return the wait that had to end before a sequence reached a line."""
        scan = self.recording.numbers[row]
        steps = [step for step in self._steps(line.function) if step.scan < scan]
        return [self._of_end(steps, len(steps) - 1, row)] if steps else []

    def _of_sender(self, line: Line, row: int) -> list[CauseLink]:
        """Return the wait that ended before a sequence reached the line that awaits an axis command."""
        scan, file = self.recording.numbers[row], Path(line.file).name
        steps = [step for step in self._steps(line.function) if step.scan <= scan]
        positions = [
            number for number, step in enumerate(steps) if (step.file, step.line) == (file, line.number)
        ]
        return (
            [self._of_end(steps, positions[-1] - 1, self._row(steps[positions[-1]]))]
            if positions and positions[-1]
            else []
        )

    def _of_wait(self, steps: Sequence[Step], number: int) -> CauseLink:
        """Return the link of a wait that has begun; its cause is the end of the previous wait."""
        step = steps[number]
        row = self._row(step)
        causes = [(self._of_end(steps, number - 1, row),)] if number else []
        before = f"waits for {steps[number - 1].wait}" if number else None
        text = f"waits for {step.wait}" if step.line else "is over"
        return linked(causes, **self._parts(step, row, text), before=before)

    def _of_end(self, steps: Sequence[Step], number: int, row: int) -> CauseLink:
        """Return the link of a wait's end in a scan, caused by what it waited for or by the previous wait."""
        ends = [row]  # the rows in which this wait ended, then the previous one, and so on
        while not (causes := [(cause,) for cause in self._of_condition(steps[number], ends[-1])]) and number:
            ends.append(self._row(steps[number]))
            number -= 1
        while True:
            step, row = steps[number], ends.pop()
            link = linked(causes, **self._parts(step, row, f"{step.wait} is over"))
            if not ends:
                return link
            causes, number = [(link,)], number + 1

    def _parts(self, step: Step, row: int, text: str) -> dict[str, Any]:
        line = Line(str(self.load.folder / step.file), step.line, step.sequence)
        moment = {"scan": self.recording.numbers[row], "now_ns": self.recording.times[row]}
        return {
            "kind": "wait",
            "name": step.sequence,
            "value": None,
            **moment,
            "text": text,
            "site": _site(line),
        }

    def _row(self, step: Step) -> int:
        return bisect_left(self.recording.numbers, step.scan)

    def _of_condition(self, step: Step, row: int) -> Iterator[CauseLink]:
        """Yield the inputs and axes in a wait's condition that changed in the scan that ended it."""
        for name in self.names.named_in(step.wait):
            slot = self.names.axes.get(name)
            if slot is None:
                yield from self._new(Bits.at(self.place(name)), name, row)
            else:
                yield from self._of_axis(slot, row)

    def _new(self, bits: Bits, name: str, row: int) -> Iterator[CauseLink]:
        if (
            bits.image == "in"
            and Past(self.recording, row).last_change(bits.slot, "in", bits.word, bits.mask) == row
        ):
            yield self._of_change(bits, name, row)

    def _of_axis(self, slot: int, row: int) -> Iterator[CauseLink]:
        """Yield the named status bits of an axis that changed in a scan."""
        past = Past(self.recording, row)
        words = self.slot(slot).words
        before = past.words(slot, "in", row - 1)[0] if row else 0
        differs = (past.words(slot, "in", row)[0] ^ before) & ALL_BITS
        came = differs & past.words(slot, "in", row)[0] or differs
        for name, bit in words.bits("I", 0):
            if came >> bit & 1:
                yield self._of_change(Bits(slot, "in", 0, 1 << bit), f"slot{slot}.status.{name}", row)
                return


def _source(namespace: Any, text: str) -> str:
    (value,) = named_values(namespace, [text])
    return value.source


def _site(line: Line) -> Site:
    return Site(
        file=Path(line.file).name,
        line=line.number,
        routine="",
        instruction=source_line(line.file, line.number),
    )


def _differs(change: TracedChange, at: int, mask: int) -> bool:
    """Return whether a change affects the masked bits of the word at an offset in the memory block."""
    before, after = (
        int.from_bytes(state[0][at : at + 2], "little") for state in (change.before, change.after)
    )
    return bool((before ^ after) & mask)
