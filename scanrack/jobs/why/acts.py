"""Finds acts by a user that change a value, by trying them on copies of the rack.

    the rack at the scan | copy 1: no action
                         | copy 2: press start for 60 ms, then 5 s
                         | copy 3: close stop, then press start ...

A copy is a fork of the process, which continues with rack, machine and program. Single acts are tried before
pairs, so that every result is minimal. Every reported result has been tried.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import permutations
from typing import Any, Protocol

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import parse_duration, seconds
from scanrack.ladder.debug import CauseLink
from scanrack.ladder.debug.watched import shown
from scanrack.runtime.config.rackspec import SlotSpec
from scanrack.runtime.live import actions
from scanrack.runtime.live.operator_actions import OperatorActions
from scanrack.runtime.machine.spec import INPUT_NAMES
from scanrack.runtime.modules.record import Trait

from .copies import can_copy, in_copy

PRESS = "60 ms"
BETWEEN = "100 ms"
WITHIN_NS = 5_000_000_000
"""Time that a copy runs after the last act, ns."""

READ_EVERY = "20 ms"
"""Time between two readings of the value on a copy."""

MOST_TRIES = 60
"""Maximum number of copies."""

MOST_ACTS = 2

_TERMINAL = re.compile(r"slot (\d+) input (?:\d+ \((\w+)\)|IN_(\w+))")
"""A terminal in the text of a link: `slot 1 input 3 (START)`, or `slot 1 input IN_HOME` of a stepper."""
_SLOT = re.compile(r"slot (\d+): ")
"""The module in the text of an injected fault's link: `slot 1: the link to it is lost`."""


class Rack(Protocol):
    """The bench methods that acts use."""

    spec: Any
    slot: Any
    events: Any

    def __getitem__(self, tag: str) -> Any: ...
    def __setitem__(self, tag: str, value: object) -> None: ...

    @property
    def now_ns(self) -> int:
        """The time of the bench, ns."""

    def run_for(self, time: str) -> None:
        """Run the bench for a time."""

    def unforce(self, address: str) -> None:
        """Release a force."""

    def run_mode(self) -> None:
        """Turn the key to run."""


@dataclass(frozen=True, slots=True)
class Act:
    """An action that a user can take."""

    text: str  # press start for 60 ms
    target: str  # the object it acts on: two acts on one object are never tried together
    do: Callable[[Any], object]  # does the act on a bench
    is_press: bool = False  # whether it presses a button
    orders: tuple[actions.Action | int, ...] = ()  # operator actions, and waits in ns; may be empty


@dataclass(frozen=True, slots=True)
class Acts:
    """A result of the search: acts after which the tag gets the requested value."""

    tag: str
    requested: object
    acts: tuple[Act, ...] | None  # in order; empty: the value changes by itself; None: nothing was found
    after_ns: int  # from the first act until the tag has the value
    stimulus: str  # the first stimulus of the machine or the rack file meanwhile; "" without one
    tries: int

    def __str__(self) -> str:
        """Return the result as a sentence."""
        goal = f"{self.tag} {_goal_text(self.requested)}"
        if self.acts is None:
            tries = "1 try" if self.tries == 1 else f"{self.tries} tries"
            return f"{goal}: found no operator action in {tries}"
        after = f"{seconds(self.after_ns)} s"
        if self.acts:
            return f"{goal} {after} after this: {', then '.join(act.text for act in self.acts)}"
        if self.stimulus:
            return f"{goal} in {after}, as the rack file continues: {self.stimulus}"
        return f"{goal} by itself: wait {after}"

    def orders(self) -> list[dict[str, Any]] | None:
        """Return the acts as messages of a session and waits (`wait_ns`); None if an act has no message."""
        steps: list[actions.Action | int] = []
        for act in self.acts or ():
            if not act.orders:
                return None
            steps += [*act.orders, parse_duration(BETWEEN)]
        return [{"wait_ns": step} if isinstance(step, int) else actions.message_of(step) for step in steps]

    def as_json(self) -> dict[str, object]:
        """Return the result as JSON values."""
        acts = None if self.acts is None else [act.text for act in self.acts]
        return {"acts": acts, "after_ns": self.after_ns, "tries": self.tries}


def acts_for(bench: Rack, link: CauseLink, tag: str, requested: object) -> Acts | None:
    """Return acts by a user that change a value; None on a system that can't fork a process.

    Args:
        bench: the bench, which does not change. It must not be recording, since a copy would also write to
            the recording.
        link: the chain of the current value; acts on its ends are tried first.
    """
    if not can_copy():
        return None
    return next(every_act(bench, link, tag, requested))


def every_act(bench: Rack, link: CauseLink, tag: str, requested: object) -> Iterator[Acts]:
    """Yield the minimal results; if there are none, one result without acts."""
    tries, minimal = 0, list[set[str]]()
    for chosen in _choices(_acts(bench, link)):
        texts = {act.text for act in chosen}
        if tries == MOST_TRIES or any(minimal_texts <= texts for minimal_texts in minimal):
            continue
        tries += 1
        outcome = _try_on_copy(bench, chosen, tag, requested)
        if outcome is not None:
            minimal.append(texts)
            after_ns, stimulus = outcome
            yield Acts(tag, requested, chosen, after_ns=after_ns, stimulus=stimulus, tries=tries)
    if not minimal:
        yield Acts(tag, requested, acts=None, after_ns=0, stimulus="", tries=tries)


def _choices(acts: Sequence[Act]) -> Iterator[tuple[Act, ...]]:
    """Yield an empty choice, single acts, and pairs on two objects; first pairs that end with a button."""

    def is_last_choice(chosen: tuple[Act, ...]) -> bool:
        *earlier, last = (act.is_press for act in chosen)
        return any(earlier) or not last

    yield ()
    for count in range(1, MOST_ACTS + 1):
        choices = permutations(acts, count)
        on_different_objects = [acts for acts in choices if len({act.target for act in acts}) == count]
        yield from sorted(on_different_objects, key=is_last_choice)


def _try_on_copy(bench: Rack, acts: Sequence[Act], tag: str, requested: object) -> tuple[int, str] | None:
    """Try acts on a copy; return the time until the tag has the value, ns, and the first stimulus."""
    reply = in_copy(lambda: _time_to_value(bench, acts, tag, requested))
    after, _, stimulus = reply.partition(" ")
    return (int(after), stimulus) if reply else None


def _time_to_value(bench: Rack, acts: Sequence[Act], tag: str, requested: object) -> str:
    """Carry out acts; return a text: time until a tag has the value (ns), a space, the first stimulus.

    Returns "" if the tag does not get the value in `WITHIN_NS`.
    """
    start_ns, old_events = bench.now_ns, len(bench.events)
    for act in acts:
        act.do(bench)
        bench.run_for(BETWEEN)
    limit = bench.now_ns + WITHIN_NS
    while bench[tag] != requested:
        if bench.now_ns >= limit:
            return ""
        bench.run_for(READ_EVERY)
    stimuli = [event.text for event in bench.events[old_events:] if event.kind == "stimulus"]
    return f"{bench.now_ns - start_ns} {stimuli[0] if stimuli else ''}"


# --- the acts


def _acts(bench: Rack, link: CauseLink) -> list[Act]:
    """Return the acts without duplicates, starting with acts on the ends of the chain."""
    acts: dict[str, Act] = {}
    for act in (*_acts_on_links(bench, link), *_acts_on_panels(bench)):
        acts.setdefault(act.text, act)
    return list(acts.values())


def _acts_on_links(bench: Rack, link: CauseLink) -> Iterator[Act]:
    """Yield the acts that could undo each cause in a chain, such as a force or an input."""
    for cause in link.walk():
        terminal = _TERMINAL.search(cause.text)
        slot = _SLOT.match(cause.text)
        if cause.kind == "force":
            yield _unforce_act(cause.name)
        elif cause.kind == "mode":
            turn = actions.Mode("run")
            yield Act("turn the key to run", "the key", lambda bench: bench.run_mode(), orders=(turn,))
        elif cause.kind in ("input", "operator") and terminal is not None:
            yield from _input_acts(bench, int(terminal[1]), (terminal[2] or terminal[3]).lower())
        elif cause.kind == "operator" and isinstance(cause.value, bool):
            yield _set_act(cause.name, not cause.value)
        elif cause.kind == "incident" and slot is not None:
            yield _restore_act(int(slot[1]))


def _unforce_act(name: str) -> Act:
    order = actions.Unforce(name)
    return Act(f"take the force off {name}", name, lambda bench: bench.unforce(name), orders=(order,))


def _restore_act(number: int) -> Act:
    text = f"restore the link to slot {number}"
    return Act(text, f"slot {number}", lambda bench: bench.slot[number].inject(None))


def _set_act(name: str, value: bool) -> Act:
    """Return an act that sets a tag."""

    def write(bench: Any) -> None:
        bench[name] = value

    return Act(f"set {name} to {shown(value)}", name, write, orders=(actions.Write(name, value),))


def _acts_on_panels(bench: Rack) -> Iterator[Act]:
    """Yield acts on the named inputs of cards, buttons and switches, and on the inputs of axes.

    Inputs of a 3601 that are off are in the chain, by name. A drive has a function for each input.
    """
    for slot in bench.spec.slot:
        for name in (slot.options or {}).get("inputs") or ():
            yield from _input_acts(bench, slot.number, str(name))
        if slot.has(Trait.MACHINE) and not slot.is_live:
            yield from _acts_on_machine(bench, slot)


def _acts_on_machine(bench: Rack, slot: SlotSpec) -> Iterator[Act]:
    """Yield acts on the inputs of an axis.

    These are all inputs of a drive, but only the inputs of a 3601 that are on.
    """
    energized = bench.slot[slot.number].energized
    for name in slot.record.machine_inputs(slot.options or {}):
        if name in energized or not is_stepper(slot.words):
            yield from _input_acts(bench, slot.number, name)


def _input_acts(bench: Rack, number: int, name: str) -> Iterator[Act]:
    """Yield acts on an input: open it if it is on, else press or close it.

    If the machine operates the input, yield nothing.
    """
    slot = next(slot_spec for slot_spec in bench.spec.slot if slot_spec.number == number)
    drive_terminal = ""
    if slot.has(Trait.MACHINE) and name in INPUT_NAMES:
        if slot.machine.fed_inputs & INPUT_NAMES[name].value:
            return
        drive_terminal = slot.record.machine_inputs(slot.options or {}).get(name, "")
        is_on = name in bench.slot[number].energized
    else:
        is_on = bool(bench[f"slot{number}.input.{name}"])
    terminal = f"{name} (slot {number}{f' {drive_terminal}' if drive_terminal else ''})"
    open_, close = (actions.Press(number, name, closed) for closed in (False, True))
    if is_on:
        yield _input_act(f"open {terminal}", terminal, open_)
        return
    press = _input_act(f"press {terminal} for {PRESS}", terminal, close, parse_duration(PRESS), open_)
    yield replace(press, is_press=True)
    yield _input_act(f"close {terminal}", terminal, close)


def _input_act(text: str, terminal: str, *orders: actions.Action | int) -> Act:
    """Return an act that applies operator actions to a bench, with waits between them in ns."""

    def do(bench: Any) -> None:
        operator_actions = OperatorActions(bench.cpu, bench.cpu.rack, tags=None)
        for order in orders:
            if isinstance(order, int):
                bench.run_for(f"{order} ns")
            else:
                operator_actions.act(order, bench.now_ns, bench.scans)

    return Act(text, terminal, do, orders=orders)


def _goal_text(requested: object) -> str:
    if isinstance(requested, bool):
        return "comes on" if requested else "goes off"
    return f"becomes {requested}"
