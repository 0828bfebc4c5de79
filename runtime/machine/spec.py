"""The parts of a machine: switches, timeline, encoder, slips, jams, stations.

Positions are true shaft positions in motor steps, CW positive, 0 at power-up of the rack. Times are ns since
power-up. Everything here is data; `machine.Machine` implements the behavior. An invalid part raises a
ValueError that shows the field, the value and the allowed values. A rack file uses the same names; the field
types define how values are written in the file.
"""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from typing import Annotated

from pydantic import (
    BeforeValidator,
    ConfigDict,
    PlainSerializer,
    PlainValidator,
    StrictBool,
    StrictInt,
    WithJsonSchema,
)
from pydantic_core import PydanticCustomError
from scanrack.io_images.addresses import allowed
from scanrack.io_images.amci3601.bits import InputBit
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import SettingError


def input_name(bit: InputBit) -> str:
    """Return the name of an input in files and requests.

    >>> input_name(InputBit.CW_LIMIT)
    'cw_limit'
    """
    return str(bit.name).lower()


INPUT_NAMES = {input_name(bit): bit for bit in InputBit}
"""The inputs by name: capture, external, home, estop, cw_limit, ccw_limit."""


def input_of(value: object) -> InputBit:
    """Return the input with a name; raise PydanticCustomError for an unknown name.

    >>> input_of("cw_limit")
    <InputBit.CW_LIMIT: 16>
    """
    bit = INPUT_NAMES.get(str(value).lower())
    if bit is None:
        raise PydanticCustomError("name", "{hint}", {"hint": allowed(value, INPUT_NAMES)})
    return bit


def _number(value: object) -> Fraction:
    """Return a number as an exact fraction; a float has the value of its shortest decimal form."""
    if isinstance(value, int | float | Decimal) and not isinstance(value, bool):
        try:
            return Fraction(str(value))  # the shortest decimal form of a float
        except ValueError:
            pass
    raise PydanticCustomError("allowed", "a number")


def _ratio(value: object) -> Fraction:
    """Return a number, or a text such as "4/3", as a fraction."""
    try:
        return Fraction(value) if isinstance(value, str) else _number(value)
    except (ValueError, ZeroDivisionError):
        raise PydanticCustomError("allowed", 'a number, or a fraction such as "4/3"') from None


def _times(value: object) -> object:
    return None if value == "always" else value


InputName = Annotated[
    InputBit,
    PlainValidator(input_of),
    PlainSerializer(input_name),
    WithJsonSchema({"enum": list(INPUT_NAMES)}),
]
"""An input; in a file, its name in lower case."""

Ratio = Annotated[
    Fraction,
    PlainValidator(_ratio),
    WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "string", "pattern": r"^\d+/\d+$"}]}),
]
"""A ratio; in a file, a number or a fraction such as "4/3"."""

Chance = Annotated[
    float | Fraction, PlainValidator(_number), WithJsonSchema({"type": "number", "minimum": 0, "maximum": 1})
]
Times = Annotated[
    StrictInt | None,
    BeforeValidator(_times),
    WithJsonSchema({"anyOf": [{"type": "integer", "minimum": 1}, {"enum": ["always"]}]}),
]
"""A number of times; None means unlimited and is written "always" in a file."""

NO_MORE_KEYS = ConfigDict(extra="forbid")


def refusal(owner: object, field: str, value: object, allowed: str) -> ValueError:
    """Return the error for an invalid value in a field of `owner`."""
    return SettingError(field, f"{type(owner).__name__}.{field} is {value!r}; allowed: {allowed}")


def _check_whole(owner: object, field: str, minimum: int | None = None) -> None:
    """Raise a ValueError if a field is not a whole number or is below a minimum; True is not a number."""
    value = getattr(owner, field)
    is_int = isinstance(value, int) and not isinstance(value, bool)
    if not is_int or (minimum is not None and value < minimum):
        limit = "" if minimum is None else f", {minimum} or more"
        raise refusal(owner, field, value, f"a whole number{limit}")


def _check_choice(owner: object, field: str, choices: tuple[object, ...]) -> None:
    """Raise a ValueError if a field is not one of the choices; 1 is not True."""
    value = getattr(owner, field)
    if not any(value is choice or (value == choice and type(value) is type(choice)) for choice in choices):
        raise refusal(owner, field, value, ", ".join(map(repr, choices)))


def _check_input(owner: object, value: object) -> None:
    """Raise a ValueError if a value is not exactly one input."""
    if not (isinstance(value, InputBit) and value in tuple(InputBit)):
        raise refusal(owner, "input", value, "one of " + ", ".join(str(bit.name) for bit in InputBit))


@dataclass(frozen=True, slots=True)
class Switch:
    """A switch or sensor on the machine that is operated while the shaft is within a range of positions.

    Several switches may feed one input: normally open switches in parallel (each of them energizes it), or
    normally closed switches in series (each of them opens the circuit). An input can't have both kinds.

    Attributes:
        input: the module input that the switch is wired to.
        first: lowest shaft position that operates the switch, steps; open-ended if omitted.
        last: highest shaft position that operates the switch, steps; open-ended if omitted.
        normally_closed: whether the input is energized outside the range instead of inside it.
    """

    __pydantic_config__ = NO_MORE_KEYS

    input: InputName
    first: StrictInt | None = None
    last: StrictInt | None = None
    normally_closed: StrictBool = False

    def __post_init__(self) -> None:
        _check_input(self, self.input)
        for field in ("first", "last"):
            if getattr(self, field) is not None:
                _check_whole(self, field)
        if self.first is not None and self.last is not None and self.last < self.first:
            raise refusal(self, "last", self.last, f"{self.first} (first) or more, or None")
        _check_choice(self, "normally_closed", (False, True))

    def operated(self, shaft: int) -> bool:
        """Return whether the switch is operated when the shaft is at a position.

        >>> home = Switch(InputBit.HOME, 3000, 3500)
        >>> home.operated(2999), home.operated(3000), home.operated(3500), home.operated(3501)
        (False, True, True, False)
        """
        return (self.first is None or shaft >= self.first) and (self.last is None or shaft <= self.last)

    def closed(self, shaft: int) -> bool:
        """Return whether the contact is closed when the shaft is at a position."""
        return self.operated(shaft) is not self.normally_closed


@dataclass(frozen=True, slots=True)
class TimelineEntry:
    """The level of an input from an instant until the next entry for that input.

    On an input that a switch or a station feeds, an entry is a fault: a stuck contact (True) or a broken wire
    (False). An entry with None repairs the fault.
    """

    at_ns: int  # ns since power-up
    input: InputBit
    energized: bool | None  # the new level, or None to return the input to its switch or station

    def __post_init__(self) -> None:
        _check_whole(self, "at_ns", 0)
        _check_input(self, self.input)
        _check_choice(self, "energized", (True, False, None))


def press(
    at_ns: int, input: InputBit, for_ns: int, *, normally_closed: bool = False
) -> tuple[TimelineEntry, TimelineEntry]:
    """Return the two timeline entries for a button that is pressed and released.

    >>> [(entry.at_ns, entry.energized) for entry in press(3_200, InputBit.EXTERNAL, 50)]
    [(3200, True), (3250, False)]

    Args:
        for_ns: duration, 1 or more.
        normally_closed: whether pressing the button de-energizes the input. If so, the level before the first
            press needs an entry at 0.

    Raises:
        ValueError: `for_ns` is less than 1, or an entry is invalid.
    """
    if for_ns < 1:
        raise ValueError(f"press: for_ns {for_ns!r}: must be 1 or more")
    pressed = not normally_closed
    return TimelineEntry(at_ns, input, pressed), TimelineEntry(at_ns + for_ns, input, not pressed)


@dataclass(frozen=True, slots=True)
class EncoderSpec:
    """A quadrature encoder that the shaft turns.

    Attributes:
        counts_per_step: x4 counts per step of the shaft, more than 0; a number, or a fraction such as "4/3".
        direction: 1 counts up when the shaft turns CW, -1 counts down.
        marker_every: x4 counts between Z pulses; no Z line if omitted.
        marker_at: count at one of the Z pulses.
    """

    __pydantic_config__ = NO_MORE_KEYS

    counts_per_step: Ratio
    direction: StrictInt = 1
    marker_every: StrictInt | None = None
    marker_at: StrictInt = 0

    def __post_init__(self) -> None:
        ratio: object = self.counts_per_step
        if isinstance(ratio, bool) or not isinstance(ratio, int | Fraction) or ratio <= 0:
            raise refusal(self, "counts_per_step", ratio, "a Fraction or a whole number, more than 0")
        object.__setattr__(self, "counts_per_step", Fraction(ratio))  # the dataclass is frozen
        _check_choice(self, "direction", (1, -1))
        if self.marker_every is not None:
            _check_whole(self, "marker_every", 1)
        _check_whole(self, "marker_at")


@dataclass(frozen=True, slots=True)
class MasterTurn:
    """A movement of a master encoder that an axis follows; the module's own shaft does not turn it.

    Attributes:
        at_ns: start, ns since power-up.
        counts: x4 counts made at a constant speed, the last one at the end; a negative number counts down.
        for_ns: duration, 1 or more.
    """

    at_ns: int
    counts: int
    for_ns: int

    def __post_init__(self) -> None:
        _check_whole(self, "at_ns", 0)
        _check_whole(self, "counts")
        _check_whole(self, "for_ns", 1)

    @property
    def end_ns(self) -> int:
        """End of the movement, ns since power-up."""
        return self.at_ns + self.for_ns


@dataclass(frozen=True, slots=True)
class Slip:
    """Steps that the motor makes without moving the shaft, for example under a heavy load.

    When the motor leaves shaft position `at` in `direction`, the shaft stays for `steps` motor steps and then
    follows. Reversing the motor ends a slip.

    Attributes:
        at: the shaft position, steps.
        steps: motor steps lost each time, 1 or more.
        direction: 1 or -1 for one direction only, 0 for both.
        times: number of occurrences, 1 or more, or "always" (None in Python).
        chance: probability of a slip each time the motor leaves the position, 0 to 1.
    """

    __pydantic_config__ = NO_MORE_KEYS

    at: StrictInt
    steps: StrictInt
    direction: StrictInt = 0
    times: Times = 1
    chance: Chance = 1.0

    def __post_init__(self) -> None:
        _check_whole(self, "at")
        _check_whole(self, "steps", 1)
        _check_choice(self, "direction", (1, -1, 0))
        if self.times is not None:
            _check_whole(self, "times", 1)
        chance: object = self.chance
        if isinstance(chance, bool) or not isinstance(chance, int | float | Fraction) or not 0 <= chance <= 1:
            raise refusal(self, "chance", chance, "a number from 0 to 1")


@dataclass(frozen=True, slots=True)
class Jam:
    """A position that the shaft can't pass in one direction.

    Attributes:
        at: the last shaft position before the jam, steps.
        direction: blocked direction, 1 for clockwise, -1 for counterclockwise.
    """

    __pydantic_config__ = NO_MORE_KEYS

    at: StrictInt
    direction: StrictInt

    def __post_init__(self) -> None:
        _check_whole(self, "at")
        _check_choice(self, "direction", (1, -1))


@dataclass(frozen=True, slots=True)
class Station:
    """A station that works on a part and signals the end of its work.

    When a motion ends with the shaft exactly at `position`, the station works for `work_ns` (0 or more) and
    then energizes its input for `pulse_ns` (1 or more). A motion that begins before the pulse cancels it, but
    a pulse that has begun continues. Stations may share an input.
    """

    position: int
    input: InputBit
    work_ns: int
    pulse_ns: int

    def __post_init__(self) -> None:
        _check_whole(self, "position")
        _check_input(self, self.input)
        _check_whole(self, "work_ns", 0)
        _check_whole(self, "pulse_ns", 1)


@dataclass(frozen=True, slots=True)
class MachineSpec:
    """All parts of a machine; without any parts, it is a motor on a bench with unwired inputs."""

    switches: tuple[Switch, ...] = ()
    timeline: tuple[TimelineEntry, ...] = ()  # actions by hand; actions at one instant keep their order
    encoder: EncoderSpec | None = None
    slips: tuple[Slip, ...] = ()
    jams: tuple[Jam, ...] = ()
    stations: tuple[Station, ...] = ()
    turns: tuple[MasterTurn, ...] = ()  # in order of time, without overlaps
    master_speed: int | None = None  # highest speed of the master encoder, x4 counts/s; None without one

    def __post_init__(self) -> None:
        for field, kind in _PARTS:
            self._check_parts(field, kind)
        if self.encoder is not None and not isinstance(self.encoder, EncoderSpec):
            raise refusal(self, "encoder", self.encoder, "an EncoderSpec or None")
        if self.master_speed is not None:
            _check_whole(self, "master_speed", 1)
        for turn, next_turn in pairwise(self.turns):
            if next_turn.at_ns < turn.end_ns:
                allowed_ns = f"at_ns of {turn.end_ns} or more, the end of the last turn"
                raise refusal(self, "turns", next_turn, allowed_ns)
        self._check_wiring()

    def _check_parts(self, field: str, kind: type) -> None:
        """Turn a field into a tuple; raise a ValueError if it has parts of another kind."""
        parts = getattr(self, field)
        if not isinstance(parts, Iterable):
            raise refusal(self, field, parts, f"a sequence of {kind.__name__}")
        object.__setattr__(self, field, tuple(parts))
        for part in getattr(self, field):
            if not isinstance(part, kind):
                raise refusal(self, field, part, f"{kind.__name__} only")

    def _check_wiring(self) -> None:
        """Raise a ValueError if parts contradict each other at an input.

        An input has one kind of contact. A station's input has no switch. A timeline entry can release an
        input only if a switch or a station feeds it.
        """
        normally_closed = {switch.input for switch in self.switches if switch.normally_closed}
        normally_open = {switch.input for switch in self.switches if not switch.normally_closed}
        for bit in sorted(normally_closed & normally_open):
            allowed_kinds = "normally open or normally closed, not both on one input"
            raise refusal(self, "switches", str(bit.name), allowed_kinds)
        for station in self.stations:
            if station.input in normally_closed | normally_open:
                raise refusal(self, "stations", station, "an input without a switch")
        for entry in self.timeline:
            if entry.energized is None and not self.fed_inputs & entry.input.value:
                allowed_inputs = "energized None on inputs with a switch or station only"
                raise refusal(self, "timeline", entry, allowed_inputs)

    @property
    def fed_inputs(self) -> int:
        """Mask of the inputs that a switch or a station feeds.

        >>> MachineSpec(switches=(Switch(InputBit.HOME, 0, 9),)).fed_inputs
        4
        """
        mask = 0
        for bit in [switch.input for switch in self.switches] + [station.input for station in self.stations]:
            mask |= bit.value
        return mask


_PARTS: tuple[tuple[str, type], ...] = (
    ("switches", Switch),
    ("timeline", TimelineEntry),
    ("slips", Slip),
    ("jams", Jam),
    ("stations", Station),
    ("turns", MasterTurn),
)
