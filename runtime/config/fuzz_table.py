"""The table `[fuzz]` of a rack file: what `scanrack fuzz` does there unless its options say otherwise.

[fuzz]
seed = 7                    # another search of the same program
only = ["inputs", "link"]   # what is random
without = ["firmware"]      # what is not
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from .machine_tables import Table

MOST_SEED = 2**31 - 1

Names = Annotated[tuple[str, ...], Field(strict=False)]


class FuzzTable(Table):
    """How a rack is searched.

    Attributes:
        seed: another number makes another search, 0 to 2147483647.
        only: the kinds of random events; all that are possible if left out.
        without: kinds that are left out.
    """

    seed: Annotated[int, Field(ge=0, le=MOST_SEED)] = 0
    only: Names = ()
    without: Names = ()
