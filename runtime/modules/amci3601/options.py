"""Switches of the model: where the manual contradicts itself or is silent.

Every reading is described in `docs/readings.md`; the default is the one used
everywhere else in this project. A switch exists where a user's real module may
turn out to behave the other way.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, fields

from ...loop.events import JsonValue


@dataclass(frozen=True, slots=True)
class Amci3601Options:
    """Model switches of the simulated 3601, by the names used in rack files and by `scanrack drive`.

    Attributes:
        input_scan_us: period of the module's own scan in µs, 50 to 250,000 (reading A-01).
        stopped_after_config: STOPPED is set when configuration mode is left (A-02).
        mirror_rejected_config: a rejected configuration is echoed, too (A-06).
        report_unused_inputs: status bits of unused inputs show the electrical level (A-13).
        complete_after_error: MOVE_COMPLETE is set at the end of a move during which a command
            error arose (A-27).
        hold_error_in_encoder_move: Hold during an encoder move sets COMMAND_ERROR (A-23).
        one_step_under_external: after a hold by the external input, a move that is commanded with the
            input still on makes one step and holds again; if false it is refused with a command
            error (A-47).
        registration_fault_cuts: a fault in the words of a registration move, or of a manual move that
            is given a target, ends the steps without a ramp (A-56).
        blend_type_10_invalid: acceleration type 10 of a blend segment is an invalid profile and not
            a constant acceleration (A-60).
        blend_reserved_words_checked: data in the unused words of a blend block is an invalid
            profile (A-60).
        invalid_after_program_mode: leaving run mode during a motion sets POSITION_INVALID (A-78).
        stopped_after_program_mode: leaving run mode during a motion sets STOPPED (A-78).
        clear_status_after_config: leaving configuration mode clears all status bits of word 0
            below bit 13 but POSITION_INVALID (A-102).
        home_reversal_dwell_ms: pause at each reversal of a home-switch homing, in ms, 0 and more
            (A-72b).

    Raises:
        ValueError: a number out of range, with what is allowed.
    """

    input_scan_us: int = 250
    stopped_after_config: bool = False
    mirror_rejected_config: bool = False
    report_unused_inputs: bool = False
    complete_after_error: bool = True
    hold_error_in_encoder_move: bool = True
    one_step_under_external: bool = True
    registration_fault_cuts: bool = False
    blend_type_10_invalid: bool = False
    blend_reserved_words_checked: bool = False
    invalid_after_program_mode: bool = True
    stopped_after_program_mode: bool = True
    clear_status_after_config: bool = True
    home_reversal_dwell_ms: int = 0

    def __post_init__(self) -> None:
        if not 50 <= self.input_scan_us <= 250_000:
            raise ValueError(f"option input_scan_us: {self.input_scan_us} is out of range: 50 to 250000")
        if self.home_reversal_dwell_ms < 0:
            raise ValueError(
                f"option home_reversal_dwell_ms: {self.home_reversal_dwell_ms} is out of range: 0 and more"
            )

    @classmethod
    def of(cls, given: Mapping[str, JsonValue] | None) -> Amci3601Options:
        """Make options from names and values.

        Raises:
            ValueError: an unknown name, or a value of another type, with what is allowed.
        """
        defaults = {field.name: field.default for field in fields(cls)}
        for name, value in (given or {}).items():
            if name not in defaults:
                near = difflib.get_close_matches(name, defaults, n=1)
                hint = f"; did you mean {near[0]}?" if near else f"; allowed are {', '.join(defaults)}"
                raise ValueError(f"option {name}: the simulated 3601 has no such switch{hint}")
            kind = type(defaults[name])
            if type(value) is not kind:
                wanted = "true or false" if kind is bool else "a whole number"
                raise ValueError(f"option {name}: {value!r} is not {wanted}")
        return cls(**(given or {}))  # type: ignore[arg-type]  # checked name by name above
