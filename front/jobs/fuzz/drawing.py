"""Random scenarios, drawn by Hypothesis; `shrink` reduces those that break an invariant."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from enum import Enum
from typing import Any, TypeVar

from hypothesis import strategies as st

from ...io_images.amci3601.bits import InputBit
from ...io_images.amci3601.firmware import KNOWN, Firmware
from ...io_images.image import WORDS
from ...runtime.config.rackspec import RackSpec, SlotSpec
from ...runtime.loop.incidents import FaultKind, Incident
from ...runtime.modules.record import Trait
from ...runtime.modules.registry import MODULES, has
from .scenarios.scenario import LostSteps, Press, Push, Scenario, Shift, Signal

T = TypeVar("T")
Timed = TypeVar("Timed", Press, Push, Signal, Incident)
"""A part of a scenario with an instant."""


class Kind(Enum):
    """A kind of random event."""

    INPUTS = "inputs"
    """Buttons are pressed, sensors stick or break."""
    MACHINE = "machine"
    """Switches are displaced, steps are lost."""
    LINK = "link"
    """Modules stop answering for a time."""
    POWER = "power"
    """Modules lose power for a moment."""
    MODE = "mode"
    """The CPU's key is turned to program and back."""
    TORN = "torn"
    """An update falls into the middle of a scan, and some words come late."""
    FIRMWARE = "firmware"
    """Modules are of another version."""
    LINE = "line"
    """The line between an adapter and its controller fails, or the controller's power does."""


def possible_kinds(spec: RackSpec) -> frozenset[Kind]:
    """Return the kinds that are possible in a rack: some need a 3601, some an adapter."""
    with_trait = frozenset(kind for kind in Kind if kind not in _NEEDS or _with(spec, _NEEDS[kind]))
    return with_trait | {Kind.INPUTS} if card_buttons(spec) or card_signals(spec) else with_trait


def card_buttons(spec: RackSpec) -> list[tuple[int, str]]:
    """Return the contacts of cards that a person operates: slot and name."""
    return [
        (slot.number, name)
        for slot in spec.slot
        if slot.module in MODULES
        for name in MODULES[slot.module].buttons(slot.options)
    ]


def card_signals(spec: RackSpec) -> list[tuple[int, str, float]]:
    """Return test values of the cards' analog inputs: slot, name, value."""
    return [
        (slot.number, name, value)
        for slot in spec.slot
        if slot.module in MODULES
        for name, values in MODULES[slot.module].signals(slot.options).items()
        for value in values
    ]


_NEEDS = {
    Kind.INPUTS: Trait.MACHINE,
    Kind.MACHINE: Trait.MACHINE,
    Kind.LINK: Trait.STOPS_ANSWERING,
    Kind.FIRMWARE: Trait.FIRMWARE,
    Kind.LINE: Trait.LINE,
}
"""Kinds that need a module with a trait."""


def kinds_for(spec: RackSpec) -> frozenset[Kind]:
    """Return the likely kinds: torn updates only where exchanges do not wait for the scan's end."""
    torn = spec.controller == "compactlogix"
    return frozenset(kind for kind in possible_kinds(spec) if kind is not Kind.TORN or torn)


def _with(spec: RackSpec, trait: Trait) -> list[int]:
    """Return the slots whose modules have a trait."""
    return [slot.number for slot in spec.slot if has(slot.module, trait)]


LASTING_MS = (2, 20, 100, 500, 2000)

STEPS = (1, -1, 10, -10, 200, -200, 3000, -3000)
"""Displacements of a machine, steps."""


def scenarios(
    spec: RackSpec, scans: int, kinds: Collection[Kind], *, base: Scenario | None = None, most: int = 4
) -> st.SearchStrategy[Scenario]:
    """Return a strategy of scenarios for a rack.

    Args:
        scans: length of a run, with all events.
        kinds: random events, as far as they are possible.
        base: a scenario to vary: some of its parts are kept, others added.
    """
    kinds = possible_kinds(spec).intersection(kinds)
    times = st.integers(0, scans - 1).map(lambda scan: scan * spec.scan_ns)
    bolted = [slot for slot in spec.slot if has(slot.module, Trait.MACHINE)]
    slots = st.sampled_from(bolted or spec.slot)
    numbers = slots.map(lambda slot: slot.number)
    contacts = card_buttons(spec) if Kind.INPUTS in kinds else []
    values = card_signals(spec) if Kind.INPUTS in kinds else []
    nothing: st.SearchStrategy[tuple[()]] = st.just(())
    presses = {slot.number: _presses(slot, times) for slot in bolted}  # made once: a draw costs half

    def some(kind: Kind, part: st.SearchStrategy[object], limit: int = most) -> st.SearchStrategy[object]:
        return st.lists(part, max_size=limit).map(tuple) if kind in kinds else nothing

    happening = [_incidents(kind, spec, times) for kind in INCIDENTS if kind in kinds]
    made = st.builds(
        Scenario,
        firmware=_firmware(spec) if Kind.FIRMWARE in kinds else nothing,
        presses=some(Kind.INPUTS, slots.flatmap(lambda slot: presses[slot.number])) if bolted else nothing,
        incidents=st.lists(st.one_of(happening), max_size=most).map(tuple) if happening else nothing,
        shifts=some(Kind.MACHINE, st.builds(Shift, numbers, st.sampled_from(STEPS)), 1),
        lost=some(Kind.MACHINE, _lost(_with(spec, Trait.SLIPS)), 1) if _with(spec, Trait.SLIPS) else nothing,
        pushes=some(Kind.INPUTS, _operated(Push, contacts, times)) if contacts else nothing,
        signals=some(Kind.INPUTS, _operated(Signal, values, times)) if values else nothing,
    )
    return made if base is None else st.builds(_joined, _parts_of(base, spec.scan_ns), made)


INCIDENTS = (Kind.LINK, Kind.POWER, Kind.MODE, Kind.TORN, Kind.LINE)


def _lost(slots: Sequence[int]) -> st.SearchStrategy[LostSteps]:
    where = st.integers(-20_000, 20_000)
    return st.builds(LostSteps, st.sampled_from(slots), where, st.sampled_from((1, 5, 200)))


def _durations() -> st.SearchStrategy[int]:
    return st.sampled_from(LASTING_MS).map(lambda ms: ms * 1_000_000)


def _presses(slot: SlotSpec, times: st.SearchStrategy[int]) -> st.SearchStrategy[Press]:
    """Return presses of buttons; sensors fail either way."""
    pressed, wired = buttons(slot), sensors(slot)
    number, durations = st.just(slot.number), _durations()
    parts = []
    if pressed:  # releasing a button that is not pressed changes nothing
        parts.append(st.builds(Press, number, st.sampled_from(pressed), st.just(True), times, durations))
    if wired:
        either = st.booleans().map(lambda off: not off)  # the simplest draw is an energised input
        parts.append(st.builds(Press, number, st.sampled_from(wired), either, times, durations))
    return st.one_of(parts)


def _operated(
    part: Callable[..., Push | Signal], inputs: Sequence[tuple[Any, ...]], times: st.SearchStrategy[int]
) -> st.SearchStrategy[Push | Signal]:
    def made(given: tuple[Any, ...], at_ns: int, for_ns: int) -> Push | Signal:
        return part(*given, at_ns, for_ns)

    return st.builds(made, st.sampled_from(inputs), times, _durations())


def sensors(slot: SlotSpec) -> list[InputBit]:
    """Return the inputs that the machine energises."""
    fed = {bit for bit in InputBit if slot.machine.fed_inputs & bit.value}
    return sorted(fed | {each.input for each in slot.machine.timeline})


def buttons(slot: SlotSpec) -> list[InputBit]:
    """Return the inputs that only a person energises."""
    return [bit for bit in InputBit if bit not in sensors(slot)]


def _firmware(spec: RackSpec) -> st.SearchStrategy[tuple[tuple[int, str], ...]]:
    """Return another version for all modules, or their own; none older than the program needs."""
    behind_micrologix = spec.controller == "micrologix"
    needed = max(Firmware.parse(slot.needs_firmware) for slot in spec.slot)
    versions = [str(each) for each in KNOWN if each >= needed and (each.micrologix or not behind_micrologix)]
    same: st.SearchStrategy[tuple[tuple[int, str], ...]] = st.just(())
    return same | st.sampled_from(versions).map(
        lambda version: tuple((slot, version) for slot in _with(spec, Trait.FIRMWARE))
    )


def _incidents(kind: Kind, spec: RackSpec, times: st.SearchStrategy[int]) -> st.SearchStrategy[Incident]:
    slots = st.sampled_from([slot.number for slot in spec.slot])
    if kind is Kind.LINK:
        lost = st.sampled_from((FaultKind.LINK_LOST, FaultKind.REMOVED, FaultKind.FATAL_ERROR))
        return st.builds(
            Incident, times, lost, st.sampled_from(_with(spec, Trait.STOPS_ANSWERING)), _durations()
        )
    if kind is Kind.POWER:
        return st.builds(Incident, times, st.just(FaultKind.POWER_CYCLE), slots)
    if kind is Kind.MODE:
        return st.builds(Incident, times, st.just(FaultKind.PROGRAM_MODE), st.just(0), _durations())
    if kind is Kind.LINE:
        return _on_the_line(st.sampled_from(_with(spec, Trait.LINE)), times)
    late = st.sets(st.integers(0, WORDS - 1), min_size=1).map(lambda words: tuple(sorted(words)))
    return st.builds(Incident, times, st.just(FaultKind.TORN_UPDATE), slots, st.just(0), late)


def _on_the_line(slots: st.SearchStrategy[int], times: st.SearchStrategy[int]) -> st.SearchStrategy[Incident]:
    """Return a lost or damaged reply, several in a row, an open line, or a controller without power."""
    replies = st.sampled_from((FaultKind.REPLIES_LOST, FaultKind.REPLIES_DAMAGED))
    lasting = st.sampled_from((FaultKind.LINE_DOWN, FaultKind.REPLIES_LOST, FaultKind.REPLIES_DAMAGED))
    return st.one_of(
        st.builds(Incident, times, replies, slots),
        st.builds(Incident, times, lasting, slots, _durations()),
        st.builds(Incident, times, st.just(FaultKind.CONTROLLER_POWER_CYCLE), slots),
    )


MOVED = (0, 1, -1, 10, -10, 100, -100)
"""Displacements of an event from the varied scenario, scans."""


def _parts_of(base: Scenario, scan_ns: int) -> st.SearchStrategy[Scenario]:
    """Return another scenario unchanged, or some of its parts, at other times."""

    def kept(parts: Sequence[T]) -> st.SearchStrategy[tuple[T, ...]]:
        flags = st.tuples(*[st.booleans()] * len(parts))
        return flags.map(lambda wanted: tuple(part for part, keep in zip(parts, wanted, strict=True) if keep))

    def moved(parts: Sequence[Timed]) -> st.SearchStrategy[tuple[Timed, ...]]:
        return kept(parts).flatmap(lambda some: st.tuples(*(_moved(part, scan_ns) for part in some)))

    varied = st.builds(
        Scenario,
        st.just(base.firmware),
        moved(base.presses),
        moved(base.incidents),
        kept(base.shifts),
        kept(base.lost),
        moved(base.pushes),
        moved(base.signals),
    )
    return varied | st.just(base)


def _moved(part: Timed, scan_ns: int) -> st.SearchStrategy[Timed]:
    return st.sampled_from(MOVED).map(lambda scans: replace(part, at_ns=max(0, part.at_ns + scans * scan_ns)))


def _joined(a: Scenario, b: Scenario) -> Scenario:
    return Scenario(
        b.firmware or a.firmware,
        (*a.presses, *b.presses),
        (*a.incidents, *b.incidents),
        a.shifts or b.shifts,
        (*a.lost, *b.lost),
        (*a.pushes, *b.pushes),
        (*a.signals, *b.signals),
    )
