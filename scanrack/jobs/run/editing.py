"""The program of a run: edits between two scans, and a recorder for the files of edits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol, TypeGuard

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.doors import json_value
from scanrack.ladder.python.online.fields import Fields
from scanrack.ladder.python.sequences import Logic
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.events import Event, JsonValue
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import AttachedLogic, ScanLogic
from scanrack.traces.format.topics import ORDERS
from scanrack.traces.write.recorder import ScanRecorder

from ..load.loading import LoadedRack
from ..load.rungs import is_rungs
from ..record.sequence_watch import WatchesSequences, waiting_in

if TYPE_CHECKING:  # most runs are neither operated nor edited
    from scanrack.ladder.debug import Debugger
    from scanrack.ladder.python.online.editing import LogicEdit
    from scanrack.ladder.run import edit as rung_editing
    from scanrack.runtime.live.actions import Edit
    from scanrack.runtime.live.operator_actions import OperatorActions

    from ..record.program_versions import ProgramVersions

NO_TAGS: Mapping[str, list[str]] = MappingProxyType({"new": [], "changed": [], "dropped": []})


class DescribedEdit(Protocol):
    """The effects of an edit."""

    @property
    def keeps(self) -> str:
        """A sentence about the values that are kept."""

    @property
    def groups(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The affected names, grouped by effect."""


@dataclass(frozen=True, slots=True)
class RestartEdit:
    """An edit that restarts a Python program with new objects in its module."""

    names: tuple[str, ...]  # names of the program's values
    keeps = "the program is loaded again: the objects of its module are new"

    @property
    def groups(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """See `DescribedEdit`."""
        return (("restart", self.names),)


@dataclass(frozen=True, slots=True)
class ProgramEdit:
    """An edit of the running program."""

    number: int
    at_ns: int  # time of the first scan after the edit, ns
    name: str
    text: str
    tags: Mapping[str, list[str]]  # new, changed and removed tags


class RunProgram:
    """The program of a run; edits replace it between two scans.

    Args:
        handled: whether the rack can be operated while it runs; a ladder program then runs under a debugger.
        editions: loads the programs of edits; None without edits.
        remembered: snapshots of a ladder program, see `Debugger`.

    Attributes:
        debugger: the debugger of a ladder program; None for other programs and for racks that aren't
            operated.
        logic: the logic that the CPU calls: the debugger, or the program.
        on_edit: called after every edit.
        may_bring_sequences: whether an edit may introduce a program that has sequences.
    """

    def __init__(
        self, logic: ScanLogic, *, handled: bool, editions: ProgramVersions | None, remembered: int = 0
    ) -> None:
        self.debugger = _debugger_of(logic, remembered) if handled else None
        self.logic: ScanLogic = self.debugger or logic
        self.on_edit: Callable[[ProgramEdit], object] = lambda _edited: None
        self.editions = editions
        self._edits = 0  # of a Python program; a debugger counts its own
        self._fields = Fields(self._own_logic)
        self._followers: list[WatchesSequences] = []
        self.may_bring_sequences = editions is not None and self.debugger is None

    @property
    def edits(self) -> int:
        """Number of edits so far."""
        return self._edits if self.debugger is None else len(self.debugger.edits)

    def following(self, listener: ScanListener) -> ScanListener:
        """Return a listener that also receives the sequences of the program and of edited programs."""
        sequences = waiting_in(self.logic)
        if not self.may_bring_sequences and not sequences:
            return listener
        self._followers.append(WatchesSequences(listener, sequences))
        return self._followers[-1]

    def recorded(self, recorder: ScanRecorder) -> ScanListener:
        """Return a recorder that also receives the sequences of the program and the files of edits."""
        return self.following(recorder if self.editions is None else RecordsEdits(recorder, self.editions))

    def hands(self, cpu: Cpu, rack: Rack) -> OperatorActions:
        """Return the executor of operator actions on a rack; see `operated` for actions on tags."""
        from scanrack.runtime.live.operator_actions import OperatorActions

        edit = None if self.editions is None else partial(self._edit, cpu, self.editions)
        return OperatorActions(cpu, rack, self.operated, edit)

    @property
    def operated(self) -> Debugger | Fields | None:
        """The values of the program that can be set and forced; None if it has none."""
        if self.debugger is not None:
            return self.debugger
        return self._fields if isinstance(self.logic, Logic) else None

    def _own_logic(self) -> Logic:
        assert isinstance(self.logic, Logic), "an edit does not change the kind of a program"
        return self.logic

    def _edit(self, cpu: Cpu, editions: ProgramVersions, order: Edit, at_ns: int) -> None:
        """Continue with an edited program from the next scan, and announce the edit.

        Raises:
            ValueError: the edited program can't be used; the current program continues.
        """
        from scanrack.runtime.live.actions import names_in

        name, text, tags = self._take_over(cpu, editions.job(order.number), names_in(order.restart))
        cpu.announce(Event(at_ns, "edit", name, text, {**tags}))
        self.on_edit(ProgramEdit(order.number, at_ns, name, text, tags))

    def planned(self, cpu: Cpu, job: LoadedRack, restart: Sequence[str]) -> DescribedEdit:
        """Return the effects of an edit to the program of a job, without making the edit.

        Raises:
            ValueError: the run can't continue with that program.
        """
        logic = job.logic
        if self.debugger is not None and is_rungs(logic):
            from scanrack.ladder.run.edit import planned

            return planned(self.debugger.engine, logic.build())
        if self._continues(logic, cpu, restart):
            from scanrack.ladder.python.online.editing import plan_edit

            return plan_edit(self._own_logic(), logic, restart).edit
        return RestartEdit(_value_names(self.logic))

    def _continues(self, logic: ScanLogic, cpu: Cpu, restart: Sequence[str]) -> TypeGuard[Logic]:
        """Return whether a Python program continues as the edited one; if not, the edited one restarts."""
        from scanrack.runtime.live.actions import ALL

        are_logic = isinstance(self.logic, Logic) and isinstance(logic, Logic)
        return are_logic and bool(cpu.scan) and ALL not in restart

    def _take_over(
        self, cpu: Cpu, job: LoadedRack, restart: Sequence[str]
    ) -> tuple[str, str, Mapping[str, list[str]]]:
        """Continue with the program of a job; return its name, a sentence, and the affected tags.

        Raise ValueError if ladder logic would replace Python, or the reverse.
        """
        logic = job.logic
        if self.debugger is not None and is_rungs(logic):
            edit_result: rung_editing.Edit | LogicEdit = self.debugger.edit(logic)
            return logic.name, str(edit_result), tags_in(edit_result)
        if self.debugger is not None or is_rungs(logic):
            raise ValueError(f"{job.program.name}: a program of another kind needs a new session")
        if self._continues(logic, cpu, restart):
            edit_result = continue_as(self._own_logic(), logic, restart, self._fields, self._followers)
            self._edits += 1
            return job.program.name, str(edit_result), tags_in(edit_result)
        text = f"{job.program.name} is loaded again: the objects of its module are new"
        return job.program.name, text + self._replace(cpu, logic), NO_TAGS

    def _replace(self, cpu: Cpu, logic: ScanLogic) -> str:
        """Continue with another Python program; return a phrase about an error of the previous one."""
        if isinstance(logic, AttachedLogic):
            logic.__attach_logic__(dict(cpu.rack.slots))  # first, since it may raise
        previous, self.logic = self.logic, logic
        cpu.program = logic
        if isinstance(previous, Logic) and Fields(lambda: previous).forces:
            cpu.tags_from_outside({})
        self._edits += 1
        for follower in self._followers:
            follower.watch(waiting_in(logic))
        try:
            if isinstance(previous, AttachedLogic):
                previous.__close_logic__()
        except Exception as error:  # a user's error, in a program that has ended
            return f"; at its end the one before raised {type(error).__name__}: {error}"
        return ""


def _value_names(logic: ScanLogic) -> tuple[str, ...]:
    """Return the names of a Python program's values."""
    from ..record.tag_names import named_values, namespace_of

    try:
        return tuple(named_value.name for named_value in named_values(namespace_of(logic), ["*"]))
    except ValueError:
        return ()


def _debugger_of(logic: ScanLogic, remembered: int) -> Debugger | None:
    """Return a debugger for a ladder program; None for other logic."""
    if not is_rungs(logic):
        return None
    from scanrack.ladder.debug import Debugger  # not needed by a rack without a session

    return Debugger(logic, remembered=remembered)


def tags_in(edit: rung_editing.Edit | LogicEdit) -> dict[str, list[str]]:
    """Return the tags or fields that an edit affects, in the form of an event."""
    return {"new": list(edit.new), "changed": list(edit.changed), "dropped": list(edit.dropped)}


def continue_as(
    logic: Logic,
    edited: Logic,
    restart: Sequence[str],
    fields: Fields,
    followers: Iterable[WatchesSequences],
) -> LogicEdit:
    """Change a running Python program into an edited one; return the effects.

    Args:
        fields: the fields of `logic`; they report released forces.
        followers: listeners that receive the sequences of the program.
    """
    from scanrack.ladder.python.online.editing import edit_logic

    forces = fields.forces
    edit_result = edit_logic(logic, edited, restart)
    if fields.forces != forces:
        fields.on_outside()
    for follower in followers:
        follower.watch(waiting_in(logic))
    return edit_result


class RecordsEdits:
    """A recorder that attaches the files of an edit before the edit's order or event."""

    def __init__(self, recorder: ScanRecorder, editions: ProgramVersions) -> None:
        """Use the recorder's own methods, except `event`."""
        self._recorder, self._editions = recorder, editions
        self.scan = recorder.scan
        self.begin_rows = recorder.begin_rows
        self.rows = recorder.rows
        self.look = recorder.look
        self.close = recorder.close

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Record an event."""
        from scanrack.runtime.live.actions import NAMES, Edit

        from ..record.order_repeater import is_edit_with_files

        is_order = topic == ORDERS.name and fields["name"] == NAMES[Edit]
        if is_order or is_edit_with_files(topic, fields):
            number = json_value(str(fields["order"]))["number"]
            self._recorder.attach(scan, self._editions.attachments(number))
        self._recorder.event(scan, now_ns, topic, fields)
