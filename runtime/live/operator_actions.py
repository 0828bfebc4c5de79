"""Applies operator actions to a rack between two scans, and announces each for the trace.

    scan          n           n+1
    time          t           t + period
    order         | acts      its scan, in the recording
    a switch      | closes: the modules stand at t

An order is announced with the number of the following scan, n + 1, and with the time of its effect, t.
Orders of the session itself, such as a pause, change no image: they are only announced. Repeating the
orders of a recording therefore gives the same images.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol, runtime_checkable

from scanrack.io_images.addresses import parse_address
from scanrack.io_images.enip.listing import patched
from scanrack.io_images.module_words import ModuleWords
from scanrack.io_images.times import exact_ns

from ..loop.cpu import Cpu
from ..loop.events import Event
from ..loop.exposed import ExposedModule
from ..loop.incidents import FaultKind, InjectedFault
from ..loop.rack import Rack
from ..loop.scan import CpuMode
from ..machine.spec import INPUT_NAMES
from ..modules.record import ModuleWithInputs, NamedInputs, PressedByTimeline
from ..tag_servers.images import output_slot
from . import actions
from .actions import ALL, NAMES, Action, Value, text_of


class AppliedAction(NamedTuple):
    """An operator action that was applied before scan `scan`."""

    scan: int
    order: Action


class WritableTags(Protocol):
    """A program whose tags can be set and forced: a debugger."""

    @property
    def tags(self) -> Any:
        """The tags by name."""

    def force(self, tag: str, value: object) -> None:
        """Hold a tag at a value; ValueError if that is impossible."""

    def unforce(self, tag: str | None = None) -> None:
        """Release a tag, or all; ValueError for a tag that is not forced."""


@runtime_checkable
class ByteStore(Protocol):
    """A program whose tags can be set as bytes: a debugger."""

    def store(self, tag: str, offset: int, data: bytes, keep: bytes) -> None:
        """Set bytes of a tag except the bits of `keep`; ValueError if that is impossible."""


@runtime_checkable
class NamedImages(Protocol):
    """A program that has names for words and bits of images: a debugger."""

    def address_of(self, tag: str) -> str | None:
        """Return the address that a tag stands for; None for any other tag."""


class OperatorActions:
    """Carries out orders on a rack.

    Args:
        rack: its simulated modules are exposed to incidents.
        desk: the program; None without tags that can be set.
        edit: continues with an edited program before the scan at a time; None if edits are impossible.

    Attributes:
        given: the orders that were carried out.
        words: word names of the modules, by slot.
    """

    def __init__(
        self,
        cpu: Cpu,
        rack: Rack,
        desk: WritableTags | None,
        edit: Callable[[actions.Edit, int], None] | None = None,
    ) -> None:
        self._cpu, self._rack, self._desk, self._editing = cpu, rack, desk, edit
        self.given: list[AppliedAction] = []
        self.words: Mapping[int, ModuleWords] = {slot.number: slot.words for slot in rack.slots.values()}

    def act(self, order: Action, at_ns: int, scan: int) -> None:
        """Carry out an order before the next scan, and announce it.

        The first press of a card's input by hand ends the card's timeline: one person operates a panel.

        Raises:
            ValueError: it can't be carried out, and nothing has changed.
        """
        action = _ACTS.get(type(order))
        effect = action(self, order, at_ns) if action is not None else None
        self.given.append(AppliedAction(scan, order))
        name, behind_ns = NAMES[type(order)], max(at_ns - self._cpu.period_ns, 0)
        text = sentence(order) if effect is None else f"{sentence(order)} {effect}"
        self._cpu.announce(Event(behind_ns, "order", name, text, {"order": text_of(order)}))

    def image(self, tag: str) -> str | None:
        """Return the address of the word or bit of an image that a tag names; None for any other tag."""
        try:
            return str(parse_address(tag, self.words))
        except ValueError:
            desk: object = self._desk
            return desk.address_of(tag) if isinstance(desk, NamedImages) else None

    # --- one order each

    def _mode(self, order: actions.Mode, _at_ns: int) -> None:
        self._cpu.mode = CpuMode[order.mode.upper()]

    def _press(self, order: actions.Press, _at_ns: int) -> str | None:
        module: Any = self._rack.slots[order.slot].module
        device = getattr(module, "module", module)  # inside of incidents
        if isinstance(device, NamedInputs):
            if order.on is None:
                raise ValueError(f"slot {order.slot}: an input of a card is on or off: give true or false")
            device.set_input(order.name, order.on)
            if isinstance(device, PressedByTimeline) and device.end_timeline():
                return f"The timeline of slot {order.slot} ends."
        elif isinstance(device, ModuleWithInputs):
            bit = INPUT_NAMES.get(order.name.lower())
            if bit is None:
                raise ValueError(f"no input {order.name!r}: inputs are {', '.join(INPUT_NAMES)}")
            device.operate(bit, order.on)
        else:
            raise ValueError(f"slot {order.slot}: its inputs are real; they can't be set here")
        return None

    def _write(self, order: actions.Write, _at_ns: int) -> None:
        if self.image(order.tag) is not None:
            raise ValueError(f"{order.tag} is an image, which every scan writes again: force it instead")
        self._program(order.tag).tags[order.tag] = order.value

    def _store(self, order: actions.Store, _at_ns: int) -> None:
        data, keep = bytes.fromhex(order.data), bytes.fromhex(order.keep)
        slot = output_slot(order.tag)
        if slot is not None and slot in self._rack.slots:
            raw = self._rack.slots[slot].outputs.raw
            part = slice(order.offset, order.offset + len(data))
            if len(raw[part]) != len(data):
                raise ValueError(f"{order.tag}: bytes {part.start} to {part.stop} of {len(raw)}")
            raw[part] = patched(bytes(raw[part]), data, keep)
            return
        desk = self._program(order.tag)
        if not isinstance(desk, ByteStore):
            raise ValueError(f"{order.tag}: the program has no tags that clients can write")
        desk.store(order.tag, order.offset, data, keep)

    def _force(self, order: actions.Force, _at_ns: int) -> None:
        if (address := self.image(order.tag)) is not None:
            self._cpu.forces.set(address, _whole(order.tag, order.value))
        else:
            self._program(order.tag).force(order.tag, order.value)

    def _unforce(self, order: actions.Unforce, _at_ns: int) -> None:
        if order.tag == ALL:
            self._cpu.forces.clear()
            if self._desk is not None:
                self._desk.unforce()
        elif (address := self.image(order.tag)) is not None:
            self._cpu.forces.remove(address)
        else:
            self._program(order.tag).unforce(order.tag)

    def _happen(self, order: actions.InjectFault, at_ns: int) -> None:
        module = self._rack.slots[order.slot].module
        if not isinstance(module, ExposedModule):
            raise ValueError(f"slot {order.slot}: can't inject faults into real modules")
        kind, for_ns = FaultKind(order.kind), exact_ns(order.for_ms, "ms", "for_ms")
        incident = InjectedFault(at_ns, kind, order.slot, for_ns, order.late_words, order.state)
        incident.check_late_words(len(self.words[order.slot].outputs))
        module.happen(incident)

    def _edit(self, order: actions.Edit, at_ns: int) -> None:
        if self._editing is None:
            raise ValueError("the files of an edited program are not there")
        self._editing(order, at_ns)

    def _program(self, tag: str) -> WritableTags:
        if self._desk is None:
            raise ValueError(f"{tag}: the program has no tags that can be set; images can be forced")
        return self._desk


_ACTS: Mapping[type[Action], Callable[[OperatorActions, Any, int], str | None]] = {
    actions.Mode: OperatorActions._mode,
    actions.Press: OperatorActions._press,
    actions.Write: OperatorActions._write,
    actions.Store: OperatorActions._store,
    actions.Force: OperatorActions._force,
    actions.Unforce: OperatorActions._unforce,
    actions.InjectFault: OperatorActions._happen,
    actions.Edit: OperatorActions._edit,
}
"""The orders that act on the rack; each returns a further sentence for its event, or None."""


def _whole(tag: str, value: Value) -> int:
    if not isinstance(value, int):
        raise ValueError(f"{tag} can't be forced to {value!r}: a word or bit takes whole numbers")
    return int(value)


_LEVELS = {True: "energized", False: "de-energized", None: "left to the machine"}

_SENTENCES: Mapping[type[Action], Callable[[Any], str]] = {
    actions.Mode: lambda order: f"The key is turned to {order.mode}.",
    actions.Pause: lambda _order: "The rack pauses.",
    actions.Continue: lambda _order: "The rack continues.",
    actions.Step: lambda order: f"{order.scans} scan{'s' * (order.scans != 1)}, then a pause.",
    actions.Speed: lambda order: f"The speed is {order.factor}.",
    actions.Press: lambda order: (
        f"Slot {order.slot}: the {order.name} input is {_LEVELS[order.on]}{_by(order.by)}."
    ),
    actions.Write: lambda order: f"{order.tag} is set to {_shown(order.value)}{_by(order.by)}.",
    actions.Store: lambda order: f"{order.client or 'A client'} writes {order.tag}{order.part}.",
    actions.Force: lambda order: f"{order.tag} is forced to {_shown(order.value)}.",
    actions.Unforce: lambda order: (
        "All forces are removed." if order.tag == ALL else f"{order.tag} is no longer forced."
    ),
    actions.InjectFault: lambda order: f"Slot {order.slot}: {order.state or order.kind}.",
    actions.Breakpoint: lambda order: f"A breakpoint is set: {order.at}.",
    actions.RemoveBreakpoint: lambda order: f"A breakpoint is removed: {order.at}.",
    actions.Reload: lambda _order: "The program is loaded again.",
    actions.Edit: lambda order: f"Edit {order.number} of the program.",
    actions.Branch: lambda order: f"Another way from scan {order.scan:,} on.",
}


def sentence(order: Action) -> str:
    """Return an order as a sentence.

    >>> from scanrack.runtime.live.actions import Press
    >>> sentence(Press(1, "home", True))
    'Slot 1: the home input is energized.'
    """
    return _SENTENCES[type(order)](order)


def _by(who: str) -> str:
    return who and f" ({who})"


def _shown(value: Value) -> str:
    return str(int(value)) if isinstance(value, bool) else str(value)
