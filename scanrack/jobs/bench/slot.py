"""A module on the bench: its words, its machine, and methods for a test to act on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scanrack.io_images.amci3601.words import profile_of
from scanrack.io_images.image import Image
from scanrack.runtime.loop.exposed import fault_event
from scanrack.runtime.loop.incidents import TROUBLES, FaultKind
from scanrack.runtime.loop.rack import Slot
from scanrack.runtime.machine.spec import INPUT_NAMES
from scanrack.runtime.modules.record import AnalogInputs, ModuleRecord, NamedInputs, Trait


class SlotBench:
    """A module on the bench, and its machine: `bench.slot[1]`.

    Attributes:
        number: slot number.
        outputs: the latest output image of the program.
        inputs: the latest input image that the program read.
        status: the bits and values of the input image, by name.
    """

    def __init__(
        self, slot: Slot, record: ModuleRecord, run_for: Callable[[str], None], now_ns: Callable[[], int]
    ) -> None:
        self.number = slot.number
        self.outputs: Image = slot.outputs
        self.inputs: Image = slot.inputs
        self._slot = slot
        self.status: Any = record.status(slot.inputs, slot.words)
        self._record = record
        self._run_for, self._now_ns = run_for, now_ns
        self._latest_fault = FaultKind.POWER_CYCLE  # the fault that was last injected
        self._module: Any = slot.module
        self._device: Any = getattr(slot.module, "module", slot.module)  # unwrap injected faults

    @property
    def moving(self) -> bool:
        """Whether the axis is moving in either direction, according to the program's latest input image."""
        return bool(self.status.moving)

    @property
    def shaft(self) -> int:
        """True position of the shaft, in steps from power-up. The module may report a different position."""
        shaft, *_ = self._device.figures()
        return int(shaft)

    @property
    def energized(self) -> frozenset[str]:
        """The inputs of the machine that are energized, by name."""
        mask = self._device.figures()[2]
        return frozenset(name for name, bit in INPUT_NAMES.items() if mask & bit)

    def set_input(self, name: str, energized: bool) -> None:
        """Set an input until it is set again.

        Args:
            name: "capture", "external", "home", "estop", "cw_limit" or "ccw_limit"; for a card, the name in
                the rack file.

        Raises:
            ValueError: the input is unknown, or is controlled by the machine of the rack file.
        """
        if isinstance(self._device, NamedInputs):
            self._device.set_input(name, energized)
            return
        bit = INPUT_NAMES.get(name.lower())
        if bit is None:
            raise ValueError(f"no input {name!r}: inputs are {', '.join(INPUT_NAMES)}")
        self._device.machine.set_input(bit, energized)
        self._device.look_again()

    def set_value(self, name: str, value: float) -> None:
        """Set an analog input of a card until it is set again.

        Args:
            value: V or mA for a channel with a range; otherwise the raw number.

        Raises:
            ValueError: the input is unknown, or the value is illegal.
        """
        if not isinstance(self._device, AnalogInputs):
            raise ValueError(f"slot {self.number}: a {self._slot.catalog} has no analog inputs")
        self._device.set_value(name, value)

    def press(self, name: str, for_: str = "50 ms") -> None:
        """Energize an input, run for a time, and then release the input.

        Raises:
            ValueError: see `set_input`; or `for_` is not a time.
        """
        self.set_input(name, True)
        self._run_for(for_)
        self.set_input(name, False)

    def power_cycle(self) -> None:
        """Remove and restore the module's power."""
        self._module.power_cycle()
        self._announce(FaultKind.POWER_CYCLE, begins=True)

    def inject(self, how: str | None) -> None:
        """Inject a fault into the module, or end its fault.

        Args:
            how: "link-lost", "removed", "fatal-error" or "asic-lost"; None = end the fault.

        Raises:
            ValueError: the fault is unknown, or the module has no faults.
        """
        troubles = {kind.value: trouble for kind, trouble in TROUBLES.items()}
        if how is not None and how not in troubles:
            raise ValueError(f"no fault {how!r}; choose from {', '.join(troubles)}")
        if not hasattr(self._device, "inject"):
            raise ValueError(f"slot {self.number}: faults can't be injected into this module")
        if how is None and self._device.trouble is TROUBLES[FaultKind.FATAL_ERROR]:
            self._device.power_cycle()  # the only end of a fatal error
        else:
            self._device.inject(None if how is None else troubles[how])
        self._announce(None if how is None else FaultKind(how), begins=how is not None)

    def _announce(self, fault: FaultKind | None, *, begins: bool) -> None:
        """Record a test's action on the module with the next scan, like an injected fault in a rack file."""
        self._latest_fault = fault or self._latest_fault
        event = fault_event(self._now_ns(), self._latest_fault, begins=begins)
        self._module.events.append(event)

    def __str__(self) -> str:
        if Trait.MACHINE not in self._record.traits:
            return f"slot {self.number}: {self.status}; outputs {list(self.outputs)}"
        msw, lsw = self.inputs[0] & 0xFFFF, self.inputs[1] & 0xFFFF
        bits = " ".join(profile_of(self._slot.words).status_names(msw, lsw)) or "no bit"
        levels = self._device.machine.levels(self._now_ns())
        energized = [name for name, bit in INPUT_NAMES.items() if levels & bit]
        return (
            f"slot {self.number}: {bits}; position {self.status.position}, shaft {self.shaft}; "
            f"energized {', '.join(energized) or 'nothing'}; outputs {list(self.outputs)}"
        )
