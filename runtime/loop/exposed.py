"""Modules with injected faults, such as loss of power or link, and torn updates."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

from scanrack.io_images.image import Image
from typing_extensions import override

from .events import Event, JsonValue
from .exchange import RPI_NS
from .incidents import LASTING, ON_THE_LINE, TROUBLES, FaultKind, InjectedFault
from .module import Module, foreseeing, unnoticed
from .module_fault import ModuleFault

if TYPE_CHECKING:
    from .module import Words

WORST_FIRST = (FaultKind.REMOVED, FaultKind.FATAL_ERROR, FaultKind.ASIC_LOST, FaultKind.LINK_LOST)
"""Order of precedence of faults. A module that has several faults shows the first one."""

_BEGUN = {
    FaultKind.POWER_CYCLE: "The module's power goes and comes back.",
    FaultKind.LINK_LOST: "The link to the module is lost.",
    FaultKind.REMOVED: "The module is taken out.",
    FaultKind.FATAL_ERROR: "The module fails.",
    FaultKind.ASIC_LOST: "The module's backplane interface fails.",
}
_BEGUN_ON_THE_LINE = {
    FaultKind.LINE_DOWN: "The line to the controller is open.",
    FaultKind.REPLIES_LOST: "A reply of the controller is lost.",
    FaultKind.REPLIES_DAMAGED: "A reply of the controller is damaged.",
    FaultKind.CONTROLLER_POWER_CYCLE: "The controller's power goes and comes back.",
}
_OVER = "The module answers again."
_OVER_ON_THE_LINE = "The line is as it should be."


@runtime_checkable
class ModuleWithFaults(Module, Protocol):
    """A module that can simulate faults."""

    def inject(self, trouble: ModuleFault | None) -> None:
        """Put the module into a fault state; None ends it."""


@runtime_checkable
class OnALine(Module, Protocol):
    """A module whose controller is on a serial line or network."""

    def disturb(self, fault: FaultKind, *, begins: bool, lasts: bool) -> None:
        """Begin or end a line fault; a fault that does not last affects one reply."""


class Conditions(Protocol):
    """A module's environment, set by texts such as "temperature=95"."""

    def check(self, state: str) -> None:
        """Raise a ValueError for a state that the module can't have."""

    def put(self, state: str) -> None:
        """Put the module into a state at its last `update`; raise ValueError as in `check`."""


class _Act(NamedTuple):
    """The beginning or the end of a fault."""

    at_ns: int
    fault: InjectedFault
    begins: bool


class ExposedModule(Module):
    """A wrapper around a module that injects scheduled faults.

    Args:
        conditions: the environment of the module; None if it can't be set.

    Raises:
        ValueError: the module can't simulate a scheduled fault, or can't have a condition.
    """

    def __init__(
        self, module: Module, incidents: Iterable[InjectedFault], conditions: Conditions | None = None
    ) -> None:
        self.module, self._conditions = module, conditions
        self._foreseeing = foreseeing(module)
        self.events = module.events
        ordered = sorted(incidents, key=lambda fault: fault.at_ns)
        for fault in ordered:
            self._check(fault)
        self._tears = [fault for fault in ordered if fault.what is FaultKind.TORN_UPDATE]
        lasting = [fault for fault in ordered if fault.what is not FaultKind.TORN_UPDATE]
        self._acts = _by_time(act for fault in lasting for act in _acts(fault))
        self._faults: set[FaultKind] = set()  # the present faults
        self._shown: FaultKind | None = None  # the worst of them, which the module shows
        self._now_ns = 0
        self._latest_outputs = Image()
        self._late_ns = 0  # when the late words of a torn update arrive
        self._torn_outputs = Image()  # the outputs until then

    def happen(self, incident: InjectedFault) -> None:
        """Add a fault that begins at the last `update` or later.

        Raises:
            ValueError: the module does not support the fault.
        """
        self._check(incident)
        self.before_change()
        if incident.what is FaultKind.TORN_UPDATE:
            self._tears = sorted([*self._tears, incident], key=lambda fault: fault.at_ns)
        else:
            self._acts = _by_time([*self._acts, *_acts(incident)])

    def _check(self, incident: InjectedFault) -> None:
        """Raise a ValueError for a fault or a condition that the module can't simulate."""
        kind, conditions = incident.what, self._conditions
        if kind is FaultKind.CONDITION and conditions is not None:
            conditions.check(incident.state)
        elif kind is FaultKind.CONDITION or not _can_happen(kind, self.module):
            hint = "; set its conditions, such as cable=lost" if conditions is not None else ""
            module = type(self.module).__name__
            raise ValueError(f"injected fault {kind.value} does not apply to {module}{hint}")

    @property
    def under_way(self) -> str | None:
        """The kind of the motion in progress, or None."""
        kind: str | None = getattr(self.module, "under_way", None)
        return kind

    @property
    def linked(self) -> bool:
        """Whether the PLC can reach the module."""
        return getattr(self.module, "linked", True)

    @property
    def follows(self) -> frozenset[int]:
        """The slots that must be advanced before this one."""
        return getattr(self.module, "follows", frozenset())

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        """Advance the module to `now_ns`, through the beginnings and ends of faults; return its inputs."""
        self._tear(outputs)
        while self._acts and self._acts[0].at_ns <= now_ns:
            act = self._acts.pop(0)
            self._advance(act.at_ns, outputs)
            self._carry_out(act)
        return self._advance(now_ns, outputs)

    @property
    def before_change(self) -> Callable[[], None]:
        """See `ForeseeingModule`."""
        return unnoticed if self._foreseeing is None else self._foreseeing.before_change

    @before_change.setter
    def before_change(self, notice: Callable[[], None]) -> None:
        if self._foreseeing is not None:
            self._foreseeing.before_change = notice

    def calm_until_ns(self, outputs: Image) -> int:
        """See `ForeseeingModule`; an injected fault counts as an event."""
        module = self._foreseeing
        if module is None or self._now_ns < self._late_ns or outputs != self._latest_outputs:
            return 0
        calm_ns = module.calm_until_ns(outputs)
        return min(calm_ns, self._acts[0].at_ns) if self._acts else calm_ns

    def foretell(self, first_ns: int, every_ns: int, count: int) -> Words:
        """See `ForeseeingModule`."""
        assert self._foreseeing is not None, "called only before the instant of `calm_until_ns`"
        return self._foreseeing.foretell(first_ns, every_ns, count)

    @override
    def plc_run(self, running: bool) -> None:
        self.module.plc_run(running)

    @override
    def power_cycle(self) -> None:
        self.module.power_cycle()

    def _tear(self, outputs: Image) -> None:
        """Begin a due torn update when the outputs change: keep the earlier values of its late words."""
        if outputs == self._latest_outputs:
            return
        if len(outputs) != len(self._latest_outputs):
            self._latest_outputs, self._torn_outputs = Image(size=len(outputs)), Image(size=len(outputs))
            if outputs == self._latest_outputs:
                return
        if self._tears and self._tears[0].at_ns <= self._now_ns:
            tear = self._tears.pop(0)
            self._torn_outputs.load(outputs)
            for index in tear.late_words:
                self._torn_outputs[index] = self._latest_outputs[index]
            self._late_ns = self._now_ns + (tear.for_ns or RPI_NS)
            fields: dict[str, JsonValue] = {"late_words": list(tear.late_words)}
            late_words = ", ".join(map(str, tear.late_words))
            text = f"Output words {late_words} come one update late."
            self.events.append(Event(self._now_ns, "stimulus", tear.what.value, text, fields))
        self._latest_outputs.load(outputs)

    def _advance(self, now_ns: int, outputs: Image) -> Image:
        """Advance the module; until the late words of a torn update arrive, it receives the torn outputs."""
        if self._now_ns < self._late_ns < now_ns:
            self.module.update(self._late_ns, self._torn_outputs)
            self._now_ns = self._late_ns
        is_torn = self._now_ns < self._late_ns
        self._now_ns = now_ns
        return self.module.update(now_ns, self._torn_outputs if is_torn else outputs)

    def _carry_out(self, act: _Act) -> None:
        """Begin or end a fault, and add its event."""
        kind, begins, state = act.fault.what, act.begins, act.fault.state
        if isinstance(self.module, OnALine) and kind in ON_THE_LINE:
            self.module.disturb(kind, begins=begins, lasts=bool(act.fault.for_ns))
        elif self._conditions is not None and kind is FaultKind.CONDITION:
            self._conditions.put(state)
        else:
            self._change_faults(kind, begins=begins)
        self.events.append(fault_event(act.at_ns, kind, begins=begins, state=state))

    def _change_faults(self, kind: FaultKind, *, begins: bool) -> None:
        """Add or remove an active fault, and show the worst one; a power cycle resets a fatal error."""
        if kind is FaultKind.POWER_CYCLE:
            self._faults.discard(FaultKind.FATAL_ERROR)
            self.module.power_cycle()
            self._shown = None
        elif begins:
            self._faults.add(kind)
        else:
            self._faults.discard(kind)
        self._show_worst_fault()

    def _show_worst_fault(self) -> None:
        """Put the module into its worst active fault, or end its faults.

        A fatal error ends with a power cycle of the module.
        """
        worst = next((kind for kind in WORST_FIRST if kind in self._faults), None)
        if worst is self._shown or not isinstance(self.module, ModuleWithFaults):
            return
        if worst is FaultKind.REMOVED:
            self._faults.discard(FaultKind.FATAL_ERROR)  # loss of power resets it
        elif self._shown is FaultKind.FATAL_ERROR:
            self.module.power_cycle()
        # the power cycle above has already ended a fatal error
        if worst is not None or self._shown is not FaultKind.FATAL_ERROR:
            self.module.inject(TROUBLES[worst] if worst else None)
        self._shown = worst


def _can_happen(kind: FaultKind, module: Module) -> bool:
    """Return whether a module can simulate a kind of fault other than a condition."""
    if kind in ON_THE_LINE:
        return isinstance(module, OnALine)
    return kind not in TROUBLES or isinstance(module, ModuleWithFaults)


def _acts(fault: InjectedFault) -> Iterable[_Act]:
    """Yield the beginning of a fault, and its end if it has a duration."""
    yield _Act(fault.at_ns, fault, begins=True)
    if fault.for_ns and fault.what in LASTING:
        yield _Act(fault.at_ns + fault.for_ns, fault, begins=False)


def _by_time(acts: Iterable[_Act]) -> list[_Act]:
    return sorted(acts, key=lambda act: act.at_ns)


def fault_event(at_ns: int, kind: FaultKind, *, begins: bool, state: str = "") -> Event:
    """Return the event for a fault that begins or ends."""
    if kind is FaultKind.CONDITION:
        text = f"Around the module: {state}."
        return Event(at_ns, "stimulus", kind.value, text, {"begins": begins, "state": state})
    if kind in ON_THE_LINE:
        text = _BEGUN_ON_THE_LINE[kind] if begins else _OVER_ON_THE_LINE
    else:
        text = _BEGUN[kind] if begins else _OVER
    return Event(at_ns, "stimulus", kind.value, text, {"begins": begins})
