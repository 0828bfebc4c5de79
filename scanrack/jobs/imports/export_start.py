"""How a program that is an export begins."""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.text_limits import EXPORT_MIB


@dataclass(frozen=True)
class ExportStart:
    """How a program that is an export begins; the table `[export]` of a rack file has the same keys.

    Attributes:
        keep_values: the first scan continues with the values of the export; without it prescan resets them.
        memory_mib: memory that the tags of the export may take, MiB.
    """

    keep_values: bool = False
    memory_mib: int = EXPORT_MIB


DOWNLOADED = ExportStart()
"""An export begins as after a download."""
