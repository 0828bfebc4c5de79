"""The rung that counts the scans of a user's controller, for import as L5X or SLC.

In a 2 ms periodic task, the count measures time. The rung writes only its own tag.
"""

from __future__ import annotations

from scanrack.ladder.files.rungfile import parse_program
from scanrack.rockwell.l5x.export import export_l5x

COUNTER_TAG = "ConformScan"
"""Tag of the counter in a Logix controller."""

RUNGS = f"""CONTROLLER Conform
TAG {COUNTER_TAG} : DINT
TASK ConformTask : PERIODIC 2 ms RUNS Conform
PROGRAM Conform MAIN Count
ROUTINE Count
ADD({COUNTER_TAG},1,{COUNTER_TAG});
END
END PROGRAM
"""

SLC = """PROJECT "CONFORM"
LADDER 2 "COUNT"
% Counts scans up to 29,999 for scanrack conform; take a word that nothing else writes. %
SOR ADD N7:0 1 N7:0 EOR
SOR GEQ N7:0 30000 CLR N7:0 EOR
DATA N7:0 0
END
"""


def counter_rung(kind: str) -> str:
    """Return the rung as a file for import: `l5x` or `slc`."""
    if kind == "slc":
        return SLC
    return export_l5x(parse_program(RUNGS), "Conform").decode("utf-8")
