"""Exceptions that an await raises if a command failed or was aborted."""

from __future__ import annotations

from enum import IntFlag


class ErrorId(IntFlag):
    """ErrorID of the function blocks, as bits, because the module may report several errors."""

    COMMAND_ERROR = 1
    INVALID_PROFILE = 2
    HOME_INVALID = 4
    INPUT_ERROR = 8
    CONFIG_ERROR = 16  # or the module has lost its configuration: configure again
    MODULE_LOST = 32  # MODULE_OK is off
    WRONG_STATE = 64  # refused: the state of the axis does not allow the command
    PARAMETER = 128  # refused: a parameter is out of range
    POSITION_INVALID = 256  # refused: an absolute move needs a valid position, see `home` and `set_position`
    LINK_LOST = 512  # the link to the module was lost during the command
    NOT_DONE = 1024  # the axis is at rest, and the command has not begun or did not end as expected
    DRIVE_FAULT = 2048  # a networked drive has stalled, its driver has a fault, or it is not enabled
    NOT_AVAILABLE = 4096  # refused: the module has no such command


WORDS = {
    ErrorId.COMMAND_ERROR: "the module reports COMMAND_ERROR",
    ErrorId.INVALID_PROFILE: "the module reports INVALID_PROFILE",
    ErrorId.HOME_INVALID: "the module reports HOME_INVALID",
    ErrorId.INPUT_ERROR: "the module reports INPUT_ERROR",
    ErrorId.CONFIG_ERROR: "the module has no valid configuration",
    ErrorId.MODULE_LOST: "MODULE_OK is off",
    ErrorId.WRONG_STATE: "the state of the axis does not allow it",
    ErrorId.PARAMETER: "a parameter is out of range",
    ErrorId.POSITION_INVALID: "the position is not valid",
    ErrorId.LINK_LOST: "the link was lost",
    ErrorId.NOT_DONE: "the axis is at rest and the command is not done",
    ErrorId.DRIVE_FAULT: "the drive has stalled, has a fault, or is not enabled",
    ErrorId.NOT_AVAILABLE: "the module has no such command",
}
"""Meaning of each bit."""


def reasons(error_id: int, detail: str = "") -> str:
    """Return the meaning of an ErrorID, followed by its number.

    >>> reasons(3)
    'the module reports COMMAND_ERROR, the module reports INVALID_PROFILE [ErrorID 3]'
    >>> reasons(64, "state ERROR_STOP")
    'the state of the axis does not allow it [ErrorID 64]: state ERROR_STOP'
    """
    text = ", ".join(words for bit, words in WORDS.items() if error_id & bit)
    return f"{text} [ErrorID {error_id}]" + (f": {detail}" if detail else "")


class AxisError(Exception):
    """A command failed or was refused; `id` is its ErrorID, bits of `ErrorId`."""

    def __init__(self, text: str, error_id: int) -> None:
        super().__init__(text)
        self.id = ErrorId(error_id)


class CommandAborted(Exception):  # noqa: N818 - the name in PLCopen
    """Another command took over the axis."""
