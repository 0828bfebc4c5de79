"""The table `[fuzz]` of a rack file: settings of `scanrack fuzz`, which its options override.

[fuzz]
seed = 7                    # another search of the same program
only = ["inputs", "link"]   # kinds of random events
without = ["firmware"]      # kinds to omit
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from .machine_tables import Table

MOST_SEED = 2**31 - 1

Names = Annotated[tuple[str, ...], Field(strict=False)]


class FuzzTable(Table):
    """Settings of `scanrack fuzz`.

    Attributes:
        seed: seed of the search, 0 to 2147483647; a different seed starts a different search.
        only: kinds of random events; all possible kinds if omitted.
        without: kinds of random events to omit.
    """

    seed: Annotated[int, Field(ge=0, le=MOST_SEED)] = 0
    only: Names = ()
    without: Names = ()
