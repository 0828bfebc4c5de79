"""The surroundings of a drive as text, for command lines and test programs: `in1=on`, `cable=lost`.

in1=on, in1=off          a level of an input; an input of a model has its own name
in1=1000..1500           a switch that is closed while the shaft is at these steps from power-up
encoder=-400             the shaft's encoder is turned by hand, x4 counts
stall=now                the motor stalls
temperature=95           of the driver, degC
driver_fault=on, off     the driver is too hot to work
encoder_error=on, off    the multi-turn encoder has an error
cable=lost, connected    the network cable
connection=lost          the controlling connection times out
power=cycle              power goes off and on; the flash and the shaft keep what they have
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ...controllers.pcl601.pinstates import range_of
from ...machine import Switch
from .drive import DriveUnit

Act = Callable[[DriveUnit], None]

COLDEST_C, HOTTEST_C = -273, 1000
COUNTS_MOST = 2**31 - 1

_ON_OFF = {"on": True, "off": False}

STATES: Mapping[str, Mapping[str, Act]] = {
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
"""What a name does in each of its states."""

NUMBERS: Mapping[str, tuple[int, int, Callable[[DriveUnit, int], None]]] = {
    "temperature": (COLDEST_C, HOTTEST_C, DriveUnit.set_temperature),
    "encoder": (-COUNTS_MOST, COUNTS_MOST, lambda drive, counts: _turn(drive, counts)),
}
"""Names with a number: its range, and what it does."""


def surround(drive: DriveUnit, name: str, state: str, wired: int = 0) -> None:
    """Put a drive into other surroundings, from the instant of its last call on.

    Args:
        wired: mask of the inputs that only the machine may change.

    Raises:
        ValueError: an unknown name or state, or an input that is wired to the machine.
    """
    if name in drive.model.input_names:
        _set_input(drive, name, state, wired)
    elif name in STATES:
        if state not in STATES[name]:
            raise ValueError(f"{name}={state}: it has to be {' or '.join(STATES[name])}")
        STATES[name][state](drive)
    elif name in NUMBERS:
        first, last, act = NUMBERS[name]
        try:
            number = int(state)
        except ValueError:
            number = last + 1
        if not first <= number <= last:
            raise ValueError(f"{name}={state}: it has to be {first:,} to {last:,}")
        act(drive, number)
    else:
        names = (*drive.model.input_names, *STATES, *NUMBERS)
        raise ValueError(f"no {name} at the {drive.model.title}; choose from {', '.join(names)}")


def _set_input(drive: DriveUnit, name: str, state: str, wired: int) -> None:
    bit = drive.terminals[drive.model.input_names.index(name)]
    if bit.value & wired:
        raise ValueError(f"{name} is wired to the machine ({str(bit.name).lower()})")
    if state in _ON_OFF:
        drive.machine.rewire(bit, [])
        drive.machine.set_input(bit, _ON_OFF[state])
        return
    try:
        first, last = range_of(state)
    except ValueError:
        allowed = "on, off, or positions such as 9000.. or ..-3000 or 5..10"
        raise ValueError(f"{name}={state}: it has to be {allowed}") from None
    drive.machine.rewire(bit, [Switch(bit, first, last)])


def _turn(drive: DriveUnit, counts: int) -> None:
    drive.machine.turn_encoder(counts, drive.now_ns, drive.now_ns)
