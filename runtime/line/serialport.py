"""pyserial for clients and served ports: settings, and the errors that occur when a port disappears.

pyserial wraps most failures of a port in `SerialException`, an OSError. It does not wrap `termios.error`,
which is not an OSError. `flush`, `apply_settings` and the constructor raise it when a port is unplugged.
"""

from __future__ import annotations

import os
import re
from contextlib import suppress
from importlib import import_module
from typing import Any

from .wire import LineFormat

PORT_ERRORS: tuple[type[Exception], ...] = (OSError, ValueError)
"""Errors that pyserial raises for a port that is missing, unplugged, or lacks the requested format."""

with suppress(ImportError):  # Windows has no termios, and pyserial raises OSErrors there
    PORT_ERRORS += (vars(import_module("termios"))["error"],)


def is_pseudo_terminal(path: str) -> bool:
    """Return whether a path leads to a pseudo-terminal, which does not accept parity."""
    # on Windows, the real path of COM3 would open the port, which resets the device
    return os.path.exists("/dev/pts") and os.path.realpath(path).startswith("/dev/pts/")


def settings(path: str, line_format: LineFormat) -> dict[str, Any]:
    """Return pyserial's settings for a line format, without parity for a pseudo-terminal."""
    return {
        "baudrate": line_format.baud,
        "bytesize": line_format.data_bits,
        "parity": "N" if is_pseudo_terminal(path) else line_format.parity,
        "stopbits": line_format.stop_bits,
    }


def reason(error: Exception) -> str:
    """Return the cause of an error: the system's message, or pyserial's message if there is none.

    >>> reason(OSError(2, "could not open port /dev/ttyUSB0: [Errno 2] No such file or directory"))
    'No such file or directory'
    >>> reason(OSError("could not open port 'COM3': PermissionError(13, 'Access is denied.', None, 5)"))
    'Access is denied.'
    """
    number = getattr(error, "errno", None)
    if number is None and len(error.args) == 2 and isinstance(error.args[0], int):  # termios.error
        number = error.args[0]
    if number is not None:
        return os.strerror(number)
    windows = re.search(r"Error\(\d+, '(.*?)', None, \d+\)", str(error))
    return windows[1] if windows else str(error)
