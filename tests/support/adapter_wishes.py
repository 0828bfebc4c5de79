"""What a PCL601 or a PMC006x3s can't do, written out a second time from the tables in docs/adapter-tables.md.

`refusal(controller, options, before, after, words)` says which row of these tables refuses words that a 3601
would carry out: `before` is an oracle of the 3601, `after` a copy of it that has seen the words for a tick.
"""

from __future__ import annotations

from typing import NamedTuple

import oracle_bits as bits
import oracle_commands as commands
from oracle_bits import CAPTURE, CCW_LIMIT, CW_LIMIT, ESTOP, EXTERNAL, HOME

PROFILE = bits.INVALID_PROFILE | bits.COMMAND_ERROR
TIMED = {"move", "manual", "registration", "home CW", "home CCW", "speed change", "encoder move"}
"""Commands that carry a speed."""


class Refusal(NamedTuple):
    """A row: its name, the error bits that it shows, and whether the motion under way is stopped."""

    name: str
    shown: int
    stops: bool = False


# ---- what a 3601 makes of the words


def wish(before, after, words):
    """Return what the words ask for and a 3601 does, None where it does nothing of the kind."""
    if before.command_error or before.invalid_profile or after.command_error or after.invalid_profile:
        return None
    if after.config_error or after.mode_config or not after.plc_running:
        return None
    if after.op == "follower" and before.op != "follower":
        return "follower"
    if after.session is not None and before.session is None:
        return "blend"
    rising = words[0] & ~before.previous0 & 0x7FFF
    if not rising:
        speeds_differ = before.op in ("manual", "registration") and after.seen_speed != before.seen_speed
        return "speed change" if speeds_differ else None
    return COMMANDS.get(words[0], nothing)(before, after, words)


def nothing(before, after, words):
    return None


def absolute_or_relative(before, after, words):
    if after.on(bits.LIMITS | ESTOP):
        return None
    return "encoder move" if words[1] & bits.ENCODER_MOVE else "move"


def resume(before, after, words):
    return None if after.on(bits.LIMITS | ESTOP) else "move"


def manual(before, after, words):
    ahead = CW_LIMIT if words[0] & bits.MANUAL_CW else CCW_LIMIT
    if after.on(ahead | ESTOP):
        return None
    return "registration" if any(words[2:4]) else "manual"


def find_home(before, after, words):
    if after.on(ESTOP):
        return None
    return "home CW" if words[0] == bits.FIND_HOME_CW else "home CCW"


def hold(before, after, words):
    return "hold" if before.op == "move" else None


COMMANDS = {
    bits.ABSOLUTE: absolute_or_relative,
    bits.RELATIVE: absolute_or_relative,
    bits.RESUME: resume,
    bits.MANUAL_CW: manual,
    bits.MANUAL_CCW: manual,
    bits.FIND_HOME_CW: find_home,
    bits.FIND_HOME_CCW: find_home,
    bits.HOLD: hold,
}


# ---- what the controllers lack


def pcl601_configuration(words, options):
    used, low = words[0] & 0x3F, words[0] & ~words[1] & 0x3F
    rows = (
        ("starting speed", starting_speed(words) > 5000),
        ("backplane home proximity", words[0] & bits.BACKPLANE_PROXIMITY),
        ("diagnostic feedback", words[0] & bits.DIAGNOSTIC),
        ("CW/CCW pulses", not words[0] & bits.STEP_AND_DIRECTION),
        ("marker home", words[0] & bits.MARKER),
        ("normally closed end limit", low & (CW_LIMIT | CCW_LIMIT)),
        ("normally closed home switch or emergency stop", low & (HOME | ESTOP)),
    )
    assert used
    return rows


def pmc006_configuration(words, options):
    used, high = words[0] & 0x3F, words[1]
    shared = HOME | CCW_LIMIT
    return (
        ("starting speed", not 65 <= starting_speed(words) <= 30_000),
        ("capture input", used & CAPTURE and options.get("capture") != "fset"),
        ("external input", used & EXTERNAL and options.get("hold") != "immediate"),
        ("FSET", (used & (CAPTURE | EXTERNAL | ESTOP)).bit_count() > 1),
        ("backplane home proximity", words[0] & bits.BACKPLANE_PROXIMITY),
        ("encoder", words[0] & bits.QUADRATURE),
        ("diagnostic feedback", words[0] & bits.DIAGNOSTIC),
        ("marker home", words[0] & bits.MARKER),
        (
            "levels of home switch and CCW limit",
            used & shared == shared and high & shared not in (0, shared),
        ),
    )


def starting_speed(words):
    return 1000 * words[2] + words[3]


class Asked:
    """The numbers of a command that a 3601 carries out."""

    def __init__(self, before, after, words):
        self.speed = commands.pair(words[4], words[5]) or 0
        self.start = after.starting_speed
        self.ramps = self.speed > self.start
        self.rates = words[6:8]
        self.target = commands.pair(words[2], words[3])
        self.way = after.hold_target - before.position
        self.stretch = 1 if not words[1] & 1 else 4 / 3 if words[1] & 2 else 2


def pcl601(feature, asked, options):
    lower = asked.stretch * (asked.speed**2 - asked.start**2) / (2000 * max(1, min(asked.rates)))
    return (
        ("encoder move", PROFILE, feature == "encoder move"),
        ("encoder follower", bits.COMMAND_ERROR, feature == "follower"),
        ("blend move", bits.INVALID_PROFILE, feature == "blend"),
        ("speed change", PROFILE, feature == "speed change" and options.get("respeed") != "restart"),
        ("speed", PROFILE, feature in TIMED and (asked.speed > 50_000 or asked.speed == 1)),
        ("distance", PROFILE, feature == "move" and abs(asked.way) > 8_388_607),
        ("registration distance", PROFILE, feature == "registration" and asked.target < lower),
    )


def pmc006(feature, asked, options):
    return (
        ("encoder move", PROFILE, feature == "encoder move"),
        ("encoder follower", bits.COMMAND_ERROR, feature == "follower"),
        ("blend move", bits.INVALID_PROFILE, feature == "blend"),
        ("registration move", PROFILE, feature == "registration"),
        ("speed change", PROFILE, feature == "speed change" and options.get("respeed") != "restart"),
        ("hold", bits.COMMAND_ERROR, feature == "hold" and options.get("hold") != "immediate"),
        ("find home CW", bits.HOME_INVALID | bits.COMMAND_ERROR, feature == "home CW"),
        ("speed", PROFILE, feature in TIMED and (asked.speed > 256_000 or 0 < asked.speed < 65)),
        ("rate", PROFILE, feature in TIMED and asked.ramps and min(asked.rates) < 6),
    )


CONFIGURATIONS = {"PCL601": pcl601_configuration, "PMC006": pmc006_configuration}
FUNCTIONS = {"PCL601": pcl601, "PMC006": pmc006}


def refusal(controller, options, before, after, words):
    """Return the first row that refuses what the words ask for, None if the controller does it."""
    if words[0] & bits.CONFIGURE:
        return configuration_refusal(controller, options, before, words)
    feature = wish(before, after, words)
    if feature is None:
        return None
    rows = FUNCTIONS[controller](feature, Asked(before, after, words), options)
    return next(
        (Refusal(name, shown, feature == "speed change") for name, shown, applies in rows if applies), None
    )


def configuration_refusal(controller, options, before, words):
    """The same for a configuration, if it is one that a 3601 accepts."""
    kept, before.words = before.words, list(words)
    valid = before.configuration_is_valid()
    before.words = kept
    if not valid:
        return None
    rows = CONFIGURATIONS[controller](words, options)
    return next((Refusal(name, bits.CONFIG_ERROR) for name, applies in rows if applies), None)
