"""The chain of causes through a Python program: its lines, the inputs they read, and waits of sequences."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import field, replace
from pathlib import Path
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.debug import CauseLink, Operand, linked
from scanrack.ladder.debug.watched import shown
from scanrack.ladder.state.memory import same
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.read.sequence_steps import Step, steps_of

from ...record.tag_names import named_values, namespace_of
from ..bits import Bits, read_bits
from ..chain import override_link
from ..overrides import forced, of_cpu
from ..past import ALL_BITS, Past
from ..source.conditions import source_line
from ..source.lines import NOWHERE, Line
from ..traced_run import TracedChange, TracedRun, Watched, fresh, last_changes, run_again, unwatched
from .python_chain import PythonChain
from .unwritten import explain_unwritten, plain, site_of
from .waiting import open_wait


@dataclass(slots=True)
class ProgramChain(PythonChain):
    """Makes chains through a recording and its Python program."""

    present: dict[str, Any] = field(default_factory=dict)  # values after the latest rerun, by name
    _runs: dict[tuple[int, str], TracedRun] = field(default_factory=dict)

    # --- questions

    def of_value(self, text: str, row: int, depth: int = 0) -> CauseLink | None:
        """See `PythonChain`."""
        changes = self._last_changes([text], row)  # this also sets `present`
        scan = self.recording.numbers[row]
        if text not in self.present:
            return None
        override = forced(self.recording.events, scan, {text}) or of_cpu(self.recording, row)
        # after a fault a value can't change, but it has its own cause
        has_own_cause = override is not None and override.kind == "fault" and text in changes
        if override is not None and not has_own_cause:
            return override_link(override, text, plain(self.present[text]))
        if text in changes:
            return self._explain_value(text, changes[text])
        return explain_unwritten(self, text, row, self.present[text], depth)

    def of_sequence(self, name: str, row: int) -> CauseLink | None:
        """See `PythonChain`."""
        steps = [step for step in self._steps(name) if step.scan <= self.recording.numbers[row]]
        if not steps:
            return None
        cause = open_wait(self, steps, row)
        link = self._wait_link(steps)
        return link if cause is None else replace(link, causes=((cause,),), depth=1 + cause.depth)

    def _explain_unchanged(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Explain unchanged bits of an image; an output is explained by the lines that could write it."""
        link = PythonChain._explain_unchanged(self, bits, name, row)
        if link is not None or bits.image == "in":
            return link
        names = [name for name, address in self.names.addresses.items() if address == str(bits.address)]
        return explain_unwritten(self, names[0], row, self.value(bits, row)) if names else None

    def _steps(self, sequence: str) -> list[Step]:
        return steps_of(self.recording.events).get(sequence, [])

    # --- lines

    def _explain_output(self, bits: Bits, name: str, row: int) -> CauseLink:
        """Return the link of a change in an output, made by a line of the program."""
        rerun = self._traced(row, "")
        offset = self.recording.span((bits.slot, "out")).start + 2 * bits.word
        changes = [change for change in rerun.changes.get(row, ()) if change.affects(offset, bits.mask)]
        before = self.value(bits, row - 1) if row else None
        values = self.value(bits, row), before
        return self._line_link(bits.slot, name, values, row, rerun=rerun, changes=changes)

    def _explain_value(self, text: str, row: int) -> CauseLink:
        """Return the link of a change in a program value, made by a line of the program."""
        rerun = self._traced(row, text)
        changes = [
            change
            for change in rerun.changes.get(row, ())
            if not same(change.before.value, change.after.value)
        ]
        before = changes[0].before.value if changes else None
        return self._line_link(0, text, (rerun.value, before), row, rerun=rerun, changes=changes)

    def _traced(self, row: int, text: str) -> TracedRun:
        """Run the program again up to a row, and trace the row; watch a value unless `text` is ""."""
        rerun = self._runs.get((row, text))
        if rerun is None:
            watched = self.watched(text) if text else unwatched
            rerun = run_again(
                self.recording, self.spec, self.load, frozenset({row}), last=row, watched=watched
            )
            self._runs[row, text] = rerun
        return rerun

    def _line_link(
        self,
        slot: int,
        name: str,
        values: tuple[Any, Any],
        row: int,
        rerun: TracedRun,
        changes: Sequence[TracedChange],
    ) -> CauseLink:
        """Return the link of a change by a line, or a link of kind "unknown" if no line can be named.

        Args:
            slot: the module of a changed output, whose axis or step may have sent the change; 0 for a
                value.
            values: the values after and before the scan.
            changes: the traced changes in the scan, in order; the last one counts.
        """
        after, before = values
        fields = {"name": name, "value": plain(after), "before": plain(before)}
        fields |= {"scan": self.recording.numbers[row], "now_ns": self.recording.times[row]}
        if not rerun.explains(row):
            return CauseLink("unknown", **fields, text=rerun.no_line(Past(self.recording, row)))
        last_change = changes[-1] if changes else None
        line = NOWHERE if last_change is None else last_change.line
        slot_senders = (
            [sender for sender in last_change.senders if sender.slot == slot] if last_change else []
        )
        if slot_senders:
            line = slot_senders[0].line
        if last_change is None or not line.number:
            if forced(self.recording.events, fields["scan"], {name}):
                return CauseLink("force", **fields, text=f"forced to {shown(fields['value'])}")
            if slot_senders:
                return CauseLink("line", **fields, text=f"sent by {slot_senders[0].text}")
            return CauseLink("unknown", **fields, text="no line of the program wrote it")
        end = self._ended_wait_of_sender(line, row) if slot_senders else self._ended_wait(line, row)
        causes = self._causes_of_change(last_change, row) if end is None else [end]
        return linked(
            [(cause,) for cause in causes],
            **fields,
            kind="line",
            site=site_of(line),
            text=source_line(line.file, line.number),
            operands=self._operands(last_change, row),
        )

    def refuse(self, text: str) -> None:
        """Raise ValueError if the program has no such name."""
        with fresh(self.load) as logic:
            named_values(namespace_of(logic), [text])

    def _operands(self, change: TracedChange, row: int) -> tuple[Operand, ...]:
        """Return the values and input bits that a change read, and whether each bit was new in the scan."""
        values = [Operand(name, value, changed=False) for name, value in change.values.items()]
        bits = [
            Operand(self.name(read), self.value(read, row), changed=changed)
            for read, changed in self._reads(change, row)
        ]
        return (*values, *bits)

    def _reads(self, change: TracedChange, row: int) -> Iterator[tuple[Bits, bool]]:
        """Yield the bits that the program read before a change, and whether each was new in the scan."""
        past = Past(self.recording, row)
        for bits in read_bits(change.masks.items()):
            before = past.words(bits.slot, "in", row - 1)[bits.word] if row else 0
            yield bits, bool((before ^ past.words(bits.slot, "in", row)[bits.word]) & bits.mask)

    def _causes_of_change(self, change: TracedChange, row: int) -> Iterator[CauseLink]:
        """Yield the new inputs that a change read; else the last changed value in its conditions."""
        new = [bits for bits, changed in self._reads(change, row) if changed]
        for bits in new:
            yield self._explain_change(bits, self.name(bits), row)
        if not new and row:
            names = [name for _, inner in change.stands.inside for name in inner]
            changes = self._last_changes(
                [self.full(name) for name in (*names, *change.stands.names)], row - 1
            )
            last_row = max(changes.values(), default=None)
            for name, change_row in changes.items():
                if change_row == last_row:
                    yield self._explain_value(name, change_row)
            if last_row is None:
                yield from self._latest_reads(change, row)

    def _latest_reads(self, change: TracedChange, row: int) -> Iterator[CauseLink]:
        """Yield the latest changes among the inputs that a change read."""
        reads = (self.of_bits(bits, self.name(bits), row) for bits, _ in self._reads(change, row))
        links = [link for link in reads if link is not None]
        last_scan = max((link.scan for link in links), default=None)
        yield from (link for link in links if link.scan == last_scan)

    # --- values

    def watched(self, text: str) -> Watched:
        """Return a function that makes a reader of a program's value."""

        def reader_of(logic: ScanLogic) -> Callable[[], Any]:
            namespace = namespace_of(logic)
            code = compile(_source_of(namespace, text), "<watched>", "eval")
            return lambda: eval(code, namespace)

        return reader_of

    def _last_changes(self, texts: Sequence[str], row: int) -> dict[str, int]:
        """Return the last row up to `row` in which each value changed.

        The values after `row` are kept in `present`.
        """

        def reader_of(logic: ScanLogic) -> Callable[[], dict[str, Any]]:
            codes = {}
            with suppress(ValueError):
                namespace = namespace_of(logic)
                for text in texts:
                    with suppress(ValueError):  # a local name, or a value that is not plain
                        codes[text] = compile(_source_of(namespace, text), "<watched>", "eval")
            return lambda: {text: eval(code, namespace) for text, code in codes.items()}

        changes, self.present = last_changes(self.recording, self.spec, self.load, row, reader_of)
        return changes

    # --- sequences

    def _ended_wait(self, line: Line, row: int) -> CauseLink | None:
        """Return the wait that had to end before a sequence reached a line; None if there was no wait."""
        scan = self.recording.numbers[row]
        steps = [step for step in self._steps(line.function) if step.scan < scan]
        return self._end_link(steps, row) if steps else None

    def _ended_wait_of_sender(self, line: Line, row: int) -> CauseLink | None:
        """Return the wait that ended before a sequence reached the line that awaits an axis command."""
        scan, file = self.recording.numbers[row], Path(line.file).name
        steps = [step for step in self._steps(line.function) if step.scan <= scan]
        while steps and (steps[-1].file, steps[-1].line) != (file, line.number):
            steps.pop()
        return self._end_link(steps[:-1], self._row(steps[-1])) if len(steps) > 1 else None

    def _wait_link(self, steps: Sequence[Step]) -> CauseLink:
        """Return the link of the last step's wait, caused by the end of the previous wait."""
        *earlier, step = steps
        row = self._row(step)
        causes = [(self._end_link(earlier, row),)] if earlier else []
        before = f"waits for {earlier[-1].wait}" if earlier else None
        text = f"waits for {step.wait}" if step.line else "is over"
        return linked(causes, **self._step_fields(step, row, text), before=before)

    def _end_link(self, steps: Sequence[Step], row: int) -> CauseLink:
        """Return the link of the end of the last step's wait, which ended in a row.

        Its cause is the awaited input or axis. Without one, it is the end of the previous wait, and so on.
        """
        causes: list[CauseLink] = []
        ends: list[
            tuple[Step, int]
        ] = []  # the steps whose waits ended, latest first, with the row of the end
        for step in reversed(steps):
            ends.append((step, row))
            causes = list(self._causes_of_end(step, row))
            if causes:
                break
            row = self._row(step)
        for step, end_row in reversed(ends):
            fields = self._step_fields(step, end_row, f"{step.wait} is over")
            link = linked([(cause,) for cause in causes], **fields)
            causes = [link]
        return link

    def _step_fields(self, step: Step, row: int, text: str) -> dict[str, Any]:
        """Return the fields of the link of a step's wait."""
        return {
            "kind": "wait",
            "name": step.sequence,
            "value": None,
            "scan": self.recording.numbers[row],
            "now_ns": self.recording.times[row],
            "text": text,
            "site": site_of(Line(str(self.load.folder / step.file), step.line, step.sequence)),
        }

    def _row(self, step: Step) -> int:
        return bisect_left(self.recording.numbers, step.scan)

    def _causes_of_end(self, step: Step, row: int) -> Iterator[CauseLink]:
        """Yield the inputs and axes in a wait's condition that changed in the scan that ended it."""
        for name in self.names.named_in(step.wait):
            slot = self.names.axes.get(name)
            if slot is not None:
                yield from self._new_status(slot, row)
                continue
            bits = Bits.at(self.place(name))
            if bits.image == "in" and self._last_change(bits, row) == row:
                yield self._explain_change(bits, name, row)

    def _new_status(self, slot: int, row: int) -> Iterator[CauseLink]:
        """Yield the first named status bit of an axis that turned on in a scan; else one that turned off."""
        past = Past(self.recording, row)
        before = past.words(slot, "in", row - 1)[0] if row else 0
        after = past.words(slot, "in", row)[0]
        changed = (after ^ before) & ALL_BITS
        changed = changed & after or changed
        for name, bit in self.slot(slot).words.bits("I", 0):
            if changed >> bit & 1:
                yield self._explain_change(Bits(slot, "in", 0, 1 << bit), f"slot{slot}.status.{name}", row)
                return


def _source_of(namespace: Any, text: str) -> str:
    """Return the expression that reads a value in a namespace; raise ValueError if it has none."""
    (value,) = named_values(namespace, [text])
    return value.source
