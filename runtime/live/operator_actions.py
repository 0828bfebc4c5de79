"""Applies operator actions to a rack between two scans, and announces an event for the trace.

    scan          n           n+1
    time          t           t + period
    action        | applied   its scan, in the trace
    a switch      | closes while the modules are at time t

An action's event has the number of the following scan, n + 1, and the time at which the action takes effect,
t. Actions on the session itself, such as a pause, only produce an event; they do not change any image.
Repeating the actions in a trace therefore produces the same images.
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
    """A program whose tags can be set and forced, such as a debugger."""

    @property
    def tags(self) -> Any:
        """The tags by name."""

    def force(self, tag: str, value: object) -> None:
        """Hold a tag at a value; raise ValueError if that is impossible."""

    def unforce(self, tag: str | None = None) -> None:
        """Release a tag, or all tags; raise ValueError for a tag that is not forced."""


@runtime_checkable
class ByteStore(Protocol):
    """A program whose tags can be set as bytes, such as a debugger."""

    def store(self, tag: str, offset: int, data: bytes, keep: bytes) -> None:
        """Set bytes of a tag, except bits that are 1 in `keep`; raise ValueError if that is impossible."""


@runtime_checkable
class NamedImages(Protocol):
    """A program that has names for words and bits of images, such as a debugger."""

    def address_of(self, tag: str) -> str | None:
        """Return the address of the word or bit that a tag names, or None for any other tag."""


class OperatorActions:
    """The operator's access to a running rack.

    Args:
        rack: the rack; its simulated modules accept injected faults.
        tags: the tags of the program; None if none can be set.
        edit: function that continues with an edited program, at the time of the next scan; None if that is
            impossible.

    Attributes:
        applied: the actions that were carried out.
        words: word names of the modules, by slot.
    """

    def __init__(
        self,
        cpu: Cpu,
        rack: Rack,
        tags: WritableTags | None,
        edit: Callable[[actions.Edit, int], None] | None = None,
    ) -> None:
        self._cpu, self._rack, self._tags, self._edit_program = cpu, rack, tags, edit
        self.applied: list[AppliedAction] = []
        self.words: Mapping[int, ModuleWords] = {slot.number: slot.words for slot in rack.slots.values()}

    def act(self, action: Action, at_ns: int, scan: int) -> None:
        """Carry out an action before the next scan, and announce the action's event.

        The first press of a card's input ends the card's timeline, so that only the operator sets its inputs.

        Raises:
            ValueError: the action can't be carried out; nothing has changed.
        """
        handler = _HANDLERS.get(type(action))
        side_effect = handler(self, action, at_ns) if handler is not None else None
        self.applied.append(AppliedAction(scan, action))
        latest_scan_ns = max(at_ns - self._cpu.period_ns, 0)
        text = sentence(action) if side_effect is None else f"{sentence(action)} {side_effect}"
        fields = {"order": text_of(action)}
        self._cpu.announce(Event(latest_scan_ns, "order", NAMES[type(action)], text, fields))

    def _image_address(self, tag: str) -> str | None:
        """Return the address of the image word or bit that a tag names, or None for any other tag."""
        try:
            return str(parse_address(tag, self.words))
        except ValueError:
            tags: object = self._tags
            return tags.address_of(tag) if isinstance(tags, NamedImages) else None

    # --- handlers: one action each

    def _mode(self, action: actions.Mode, _at_ns: int) -> None:
        self._cpu.mode = CpuMode[action.mode.upper()]

    def _press(self, action: actions.Press, _at_ns: int) -> str | None:
        """Set an input of a card or of a simulated module.

        Return a sentence if this ends the card's timeline, else None.
        """
        module: Any = self._rack.slots[action.slot].module
        device = getattr(module, "module", module)  # an ExposedModule wraps the device
        if isinstance(device, NamedInputs):
            if action.on is None:
                raise ValueError(f"slot {action.slot}: an input of a card must be true or false, not null")
            device.set_input(action.name, action.on)
            if isinstance(device, PressedByTimeline) and device.end_timeline():
                return f"The timeline of slot {action.slot} ends."
        elif isinstance(device, ModuleWithInputs):
            bit = INPUT_NAMES.get(action.name.lower())
            if bit is None:
                raise ValueError(f"no input {action.name!r}: inputs are {', '.join(INPUT_NAMES)}")
            device.operate(bit, action.on)
        else:
            raise ValueError(f"slot {action.slot}: its inputs are real; they can't be set here")
        return None

    def _write(self, action: actions.Write, _at_ns: int) -> None:
        """Set a tag of the program; refuse an image."""
        if self._image_address(action.tag) is not None:
            raise ValueError(f"{action.tag} is an image, which every scan writes again; force it instead")
        self._writable_tags(action.tag).tags[action.tag] = action.value

    def _store(self, action: actions.Store, _at_ns: int) -> None:
        """Set bytes of an output image or of a tag, for a client; bits that are 1 in `keep` do not change."""
        data, keep = bytes.fromhex(action.data), bytes.fromhex(action.keep)
        slot = output_slot(action.tag)
        if slot is not None and slot in self._rack.slots:
            raw = self._rack.slots[slot].outputs.raw
            end = action.offset + len(data)
            if end > len(raw):
                raise ValueError(f"{action.tag} has no byte {end - 1}; it has {len(raw)} bytes")
            raw[action.offset : end] = patched(bytes(raw[action.offset : end]), data, keep)
            return
        tags = self._writable_tags(action.tag)
        if not isinstance(tags, ByteStore):
            raise ValueError(f"{action.tag}: the program has no tags that clients can write")
        tags.store(action.tag, action.offset, data, keep)

    def _force(self, action: actions.Force, _at_ns: int) -> None:
        """Force a word or bit of an image, or a tag."""
        address = self._image_address(action.tag)
        if address is None:
            self._writable_tags(action.tag).force(action.tag, action.value)
        elif not isinstance(action.value, int):
            raise ValueError(f"{action.tag} can't be forced to {action.value!r}: must be a whole number")
        else:
            self._cpu.forces.set(address, int(action.value))

    def _unforce(self, action: actions.Unforce, _at_ns: int) -> None:
        """Remove the force on an image or a tag, or all forces."""
        if action.tag == ALL:
            self._cpu.forces.clear()
            if self._tags is not None:
                self._tags.unforce()
        elif (address := self._image_address(action.tag)) is not None:
            self._cpu.forces.remove(address)
        else:
            self._writable_tags(action.tag).unforce(action.tag)

    def _inject_fault(self, action: actions.InjectFault, at_ns: int) -> None:
        """Inject a fault into a simulated module."""
        module = self._rack.slots[action.slot].module
        if not isinstance(module, ExposedModule):
            raise ValueError(f"slot {action.slot}: can't inject faults into real modules")
        kind, for_ns = FaultKind(action.kind), exact_ns(action.for_ms, "ms", "for_ms")
        fault = InjectedFault(at_ns, kind, action.slot, for_ns, action.late_words, action.state)
        fault.check_late_words(len(self.words[action.slot].outputs))
        module.happen(fault)

    def _edit(self, action: actions.Edit, at_ns: int) -> None:
        if self._edit_program is None:
            raise ValueError("the files of an edited program are missing")
        self._edit_program(action, at_ns)

    def _writable_tags(self, tag: str) -> WritableTags:
        """Return the tags of the program; refuse to set `tag` if there are none."""
        if self._tags is None:
            raise ValueError(f"{tag}: the program has no tags that can be set; images can be forced")
        return self._tags


_HANDLERS: Mapping[type[Action], Callable[[OperatorActions, Any, int], str | None]] = {
    actions.Mode: OperatorActions._mode,
    actions.Press: OperatorActions._press,
    actions.Write: OperatorActions._write,
    actions.Store: OperatorActions._store,
    actions.Force: OperatorActions._force,
    actions.Unforce: OperatorActions._unforce,
    actions.InjectFault: OperatorActions._inject_fault,
    actions.Edit: OperatorActions._edit,
}
"""Handlers for actions that change the rack. Each returns None, or a sentence to replace the default one."""


_LEVELS = {True: "energized", False: "de-energized", None: "left to the machine"}

_SENTENCES: Mapping[type[Action], Callable[[Any], str]] = {
    actions.Mode: lambda action: f"The key is turned to {action.mode}.",
    actions.Pause: lambda _action: "The rack pauses.",
    actions.Continue: lambda _action: "The rack continues.",
    actions.Step: lambda action: f"{action.scans} scan{'' if action.scans == 1 else 's'}, then a pause.",
    actions.Speed: lambda action: f"The speed is {action.factor}.",
    actions.Press: lambda action: (
        f"Slot {action.slot}: the {action.name} input is {_LEVELS[action.on]}{_by(action.by)}."
    ),
    actions.Write: lambda action: f"{action.tag} is set to {_shown(action.value)}{_by(action.by)}.",
    actions.Store: lambda action: f"{action.client or 'A client'} writes {action.tag}{action.part}.",
    actions.Force: lambda action: f"{action.tag} is forced to {_shown(action.value)}.",
    actions.Unforce: lambda action: (
        "All forces are removed." if action.tag == ALL else f"{action.tag} is no longer forced."
    ),
    actions.InjectFault: lambda action: f"Slot {action.slot}: {action.state or action.kind}.",
    actions.Breakpoint: lambda action: f"A breakpoint is set: {action.at}.",
    actions.RemoveBreakpoint: lambda action: f"A breakpoint is removed: {action.at}.",
    actions.Reload: lambda _action: "The program is loaded again.",
    actions.Edit: lambda action: f"Edit {action.number} of the program.",
    actions.Branch: lambda action: f"Another way from scan {action.scan:,} on.",
}


def sentence(action: Action) -> str:
    """Describe an action in a sentence.

    >>> from scanrack.runtime.live.actions import Press
    >>> sentence(Press(1, "home", True))
    'Slot 1: the home input is energized.'
    """
    return _SENTENCES[type(action)](action)


def _by(operator: str) -> str:
    return f" ({operator})" if operator else ""


def _shown(value: Value) -> str:
    return str(int(value)) if isinstance(value, bool) else str(value)
