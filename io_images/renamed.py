"""Public names that were renamed: the old one works for one release, with a DeprecationWarning.

Renamed in 0.3; remove in 0.4.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping
from typing import Any

RENAMED: Mapping[str, str] = {
    "scanrack.Job": "LoadedRack",
    "scanrack.Moment": "Snapshot",
    "scanrack.maximize": "maximize",
    "scanrack.jobs.bench.bench.Bench.told": "events",
    "scanrack.jobs.bench.bench.Bench.what_would": "suggest_inputs",
    "scanrack.jobs.bench.slot.SlotBench.fail": "inject",
    "scanrack.jobs.check.Judgment": "ProofFinding",
    "scanrack.jobs.fuzz.Moment": "Snapshot",
    "scanrack.jobs.fuzz.SlotMoment": "SlotSnapshot",
    "scanrack.jobs.fuzz.UnsteadyError": "NondeterministicError",
    "scanrack.jobs.fuzz.maximize": "maximize",
    "scanrack.runtime.line.clients.link.BadAnswerError": "BadResponseError",
    "scanrack.runtime.line.clients.link.UncertainError": "UnconfirmedMotionError",
    "scanrack.runtime.line.clients.probing.FoundController": "FoundDevice",
    "scanrack.runtime.line.clients.watching.LostSightError": "MonitoringLostError",
    "scanrack.traces.replay.Recording": "PackedTrace",
}
"""The new name by the path of the old one: of a module, or of a class in a module."""


def renamed(module: str, name: str) -> object:
    """Return what an old name of a module means now: the module's `__getattr__`.

    Raises:
        AttributeError: the module has no such name, and had none.
    """
    new = RENAMED.get(f"{module}.{name}")
    if new is None:
        raise AttributeError(f"module {module!r} has no attribute {name!r}")
    _warn(name, new, frames=2)  # this function and `__getattr__`
    return getattr(sys.modules[module], new)


class OldName:
    """An attribute of a class under its old name; a row of `RENAMED` says the new one."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._old, self._new = name, RENAMED[f"{owner.__module__}.{owner.__name__}.{name}"]

    def __get__(self, instance: object, owner: type) -> Any:
        if instance is None:
            return self
        _warn(self._old, self._new, frames=1)
        return getattr(instance, self._new)


def _warn(old: str, new: str, frames: int) -> None:
    warnings.warn(f"{old} is now {new}", DeprecationWarning, stacklevel=2 + frames)
