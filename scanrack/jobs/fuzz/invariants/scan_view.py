"""The argument of an invariant: the images and the logic's values at the end of a scan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scanrack.io_images.amci3601 import MOTIONS, CommandMsw, StatusView
from scanrack.io_images.amci3601.words import may_be_stepper, profile_of
from scanrack.io_images.drives.status import status_view
from scanrack.io_images.drives.translation import model_of
from scanrack.io_images.image import UNSIGNED_MAX, Image
from scanrack.runtime.loop.module import Module
from scanrack.runtime.loop.rack import Rack, Slot
from scanrack.runtime.loop.scan import MODE_MASK, CpuMode, mode_name
from scanrack.runtime.modules.record import ModuleWithFigures, ModuleWithFormats

from .busy import BusyReader

NO_WORDS = Image().words
"""Words in force while the CPU sends no outputs. Also used for cards, whose words are not commands."""


class SlotSnapshot:
    """A module at the end of a scan.

    Attributes:
        outputs: the logic's latest words, sent or not. They change with each scan, so do not store them.
        status: the bits and values of `inputs` by the module's names. A card has all bits off and all values
            0.
    """

    __slots__ = ("_in_force", "_is_axis", "_profile", "_slot", "inputs", "outputs", "status")

    def __init__(self, slot: Slot) -> None:
        self._slot = slot
        self.outputs: Image = slot.outputs
        self.inputs: Image = slot.inputs
        self._is_axis = may_be_stepper(slot.words)
        self._profile = profile_of(slot.words)
        self.status = self._status_view()
        self.set_sent(True)

    def _status_view(self) -> StatusView:
        model = model_of(self._slot.words)
        if model is not None:
            return status_view(self.inputs, model, self._number)
        return self._profile.view(self.inputs if self._is_axis else Image())

    def _number(self, words: Sequence[int], first: int) -> int:
        """Return the number in two words of a drive in its current format; `first` is the first word."""
        module = self._module
        assert isinstance(module, ModuleWithFormats)
        return module.number_format.join(words[first], words[first + 1]) or 0

    @property
    def _module(self) -> Module:
        module: Module = getattr(self._slot.module, "module", self._slot.module)  # unwrap injected faults
        return module

    def set_sent(self, sent: bool) -> None:
        """Set whether the CPU sends the outputs. Words that it does not send are not in force."""
        self._in_force = self.outputs.words if sent and self._is_axis else NO_WORDS

    def __str__(self) -> str:
        """Return a description of the visible state."""
        if not self._is_axis:
            return f"outputs {_hex(self.outputs)}; inputs {_hex(self.inputs)}"
        commands = "configuration" if self.configuring else " ".join(self.commands) or "none"
        status = " ".join(self._profile.status_names(self.inputs[0], self.inputs[1])) or "none"
        return f"commands {commands}; status {status}; position {self.position}"

    @property
    def linked(self) -> bool:
        """Whether the PLC has a connection to the module."""
        return self._slot.fault == 0

    @property
    def moving(self) -> bool:
        """Whether the axis moves in either direction."""
        return self.status.moving

    @property
    def position(self) -> int:
        """The position that the module reports, steps."""
        return self.status.position

    @property
    def shaft(self) -> int:
        """The true position of the motor's shaft at the last update, steps; 0 at power-up.

        Raises:
            LookupError: the module has no machine.
        """
        module = self._module
        if not isinstance(module, ModuleWithFigures):
            raise LookupError(f"slot {self._slot.number} has no shaft")
        return module.figures()[0]

    @property
    def configuring(self) -> bool:
        """Whether the words in force are a configuration instead of commands."""
        return self._in_force[0] < 0

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the command bits in force.

        The tuple is empty in configuration mode. It is also empty while the CPU does not send its outputs
        (program and test mode).
        """
        word = self._in_force[0]
        if word < 0:
            return ()
        return tuple(str(bit.name) for bit in CommandMsw if word & bit.value)

    @property
    def motions(self) -> int:
        """Number of command bits in force that move the axis."""
        word = self._in_force[0]
        return 0 if word < 0 else (word & MOTIONS.value).bit_count()


def _hex(image: Image) -> str:
    """Return the words of an image in Logix notation, up to the last word that is not 0.

    >>> _hex(Image([5, -1])), _hex(Image())
    ('16#0005 16#FFFF', '16#0000')
    """
    words = [word & UNSIGNED_MAX for word in image.words]
    while len(words) > 1 and words[-1] == 0:
        words.pop()
    return " ".join(f"16#{word:04X}" for word in words)


class Slots(dict[int, SlotSnapshot]):
    """The modules by slot number."""

    def __missing__(self, number: object) -> SlotSnapshot:
        """Raise a LookupError that names the existing slots."""
        raise LookupError(f"no slot {number!r}; the rack has {', '.join(map(str, self))}")


class ProgramState:
    """The values of a Python program: fields of the running object, then globals of the module.

    The values are the program's own objects, so an invariant must not change them.
    """

    __slots__ = ("_namespaces",)

    def __init__(self, *namespaces: Mapping[str, Any]) -> None:
        self._namespaces = namespaces

    def __getattr__(self, name: str) -> Any:
        """Return a value of the program; raise AttributeError with the public names if it has none."""
        for namespace in self._namespaces:
            if name in namespace:
                return namespace[name]
        names = sorted({name for namespace in self._namespaces for name in namespace if name[:1] != "_"})
        raise AttributeError(f"the program has no {name}, only {', '.join(names) or 'tags'}")


class Snapshot:
    """The state at the end of a scan. A run updates the same object in every scan.

    Attributes:
        ns: virtual time, ns since power-up.
        slot: modules by slot number.
        tags: all tags of a ladder program by full name, including program-scoped tags; empty for a plain
            function.
        state: values of a Python program.
        rules: ids of the manual's rules that fired in this scan, in order.
        mode: mode of the CPU: "run", "test", "program" or "single scan".
        axes: readers of the commands in progress, one per axis of the program.
        resting: whether this scan did not call the logic, as in program mode.
    """

    __slots__ = ("_mode", "axes", "mode", "ns", "resting", "rules", "scan", "slot", "state", "tags")

    def __init__(
        self,
        rack: Rack,
        tags: Mapping[str, Any],
        axes: tuple[BusyReader, ...] = (),
        state: ProgramState | None = None,
    ) -> None:
        self.scan = 0
        self.ns = 0
        self.slot = Slots((number, SlotSnapshot(slot)) for number, slot in rack.slots.items())
        self.tags = tags
        self.axes = axes
        self.state = state or ProgramState()
        self.rules: Sequence[str] = ()
        self._mode = CpuMode.RUN.value
        self.mode = mode_name(CpuMode.RUN)
        self.resting = False

    def move_on(self, scan: int, ns: int, flags: int) -> None:
        """Update the snapshot at the end of another scan."""
        self.scan, self.ns = scan, ns
        if flags & MODE_MASK != self._mode:
            self._mode = flags & MODE_MASK
            mode = CpuMode(self._mode)
            self.mode, self.resting = mode_name(mode), mode is CpuMode.PROGRAM
            for slot in self.slot.values():
                slot.set_sent(mode is CpuMode.RUN)

    @property
    def seconds(self) -> float:
        """Virtual time of the scan, s since power-up."""
        return self.ns / 1e9
