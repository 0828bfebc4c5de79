"""The editor's position, as a scan and an instruction in that scan."""

from __future__ import annotations

from dataclasses import dataclass

from .breakpoints import Breakpoint
from .view import Stop, View

END = 1 << 30
"""Index of the end of a scan; usable before the scan's instructions are known."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A place in a scan, either before a stop or after one of the stop's writes."""

    index: int  # of the stop in `View.stops`; `END` at the end of the scan
    order: int | None  # see `View.show`

    def position(self) -> tuple[int, int]:
        """Return the sort key of the place within its scan."""
        return self.index, -1 if self.order is None else self.order


class Cursor:
    """A place in a scan that is run again."""

    end = Spot(END, None)

    def __init__(self, view: View) -> None:
        self.view, self.spot = view, self.end

    @property
    def scan(self) -> int:
        """The number of the scan."""
        return self.view.scan

    @property
    def stop(self) -> Stop | None:
        """The next instruction; None at the end of the scan."""
        return None if self.spot.index == END else self.view.stops[self.spot.index]

    @property
    def start(self) -> Spot:
        """The first instruction of the scan."""
        return self._spot(0)

    @property
    def last(self) -> Spot:
        """The last rung of the main routine; the end of the scan if the routine has no rung."""
        stops = self.view.stops
        indices = [index for index, stop in enumerate(stops) if stop.step is None and stop.depth == 0]
        return self._spot(indices[-1]) if indices else self.end

    def go(self, spot: Spot) -> None:
        """Go to another place in the scan."""
        self.spot = spot
        self.view.show(spot.order)

    def _spot(self, index: int) -> Spot:
        stops = self.view.stops
        return Spot(index, stops[index].order) if index < len(stops) else self.end

    # --- steps

    def onward(self, depth: int | None, *, by_instruction: bool) -> Spot | None:
        """Return the next rung or instruction at most `depth` calls deep, or None at the end of the scan.

        Args:
            depth: maximum number of calls; None means any depth.
            by_instruction: whether to stop at every instruction instead of only at rungs.
        """
        for index in range(self.spot.index + 1, len(self.view.stops)):
            if self._fits(self.view.stops[index], depth, by_instruction=by_instruction):
                return self._spot(index)
        return None

    def back(self, depth: int | None, *, by_instruction: bool) -> Spot | None:
        """Return the previous rung or instruction (see `onward`); None at the start of the scan."""
        stop = self.stop
        after_write = stop is not None and self.spot.order != stop.order
        last = min(self.spot.index - (not after_write), len(self.view.stops) - 1)
        for index in range(last, -1, -1):
            if self._fits(self.view.stops[index], depth, by_instruction=by_instruction):
                return self._spot(index)
        return None

    @staticmethod
    def _fits(stop: Stop, depth: int | None, *, by_instruction: bool) -> bool:
        return (by_instruction or stop.step is None) and (depth is None or stop.depth <= depth)

    @property
    def depth(self) -> int:
        """The call depth of the place."""
        return 0 if self.stop is None else self.stop.depth

    # --- breakpoints

    def spot_of(self, breakpoint: Breakpoint) -> Spot:
        """Return the place in the scan where a breakpoint was hit."""
        if breakpoint.keys:
            for index, stop in enumerate(self.view.stops):
                if stop.step is None and (stop.run.routine, stop.run.line.number) in breakpoint.keys:
                    return self._spot(index)
            return self.end
        if breakpoint.kind == "exception":
            return self.end if breakpoint.name == "fault" else self.start
        if not breakpoint.changing_tag:
            return self.end
        write = self.view.last_write(breakpoint.changing_tag)
        return self.start if write is None else Spot(*write)
