"""The contents of a trace as named columns of bits, words and decoded values, block by block.

slot1.in.COMMAND_ERROR    a bit                      slot1.in.position   a decoded value
slot1.in.status_msw       a word                     slot1.speed         a measured speed
slot1.in.status_msw.12    a bit of a word, by number
"""

from ..read.columns import ALL, Selection
from .catalog import Catalog
from .signal import Signal, SignalKind
from .stream import Block, blocks, count

__all__ = ["ALL", "Block", "Catalog", "Selection", "Signal", "SignalKind", "blocks", "count"]
