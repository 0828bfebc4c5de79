"""File names and relative paths that are the same on every system."""

from __future__ import annotations

import re
from os.path import relpath
from pathlib import Path, PurePath

DEVICE = r"(con|prn|aux|nul|com[\d¹²³]|lpt[\d¹²³])\s*(?=\.|/|$)"
"""Pattern of a part of a path that is a device on Windows, with any suffix, in upper or lower case."""

_DEVICE = re.compile(DEVICE, re.IGNORECASE)


def no_device(name: str) -> str:
    """Return the name of a file or folder; change the name if it refers to a device on Windows.

    >>> no_device("aux"), no_device("COM3.mcap"), no_device("comb")
    ('aux_', 'COM3_.mcap', 'comb')
    """
    match = _DEVICE.match(name)
    return name if match is None else f"{name[: match.end()]}_{name[match.end() :]}"


def relative(path: PurePath | str, folder: PurePath | str) -> str:
    """Return a file's path relative to a folder, with "/"; on another drive, return the absolute path."""
    try:
        relative_path = relpath(path, folder)
    except ValueError:
        relative_path = str(path)
    return Path(relative_path).as_posix()
