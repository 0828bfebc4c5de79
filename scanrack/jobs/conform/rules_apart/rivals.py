"""Rival readings: modules that follow a different interpretation of the manual than `docs/readings.md`."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.amci3601 import StatusLsw, StatusMsw
from scanrack.io_images.thousands import split_thousands
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.modules.amci3601.altered import Alteration
from scanrack.runtime.modules.amci3601.refusals import RefusalRule

from . import departures as d
from . import layers
from .departures import AT_PRESET, AT_RESET, AT_START, overlook, refuse, ruled, silent

_STOPPED, _HOME = StatusMsw.STOPPED.value, StatusMsw.AT_HOME.value
_COMPLETE, _INPUT = StatusMsw.MOVE_COMPLETE.value, StatusMsw.INPUT_ERROR.value
_INVALID, _COMMAND = StatusMsw.POSITION_INVALID.value, StatusMsw.COMMAND_ERROR.value
_KNOWN_LSW = 0x1787
_MOVES = d.ABSOLUTE | d.RELATIVE
_LEAST = split_thousands(-8_388_608)


def _option(sentence: str, name: str, value: JsonValue) -> Alteration:
    return Alteration(sentence, options={name: value})


RIVALS: Mapping[str, tuple[Alteration, ...]] = {
    "A-02": (_option("Stopped is set after a configuration.", "stopped_after_config", True),),
    "A-03": (
        d.also_clears("Preset Position clears Stopped and At Home.", _STOPPED | _HOME, at=AT_PRESET),
        d.also_clears("Reset Errors clears Stopped and At Home.", _STOPPED | _HOME, at=AT_RESET),
    ),
    "A-04": (silent("A configuration leaves the position valid.", "POS-01"),),
    "A-05": (
        ruled("A command without a configuration is a command error.", layers.ErrorWithoutConfiguration),
    ),
    "A-06": (_option("A rejected configuration is mirrored.", "mirror_rejected_config", True),),
    "A-08": (ruled("A configuration is judged once, on entry.", layers.OneLook),),
    "A-11": (ruled("A bit of the configuration word starts its command.", layers.EdgeAfterConfiguration),),
    "A-12": (overlook("A configuration that cannot home is accepted.", "CFG-01"),),
    "A-13": (_option("Unused inputs are shown.", "report_unused_inputs", True),),
    "A-14": (
        Alteration(
            "Levels of unused inputs are unused bits.",
            also=(
                RefusalRule(
                    "CFG-08",
                    lambda _host, given: given.configures and bool(given.lsw & ~given.msw & 0x3F),
                    alone=True,
                ),
            ),
        ),
    ),
    "A-15": (d.add("An emergency stop at rest makes the position invalid.", "INP-01", _INVALID),),
    "A-16": (d.add("A move under an emergency stop is a command error.", "INP-01", _COMMAND),),
    "A-17": (d.add("A move on an active limit makes the position invalid.", "INP-02", _INVALID),),
    "A-18": (ruled("Only the limit ahead stops a profile move.", layers.LimitAhead),),
    "A-19": (
        d.never_clears("Stopped stays when a move starts.", _STOPPED, at=AT_START),
        d.never_clears("Input Error stays when a move starts.", _INPUT, at=AT_START),
    ),
    "A-20": (
        silent("Ranges and speeds set Command Error only.", "PRF-01", "PRF-02", "PRF-09", "PRF-10"),
        silent("Ranges and speeds set Invalid Profile only.", "CMD-04", "CMD-05"),
    ),
    "A-21": (silent("A refused Find Home sets Command Error only.", "HOM-01", "HOM-02", "HOM-03"),),
    "A-23": (_option("Hold in an encoder move is no error.", "hold_error_in_encoder_move", False),),
    "A-24": (ruled("Hold at rest is no error.", layers.SilentIdleHold),),
    "A-26": (ruled("Hold cuts a manual move off.", layers.HoldCutsManual),),
    "A-27": (_option("No Move Complete after a command error.", "complete_after_error", False),),
    "A-28": (ruled("A hold is never forfeited.", layers.ResumableForEver),),
    "A-30": (ruled("Hold and Immediate Stop need an LSW of zero.", layers.StrictLsw),),
    "A-31": (overlook("The LSW of Reset Errors and presets is ignored.", "RST-02", "PST-08", "IOM-20"),),
    "A-32": (
        silent("Bit 14 of the command MSW is ignored.", "LSW-03"),
        refuse(
            "Reserved bits of the LSW are an error.",
            "IOM-20",
            _MOVES | d.MANUAL,
            lambda _host, given: bool(given.lsw & ~_KNOWN_LSW),
        ),
    ),
    "A-33": (ruled("Several bits leave a manual move alone.", layers.ManualThroughSeveral),),
    "A-34": (ruled("A bit that stays set counts with every change.", layers.EdgeOfNothing),),
    "A-35": (
        refuse(
            "A move of no distance is refused.",
            "CMD-04",
            d.RELATIVE,
            lambda _host, given: given.target_words == (0, 0),
        ),
        ruled("A move of no distance shows no end.", layers.NoDistanceNoEnd),
    ),
    "A-36": (
        refuse(
            "A negative MSW needs a negative LSW.",
            "CMD-04",
            _MOVES,
            lambda _host, given: given.words[2] < 0 and given.words[3] == 0,
        ),
    ),
    "A-37": (
        refuse(
            "-8,388,608 is out of range.",
            "CMD-04",
            _MOVES | d.PRESET,
            lambda _host, given: given.target_words == _LEAST,
            alone=True,
        ),
    ),
    "A-39": (ruled("Eight zero words in a manual move are a command error.", layers.ErrorAtZeroWords),),
    "A-40": (ruled("An invalid change cuts a manual move off.", layers.CutByChange),),
    "A-41": (silent("Speed 0 ends a manual move without an error.", "CMD-15", "PRF-10", "MAN-14"),),
    "A-42": (d.add("A change in constant speed mode makes the position invalid.", "CMD-13", _INVALID),),
    "A-43": (ruled("Stopped is set after a one-shot.", layers.StoppedAfterOneShot),),
    "A-44": (
        refuse(
            "The rates of a one-shot are checked.",
            "CMD-04",
            d.MANUAL,
            lambda _host, given: given.speed_words == (0, 0) and not all(given.words[6:8]),
        ),
    ),
    "A-47": (_option("A move with the external input on is refused.", "one_step_under_external", False),),
    "A-54": (silent("Hold before the registration input is no error.", "CMD-21", "REG-27"),),
    "A-56": (_option("A registration fault cuts the steps off.", "registration_fault_cuts", True),),
    "A-60": (
        _option("Type 10 of a blend segment is invalid.", "blend_type_10_invalid", True),
        _option("Reserved words of a blend block are checked.", "blend_reserved_words_checked", True),
    ),
    "A-62": (d.add("Programming during a blend move makes the position invalid.", "CMD-18", _INVALID),),
    "A-65": (d.hide("Stopped is not set after the follower.", _STOPPED, "follower"),),
    "A-70": (overlook("An encoder is preset without one.", "CMD-11"),),
    "A-72b": (_option("Homing pauses at its reversals.", "home_reversal_dwell_ms", 2000),),
    "A-78": (
        _option("Program mode leaves the position valid.", "invalid_after_program_mode", False),
        _option("Program mode does not set Stopped.", "stopped_after_program_mode", False),
    ),
    "A-81": (
        refuse(
            "The rates of a slow manual move are checked.",
            "CMD-04",
            d.MANUAL,
            lambda _host, given: given.speed_words != (0, 0) and not all(given.words[6:8]),
        ),
    ),
    "A-82": (overlook("Presets act during a motion.", "PST-01", "PST-06"),),
    "A-83": (ruled("A hold is never forfeited.", layers.ResumableForEver),),
    "A-84": (ruled("A refused Resume clears Hold State.", layers.ResumeEndsHold),),
    "A-85": (refuse("Reset Errors is refused during a motion.", "CMD-03", d.RESET, d.is_busy),),
    "A-87": (d.never_clears("Reset Errors leaves Input Error.", _INPUT, at=AT_RESET),),
    "A-92": (
        refuse(
            "Words 2 to 7 of Reset Errors are checked.",
            "CMD-09",
            d.RESET,
            lambda _host, given: any(given.words[2:]),
        ),
    ),
    "A-93": (silent("A minimum distance is refused without an error.", "REG-10", "CMD-20", "REG-13"),),
    "A-95": (d.hide("Encoder moves do not set Move Complete.", _COMPLETE, "encoder"),),
    "A-96": (d.hide("The proximity bit is not echoed.", StatusLsw.HOME_PROX_ECHO.value << 16),),
    "A-99": (ruled("End limits set Stopped in homing.", layers.StoppedWithoutHome),),
    "A-101": (d.never_clears("Configuration mode leaves Command Error.", _COMMAND, at=_COMMAND),),
    "A-102": (_option("Status bits stay over a configuration.", "clear_status_after_config", False),),
    "A-110": (ruled("Only the first fault of a command counts.", layers.OneFaultAtATime),),
    "A-115": (d.add("A rate of a blend block sets Command Error, too.", "BLD-18", _COMMAND),),
}
"""By reading, the modules with a different interpretation."""
