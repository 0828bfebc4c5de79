"""Injected faults of a module or the controller, such as a power loss, a lost link or a torn update.

    scan               n          n+1         n+2
    outputs written    A          B           B
    torn update of B:  A          B A A ...   B        (words 1 and 2 of B arrive one update late)

Each fault is data that includes its instant. The rack is built with the faults in its specification, so a run
with faults is as repeatable as a run without them.
"""

from __future__ import annotations

from enum import Enum

from pydantic import ConfigDict, StrictInt
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import WORDS_MAX
from scanrack.io_images.site import SettingError

from .module_fault import ModuleFault


class FaultKind(Enum):
    """The kind of an injected fault."""

    POWER_CYCLE = "power-cycle"
    """The module loses power and regains it immediately."""
    LINK_LOST = "link-lost"
    """See `runtime.loop.module_fault`."""
    REMOVED = "removed"
    """See `runtime.loop.module_fault`."""
    FATAL_ERROR = "fatal-error"
    """See `runtime.loop.module_fault`; a power cycle ends it."""
    ASIC_LOST = "asic-lost"
    """See `runtime.loop.module_fault`."""
    TORN_UPDATE = "torn-update"
    """The next change of the outputs arrives in two updates; some words arrive one update late."""
    PROGRAM_MODE = "program-mode"
    """The controller's key is turned to program, and later back to run."""
    LINE_DOWN = "line-down"
    """The line between an adapter and its controller is open, so nothing arrives in either direction."""
    REPLIES_LOST = "replies-lost"
    """Replies from an adapter's controller are lost, although it has carried out the requests."""
    REPLIES_DAMAGED = "replies-damaged"
    """Replies from an adapter's controller arrive with one bit flipped."""
    CONTROLLER_POWER_CYCLE = "controller-power-cycle"
    """An adapter's controller loses power and regains it immediately; the adapter keeps its power."""
    CONDITION = "condition"
    """The environment of a networked drive changes, such as an input or a temperature; see `state`."""


TROUBLES = {
    FaultKind.LINK_LOST: ModuleFault.LINK_LOST,
    FaultKind.REMOVED: ModuleFault.REMOVED,
    FaultKind.FATAL_ERROR: ModuleFault.FATAL_ERROR,
    FaultKind.ASIC_LOST: ModuleFault.ASIC_LOST,
}
"""Lasting module faults, as `ModuleFault` values."""

ON_THE_LINE = frozenset(
    {
        FaultKind.LINE_DOWN,
        FaultKind.REPLIES_LOST,
        FaultKind.REPLIES_DAMAGED,
        FaultKind.CONTROLLER_POWER_CYCLE,
    }
)
"""Faults between an adapter and its controller."""

LASTING = TROUBLES.keys() | ON_THE_LINE - {FaultKind.CONTROLLER_POWER_CYCLE}
"""Module faults that can have a duration."""


@dataclass(frozen=True, slots=True)
class InjectedFault:
    """One injected fault.

    Attributes:
        at_ns: start, ns since power-up.
        slot: slot of the module; 0 for `PROGRAM_MODE`.
        for_ns: duration; 0 = unlimited, or until a power cycle for a fatal error. For a torn update it is the
            delay of the late words, where 0 = one RPI. For lost or damaged replies, 0 = only the next reply.
        late_words: indexes of the output words that arrive late in a torn update.
        state: the new state of a condition, such as "temperature=95"; see the module's record.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")

    at_ns: StrictInt
    what: FaultKind
    slot: StrictInt = 1
    for_ns: StrictInt = 0
    late_words: tuple[StrictInt, ...] = ()
    state: str = ""

    def __post_init__(self) -> None:
        for field, value in (("at_ns", self.at_ns), ("for_ns", self.for_ns)):
            if value < 0:
                raise SettingError(field, f"{field} of {value} is not allowed: 0 or more")
        self.check_late_words(WORDS_MAX)
        if bool(self.late_words) is not (self.what is FaultKind.TORN_UPDATE):
            raise SettingError(
                "late_words", "late_words and torn-update go together: name the words that arrive late"
            )
        if bool(self.state) is not (self.what is FaultKind.CONDITION):
            raise SettingError("state", "state and condition go together: name the state that begins")
        if self.state and self.for_ns:
            raise SettingError("for_ms", "a condition has no duration; set it back with another entry")

    def check_late_words(self, outputs: int) -> None:
        """Raise a ValueError for late words that a module with `outputs` output words does not have."""
        if not set(self.late_words) <= set(range(outputs)):
            raise SettingError(
                "late_words", f"late_words {list(self.late_words)} are not allowed: 0 to {outputs - 1}"
            )
