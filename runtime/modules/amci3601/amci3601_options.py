"""Options of the simulated 3601: interpretations of the manual that a real module may contradict.

`docs/readings.md` describes every interpretation. The rest of the project uses the defaults.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from ...loop.module_options import Options


class Amci3601Options(Options):
    """Options of the simulated 3601, by the names used in rack files and by `scanrack drive`.

    Attributes:
        input_scan_us: period of the module's scan, µs, 50 to 250,000 (A-01).
        stopped_after_config: STOPPED is set when configuration mode is left (A-02).
        mirror_rejected_config: the module also echoes a rejected configuration (A-06).
        report_unused_inputs: status bits of unused inputs show the electrical level (A-13).
        complete_after_error: MOVE_COMPLETE is set at the end of a move, even after a command error during the
            move (A-27).
        hold_error_in_encoder_move: Hold during an encoder move sets COMMAND_ERROR (A-23).
        one_step_under_external: after a hold by the external input, a new move while the input is still on
            makes one step and holds again; otherwise it is refused with a command error (A-47).
        registration_fault_cuts: a fault in the words of a registration move, or a target during a manual
            move, ends the steps without a ramp (A-56).
        blend_type_10_invalid: acceleration type 10 of a blend segment is an invalid profile; otherwise it is
            a constant acceleration (A-60).
        blend_reserved_words_checked: data in the unused words of a blend block is an invalid profile (A-60).
        invalid_after_program_mode: leaving run mode during a motion sets POSITION_INVALID (A-78).
        stopped_after_program_mode: leaving run mode during a motion sets STOPPED (A-78).
        clear_status_after_config: leaving configuration mode clears all status bits of word 0 below bit 13
            except POSITION_INVALID (A-102).
        home_reversal_dwell_ms: pause at each reversal of a home-switch homing, ms, 0 or more (A-72b).
    """

    owner: ClassVar[str] = "simulated 3601"

    input_scan_us: Annotated[int, Field(ge=50, le=250_000)] = 250
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
    home_reversal_dwell_ms: Annotated[int, Field(ge=0)] = 0
