"""The contract of every module in a slot of the rack.

A simulated 3601, an adapter of a real controller, a module that replays a
trace and a module wrapped in simulated faults look the same to the scan loop.
None of them owns a clock, a thread or unseeded randomness: time is the argument
of `update`, an integer number of nanoseconds since power-up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol, TypeAlias, runtime_checkable

from scanrack.io_images.image import Image

from .events import Event

if (
    TYPE_CHECKING
):  # numpy takes longer to load than 50,000 scans; a module without prediction does not need it
    import numpy as np
    from numpy.typing import NDArray

    Words: TypeAlias = Mapping[int, NDArray[np.int64]]
    """Input words by their index, 0 to 7: their values at many instants; the low 16 bits count."""


class Module(Protocol):
    """A module, as the scan loop uses it."""

    events: list[Event]
    """Events since the list was last emptied, in order of time; the scan loop empties it."""

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to `now_ns` with `outputs` in force since the last call; return the input image then.

        The result must not depend on the number of calls: advancing once
        or in pieces gives the same images at the same instants.

        Args:
            now_ns: virtual time in ns since power-up, never less than in the previous call.
            outputs: the output image in force since the previous call (since
                power-up in the first call). The module keeps no reference to it.

        Returns:
            The input image at `now_ns`. It belongs to the module and is valid until the next
            call; copy it to keep it.
        """

    def plc_run(self, running: bool) -> None:
        """Set whether the PLC is in run mode, effective at the last `now_ns`.

        A module starts with a running PLC. Program, test and single-scan mode all
        count as not running: outputs are not sent to the module.
        """

    def power_cycle(self) -> None:
        """Remove and restore power at the last `now_ns`; volatile data are lost, the clock continues."""


@runtime_checkable
class ForeseeingModule(Module, Protocol):
    """A module that can compute its coming inputs while nothing acts on it, see `runtime.loop.ahead`.

    The predicted inputs equal the inputs of `update` bit by bit.

    Attributes:
        before_change: called by the module before anything but `update` acts on it, from its PLC's
            mode to its machine's inputs, or reads values that change in between; afterwards it is
            up to date.
    """

    before_change: Callable[[], None]

    def calm_until_ns(self, outputs: Image) -> int:
        """Return the instant before which the module only continues, without an event.

        Args:
            outputs: the output image that stays in force.

        Returns:
            An instant; one that is not later than the last `update` if it is unknown.
        """

    def foretell(self, first_ns: int, every_ns: int, count: int) -> Words:
        """Return the input words that change at `count` instants, `every_ns` apart; the others stay.

        Args:
            first_ns: the first instant, later than the last `update`.
            count: 1 or more; all instants lie before `calm_until_ns`.
        """


def foreseeing(module: Module) -> ForeseeingModule | None:
    """Return a module that can compute its coming inputs, None for others; faster than `isinstance`."""
    is_foreseeing = all(hasattr(module, name) for name in ("before_change", "calm_until_ns", "foretell"))
    return module if is_foreseeing else None  # type: ignore[return-value]


def unnoticed() -> None:
    """Ignore a change: the value of `before_change` while nothing has been computed ahead."""


@runtime_checkable
class Follower(Module, Protocol):
    """A module whose inputs depend on other slots' modules at the same instant."""

    @property
    def follows(self) -> frozenset[int]:
        """The slots to be advanced before this one in every exchange; none of them follows another."""

    def join(self, modules: Mapping[int, Module]) -> None:
        """Connect to the modules of the rack, by slot number, before the first `update`.

        Raises:
            ValueError: a slot without a module that it can follow.
        """


def following(module: Module) -> Follower | None:
    """Return a module that depends on others, None for the rest; faster than `isinstance`."""
    return module if hasattr(module, "follows") and hasattr(module, "join") else None  # type: ignore[return-value]
