"""The contracts of the 3601, in the order of its status bits: one row per rule that a proof may rely on."""

from __future__ import annotations

from ..bits import COMPLETION_BITS, MOTIONS, CommandLsw, CommandMsw, StatusLsw, StatusMsw
from .contract import Contract
from .fact import AnyOf, Fact, Side, Within, every, now, sent, was

MOVING = (StatusMsw.MOVING_CW, StatusMsw.MOVING_CCW)
RAMPS = (StatusMsw.ACCELERATING, StatusMsw.DECELERATING)
RESULTS = tuple(bit for bit in StatusMsw if bit & COMPLETION_BITS)
STARTS = tuple(bit for bit in CommandMsw if bit & MOTIONS)
MODE, OK = StatusMsw.MODE_CONFIG, StatusMsw.MODULE_OK
STOPPED, HOLD_STATE, AT_HOME = StatusMsw.STOPPED, StatusMsw.HOLD_STATE, StatusMsw.AT_HOME
MOVE_COMPLETE = StatusMsw.MOVE_COMPLETE
HOME_INVALID, INVALID_PROFILE = StatusMsw.HOME_INVALID, StatusMsw.INVALID_PROFILE
POSITION_INVALID, INPUT_ERROR = StatusMsw.POSITION_INVALID, StatusMsw.INPUT_ERROR
COMMAND_ERROR, CONFIG_ERROR = StatusMsw.COMMAND_ERROR, StatusMsw.CONFIG_ERROR
FOLLOWER, BLENDING, BLEND_ACK = StatusLsw.ENC_FOLLOWER, StatusLsw.BLEND_RUNNING, StatusLsw.BLEND_ACK
RESET, PRESET = CommandMsw.RESET_ERRORS, CommandMsw.PRESET_POSITION
CONFIGURE = CommandMsw.MODE_CONFIG
MANUAL = (CommandMsw.MANUAL_CW, CommandMsw.MANUAL_CCW)
FOLLOW, TRANSMIT = CommandLsw.ENC_FOLLOWER, CommandLsw.BLEND_TRANSMIT

OPERATING = now(OK)
IN_COMMAND_MODE = OPERATING & ~now(MODE)
STAYS_IN_COMMAND_MODE = IN_COMMAND_MODE & was(OK) & ~was(MODE)
KNOWN = ~(was(MOVING[0]) & was(MOVING[1]) & ~was(MODE))
"""The fact that there was an earlier image; a proof's first scan uses an image that no module sends."""

POWERED_UP = now(CONFIG_ERROR)
"""The sign of a power-up between two images in command mode; nothing else causes this error."""


def rises(bit: StatusMsw | StatusLsw) -> Fact:
    """Return the fact that a status bit becomes set in command mode."""
    return STAYS_IN_COMMAND_MODE & now(bit) & ~was(bit)


def falls(bit: StatusMsw | StatusLsw) -> Fact:
    """Return the fact that a status bit becomes clear in command mode, without a power-up in between."""
    return STAYS_IN_COMMAND_MODE & was(bit) & ~now(bit) & ~POWERED_UP


def none_but(*bits: StatusMsw) -> Fact:
    """Return the fact that no other bit of input word 0 is set."""
    return ~AnyOf(Side.NOW, 0, 0xFFFF & ~sum(bit.value for bit in bits))


def frozen() -> Fact:
    """Return the fact that input word 0 is unchanged except for Module OK and the bits of a motion."""
    status_bits = (bit for bit in StatusMsw if bit not in (OK, *MOVING, *RAMPS))
    return every(*(now(bit).same_as(was(bit)) for bit in status_bits))


def at_most_one(*bits: StatusMsw) -> Fact:
    """Return the fact that at most one of the bits is set."""
    return every(*(~(now(bit) & now(*bits[index + 1 :])) for index, bit in enumerate(bits[:-1])))


def words(least: int, most: int, *numbers: int) -> Fact:
    """Return the fact that signed input words are in a range."""
    return every(*(Within(Side.NOW, number, least, most) for number in numbers))


# fmt: off
TYPICAL = (
    0x6400, 0x4400, 0x4000,  # powered up, configured, position preset
    0x4021, 0x4001, 0x4042, 0x4402,  # motions
    0x4080, 0x4480, 0x4010, 0x4004, 0x4008, 0x4408, 0x4C08,  # results
    0x5080, 0x5010, 0x5208, 0x5001, 0x4D00, 0x4900,  # errors
    0xC000, 0xE000, 0xC43E, 0,  # configuration mode; removed
)
"""Common values of input word 0, for random scans that search for invariants."""

# One row per rule of the manual; the formatter would spread each over ten lines.

ROWS: tuple[Contract, ...] = (
    # -- one image
    Contract("one direction", "The axis moves in one direction at a time.",
             ("STS-M00", "STS-M01"),
             IN_COMMAND_MODE.only_with(at_most_one(*MOVING)), adapters=True),
    Contract("one ramp", "An axis that accelerates or decelerates moves, and does one of both.",
             ("STS-M05", "STS-M06"),
             (IN_COMMAND_MODE & now(*RAMPS)).only_with(now(*MOVING) & at_most_one(*RAMPS)), adapters=True),
    Contract("one result", "At most one of Hold State, Stopped, At Home and Move Complete is set.",
             ("STS-M03",),
             IN_COMMAND_MODE.only_with(at_most_one(*RESULTS)), adapters=True),
    Contract("no result in motion", "None of these four is set while the axis moves.",
             ("HLD-12", "STS-M03", "MC-02"),
             (IN_COMMAND_MODE & now(*MOVING)).only_with(~now(*RESULTS)), adapters=True),
    Contract("no result in follower mode", "None of these four is set in encoder follower mode.",
             ("STOP-06",),
             (IN_COMMAND_MODE & now(FOLLOWER)).only_with(~now(*RESULTS))),
    Contract("home is valid", "The position is valid while At Home is set.",
             ("HMG-19",),
             (IN_COMMAND_MODE & now(AT_HOME)).only_with(~now(POSITION_INVALID)),
             readings={"clear_status_after_config": True}),
    Contract("nothing before a configuration", "While Configuration Error is set in command mode, Position "
             "Invalid is set and all other bits of word 0 but Module OK are not.",
             ("CFG-12", "CFG-13"),
             (IN_COMMAND_MODE & now(CONFIG_ERROR)).only_with(
                 now(POSITION_INVALID) & none_but(CONFIG_ERROR, POSITION_INVALID, OK)),
             readings={"clear_status_after_config": True}),
    Contract("blend moves", "The axis moves while Blend Running is set.",
             ("BLD-20",),
             (IN_COMMAND_MODE & now(BLENDING)).only_with(now(*MOVING))),
    Contract("two words", "The LSW of position, encoder and captured value lies between -999 and 999.",
             ("IOM-11", "IOM-13", "IOM-14"),
             IN_COMMAND_MODE.only_with(words(-999, 999, 3, 5, 7)), adapters=True),
    Contract("words of a configuration", "In configuration mode words 4 and 5 are zero.",
             ("IOM-08",),
             (OPERATING & now(MODE)).only_with(words(0, 0, 4, 5))),
    Contract("no motion in trouble", "No motion is shown while Module OK is clear.",
             ("MOK-01",),
             (~OPERATING).only_with(~now(*MOVING, *RAMPS))),
    # -- two images
    Contract("frozen in trouble", "While Module OK is clear, word 0 stays as it was, or is 0: the module has "
             "no power.",
             ("MOK-01",),
             (KNOWN & ~OPERATING).only_with(frozen() | none_but(POSITION_INVALID, CONFIG_ERROR)
                                            & now(POSITION_INVALID).same_as(now(CONFIG_ERROR)))),
    Contract("trouble ends with a power-up", "Module OK rises by a power-up: not configured, or in "
             "configuration mode.",
             ("MOK-01", "CFG-12"),
             (KNOWN & ~was(OK) & OPERATING).only_with(now(CONFIG_ERROR, MODE))),
    Contract("position lost", "Position Invalid rises only with Stopped or Home Invalid, or at power-up.",
             ("POS-02", "POS-03", "POS-04", "POS-05", "POS-06", "PRG-01"),
             rises(POSITION_INVALID).only_with(now(STOPPED, HOME_INVALID) | POWERED_UP),
             readings={"stopped_after_program_mode": True}),
    Contract("error until configured", "Configuration Error goes off in configuration mode only.",
             ("CFG-13",),
             ~(STAYS_IN_COMMAND_MODE & was(CONFIG_ERROR) & ~now(CONFIG_ERROR))),
    Contract("home is zero", "The position is zero and valid when At Home rises.",
             ("HMG-03", "HMG-19"),
             rises(AT_HOME).only_with(words(0, 0, 2, 3) & ~now(POSITION_INVALID))),
    # -- two images, and the outputs between both
    Contract("emergency stop", "While the emergency stop input is active, no motion is shown but that of a "
             "one-shot manual move.",
             ("EST-01", "MAN-16"),
             (STAYS_IN_COMMAND_MODE & now(StatusLsw.IN_ESTOP) & now(*MOVING)).only_with(sent(*MANUAL)),
             readings={"report_unused_inputs": False}),
    Contract("position found", "Position Invalid falls only at home or by Preset Position.",
             ("STS-M10", "PST-02", "HMG-19"),
             falls(POSITION_INVALID).only_with(now(AT_HOME) | sent(PRESET))),
    Contract("motion is commanded", "An axis that showed a result moves only by a command.",
             ("MC-02", "FOL-01"),
             (STAYS_IN_COMMAND_MODE & was(*RESULTS) & now(*MOVING)).only_with(sent(*STARTS) | sent(FOLLOW))),
    Contract("move complete", "Move Complete rises only after a motion or a command to move.",
             ("MC-01",),
             rises(MOVE_COMPLETE).only_with(was(*MOVING) | sent(*STARTS))),
    Contract("move complete stays", "Move Complete falls only by the next command to move.",
             ("MC-02", "MC-03"),
             falls(MOVE_COMPLETE).only_with(sent(*STARTS) | sent(FOLLOW))),
    Contract("hold state", "Hold State rises only after a motion or a command to move.",
             ("STS-M02",),
             rises(HOLD_STATE).only_with(was(*MOVING) | sent(*STARTS))),
    Contract("stopped stays", "Stopped falls only by the next command to move.",
             ("STS-M03",),
             falls(STOPPED).only_with(sent(*STARTS) | sent(FOLLOW))),
    Contract("input error stays", "Input Error falls only by Reset Errors or a command to move.",
             ("STS-M11", "RST-04"),
             falls(INPUT_ERROR).only_with(sent(RESET, *STARTS) | sent(FOLLOW))),
    Contract("command error stays", "Command Error falls only by Reset Errors, or while a blend move ends.",
             ("STS-M12", "CMD-19"),
             falls(COMMAND_ERROR).only_with(sent(RESET) | was(BLENDING))),
    Contract("invalid profile stays", "Invalid Profile falls only by Reset Errors.",
             ("STS-M09", "RST-01"),
             falls(INVALID_PROFILE).only_with(sent(RESET))),
    Contract("home invalid stays", "Home Invalid falls only by Reset Errors or Find Home.",
             ("STS-M08", "RST-01"),
             falls(HOME_INVALID).only_with(
                 sent(RESET, CommandMsw.FIND_HOME_CW, CommandMsw.FIND_HOME_CCW))),
    Contract("locked", "With Command Error an axis that showed a result does not move.",
             ("STS-M12", "RST-03"),
             (STAYS_IN_COMMAND_MODE & was(COMMAND_ERROR) & was(*RESULTS)).only_with(~now(*MOVING))),
    Contract("configuration mode entered", "The module enters configuration mode only by the mode bit.",
             ("CFG-15", "STS-M15"),
             (OPERATING & was(OK) & ~was(MODE) & now(MODE)).only_with(sent(CONFIGURE))),
    Contract("configuration mode left", "The module leaves configuration mode only by the mode bit.",
             ("CFG-15", "STS-M15"),
             (IN_COMMAND_MODE & was(OK) & was(MODE)).only_with(~sent(CONFIGURE) | POWERED_UP)),
    Contract("position after a configuration", "The position is invalid after configuration mode, unless the "
             "same words preset it.",
             ("POS-01",),
             (IN_COMMAND_MODE & was(OK) & was(MODE)).only_with(
                 now(POSITION_INVALID, AT_HOME) | sent(PRESET))),
    Contract("blend acknowledged", "Blend Acknowledge rises only with the transmit bit.",
             ("STS-L09",),
             rises(BLEND_ACK).only_with(sent(TRANSMIT))),
)
# fmt: on
