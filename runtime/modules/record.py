"""The record of a kind of module; other packages use modules only through their records."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import Image
from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords
from scanrack.io_images.number_formats import NumberFormat
from scanrack.io_images.site import SettingError

from ..loop.events import JsonValue
from ..loop.exposed import Conditions
from ..loop.module import Module
from ..machine import Machine
from ..machine.spec import INPUT_NAMES

if TYPE_CHECKING:
    from pydantic import BaseModel

Options = Mapping[str, JsonValue]
"""A slot's options by name, as written in a rack file."""


class LiveModule(Module, Protocol):
    """A module on a real port."""

    def close(self) -> None:
        """Stop the motor and close the port."""


@runtime_checkable
class NamedInputs(Protocol):
    """A module with named inputs."""

    def set_input(self, name: str, energized: bool) -> None:
        """Set an input; raise ValueError for an unknown input."""


@runtime_checkable
class AnalogInputs(Protocol):
    """A module with named analog inputs."""

    def set_value(self, name: str, value: float) -> None:
        """Set an input; raise ValueError for an unknown input or an invalid value."""


@runtime_checkable
class ModuleWithInputs(Protocol):
    """A module whose machine has inputs that can be operated by hand."""

    def operate(self, bit: InputBit, energized: bool | None) -> None:
        """Set an input at the last `update`; None returns it to the machine."""


@runtime_checkable
class ModuleWithFigures(Protocol):
    """A module whose machine can be read between scans without side effects."""

    def figures(self) -> tuple[int, int, int]:
        """Return the shaft's position (steps), the encoder's counts, and the mask of energized inputs."""


@runtime_checkable
class ModuleWithFormats(Protocol):
    """A module whose configuration selects its number format."""

    @property
    def number_format(self) -> NumberFormat:
        """The format of the numbers that the PLC reads."""


@runtime_checkable
class PressedByTimeline(Protocol):
    """A module whose inputs are operated by a timeline in the rack file."""

    def end_timeline(self) -> bool:
        """Cancel the remaining presses; return whether any remained."""


@runtime_checkable
class ModuleWithMachine(Module, Protocol):
    """A module that drives a simulated machine."""

    def machine_at(self, now_ns: int) -> Machine:
        """Return the machine at `now_ns`, the instant of the last `update`."""


@runtime_checkable
class PredictableMachine(ModuleWithMachine, Protocol):
    """A module that can predict its machine as long as nothing acts on the machine.

    If it can't predict, it returns an instant no later than the last `update`.
    """

    def shaft_calm_until_ns(self, first: int | None, last: int | None) -> int:
        """Return an instant before which the shaft does not enter or leave positions `first` to `last`.

        None means an open end.
        """

    def levels_calm_until_ns(self) -> int:
        """Return an instant before which no level of the machine's inputs changes."""


class Trait(Enum):
    """Possible faults and equipment of a kind of module, for `fuzz` and `drive`."""

    FIRMWARE = "has the firmware versions of a 3601"
    STOPS_ANSWERING = "can be made to stop answering"
    MACHINE = "drives a machine"
    SLIPS = "its machine may lose steps"
    LINE = "has a device at the far end of a line"


@dataclass(frozen=True, slots=True, kw_only=True)
class LivePort:
    """Opens an adapter of one kind on a real port."""

    opened: Callable[[str, int, Options], LiveModule]  # opens (port, address, options), or ValueError
    factory_address: int
    highest_address: int  # an address is 1 to `highest_address`, or `factory_address`

    def check_address(self, address: int | None) -> None:
        """Raise a ValueError if the device can't have an address."""
        if address is None or 1 <= address <= self.highest_address or address == self.factory_address:
            return
        allowed = f"1 to {self.highest_address}"
        if self.factory_address > self.highest_address:
            allowed += f", or {self.factory_address} (factory setting)"
        raise SettingError("address", f"address {address}: must be {allowed}")

    def open(self, port: str, address: int | None, options: Options) -> LiveModule:
        """Open a port, and return its adapter.

        Args:
            port: a serial device, or tcp:HOST:PORT.
            address: address of the device, or None for the factory setting.

        Raises:
            ValueError: an invalid option, or a port that can't be opened.
        """
        return self.opened(port, self.factory_address if address is None else address, options)


class NamedStatus:
    """An input image with the module's names as attributes: bits of the group "status", and words.

    >>> from scanrack.io_images.module_words import BitPlace
    >>> words = ModuleWords("Lamp", PLAIN_WORDS.outputs, ("state", *PLAIN_WORDS.inputs[1:]),
    ...                     {"status": {"LIT": BitPlace("I", 0, 3)}})
    >>> seen = NamedStatus(Image([0b1000]), words)
    >>> seen.LIT, seen.state, str(seen)
    (True, 8, 'LIT')
    """

    def __init__(self, inputs: Image, words: ModuleWords) -> None:
        self._inputs = inputs
        self._bits = dict(words.groups.get("status", {}))
        self._words = {name: number for number, name in enumerate(words.inputs)}

    def __getattr__(self, name: str) -> bool | int:
        if name in self._bits:
            return self._inputs.bit(self._bits[name].word, self._bits[name].bit)
        if name in self._words:
            return self._inputs[self._words[name]]
        name_list = ", ".join([*self._bits, *self._words])
        raise AttributeError(f"the module's inputs have no {name!r}; choose from {name_list}")

    def __str__(self) -> str:
        return " ".join(name for name in self._bits if getattr(self, name)) or "no bit"


def _any_controller(firmware: str, controller: str) -> None:
    """Accept any controller."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModuleRecord:
    """A kind of module.

    Attributes:
        name: the module's catalog name, as used in rack files and by `scanrack drive`.
        make: makes a simulated module from (firmware, machine, seed, options, wiring), or raises a ValueError
            that names the invalid argument.
        words: returns the names of its words and bits for the options.
        has_firmware: whether traces record its firmware.
        status: decodes its input image; by default with the names of its words.
        live: opens the module on a real port; None if it does not support one.
        traits: its possible faults and equipment.
        follows: returns the slots whose machines operate its inputs.
        buttons: returns the names of the inputs that are operated by a person.
        signals: returns its analog inputs by name, with test values.
        check_controller: refuses an incompatible (firmware, controller) with a ValueError.
        family: "1762" or "1769" for a card that fits only one family of controllers; "" for any other module.
        switches: returns (slot, switch) for each machine switch that operates one of its inputs.
        capabilities: returns the table of its refusals in Markdown; None without refusals.
        option_table: returns the class of its options, for editors; None without options.
        round_trip_ms: maximum time to answer a command, ms; 0 if it answers at once.
        conditions: returns the environment of a module, if it can be set while the module runs.
        states: returns the names in the environment, with their states or an example of their number.
        machine_inputs: returns the machine's inputs that are wired to the module, with the module's names for
            them, or "" if the names are equal.
        unread: whether the module's file is not executed, so that options and named bits are not checked.
    """

    name: str
    make: Callable[..., Module]
    words: Callable[[Options], ModuleWords] = lambda _options: PLAIN_WORDS
    has_firmware: bool = False
    status: Callable[[Image, ModuleWords], Any] = NamedStatus
    live: LivePort | None = None
    traits: frozenset[Trait] = frozenset()
    follows: Callable[[Options], frozenset[int]] = lambda _options: frozenset()
    buttons: Callable[[Options], tuple[str, ...]] = lambda _options: ()
    signals: Callable[[Options], Mapping[str, tuple[float, ...]]] = lambda _options: {}
    check_controller: Callable[[str, str], None] = _any_controller
    family: str = ""
    switches: Callable[[Options], tuple[tuple[int, str], ...]] = lambda _options: ()
    capabilities: Callable[[], str] | None = None
    option_table: Callable[[], type[BaseModel]] | None = None
    round_trip_ms: int = 0
    conditions: Callable[[Any], Conditions] | None = None
    states: Callable[[], Mapping[str, Sequence[str]]] = dict
    machine_inputs: Callable[[Options], Mapping[str, str]] = lambda _options: dict.fromkeys(INPUT_NAMES, "")
    unread: bool = False
