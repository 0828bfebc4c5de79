"""The error code register, bit by bit [Section 5, Error Codes].

The register is the sum of all errors; `!`, command code 10 and a reset clear it. No error locks the
controller.
"""

from __future__ import annotations

from enum import IntFlag


class Error(IntFlag):
    """A bit of the error code register."""

    RECEIVE_OVERFLOW = 1 << 0
    ENCODER_CORRECTED = 1 << 1
    ENCODER_FAILED = 1 << 2
    COMMAND = 1 << 3
    MOTOR = 1 << 4
    RANGE_OVERFLOW = 1 << 5
    RANGE = 1 << 6
    TRANSMIT = 1 << 7
    MODE = 1 << 8
    ZERO_PARAMETERS = 1 << 9
    BUSY = 1 << 10
    MEMORY_RANGE = 1 << 11
    MEMORY_COMMAND = 1 << 12
    THUMBWHEEL = 1 << 13


NO_ERROR = Error(0)

CAUSES: dict[Error, str] = {
    Error.RECEIVE_OVERFLOW: "an AA ASCII line longer than the receive buffer",
    Error.ENCODER_CORRECTED: "the encoder was outside the window and a correction was begun",
    Error.ENCODER_FAILED: "still outside the window after all retries; output 8 is on",
    Error.COMMAND: "a command that is none: an unknown letter, a command code above 15",
    Error.MOTOR: "motion requested with base speed >= max (or jog) speed, or an acceleration out of range",
    Error.RANGE_OVERFLOW: "P beyond ±8,388,607, or further than 8,388,607 steps away",
    Error.RANGE: "a parameter out of range or in the wrong form; motion to a position out of range",
    Error.TRANSMIT: "internal to the controller: the simulation never raises it",
    Error.MODE: "not for the present mode: writing while a program runs, text in Modbus mode",
    Error.ZERO_PARAMETERS: "a parameter is missing; M, N, P without one while their input is disabled",
    Error.BUSY: "a command that needs an idle axis was given in motion",
    Error.MEMORY_RANGE: "a program beyond 2,046 bytes: refused before it is loaded, so never raised",
    Error.MEMORY_COMMAND: "no instruction where one was to be executed: no program, RETURN without GOTO",
    Error.THUMBWHEEL: "no thumbwheel, or SW2 not in its position",
}
"""Cause of each bit in the simulation, in bit order."""
