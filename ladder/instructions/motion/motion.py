"""Motion instructions: their operands, and their status bits [MOTION-RM002].

    rung  ___|‾‾‾‾‾‾‾‾‾‾|______        ___|‾‾‾‾‾‾‾‾|___
    EN    ___|‾‾‾‾‾‾‾‾‾‾|______        ___|‾‾‾‾‾‾‾‾|___
    DN    ____|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾        ________________     the axis has accepted it
    IP    ____|‾‾‾‾‾‾‾‾‾‾‾‾|___        ________________     until the motion ends, also on a false rung
    PC    _________________|‾‾‾        ________________
    ER    _____________________        ___|‾‾‾‾‾‾‾‾‾‾‾‾     refused; ERR has the reason

A rising rung begins an instruction; in structured text, every call does. An axis without a slot in the rack
is an ideal axis (`ideal_axis`); `checks` reports it.
"""

from __future__ import annotations

from typing import TypeGuard

from ...interpreter import Interpreter
from ...model.operands import Group, Resolved
from ...model.predefined.motion_types import COORDINATE_SYSTEM, MOTION_INSTRUCTION, is_axis
from ...model.spec import InstructionKind, Spec, Use
from . import ideal_moves, ideal_systems
from .axis_3601 import Axis
from .calls import MotionCall
from .motion_3601 import begin, follow
from .motion_control import AXIS_NOT_CONFIGURED, ILLEGAL, MotionControl, MotionError

USES = {
    "axis": Use.AXIS,
    "control": Use.MOTION,
    "group": Use.MOTION_GROUP,
    "system": Use.COORDINATE_SYSTEM,
    "number": Use.NUMBER,
    "word": Use.KEYWORD,
    "array": Use.TABLE,
    "profile": Use.IGNORED,
    "other": Use.IGNORED,
}
"""Kinds of operands in `OPERANDS`."""

_SPEED = "speed number, units word"
_RATES = "acceleration number, units word, deceleration number, units word"
_JERKS = "profile word, acceleration jerk number, deceleration jerk number, units word"
_MERGE = "merge word, merge speed word"
_LOCK = "lock position number, lock direction word"
_EVENTS = "event distance other, calculated data other"
_STOP = (
    "stop type word, change deceleration word, deceleration number, units word, change jerk word, "
    "jerk number, units word"
)
_PLAIN = "axis, control"


def _use(text: str) -> Use:
    """Return the use of an operand such as `speed number`, by the last words of its text; see `USES`."""
    return next(use for words, use in USES.items() if f" {text}".endswith(f" {words}"))


def _run(machine: Interpreter, power: bool, name: str, *operands: Resolved) -> None:
    """Begin an instruction if its rung has risen, otherwise update its bits.

    A MotionError sets ER and ERR.
    """
    motion = _control_of(machine, operands)
    site = machine.lowered.sites[machine.site]
    axis_number = _number_of(machine, operands[0])
    axis = Axis(machine, list(machine.lowered.axes.values())[axis_number - 1]) if axis_number > 0 else None
    if power and not (site.unit == "rung" and motion["EN"]):
        try:
            if axis is not None:
                motion.begin()
                begin(axis, MotionCall(machine, motion, name, operands[2:]))
            else:
                _begin_ideal(machine, motion, name, operands, axis_number)
        except MotionError as refused:
            motion.refuse(refused.code)
        return
    if axis is not None:
        follow(axis, motion, name)
    if not power and (motion["DN"] or motion["ER"]):
        motion.set(EN=False)


def _begin_ideal(
    machine: Interpreter, motion: MotionControl, name: str, operands: tuple[Resolved, ...], number: int
) -> None:
    """Begin an instruction on an ideal axis, a coordinate system or a group."""
    motion.begin(motion.ticket % MOST_TICKETS + 1)
    other_operands = [operand for operand in operands[1:] if not _is_control(operand)]
    call = MotionCall(machine, motion, name, other_operands)
    ideal, first = machine.lowered.ideal, operands[0]
    ideal_systems.catch_up(machine.memory, ideal, machine.now_ns)
    if name in ideal_moves.GROUP_ACTIONS:
        ideal_moves.begin_of_group(ideal, call)
    elif number:
        ideal_moves.begin(ideal, number, call)
    elif isinstance(first, Group) and first.type == COORDINATE_SYSTEM:
        system = machine.whole(machine.get(first.member("~number")))
        if not system:
            raise MotionError(AXIS_NOT_CONFIGURED)
        ideal_systems.begin(ideal, system, call)
    else:
        raise MotionError(ILLEGAL)


MOST_TICKETS = (1 << 31) - 1
"""Largest request number."""


def _number_of(machine: Interpreter, operand: Resolved) -> int:
    """Return the number of an axis: positive on a 3601, negative if ideal, and 0 for any other operand."""
    if not isinstance(operand, Group) or not is_axis(operand.type):
        return 0
    return machine.whole(machine.get(operand.member("~axis")))


def _prescan(machine: Interpreter, *operands: Resolved) -> None:
    _control_of(machine, operands).set(EN=False, DN=False, ER=False)


def _control_of(machine: Interpreter, operands: tuple[Resolved, ...]) -> MotionControl:
    return next(MotionControl(machine, operand) for operand in operands if _is_control(operand))


def _is_control(operand: Resolved) -> TypeGuard[Group]:
    return isinstance(operand, Group) and operand.type == MOTION_INSTRUCTION


def _row(name: str, operands: str, *, optional: int = 0) -> Spec:
    """Return a row from operand names and kinds (see `USES`). The last `optional` operands can be omitted."""
    uses = tuple(map(_use, operands.split(", ")))

    def run(machine: Interpreter, power: bool, *resolved: Resolved) -> None:
        _run(machine, power, name, *resolved)

    return Spec(name, InstructionKind.BOTH, uses, run=run, prescan=_prescan, optional=optional)


# motion state

MSO = _row("MSO", _PLAIN)
MSF = _row("MSF", _PLAIN)
MASD = _row("MASD", _PLAIN)
MASR = _row("MASR", _PLAIN)
MDO = _row("MDO", f"{_PLAIN}, drive output number, drive units word")
MDF = _row("MDF", _PLAIN)
MDS = _row("MDS", f"{_PLAIN}, {_SPEED}")
MAFR = _row("MAFR", _PLAIN)

# motion move

MAS = _row("MAS", f"{_PLAIN}, {_STOP}")
MAH = _row("MAH", _PLAIN)
MAJ = _row("MAJ", f"{_PLAIN}, direction word, {_SPEED}, {_RATES}, {_JERKS}, {_MERGE}, {_LOCK}", optional=2)
MAM = _row(
    "MAM",
    f"{_PLAIN}, move type number, position number, {_SPEED}, {_RATES}, {_JERKS}, {_MERGE}, {_LOCK}, "
    f"{_EVENTS}",
    optional=4,
)
MAG = _row(
    "MAG",
    "slave axis, master axis, control, direction word, ratio number, slave counts number, "
    "master counts number, master reference word, ratio format word, clutch word, acceleration number, "
    "units word",
)
MCD = _row(
    "MCD",
    f"{_PLAIN}, motion type word, change speed word, speed number, change acceleration word, "
    "acceleration number, change deceleration word, deceleration number, change acceleration jerk word, "
    "acceleration jerk number, change deceleration jerk word, deceleration jerk number, speed units word, "
    "acceleration units word, deceleration units word, jerk units word",
)
MRP = _row("MRP", f"{_PLAIN}, type word, position select word, position number")
MCCP = _row(
    "MCCP", "control, cam array, length number, start slope number, end slope number, cam profile profile"
)
MCSV = _row(
    "MCSV",
    "control, cam profile profile, master value number, slave value other, slope other, "
    "slope derivative other",
)
MAPC = _row(
    "MAPC",
    "slave axis, master axis, control, direction word, cam profile profile, slave scaling number, "
    "master scaling number, execution mode word, execution schedule word, master lock position number, "
    "cam lock position number, master reference word, master direction word",
)
MATC = _row(
    "MATC",
    f"{_PLAIN}, direction word, cam profile profile, distance scaling number, time scaling number, "
    f"execution mode word, execution schedule word, {_LOCK}, instruction mode word",
    optional=3,
)
MDAC = _row("MDAC", "slave axis, master axis, control, motion type word, master reference word")

# motion group

MGS = _row("MGS", "group, control, stop mode word")
MGSD = _row("MGSD", "group, control")
MGSR = _row("MGSR", "group, control")
MGSP = _row("MGSP", "group, control")

# motion event

MAW = _row("MAW", f"{_PLAIN}, trigger condition word, position number")
MDW = _row("MDW", _PLAIN)
MAR = _row(
    "MAR",
    f"{_PLAIN}, trigger condition word, windowed registration word, minimum position number, "
    "maximum position number, input number number",
    optional=1,
)
MDR = _row("MDR", f"{_PLAIN}, input number number", optional=1)
MAOC = _row(
    "MAOC",
    "axis, execution target word, control, output other, input other, output cam other, "
    "cam start position number, cam end position number, output compensation other, execution mode word, "
    "execution schedule word, axis arm position number, cam arm position number, reference word",
)
MDOC = _row("MDOC", "axis, execution target word, control, disarm type word")

# motion configuration

MAAT = _row("MAAT", _PLAIN)
MRAT = _row("MRAT", _PLAIN)
MAHD = _row("MAHD", f"{_PLAIN}, diagnostic test word, observed direction word")
MRHD = _row("MRHD", f"{_PLAIN}, diagnostic test word")

# multi-axis coordinated motion

MCS = _row("MCS", f"system, control, {_STOP}")
MCLM = _row(
    "MCLM",
    f"system, control, move type number, position array, {_SPEED}, {_RATES}, {_JERKS}, "
    f"termination type number, {_MERGE}, command tolerance number, {_LOCK}, {_EVENTS}",
    optional=5,
)
MCCM = _row(
    "MCCM",
    f"system, control, move type number, position array, circle type number, via array, direction word, "
    f"{_SPEED}, {_RATES}, {_JERKS}, termination type number, {_MERGE}, command tolerance number, {_LOCK}, "
    f"{_EVENTS}",
    optional=5,
)
MCCD = _row(
    "MCCD",
    "system, control, motion type word, change speed word, speed number, units word, "
    "change acceleration word, acceleration number, units word, change deceleration word, "
    "deceleration number, units word, change acceleration jerk word, acceleration jerk number, "
    "change deceleration jerk word, deceleration jerk number, units word, scope word",
)
MCSD = _row("MCSD", "system, control")
MCSR = _row("MCSR", "system, control")
MCT = _row("MCT", "source system, target system, control, orientation array, translation array")
MCTP = _row(
    "MCTP",
    "source system, target system, control, orientation array, translation array, "
    "transform direction word, reference position array, transform position array",
)
MCTO = _row("MCTO", "source system, target system, control, work frame other, tool frame other")
MCTPO = _row(
    "MCTPO",
    "source system, target system, control, work frame other, tool frame other, transform direction word, "
    "reference position array, transform position array, robot configuration other, turns counters other",
)
MCPM = _row(
    "MCPM", "system, control, path other, length number, dynamics other, lock position number, direction word"
)
MDCC = _row("MDCC", "slave other, master axis, control, master reference word, nominal velocity number")
MDSC = _row("MDSC", "slave other, master axis, control, master reference word, nominal velocity number")
