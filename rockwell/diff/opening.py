"""Compares two files: both L5X, or both RSLogix 500 text."""

from __future__ import annotations

from pathlib import Path

from scanrack.ladder.model.errors import LadderError

from ..l5x.xml.document import read_bytes
from .comparison import Comparison, compared
from .l5x import outline, outlines
from .outline import canonical_lines
from .slc import outline_of_slc


def compare_exports(old: Path, new: Path) -> Comparison:
    """Compare two versions of an export.

    Raises:
        LadderError: a file can't be read, or only one of them is an L5X.
    """
    old_data, new_data = read_bytes(old), read_bytes(new)
    if _is_xml(old_data) and _is_xml(new_data):
        return compared(*outlines(old_data, new_data, (str(old), str(new))))
    if _is_xml(old_data) or _is_xml(new_data):
        names = [
            f"{file} is {'an L5X' if _is_xml(data) else 'text of RSLogix 500'}"
            for file, data in ((new, new_data), (old, old_data))
        ]
        raise LadderError(f"{', '.join(names)}: --against compares two L5X files, or two of RSLogix 500")
    return compared(outline_of_slc(old_data, str(old)), outline_of_slc(new_data, str(new)))


def text_of_export(path: Path) -> str:
    """Return an export as text that ignores order and dates; raise a LadderError if it can't be read."""
    data = read_bytes(path)
    item = outline(data, str(path)) if _is_xml(data) else outline_of_slc(data, str(path))
    return "\n".join(canonical_lines(item))


def _is_xml(data: bytes) -> bool:
    """Return whether bytes begin like XML in any encoding."""
    return b"<" in data.lstrip(b"\xef\xbb\xbf\xff\xfe \t\r\n")[:2]
