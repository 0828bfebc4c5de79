"""The rack's memory in upcoming scans, computed in advance while the modules have no events.

    ordinary scans      block of rows, each one scan's memory          ordinary scan
    | . . . . . . . . | row row row row row row row row row row ... |  . (a ramp ends here)
      wait              calm: outputs unchanged, no event

Between two events of a module, position and count are closed forms of time. A `ForeseeingModule` returns the
instant of the next event and, in one call, its changing words for all scans until then. The other words of a
row keep their current values. A scan then copies a row into the rack's memory instead of updating the
modules.

Rows are valid as long as nothing acts on a module. New outputs are detected when the memory after the logic
differs from the row. Any other action on a module calls its `before_change`. In both cases one `update`
brings the modules up to date, which their contract allows.
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
"""Minimum number of scans in a block: computing a shorter block costs more than it saves."""

PAYING_SCANS = 64
"""Number of scans after which a block has saved more than it cost."""

NUMPY_WORTH_SCANS = 50_000
"""Loading numpy takes as long as this many scans of a module. A shorter run does not load it."""


class Block(NamedTuple):
    """Scans computed in advance, with the rack's memory in each."""

    rows: list[bytes] | bytes  # the rack's memory before the logic: of each scan, or the same for all
    length: int
    updated: Sequence[bool] | None = None  # whether the modules update in each scan; None = in all of them

    @classmethod
    def all_updated(cls, rows: list[bytes] | bytes, count: int) -> Block:
        """Return a block in which every scan updates the inputs.

        Args:
            rows: one row per scan, or a single row for all scans.
            count: number of scans if there is a single row; ignored otherwise.
        """
        return cls(rows, count if isinstance(rows, bytes) else len(rows))

    def rows_from(self, start: int, count: int) -> list[bytes]:
        """Return the rows of `count` scans, the first one with index `start`."""
        return [self.rows] * count if isinstance(self.rows, bytes) else self.rows[start : start + count]

    def updates(self, start: int) -> Iterator[bool]:
        """For each scan from index `start` on, yield whether the modules update."""
        return repeat(True) if self.updated is None else islice(self.updated, start, None)

    def scans(self, start: int) -> Iterator[tuple[bytes, bool]]:
        """For each scan from index `start` on, yield its row and whether the modules update."""
        rows = self.rows
        if isinstance(rows, bytes):
            return zip(repeat(rows, self.length - start), self.updates(start), strict=False)
        return zip(islice(rows, start, None), self.updates(start), strict=False)


class RackPrediction:
    """The combined prediction of a rack's modules.

    Attributes:
        possible: whether all modules can predict. If not, nothing is predicted.

    Args:
        sent: the output images in effect, in slot order.
    """

    def __init__(self, rack: Rack, sent: Sequence[Image]) -> None:
        self._memory = rack.memory
        images = rack.layout.places.values()  # slices of the memory
        self._inputs = [image.inputs for image in images]
        self._outputs = [image.outputs for image in images]
        modules = [slot.module for slot in rack.slots.values()]
        self._modules = [module for module in map(foreseeing, modules) if module is not None]
        self._sent = sent
        self._block: NDArray[np.int16] | None = None
        self.possible = bool(modules) and len(self._modules) == len(modules)

    def call_before_change(self, notice: Callable[[], None]) -> None:
        """Arrange for `notice` to be called before anything acts on a module."""
        for module in self._modules:
            module.before_change = notice

    def calm_until_ns(self) -> int:
        """Return the instant, ns, before which the modules have no events; 0 if it is unknown."""
        if not self.possible:
            return 0
        until_ns = []
        for module, outputs in zip(self._modules, self._sent, strict=True):
            until_ns.append(module.calm_until_ns(outputs))
            if not until_ns[-1]:
                return 0
        return min(until_ns)

    def rows(self, latest_ns: int, first_ns: int, every_ns: int, count: int) -> list[bytes] | bytes:
        """Return the rack's memory at `count` instants before `calm_until_ns`; a single row if constant.

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
        """Return the current memory with the modules' own inputs in place of forced ones."""
        present = bytearray(self._memory)
        for inputs, module, outputs in zip(self._inputs, self._modules, self._sent, strict=True):
            present[inputs] = module.update(latest_ns, outputs).raw
        return bytes(present)

    def outputs_of(self, memory: bytes | bytearray) -> list[bytes]:
        """Return the output images in a memory that has the rack's layout."""
        return [bytes(memory[image]) for image in self._outputs]


def numpy_is_worth_it(scans: int) -> bool:
    """Return whether numpy is already loaded, or is worth loading after this number of scans."""
    return "numpy" in sys.modules or scans >= NUMPY_WORTH_SCANS


class Patience:
    """Decides when and how far to look ahead: less often after failures, and farther after successes."""

    SHORTEST_WAIT, LONGEST_WAIT = 4, 128
    FEWEST_ROWS, MOST_ROWS = 256, 2048

    def __init__(self) -> None:
        self.wait = self.SHORTEST_WAIT  # ordinary scans before the next block
        self.longest_wait = self.LONGEST_WAIT
        self.most_rows = self.FEWEST_ROWS  # maximum rows of a block while an axis moves

    def not_calm(self, scans: int) -> None:
        """Wait, because the next event is due in `scans` scans; 0 = unknown."""
        self.wait = scans + 1 if scans else min(2 * self.wait, self.longest_wait)

    def ended(self, used: int, count: int) -> None:
        """Adapt to a block that has ended after its first `used` scans were run."""
        if used == count:
            self.wait = 1
            self.most_rows = min(2 * self.most_rows, self.MOST_ROWS)
            return
        was_worth_it = used >= PAYING_SCANS
        self.wait = self.SHORTEST_WAIT if was_worth_it else min(2 * self.wait, self.longest_wait)
        if 4 * used < self.most_rows:
            self.most_rows = max(self.most_rows // 2, self.FEWEST_ROWS)
