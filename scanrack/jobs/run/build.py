"""Builds the CPU that repeats a recording, and checks the use of real ports."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from scanrack.io_images.times import exact_ns
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.exchange import EveryRpi, RecordedAtRpi
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.pace import Watchdog
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic

from ..load.building import exchange_of

if TYPE_CHECKING:  # a run does not repeat recordings
    from .playback import Playback, ReplayPlan


def build_playback(
    spec: RackSpec,
    plan: ReplayPlan,
    logic: ScanLogic,
    rack: Rack,
    *,
    listeners: Iterable[ScanListener],
    watchdog: Watchdog | None = None,
) -> Playback:
    """Create a CPU that repeats the scans of a recording with `logic` on `rack`.

    Modes and forces come from the recording instead of `spec`. Recorded inputs are read in each scan, so a
    rack of `RecordedInputs` does not exchange images itself. By default, `watchdog` comes from `spec`.
    """
    from .playback import Playback, RecordedInputs

    has_recorded_inputs = any(isinstance(slot.module, RecordedInputs) for slot in rack.slots.values())
    return Playback(
        plan,
        rack,
        logic,
        spec.scan_ns,
        exchange=exchange_of(spec, RecordedAtRpi if has_recorded_inputs else EveryRpi),
        listeners=listeners,
        watchdog=watchdog or Watchdog(exact_ns(spec.watchdog_ms, "ms")),
    )


NO_SAFETY_SYSTEM = (
    "this is not a safety system: the controller has no watchdog, and if scanrack dies in a manual move, "
    "the axis continues until a limit stops it; wire end limits and emergency stop so that they act "
    "without software"
)


def check_ports(spec: RackSpec, *, realtime: bool, live: bool) -> None:
    """Raise ValueError for a real port in virtual time or without --live."""
    for slot in spec.slot:
        if slot.is_live and not realtime:
            raise ValueError(
                f"slot {slot.number}: port {slot.port} is real, and a real controller does not "
                "wait for virtual time: give --realtime"
            )
        if slot.is_live and not live:
            raise ValueError(
                f"slot {slot.number}: port {slot.port} moves a real motor; {NO_SAFETY_SYSTEM}. "
                "Then give --live"
            )
