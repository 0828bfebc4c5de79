"""Builds a rack and its CPU from a specification."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import ExitStack, closing

from scanrack.io_images.times import exact_ns
from scanrack.runtime.config.rackspec import RackSpec, SlotSpec
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.exchange import EndOfScan, EveryRpi, Exchange
from scanrack.runtime.loop.exposed import ExposedModule
from scanrack.runtime.loop.incidents import FaultKind
from scanrack.runtime.loop.key_switch import KeySwitch
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.module import Module, following
from scanrack.runtime.loop.pace import Pacer, Watchdog
from scanrack.runtime.loop.rack import Card, Rack
from scanrack.runtime.loop.scan import CpuMode, ScanLogic


def build_rack(
    spec: RackSpec,
    ports: ExitStack | None = None,
    *,
    handled: bool = False,
    around: Callable[[int, Module], Module] | None = None,
) -> Rack:
    """Build a new rack with new modules.

    The random numbers of slot n are seeded with the rack's seed and n, so that slots differ.

    Args:
        ports: stack that closes the real ports opened here; None = real ports are not allowed.
        handled: whether faults may be injected into any module while the rack runs, see `ExposedModule`.
        around: returns a replacement, such as a wrapper, for the module of a slot.

    Raises:
        ValueError: a real port is not allowed or can't be opened.
    """
    modules = {slot.number: _new_module(slot, slot_seed(spec.seed, slot.number), ports) for slot in spec.slot}
    for module in modules.values():  # after all are made, because a follower needs another slot's module
        if (follower := following(module)) is not None:
            follower.join(modules)
    if around is not None:
        modules = {number: around(number, module) for number, module in modules.items()}
    return Rack(
        Card(
            slot.number,
            _exposed_module(spec, slot, modules[slot.number], handled=handled and not slot.is_live),
            catalog=slot.module,
            firmware=slot.recorded_firmware,
            words=slot.words,
            round_trip_ms=round_trip_ms(spec, slot),
        )
        for slot in spec.slot
    )


def round_trip_ms(spec: RackSpec, slot: SlotSpec) -> int:
    """Return the time for a command to a slot and its response, ms, including networks beyond the module.

    A CompactLogix exchanges images at its own interval, so a command waits for one exchange and its response
    waits for the next.
    """
    own_ms = slot.record.round_trip_ms
    if spec.controller != "compactlogix":
        return own_ms
    return own_ms + -(-(2 * spec.rpi_ns + spec.scan_ns) // 1_000_000)


def _exposed_module(spec: RackSpec, slot: SlotSpec, module: Module, *, handled: bool) -> Module:
    """Return a slot's module, exposed to injected faults of the rack file and of operators."""
    incidents = [incident for incident in spec.incidents if incident.slot == slot.number]
    for incident in incidents:
        incident.check_late_words(len(slot.words.outputs))
    if not (incidents or handled):
        return module
    conditions = slot.record.conditions
    return ExposedModule(module, incidents, None if conditions is None else conditions(module))


def _new_module(slot: SlotSpec, seed: int, ports: ExitStack | None) -> Module:
    """Return the module of a slot.

    A live slot opens its real port, or raises ValueError without `ports`.
    """
    if not slot.is_live:
        return slot.make(seed)
    if ports is None:
        raise ValueError(
            f"slot {slot.number}: port {slot.port} is real, and needs real time: "
            "only scanrack run --realtime --live drives it"
        )
    return ports.enter_context(closing(slot.open()))


def build_cpu(
    spec: RackSpec,
    logic: ScanLogic,
    rack: Rack,
    *,
    listeners: Iterable[ScanListener] = (),
    pacer: Pacer | None = None,
    watchdog: Watchdog | None = None,
) -> Cpu:
    """Create the CPU of a specification with its logic, rack and forces."""
    cpu = Cpu(
        rack,
        logic,
        spec.scan_ns,
        exchange=exchange_of(spec),
        mode=CpuMode[spec.mode.upper()],
        listeners=listeners,
        pacer=pacer,
        watchdog=watchdog or Watchdog(exact_ns(spec.watchdog_ms, "ms")),
    )
    for force in spec.force:
        cpu.forces.set(force.address, force.value)
    turns = [incident for incident in spec.incidents if incident.what is FaultKind.PROGRAM_MODE]
    if turns:
        cpu.add_listener(KeySwitch(cpu, turns))
    return cpu


def slot_seed(seed: int, number: int) -> int:
    """Return the seed of a slot; slot 1 has the seed of the rack.

    >>> slot_seed(7, 1), slot_seed(7, 2)
    (7, 4294967303)
    """
    return seed + ((number - 1) << 32)


def exchange_of(spec: RackSpec, at_rpi: Callable[[int], Exchange] = EveryRpi) -> Exchange:
    """Return the timing of image exchanges: at the end of each scan, or every RPI."""
    return at_rpi(spec.rpi_ns) if spec.controller == "compactlogix" else EndOfScan()
