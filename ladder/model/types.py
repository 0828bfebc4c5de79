"""Data types of tags, and their layout in bytes.

| type | values | bits |
|---|---|--:|
| BOOL | False, True | 1 |
| SINT, INT, DINT, LINT | signed integers | 8, 16, 32, 64 |
| USINT, UINT, UDINT, ULINT | integers from 0 | 8, 16, 32, 64 |
| REAL | IEEE 754 single precision, rounded at every store | 32 |
| LREAL | IEEE 754 double precision | 64 |

Structures have members of any type. The byte layout matters only to COP and CPS
[1756-RM003N p. 371: a straight byte-to-byte copy].
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import field
from functools import cached_property, lru_cache
from math import prod

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.records import record

from .errors import LadderError

MAX_DIMENSIONS = 3
"""Maximum number of dimensions of an array."""


@dataclass(frozen=True)
class Elementary:
    """The type of a single value; `code` is its letter in the `struct` module."""

    name: str
    bits: int
    code: str

    @cached_property
    def is_bool(self) -> bool:
        """Whether it is one bit."""
        return self.bits == 1

    @cached_property
    def is_real(self) -> bool:
        """Whether it is floating point in single precision."""
        return self.code == "f"

    @cached_property
    def is_double(self) -> bool:
        """Whether it is floating point in double precision."""
        return self.code == "d"

    @cached_property
    def is_integer(self) -> bool:
        """Whether it is an integer type, signed or unsigned."""
        return not (self.is_bool or self.is_real or self.is_double)

    @cached_property
    def is_signed(self) -> bool:
        """Whether an integer type has negative values."""
        return self.code.islower()

    @cached_property
    def wraps(self) -> int:
        """The number of bits for `arithmetic.wrap`; negative if unsigned."""
        return self.bits if self.is_signed else -self.bits

    @cached_property
    def lowest(self) -> int:
        """Lowest value of an integer type."""
        return -1 << self.bits - 1 if self.is_signed else 0

    @cached_property
    def highest(self) -> int:
        """Highest value of an integer type."""
        return (1 << self.bits - self.is_signed) - 1

    @cached_property
    def zero(self) -> bool | int | float:
        """Default initial value."""
        return False if self.is_bool else 0 if self.is_integer else 0.0


BOOL = Elementary("BOOL", 1, "?")
SINT = Elementary("SINT", 8, "b")
INT = Elementary("INT", 16, "h")
DINT = Elementary("DINT", 32, "i")
LINT = Elementary("LINT", 64, "q")
USINT = Elementary("USINT", 8, "B")
UINT = Elementary("UINT", 16, "H")
UDINT = Elementary("UDINT", 32, "I")
ULINT = Elementary("ULINT", 64, "Q")
REAL = Elementary("REAL", 32, "f")
LREAL = Elementary("LREAL", 64, "d")


@dataclass(frozen=True, slots=True)
class Member:
    """A member of a structure."""

    name: str
    type: DataType
    dims: tuple[int, ...] = ()
    bit: int | None = None  # of a predefined structure's BOOL: its bit in the first DINT
    initial: object = field(default=None, compare=False)  # see `tags.Tag`; None = zero. Not compared
    at: str = ""  # the part of the structure that it is an alias of: `Host.3`; "" with its own memory
    hidden: bool = False  # whether views omit it, like the host of packed bits


@dataclass(frozen=True)
class Structure:
    """A type with members; `hidden` members have no address and store an instruction's state."""

    name: str
    members: tuple[Member, ...]
    hidden: tuple[Member, ...] = field(default=())

    @cached_property
    def is_string(self) -> bool:
        """Whether it is a string of any length, with LEN and characters."""
        if len(self.members) != 2:
            return False
        length, data = self.members
        return (length.name, length.type, length.dims) == ("LEN", DINT, ()) and (
            data.name == "DATA" and data.type == SINT and len(data.dims) == 1
        )

    def __hash__(self) -> int:
        """Return the hash of the name only, because types are often keys and equal names are rare."""
        return hash(self.name)

    def __post_init__(self) -> None:
        """Raise a LadderError if a member's `at` does not name a member with its own memory."""
        for member in self.members:
            host = self.member(re.split(r"[.\[]", member.at)[0]) if member.at else member
            if host is None or (member.at and host.at):
                raise LadderError(
                    f"{member.name} of {self.name} is at {member.at}, which has no memory of its own"
                )

    @cached_property
    def own(self) -> tuple[Member, ...]:
        """The members with their own memory."""
        return tuple(member for member in self.members if not member.at)

    @cached_property
    def packed(self) -> Mapping[str, tuple[str, int]]:
        """Host and bit of each member that is a bit of another member, such as `EN` at `FLAGS.7`."""
        places = ((member.name, _PACKED.fullmatch(member.at)) for member in self.members if member.at)
        return {name: (place["host"], int(place["bit"])) for name, place in places if place}

    def member(self, name: str) -> Member | None:
        """Return a member by its name in any case; None if it does not exist."""
        return self._by_name.get(name.upper())

    @cached_property
    def _by_name(self) -> Mapping[str, Member]:
        return {member.name.upper(): member for member in reversed(self.members)}


DataType = Elementary | Structure

_PACKED = re.compile(r"(?P<host>\w+)\.(?P<bit>\d+)")


def members_of(text: str) -> tuple[Member, ...]:
    """Return the members from a text: types, each followed by names with optional length and value.

    >>> [(member.name, member.dims, member.initial) for member in members_of("DINT PRE=500 SINT DATA[82]")]
    [('PRE', (), 500), ('DATA', (82,), None)]
    """
    kind: DataType = BOOL
    members = []
    for word in text.split():
        if word in TYPES:
            kind = TYPES[word]
        else:
            name, length, value = _MEMBER.fullmatch(word).groups()  # type: ignore[union-attr]  # our own table always matches
            initial = None if value is None else _initial(kind, value)
            members.append(Member(name, kind, (int(length),) if length else (), initial=initial))
    return tuple(members)


_MEMBER = re.compile(r"(\w+)(?:\[(\d+)\])?(?:=(.+))?")


def _initial(kind: DataType, value: str) -> object:
    """Return an initial value from its text: a BOOL, a number, or a name in `_VALUES`."""
    if value in _VALUES:
        return _VALUES[value]
    if kind is BOOL:
        return value != "0"
    return float(value) if "." in value else int(value)


MAX_REAL, MIN_REAL = 3.4028234663852886e38, 1.1754943508222875e-38
"""The largest REAL, and the smallest positive REAL with full precision."""

_VALUES: Mapping[str, object] = {"max": MAX_REAL, "-max": -MAX_REAL, "min": MIN_REAL}

TYPES: dict[str, DataType] = {
    kind.name: kind for kind in (BOOL, SINT, INT, DINT, LINT, USINT, UINT, UDINT, ULINT, REAL, LREAL)
}


def packed_in(host: Member, bits: Mapping[str, int]) -> tuple[Member, ...]:
    """Return a number, and members that are its bits."""
    return (host, *(Member(name, BOOL, at=f"{host.name}.{bit}") for name, bit in bits.items()))


HIDDEN = "~"
"""Prefix of a hidden member's name in its path."""


def status_bits(names: str) -> tuple[Member, ...]:
    """Return BOOLs in the first DINT, starting at bit 31 and going down."""
    return tuple(Member(name, BOOL, bit=31 - number) for number, name in enumerate(names.split()))


TIMER = Structure(
    "TIMER", status_bits("EN TT DN") + members_of("DINT PRE ACC"), hidden=members_of("LINT last_ns")
)
"""PRE and ACC in ms; `last_ns` is the instant up to which ACC has been counted."""

COUNTER = Structure("COUNTER", status_bits("CU CD DN OV UN") + members_of("DINT PRE ACC"))

CONTROL = Structure("CONTROL", status_bits("EN EU DN EM ER UL IN FD") + members_of("DINT LEN POS"))

STRING = Structure("STRING", members_of("DINT LEN SINT DATA[82]"))

TYPES |= {kind.name: kind for kind in (TIMER, COUNTER, CONTROL, STRING)}

FBD_TIMER = Structure(
    "FBD_TIMER",
    members_of(
        "BOOL EnableIn TimerEnable DINT PRE BOOL Reset EnableOut DINT ACC BOOL EN TT DN DINT Status "
        "BOOL InstructFault PresetInv"
    ),
    hidden=members_of("LINT last_ns"),
)
"""Structure of TONR, TOFR and RTOR."""

FBD_COUNTER = Structure(
    "FBD_COUNTER",
    members_of("BOOL EnableIn CUEnable CDEnable DINT PRE BOOL Reset EnableOut DINT ACC BOOL CU CD DN OV UN"),
    hidden=members_of("BOOL up down"),
)
"""Structure of CTUD; `up` and `down` are CUEnable and CDEnable of the previous scan."""

FBD_ONESHOT = Structure(
    "FBD_ONESHOT", members_of("BOOL EnableIn InputBit EnableOut OutputBit"), hidden=members_of("BOOL before")
)
"""Structure of OSRI and OSFI; `before` is InputBit of the previous scan."""

MESSAGE_BITS = {"EW": 2, "ER": 4, "DN": 5, "ST": 6, "EN": 7, "TO": 8, "EN_CC": 9}
"""Bits of FLAGS of a MESSAGE [Studio 5000 help, MESSAGE structure]."""

MESSAGE = Structure(
    "MESSAGE",
    packed_in(Member("FLAGS", INT), MESSAGE_BITS)
    + members_of(
        "INT ERR DINT EXERR SINT ERR_SRC "
        "INT DN_LEN REQ_LEN DestinationLink DestinationNode SourceLink Class Attribute "
        "DINT Instance LocalIndex SINT Channel Rack Group Slot STRING Path DINT RemoteIndex "
        "STRING RemoteElement DINT UnconnectedTimeout ConnectionRate SINT TimeoutMultiplier"
    ),
    hidden=members_of("LINT started_ns BOOL waiting"),
)
"""Structure of MSG; `waiting` is set while structured text executes it."""

_PID_BITS = {
    **{name: 31 - number for number, name in enumerate(["EN", "CT", "CL", "PVT", "DOE", "SWM", "CA", "MO"])},
    **{name: 23 - number for number, name in enumerate(["PE", "NDF", "NOBC", "NOZC"])},
    **{name: 15 - number for number, name in enumerate(["INI", "SPOR", "OLL", "OLH", "EWD"])},
    **{name: 10 - number for number, name in enumerate(["DVNA", "DVPA", "PVLA", "PVHA"])},
}
"""Bits of CTL of a PID [1756-RM003N p. 512]."""

PID = Structure(
    "PID",
    packed_in(Member("CTL", DINT), _PID_BITS)
    + members_of(
        "REAL SP KP KI KD BIAS MAXS MINS DB SO MAXO MINO UPD PV ERR OUT PVH PVL DVP DVN PVDB DVDB MAXI MINI "
        "TIE MAXCV MINCV MINTIE MAXTIE DATA[17]"
    ),
    hidden=members_of("LREAL sum last error BOOL crossed"),
)
"""Structure of PID; `sum` is the integral term, `last` and `error` are from the previous update."""


def for_each(text: str, *names: object) -> str:
    """Return a text once for each name, with the name in place of `#`."""
    return " ".join(text.replace("#", str(name)) for name in names)


_ALARM_COMMANDS = for_each("Prog# Oper#", "Suppress", "Unsuppress", "Disable", "Enable")

ALARM_DIGITAL = Structure(
    "ALARM_DIGITAL",
    members_of(
        "BOOL EnableIn In InFault Condition=1 AckRequired=1 Latched ProgAck OperAck ProgReset OperReset "
        f"{_ALARM_COMMANDS} AlarmCountReset UseProgTime LINT ProgTime DINT Severity=500 MinDurationPRE "
        "BOOL EnableOut InAlarm Acked=1 InAlarmUnack Suppressed Disabled DINT MinDurationACC "
        "LINT InAlarmTime DINT AlarmCount BOOL InstructFault InFaulted SeverityInv DINT Status"
    ),
    hidden=members_of("BOOL Ack Reset active LINT since_ns"),
)
"""Structure of ALMD [1756-RM003N p. 45-48]."""

ALARM_LEVELS = ("HH", "H", "L", "LL")

ANALOG_ALARMS = (*ALARM_LEVELS, "ROCPos", "ROCNeg")
"""The alarms of an ALMA."""

ALARM_ANALOG = Structure(
    "ALARM_ANALOG",
    members_of(
        f"BOOL EnableIn REAL In BOOL InFault {for_each('#Enabled=1', *ALARM_LEVELS)} AckRequired=1 "
        f"ProgAckAll OperAckAll {_ALARM_COMMANDS} REAL {for_each('#Limit', *ALARM_LEVELS)} "
        f"DINT {for_each('#Severity=500', *ANALOG_ALARMS)} MinDurationPRE "
        "REAL Deadband ROCPosLimit ROCNegLimit ROCPeriod ROC BOOL EnableOut InAlarm AnyInAlarmUnack "
        f"{for_each('#InAlarm', *ANALOG_ALARMS)} {for_each('#Acked=1', *ANALOG_ALARMS)} "
        f"{for_each('#InAlarmUnack', *ANALOG_ALARMS)} Suppressed Disabled DINT MinDurationACC Status"
    ),
    hidden=members_of("BOOL AckAll active LINT since_ns BOOL sampled LINT sampled_ns REAL sample"),
)
"""Structure of ALMA [1756-RM003N p. 56-63]."""

_STRUCTURES = (FBD_TIMER, FBD_COUNTER, FBD_ONESHOT, MESSAGE, PID, ALARM_DIGITAL, ALARM_ANALOG)
TYPES |= {kind.name: kind for kind in _STRUCTURES}


@record
class Field:
    """The place of an elementary value in the bytes of its type."""

    path: str  # members joined by dots; "" for an elementary type itself
    type: Elementary
    offset: int  # byte
    bit: int | None = None  # bit from the low end of the byte, for a BOOL
    index: int = 0  # its index among the values of the path


@lru_cache(maxsize=1024)
def size_of(kind: DataType) -> int:
    """Return the size of one element of a type, bytes.

    >>> size_of(INT), size_of(TIMER), size_of(STRING)
    (2, 12, 88)
    """
    return _layout_of(kind).size


@lru_cache(maxsize=1024)
def fields_of(kind: DataType) -> tuple[Field, ...]:
    """Return the location of each elementary value in one element of a type."""
    if isinstance(kind, Elementary):
        return (Field("", kind, 0, 0 if kind.is_bool else None),)
    return tuple(_fields_in(kind))


def _fields_in(kind: Structure) -> Iterator[Field]:
    """Yield the place of each elementary value in a structure."""
    for member, begin, bit in members_at(kind):
        name = member.name
        if member.type is BOOL:
            first = 8 * begin + (bit or 0)
            for index in range(count_of(member.dims)):
                yield Field(name, BOOL, (first + index) // 8, (first + index) % 8, index)
            continue
        inner, size = fields_of(member.type), size_of(member.type)
        counts = Counter(part.path for part in inner)
        for item in range(count_of(member.dims)):
            offset = begin + item * size
            for part in inner:
                path = f"{name}.{part.path}" if part.path else name
                index = item * counts[part.path] + part.index
                yield Field(path, part.type, offset + part.offset, part.bit, index)


@lru_cache(maxsize=1024)
def members_at(kind: Structure) -> tuple[tuple[Member, int, int | None], ...]:
    """Return the members with their own memory, each with its byte and, for a BOOL, its bit.

    >>> [(member.name, byte, bit) for member, byte, bit in members_at(COUNTER)][-3:]
    [('UN', 3, 3), ('PRE', 4, None), ('ACC', 8, None)]
    """
    return tuple(_layout_of(kind).places)


@lru_cache(maxsize=1024)
def _layout_of(kind: DataType) -> _Layout:
    return _Layout(kind)


class _Layout:
    """Lays out a type once: adjacent BOOLs share bytes, and other members are aligned to their size."""

    def __init__(self, kind: DataType) -> None:
        self.places: list[tuple[Member, int, int | None]] = []  # member, byte, and for a BOOL its bit
        self.size = 0  # bytes so far
        self._open_byte: int | None = None  # the byte of adjacent BOOLs; None if the last member is no BOOL
        self._bits_used = 0  # in the open byte
        if isinstance(kind, Elementary):
            self.size = max(1, kind.bits // 8)
        else:
            self._add_structure(kind)

    def _add_structure(self, kind: Structure) -> None:
        """Place all members with their own memory; bits of a predefined structure share its first word."""
        if any(member.bit is not None for member in kind.members):
            self.size = 4 if any((member.bit or 0) > 15 for member in kind.members) else 2
        for member in kind.own:
            if member.bit is not None:
                self.places.append((member, member.bit // 8, member.bit % 8))
            elif member.type is BOOL and not member.dims:
                self._add_packed_bool(member)
            else:
                self._open_byte = None
                self._add_member(member)
        alignment = _alignment(kind)
        self.size = -(-self.size // alignment) * alignment

    def _add_packed_bool(self, member: Member) -> None:
        """Place a BOOL in the next free bit of a byte."""
        if self._open_byte is None or self._bits_used == 8:
            self._open_byte, self._bits_used = self.size, 0
            self.size += 1
        self.places.append((member, self._open_byte, self._bits_used))
        self._bits_used += 1

    def _add_member(self, member: Member) -> None:
        """Place a member at its alignment; an array of BOOL has whole DINTs."""
        alignment = _alignment(member.type)
        self.size = -(-self.size // alignment) * alignment
        self.places.append((member, self.size, None))
        count = count_of(member.dims)
        self.size += -(-count // 32) * 4 if member.type is BOOL else count * size_of(member.type)


@lru_cache(maxsize=1024)
def _alignment(kind: DataType) -> int:
    if isinstance(kind, Elementary):
        return 4 if kind.is_bool else kind.bits // 8
    return max(4, *(_alignment(member.type) for member in kind.members)) if kind.members else 4


def dims_text(dims: tuple[int, ...]) -> str:
    """Return dimensions in brackets; "" for no dimensions.

    >>> dims_text((4, 2)), dims_text(())
    ('[4,2]', '')
    """
    return f"[{','.join(map(str, dims))}]" if dims else ""


def count_of(dims: tuple[int, ...]) -> int:
    """Return the number of elements of an array; 1 for a single value.

    >>> count_of((2, 3)), count_of(())
    (6, 1)
    """
    return prod(dims)


def leaves_of(
    kind: DataType, dims: tuple[int, ...] = ()
) -> Iterator[tuple[str, Elementary, tuple[int, ...]]]:
    """Yield the path, type and dimensions of each elementary value of a type, hidden ones last."""
    if isinstance(kind, Elementary):
        yield "", kind, dims
        return
    for member in kind.own:
        for path, leaf, inner in leaves_of(member.type, dims + member.dims):
            yield f"{member.name}.{path}" if path else member.name, leaf, inner
    for member in kind.hidden:
        if isinstance(member.type, Elementary):
            yield f"{HIDDEN}{member.name}", member.type, dims
