"""The table `[export]` of a rack file: how an exported program starts.

[export]
keep_values = true    # continue with the values of the export, without prescan
memory_mib = 512      # memory for the tags
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from scanrack.io_images.text_limits import EXPORT_MIB, EXPORT_MIB_MOST

from .machine_tables import Table


class ExportTable(Table):
    """How an exported program starts.

    Attributes:
        keep_values: whether the first scan continues with the values in the export (timers, one-shots, chart
            steps); if false, prescan resets them, as after a download.
        memory_mib: maximum memory of the export's tags, 1 to 4096 MiB.
    """

    keep_values: bool = False
    memory_mib: Annotated[int, Field(ge=1, le=EXPORT_MIB_MOST)] = EXPORT_MIB
