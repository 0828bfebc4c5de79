"""The path of a rack's operator panel, which the page shows."""

from __future__ import annotations

from pathlib import PurePath

from .program import split_address

SUFFIX = ".panel"
"""Suffix of a panel. Its content is TOML, but the suffix .toml is used for racks."""


def panel_name(rack: str) -> str:
    """Return the path of the panel beside a rack.

    >>> panel_name("feeder.toml"), panel_name("line.py:rack")
    ('feeder.panel', 'line.panel')
    """
    return str(PurePath(split_address(rack)[0]).with_suffix(SUFFIX))
