"""Looking ahead: the rack's memory of the coming scans, while no module has anything new to show.

    ordinary scans      block of rows, each one scan's memory          ordinary scan
    | . . . . . . . . | row row row row row row row row row row ... |  . (a ramp ends here)
      wait              calm: outputs stay, nothing happens

Between two events of a module, position and count are closed forms of time. A module that is `Foreseeing`
says until when that holds and tells its words of all scans up to there at once; what does not change stays
in the rows as it is. A scan then copies a row into the rack's memory instead of updating the modules.

Rows hold as long as nobody acts on a module. New outputs are seen by comparing the memory with the row
after the logic; whatever else acts on a module calls its `before_change`. Either way the modules are brought
up to the present by one `update`, which their contract allows, and go on as ever.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from itertools import repeat
from typing import NamedTuple

from ...io_images.image import IMAGE_BYTES, Image
from .module import Foreseeing
from .rack import SLOT_BYTES, Rack

_SLOT_WORDS = SLOT_BYTES // 2
_INPUT_WORDS = _SLOT_WORDS // 2

LEAST_ROWS = 16
"""A block is not worth its making for fewer scans."""

PAYING_SCANS = 64
"""The scans that pay for the making of a block."""

NUMPY_WORTH_SCANS = 50_000
"""Loading numpy takes as long as so many scans of a module: for fewer it isn't loaded."""


class Block(NamedTuple):
    """The coming scans, as far as they are foreseen.

    Attributes:
        scans: for each the rack's memory as the logic finds it, and whether the modules update their inputs.
        count: how many scans.
    """

    scans: Iterable[tuple[bytes, bool]]
    count: int


class Outlook:
    """What the modules of a rack foretell together.

    Attributes:
        possible: whether all of them can; otherwise nothing is foreseen.

    Args:
        rack: the rack.
        sent: the output images in force, in order of the slots.
    """

    def __init__(self, rack: Rack, sent: Sequence[Image]) -> None:
        self._memory = rack.memory
        modules = [slot.module for slot in rack.slots.values()]
        self._modules = [module for module in modules if isinstance(module, Foreseeing)]
        self._sent = sent
        self.possible = bool(modules) and len(self._modules) == len(modules)

    def tell_before_change(self, notice: Callable[[], None]) -> None:
        """Have `notice` called before anything acts on a module."""
        for module in self._modules:
            module.before_change = notice

    def calm_until_ns(self) -> int:
        """Return the instant before which nothing but closed forms changes, 0 if that isn't known."""
        if not self.possible:
            return 0
        until_ns = []
        for module, outputs in zip(self._modules, self._sent, strict=True):
            until_ns.append(module.calm_until_ns(outputs))
            if not until_ns[-1]:
                return 0
        return min(until_ns)

    def rows(self, first_ns: int, every_ns: int, count: int) -> list[bytes] | None:
        """Return the rack's memory at `count` instants before `calm_until_ns`; None = it stays as it is."""
        told = [module.foretell(first_ns, every_ns, count) for module in self._modules]
        if not any(told):
            return None
        import numpy as np

        present = np.frombuffer(self._memory, "<i2")
        block = np.empty((count, len(present)), "<i2")
        block[:] = present
        for place, words in enumerate(told):
            for index, values in words.items():
                block[:, _SLOT_WORDS * place + _INPUT_WORDS + index] = values
        rows: list[bytes] = block.view(f"V{len(self._memory)}").ravel().tolist()
        return rows

    def foresee(self, first_ns: int, every_ns: int, count: int, most_rows: int) -> Block:
        """Return the scans at `count` instants before `calm_until_ns`, up to `most_rows` if anything moves."""
        rows = self.rows(first_ns, every_ns, min(count, most_rows))
        if rows is None:
            return Block(repeat((bytes(self._memory), True), count), count)
        return Block(zip(rows, repeat(True)), len(rows))


def outputs_of(memory: bytes | bytearray) -> list[bytes]:
    """Return the output images in a block of memory.

    >>> outputs_of(bytes(range(64)))[1].hex()
    '202122232425262728292a2b2c2d2e2f'
    """
    return [bytes(memory[at : at + IMAGE_BYTES]) for at in range(0, len(memory), SLOT_BYTES)]


def numpy_is_worth_it(scans: int) -> bool:
    """Return whether rows may be computed after so many scans: numpy is loaded, or worth loading."""
    return "numpy" in sys.modules or scans >= NUMPY_WORTH_SCANS


class Patience:
    """When to look ahead again, and how far: where it did not pay, less often; where it did, farther.

    Attributes:
        wait: ordinary scans to run first.
        most_rows: most scans to foresee while an axis moves.
    """

    SHORTEST_WAIT, LONGEST_WAIT = 4, 128
    FEWEST_ROWS, MOST_ROWS = 256, 2048

    def __init__(self) -> None:
        self.wait = self.SHORTEST_WAIT
        self.most_rows = self.FEWEST_ROWS

    def not_calm(self, scans: int) -> None:
        """Wait because an event comes within so many scans; 0 = the modules can't tell."""
        self.wait = scans + 1 if scans else min(2 * self.wait, self.LONGEST_WAIT)

    def ended(self, used: int, count: int) -> None:
        """Learn from a block of which so many scans were used."""
        if used == count:
            self.wait = 1
            self.most_rows = min(2 * self.most_rows, self.MOST_ROWS)
            return
        paid = used >= PAYING_SCANS
        self.wait = self.SHORTEST_WAIT if paid else min(2 * self.wait, self.LONGEST_WAIT)
        if 4 * used < self.most_rows:
            self.most_rows = max(self.most_rows // 2, self.FEWEST_ROWS)
