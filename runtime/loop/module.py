"""The contract that every module in a slot of the rack fulfills.

The scan loop treats a simulated 3601, an adapter for a real controller, a module that replays a trace, and a
module with injected faults all in the same way. None of them has a clock, a thread or unseeded randomness.
Time is an argument of `update`, an integer number of nanoseconds since power-up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol, TypeAlias, runtime_checkable

from scanrack.io_images.image import Image

from .events import Event

if TYPE_CHECKING:  # loading numpy takes longer than 50,000 scans, and only predictions need it
    import numpy as np
    from numpy.typing import NDArray

    Words: TypeAlias = Mapping[int, NDArray[np.int64]]
    """Values of input words at many instants, by index of the word; only the low 16 bits count."""


class Module(Protocol):
    """A module, as the scan loop uses it."""

    events: list[Event]
    """Events in chronological order; the scan loop clears the list."""

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance to `now_ns` with `outputs` in effect since the last call; return the input image.

        The result must not depend on the number of calls: one long advance and several short ones must return
        the same images at the same instants.

        Args:
            now_ns: virtual time, ns since power-up; never less than in the previous call.
            outputs: the output image in effect since the previous call (since
                power-up in the first call). The module must not keep a reference to it.

        Returns:
            The input image at `now_ns`. It belongs to the module and is valid until the next
            call; copy it to keep it.
        """

    def plc_run(self, running: bool) -> None:
        """Set whether the PLC is in run mode, effective at the last `now_ns`.

        A module initially assumes that the PLC is running. Program, test and single-scan mode all count as
        not running, since outputs are not sent to the module.
        """

    def power_cycle(self) -> None:
        """Remove and restore power at the last `now_ns`. Volatile data is lost; time continues."""


@runtime_checkable
class ForeseeingModule(Module, Protocol):
    """A module that can compute its upcoming inputs in advance; see `runtime.loop.ahead`.

    The predicted inputs equal those from `update` bit for bit.

    Attributes:
        before_change: function that the module calls before anything except `update` changes the module, such
            as the PLC's mode or the machine's inputs, or reads its values. The call brings the module up to
            date.
    """

    before_change: Callable[[], None]

    def calm_until_ns(self, outputs: Image) -> int:
        """Return the instant before which the module has no event.

        Args:
            outputs: the output image, which stays in effect.

        Returns:
            The instant, ns; if it is unknown, an instant not later than the last `update`.
        """

    def foretell(self, first_ns: int, every_ns: int, count: int) -> Words:
        """Return the input words that change, at `count` instants spaced `every_ns` apart.

        Args:
            first_ns: the first instant, later than the last `update`.
            count: 1 or more; all instants are before `calm_until_ns`.
        """


def foreseeing(module: Module) -> ForeseeingModule | None:
    """Return the module if it can compute its upcoming inputs, otherwise None; faster than `isinstance`."""
    is_foreseeing = all(hasattr(module, name) for name in ("before_change", "calm_until_ns", "foretell"))
    return module if is_foreseeing else None  # type: ignore[return-value]


def unnoticed() -> None:
    """Do nothing; the default `before_change`, for a module whose inputs are not predicted."""


@runtime_checkable
class Follower(Module, Protocol):
    """A module whose inputs depend on the modules in other slots at the same instant."""

    @property
    def follows(self) -> frozenset[int]:
        """The slots that every exchange advances before this one; their modules do not follow others."""

    def join(self, modules: Mapping[int, Module]) -> None:
        """Connect to the rack's modules, by slot number, before the first `update`.

        Raises:
            ValueError: a slot is empty, or its module can't be followed.
        """


def following(module: Module) -> Follower | None:
    """Return the module if it follows others, otherwise None; faster than `isinstance`."""
    return module if hasattr(module, "follows") and hasattr(module, "join") else None  # type: ignore[return-value]
