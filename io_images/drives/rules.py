"""A drive's rules for refusing commands and reporting errors: one row each, with page and status bits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .bits import StatusBit
from .configuration import RULES as CONFIGURATION_RULES
from .configuration import configuration_rules
from .models import Model

_COMMAND = StatusBit.COMMAND_ERROR
_INPUT = StatusBit.INPUT_ERROR
_POSITION = StatusBit.POSITION_INVALID


@dataclass(frozen=True, slots=True)
class DriveRule:
    """A rule of the family.

    Attributes:
        id: prefix and number, such as "CMD-04".
        section: source and page.
        text: the error or event.
        sets: the status bits that it sets.
        reading: ids of the readings that it is based on.
    """

    id: str
    section: str
    text: str
    sets: StatusBit
    reading: tuple[str, ...] = ()


# One row per rule; the formatter would spread each over many lines.
# fmt: off
ROWS: tuple[DriveRule, ...] = (
    # configuration mode
    *(
        DriveRule(row.id, row.section, row.text, StatusBit.CONFIG_ERROR, row.reading)
        for row in CONFIGURATION_RULES
    ),
    DriveRule("CFG-20", "17 p. 82", "The unit has no valid configuration.",
        StatusBit.CONFIG_ERROR, ("R-09",)),
    DriveRule("CFG-21", "17 p. 82", "A configuration was written.", _POSITION),
    DriveRule("CFG-22", "SMD_Control_Server", "Configuration mode cuts a motion.", _POSITION, ("R-21",)),
    # commands
    DriveRule("CMD-01", "SMD p. 68", "More than one command bit rises.", _COMMAND, ("R-23",)),
    DriveRule("CMD-02", "SMD p. 72", "A reserved bit of command word 1 is set.", _COMMAND, ("R-08",)),
    DriveRule("CMD-03", "SD p. 55; EDS", "A parameter is out of range.", _COMMAND, ("R-12", "R-28")),
    DriveRule("CMD-04", "3401 p. 29", "A move is commanded during a move.", _COMMAND, ("R-25",)),
    DriveRule("CMD-05", "17 p. 82", "An absolute move is commanded without a valid position.", _COMMAND),
    DriveRule("CMD-06", "SD p. 23", "No move can be held now.", _COMMAND, ("R-15",)),
    DriveRule("CMD-07", "SD p. 23", "No held move can be resumed.", _COMMAND),
    DriveRule("CMD-08", "SMD p. 59", "A move is commanded with the driver disabled.", _COMMAND, ("R-29",)),
    DriveRule("CMD-09", "SD2 p. 59", "The unit has no valid configuration.", _COMMAND, ("R-32", "R-40")),
    DriveRule("CMD-10", "17 p. 80", "No profile is stored.", _COMMAND, ("R-30",)),
    DriveRule("CMD-11", "17 p. 80", "A segment is refused, and the profile with it.", _COMMAND, ("R-30",)),
    DriveRule("CMD-12", "EDS", "No encoder is in use.", _COMMAND, ("R-08", "R-36")),
    DriveRule("CMD-13", "17 p. 82", "COMMAND_ERROR is set: Reset Errors comes first.", _COMMAND, ("R-24",)),
    DriveRule("CMD-14", "SMD p. 40", "The registers of Synchrostep moves are not known.", _COMMAND),
    DriveRule("CMD-15", "SMD p. 67", "The stopping distance is shorter than the ramp.", _COMMAND, ("R-17",)),
    DriveRule("CMD-16", "17 p. 80", "A segment is sent without a profile in programming.", _COMMAND),
    DriveRule("CMD-17", "EDS", "The model has no such command.", _COMMAND),
    DriveRule("CMD-18", "SMD p. 38", "A segment is shorter than its ramps.", _COMMAND, ("R-20",)),
    DriveRule("CMD-19", "ANF2 README", "A limit is active: only a jog leaves it.", _COMMAND, ("R-39",)),
    DriveRule("CMD-20", "3601", "The input of a registration move is active at its start.",
        _COMMAND, ("R-17",)),
    DriveRule("CMD-21", "SMD p. 13", "No input has the function home.", _COMMAND, ("R-43",)),
    # jogs
    DriveRule("JOG-01", "17 p. 84", "New values of a jog are out of range.",
        StatusBit.INVALID_JOG_CHANGE, ("R-16",)),
    # inputs
    DriveRule("INP-01", "17 p. 82", "The emergency stop input is active.", _INPUT),
    DriveRule("INP-02", "17 p. 82", "An end limit has become active in a move.",
        _INPUT | StatusBit.LIMIT_CONDITION),
    DriveRule("INP-03", "17 p. 82", "A move is commanded toward an active end limit.", _INPUT, ("R-39",)),
    DriveRule("INP-04", "17 p. 82", "A home search has met an end limit that it can't leave.",
        _INPUT | _POSITION, ("R-19",)),
    DriveRule("INP-05", "17 p. 82, p. 84", "The cable was lost and is back.",
        _INPUT | StatusBit.CONNECTION_LOST, ("R-22",)),
    DriveRule("INP-06", "ANF2 README", "A home search has run out of its time.",
        _INPUT | _POSITION, ("R-44",)),
    # causes of an invalid position
    DriveRule("POS-01", "17 p. 82", "The unit has powered up.", _POSITION, ("R-09",)),
    DriveRule("POS-02", "SMD p. 83", "A motion was cut by Immediate Stop.", _POSITION),
    DriveRule("POS-03", "17 p. 82", "A motion was cut by the emergency stop input.", _POSITION),
    DriveRule("POS-04", "17 p. 82", "A motion was cut by an end limit.", _POSITION),
    DriveRule("POS-05", "17 p. 82", "The cable is lost.", _POSITION, ("R-22",)),
    DriveRule("POS-06", "EDS", "A motion was cut by the loss of the connection.", _POSITION, ("R-22",)),
    # the driver
    DriveRule("DRV-01", "17 p. 84", "The driver is too hot: its current is off.", StatusBit.DRIVER_FAULT),
    DriveRule("DRV-02", "SMD p. 59", "The driver was disabled in a motion.", _POSITION, ("R-33",)),
    DriveRule("DRV-03", "SD2 p. 42; 17 p. 82", "The shaft does not follow the motor.",
        StatusBit.STALL_DETECTED | _POSITION, ("R-42",)),
    DriveRule("DRV-04", "17 p. 84", "A motion was cut by a fault of the driver.", _POSITION),
)
# fmt: on

RULES: Mapping[str, DriveRule] = {row.id: row for row in ROWS}
"""The rules by id."""


def rules_of(model: Model) -> list[DriveRule]:
    """Return the rules that a model can report with its configuration words and status bits."""
    other_ids = {row.id for row in CONFIGURATION_RULES} - {row.id for row in configuration_rules(model)}
    missing_bits = sum(bit for bit, mask in model.moved_status.items() if not mask)
    return [row for row in ROWS if row.id not in other_ids and row.sets & ~missing_bits]
