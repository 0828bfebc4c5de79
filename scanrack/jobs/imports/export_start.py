"""The initial state of an exported program."""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.text_limits import EXPORT_MIB


@dataclass(frozen=True)
class ExportStart:
    """The initial state of an exported program; the table `[export]` of a rack file has the same keys.

    Attributes:
        keep_values: whether the first scan continues with the values of the export; otherwise prescan resets
            some of them.
        memory_mib: maximum memory for the tags of the export, MiB.
    """

    keep_values: bool = False
    memory_mib: int = EXPORT_MIB


DOWNLOADED = ExportStart()
"""The initial state after a download."""
