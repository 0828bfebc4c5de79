"""Compare two files: both L5X, or both RSLogix 500 text."""

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
        LadderError: one can't be read, or one is an L5X and the other is not.
    """
    before, after = read_bytes(old), read_bytes(new)
    kinds = [_is_xml(export) for export in (before, after)]
    if kinds[0] != kinds[1]:
        names = [
            f"{file} is {'an L5X' if xml else 'text of RSLogix 500'}"
            for file, xml in zip((new, old), kinds[::-1], strict=True)
        ]
        raise LadderError(f"{', '.join(names)}: --against compares two L5X files, or two of RSLogix 500")
    if kinds[0]:
        return compared(*outlines(before, after, (str(old), str(new))))
    return compared(outline_of_slc(before, str(old)), outline_of_slc(after, str(new)))


def text_of_export(path: Path) -> str:
    """Return an export as text that ignores order and dates; raise a LadderError if it can't be read."""
    data = read_bytes(path)
    item = outline(data, str(path)) if _is_xml(data) else outline_of_slc(data, str(path))
    return "\n".join(canonical_lines(item))


def _is_xml(data: bytes) -> bool:
    """Whether bytes begin like XML, in any encoding."""
    return b"<" in data.lstrip(b"\xef\xbb\xbf\xff\xfe \t\r\n")[:2]
