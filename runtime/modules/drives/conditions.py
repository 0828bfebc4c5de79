"""The environment of a drive, as text for rack files, pages, command lines and test programs.

in1=on, in1=off          level of an input; the names of the inputs depend on the model
in1=1000..1500           switch that is closed between these shaft positions, steps from power-up
encoder=-400             the shaft's encoder is turned by hand, x4 counts
stall=now                the motor stalls
temperature=95           temperature of the driver, degC
driver_fault=on, off     the driver is too hot to work
encoder_error=on, off    the multi-turn encoder has an error
cable=lost, connected    the network cable
connection=lost          the controlling connection times out
power=cycle              power goes off and on; the flash and the shaft keep their state
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.drives.bits import StatusBit
from scanrack.io_images.site import SettingError

from ...controllers.pcl601.pinstates import range_of
from ...machine import Switch
from .drive import DriveUnit

Action = Callable[[DriveUnit], None]

COLDEST_C, HOTTEST_C = -273, 1000
COUNTS_MAX = 2**31 - 1

_ON_OFF = {"on": True, "off": False}

STATES: Mapping[str, Mapping[str, Action]] = {
    "driver_fault": {
        "on": lambda drive: drive.set_driver_fault(True),
        "off": lambda drive: drive.set_driver_fault(False),
    },
    "encoder_error": {
        "on": lambda drive: drive.set_encoder_error(True),
        "off": lambda drive: drive.set_encoder_error(False),
    },
    "cable": {
        "lost": lambda drive: drive.set_cable(False),
        "connected": lambda drive: drive.set_cable(True),
    },
    "connection": {"lost": DriveUnit.lose_connection},
    "stall": {"now": DriveUnit.stall},
    "power": {"cycle": DriveUnit.power_cycle},
}
"""The actions of each name, by state."""


class NumberRow(NamedTuple):
    """A name whose state is a number."""

    lowest: int
    highest: int
    example: str
    set_number: Callable[[DriveUnit, int], None]


NUMBERS: Mapping[str, NumberRow] = {
    "temperature": NumberRow(COLDEST_C, HOTTEST_C, "95", DriveUnit.set_temperature),
    "encoder": NumberRow(-COUNTS_MAX, COUNTS_MAX, "-400", lambda drive, counts: _turn(drive, counts)),
}


NEEDED: Mapping[str, StatusBit] = {
    "driver_fault": StatusBit.DRIVER_FAULT,
    "encoder_error": StatusBit.ENCODER_ERROR,
    "stall": StatusBit.STALL_DETECTED,
    "temperature": StatusBit.TEMPERATURE_90C,
}
"""The status bit that a model needs to support a name."""


class DriveConditions:
    """The environment of a drive in a slot; satisfies `runtime.loop.exposed.Conditions`.

    Args:
        drive: a drive on which no input has been set yet; inputs that its machine operates can't be set.
    """

    def __init__(self, drive: DriveUnit) -> None:
        self._drive, self._wired = drive, drive.machine.spec.fed_inputs

    def check(self, state: str) -> None:
        """Raise a ValueError if the drive can't have a state."""
        action(self._drive, *_split_state(state), self._wired)

    def put(self, state: str) -> None:
        """Put the drive into a state at the instant of its last `update`."""
        action(self._drive, *_split_state(state), self._wired)()


def states() -> Mapping[str, Sequence[str]]:
    """Return the names for all models, with their states or an example of their number."""
    examples = {name: (row.example,) for name, row in NUMBERS.items()}
    return {**{name: tuple(actions) for name, actions in STATES.items()}, **examples}


def _split_state(state: str) -> tuple[str, str]:
    name, equals, value = state.partition("=")
    if not equals:
        raise SettingError("state", f"state {state!r}: must be NAME=STATE, such as temperature=95")
    return name.strip(), value.strip()


def action(drive: DriveUnit, name: str, state: str, wired: int = 0) -> Callable[[], None]:
    """Return a function that puts a drive into a state at the instant of the drive's last call.

    Args:
        wired: mask of the inputs that only the machine may change.

    Raises:
        ValueError: an unknown name or state, an input wired to the machine, or a function that the model
            lacks.
    """
    model = drive.model
    if name in model.input_names:
        return _input_action(drive, name, state, wired)
    if name in NEEDED and model.moved_status.get(NEEDED[name]) == 0:
        raise ValueError(f"{name}={state}: the {model.title} lacks the status bit {NEEDED[name].name}")
    if name == "encoder" and not drive.options.encoder_fitted:
        raise ValueError(f"{name}={state}: the unit has no encoder (option encoder_fitted = false)")
    if name in STATES:
        if state not in STATES[name]:
            raise ValueError(f"{name}={state}: must be {' or '.join(STATES[name])}")
        return partial(STATES[name][state], drive)
    if name in NUMBERS:
        row = NUMBERS[name]
        try:
            number = int(state)
        except ValueError:
            number = row.highest + 1
        if not row.lowest <= number <= row.highest:
            raise ValueError(f"{name}={state}: must be {row.lowest:,} to {row.highest:,}")
        return partial(row.set_number, drive, number)
    names = (*model.input_names, *STATES, *NUMBERS)
    raise ValueError(f"no {name} at the {model.title}; choose from {', '.join(names)}")


def _input_action(drive: DriveUnit, name: str, state: str, wired: int) -> Callable[[], None]:
    """Return a function that sets an input, or wires it as a switch at positions; see `action`."""
    bit = drive.terminals[drive.model.input_names.index(name)]
    if bit.value & wired:
        raise ValueError(f"{name} is wired to the machine ({str(bit.name).lower()})")
    if state in _ON_OFF:
        return partial(_hold_input, drive, bit, _ON_OFF[state])
    try:
        first_step, last_step = range_of(state)
    except ValueError:
        allowed = "on, off, or positions such as 9000.. or ..-3000 or 5..10"
        raise ValueError(f"{name}={state}: must be {allowed}") from None
    return partial(drive.machine.rewire, bit, [Switch(bit, first_step, last_step)])


def _hold_input(drive: DriveUnit, bit: InputBit, energized: bool) -> None:
    drive.machine.rewire(bit, [])
    drive.machine.set_input(bit, energized)


def _turn(drive: DriveUnit, counts: int) -> None:
    drive.machine.turn_encoder(counts, drive.now_ns, drive.now_ns)
