"""Standard invariants for almost every program, by their names on the command line."""

from __future__ import annotations

from dataclasses import replace

from .busy import RestMeter
from .invariants import FOREVER_NS, Invariant, always, never
from .scan_view import Snapshot


def _any_slot(now: Snapshot, bit: str) -> bool:
    return any(getattr(slot.status, bit) for slot in now.slot.values())


@never
def command_error(now: Snapshot) -> bool:
    """No command of the program is refused: COMMAND_ERROR is never set."""
    return _any_slot(now, "COMMAND_ERROR")


@never
def invalid_profile(now: Snapshot) -> bool:
    """No move of the program has a profile the module refuses: INVALID_PROFILE is never set."""
    return _any_slot(now, "INVALID_PROFILE")


@never
def home_invalid(now: Snapshot) -> bool:
    """No homing of the program is refused: HOME_INVALID is never set."""
    return _any_slot(now, "HOME_INVALID")


@always
def one_motion(now: Snapshot) -> bool:
    """Never two motion commands at once."""
    return all(slot.motions <= 1 for slot in now.slot.values())


class _CommandsEnd:
    """Watches a run for a command whose axis rests for too long."""

    def __init__(self) -> None:
        self._meter: RestMeter | None = None

    def __call__(self, now: Snapshot) -> str | None:
        if self._meter is None or now.resting:  # the axes restart when the PLC runs again
            self._meter = RestMeter(now.axes)
        return self._meter.update(now.ns, linked=all(slot.linked for slot in now.slot.values()))

    def same_until_ns(self, _counting: bool) -> int:
        """See `Watch`."""
        return FOREVER_NS if self._meter is None else self._meter.same_until_ns


commands_end = Invariant(
    "commands_end", "No command is busy while its axis rests for a second and the link is good", _CommandsEnd
)


STANDARD: dict[str, Invariant] = {
    name: replace(invariant, name=name)
    for name, invariant in (
        ("no-command-error", command_error),
        ("no-invalid-profile", invalid_profile),
        ("no-home-invalid", home_invalid),
        ("one-motion", one_motion),
        ("commands-end", commands_end),
    )
}
"""The standard invariants by name. A CPU fault by the program is always a failure."""
