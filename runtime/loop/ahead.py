"""Looking ahead: the rack's memory of the coming scans, computed while the modules only continue.

    ordinary scans      block of rows, each one scan's memory          ordinary scan
    | . . . . . . . . | row row row row row row row row row row ... |  . (a ramp ends here)
      wait              calm: outputs stay, no event

Between two events of a module, position and count are closed forms of time. A `ForeseeingModule` returns
the end of that time, and its words of all scans until then at once; other words stay
unchanged in the rows. A scan then copies a row into the rack's memory instead of updating the modules.

Rows are valid as long as nothing acts on a module. New outputs are detected by comparing the memory with the
row after the logic; any other action on a module calls its `before_change`. Either way one `update` brings
the modules up to the present, which their contract allows.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from itertools import islice, repeat
from typing import TYPE_CHECKING, NamedTuple

from scanrack.io_images.image import Image

from .module import foreseeing
from .rack import Rack

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

LEAST_ROWS = 16
"""Minimum number of scans for which a block is worth its cost."""

PAYING_SCANS = 64
"""Number of scans by rows that make up for the cost of a block."""

NUMPY_WORTH_SCANS = 50_000
"""Loading numpy takes as long as this many scans of a module: for fewer it isn't loaded."""


class Block(NamedTuple):
    """The foreseen scans."""

    rows: list[bytes] | bytes  # the rack's memory before the logic of each scan, or of all of them
    length: int
    updated: Sequence[bool] | None = None  # whether the modules update in each scan; None = in all of them

    @classmethod
    def of(cls, rows: list[bytes] | bytes, count: int) -> Block:
        """Return the block in which every scan updates the inputs.

        Args:
            rows: one per scan, or a single one for all.
            count: number of scans, if there is a single row.
        """
        return cls(rows, count if isinstance(rows, bytes) else len(rows))

    def part(self, start: int, count: int) -> list[bytes]:
        """Return the rows of some of its scans."""
        return [self.rows] * count if isinstance(self.rows, bytes) else self.rows[start : start + count]

    def updates(self, start: int) -> Iterator[bool]:
        """Yield whether the modules update in each scan, starting with a given scan."""
        return repeat(True) if self.updated is None else islice(self.updated, start, None)

    def scans(self, start: int) -> Iterator[tuple[bytes, bool]]:
        """Yield rows and updates, starting with a given scan."""
        rows = self.rows
        rows_left = (
            repeat(rows, self.length - start) if isinstance(rows, bytes) else islice(rows, start, None)
        )
        return zip(rows_left, self.updates(start), strict=False)


class RackPrediction:
    """The combined prediction of a rack's modules.

    Attributes:
        possible: whether all modules can predict; if not, nothing is predicted.

    Args:
        sent: the output images in force, in order of the slots.
    """

    def __init__(self, rack: Rack, sent: Sequence[Image]) -> None:
        self._memory = rack.memory
        places = rack.layout.places.values()
        self._inputs = [slot_places.inputs for slot_places in places]
        self._outputs = [slot_places.outputs for slot_places in places]
        modules = [slot.module for slot in rack.slots.values()]
        self._modules = [foreseen for module in modules if (foreseen := foreseeing(module)) is not None]
        self._sent = sent
        self._block: NDArray[np.int16] | None = None
        self.possible = bool(modules) and len(self._modules) == len(modules)

    def tell_before_change(self, notice: Callable[[], None]) -> None:
        """Call `notice` before anything acts on a module."""
        for module in self._modules:
            module.before_change = notice

    def calm_until_ns(self) -> int:
        """Return the instant before which only closed forms change, 0 if unknown."""
        if not self.possible:
            return 0
        until_ns = []
        for module, outputs in zip(self._modules, self._sent, strict=True):
            until_ns.append(module.calm_until_ns(outputs))
            if not until_ns[-1]:
                return 0
        return min(until_ns)

    def rows(self, latest_ns: int, first_ns: int, every_ns: int, count: int) -> list[bytes] | bytes:
        """Return the rack's memory at `count` instants before `calm_until_ns`; a single row if it stays.

        Args:
            latest_ns: the instant of the modules' last `update`.
            first_ns: the first instant.
        """
        foretold = [module.foretell(first_ns, every_ns, count) for module in self._modules]
        present = self._present(latest_ns)
        if not any(foretold):
            return present
        import numpy as np

        words = np.frombuffer(present, "<i2")
        if self._block is None or len(self._block) < count:
            self._block = np.empty((count, len(words)), "<i2")  # reused: new memory must be cleared
        block = self._block[:count]
        block[:] = words
        for inputs, changing in zip(self._inputs, foretold, strict=True):
            for index, values in changing.items():
                block[:, inputs.start // 2 + index] = values
        rows: list[bytes] = block.view(f"V{len(present)}").ravel().tolist()
        return rows

    def _present(self, latest_ns: int) -> bytes:
        """Return the memory with the modules' own inputs, which a force may have covered."""
        present = bytearray(self._memory)
        for inputs, module, outputs in zip(self._inputs, self._modules, self._sent, strict=True):
            present[inputs] = module.update(latest_ns, outputs).raw
        return bytes(present)

    def outputs_of(self, memory: bytes | bytearray) -> list[bytes]:
        """Return the output images in a block with the layout of the rack's memory."""
        return [bytes(memory[image_place]) for image_place in self._outputs]


def numpy_is_worth_it(scans: int) -> bool:
    """Return whether rows may be computed after a number of scans: numpy is loaded, or worth loading."""
    return "numpy" in sys.modules or scans >= NUMPY_WORTH_SCANS


class Patience:
    """Decides when and how far to look ahead: less often after failures, farther after successes."""

    SHORTEST_WAIT, LONGEST_WAIT = 4, 128
    FEWEST_ROWS, MOST_ROWS = 256, 2048

    def __init__(self) -> None:
        self.wait = self.SHORTEST_WAIT  # ordinary scans to run first
        self.longest_wait = self.LONGEST_WAIT
        self.most_rows = self.FEWEST_ROWS  # most scans to foresee while an axis moves

    def not_calm(self, scans: int) -> None:
        """Wait because an event comes within `scans` scans; 0 = the modules can't tell."""
        self.wait = scans + 1 if scans else min(2 * self.wait, self.longest_wait)

    def ended(self, used: int, count: int) -> None:
        """Adapt to a block whose first `used` scans were run."""
        if used == count:
            self.wait = 1
            self.most_rows = min(2 * self.most_rows, self.MOST_ROWS)
            return
        paid = used >= PAYING_SCANS
        self.wait = self.SHORTEST_WAIT if paid else min(2 * self.wait, self.longest_wait)
        if 4 * used < self.most_rows:
            self.most_rows = max(self.most_rows // 2, self.FEWEST_ROWS)
