"""Finds what a user could do to change a value, by trying it on copies of the rack.

    the rack at the scan | copy 1: no action
                         | copy 2: press start for 60 ms, then 5 s
                         | copy 3: close stop, then press start ...

A copy is a fork of the process, in which rack, machine and program continue. Single acts are tried before
pairs, so that every result is minimal. Every reported result has been tried.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import permutations
from typing import Any, Protocol

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import parse_duration, seconds
from scanrack.ladder.debug import CauseLink
from scanrack.ladder.debug.watched import shown
from scanrack.runtime.live import actions
from scanrack.runtime.live.operator_actions import OperatorActions
from scanrack.runtime.machine.spec import INPUT_NAMES
from scanrack.runtime.modules.record import Trait

from .copies import can_copy, in_copy

PRESS = "60 ms"
BETWEEN = "100 ms"
WITHIN_NS = 5_000_000_000
"""How long a copy runs after the last act."""

LOOKS = "20 ms"
"""Time between two readings of the value in a copy."""

MOST_TRIES = 60
"""Maximum number of copies."""

MOST_ACTS = 2

_TERMINAL = re.compile(r"slot (\d+) input (?:\d+ \((\w+)\)|IN_(\w+))")
_SLOT = re.compile(r"slot (\d+): ")


class Rack(Protocol):
    """The part of a bench that acts use."""

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
    """Something that a user can do."""

    text: str  # press start for 60 ms
    on: str  # the object it acts on: two acts on one object are never tried together
    do: Callable[[Any], object]
    is_press: bool = False  # whether it presses a button
    orders: tuple[actions.Action | int, ...] = ()  # session orders and waits in ns; may be empty


@dataclass(frozen=True, slots=True)
class Acts:
    """A result: the acts in order, and the time from the first one until the tag has the requested value."""

    tag: str
    requested: object
    found: tuple[Act, ...] | None  # empty: the value changes by itself; None: nothing was found
    after_ns: int
    stimulus: str  # the first thing that the machine or the rack file's timeline did meanwhile
    tries: int

    def __str__(self) -> str:
        goal = f"{self.tag} {_becomes(self.requested)}"
        if self.found is None:
            tries = "1 try" if self.tries == 1 else f"{self.tries} tries"
            return f"{goal}: nothing that an owner can do was found in {tries}"
        after = f"{seconds(self.after_ns)} s"
        if not self.found and self.stimulus:
            return f"{goal} in {after}, as the rack file continues: {self.stimulus}"
        if not self.found:
            return f"{goal} by itself: wait {after}"
        return f"{goal} {after} after this: {', then '.join(act.text for act in self.found)}"

    def orders(self) -> list[dict[str, Any]] | None:
        """Return the acts as session orders, messages or `wait_ns`; None if an act has no orders."""
        steps: list[actions.Action | int] = []
        for act in self.found or ():
            if not act.orders:
                return None
            steps += [*act.orders, parse_duration(BETWEEN)]
        return [{"wait_ns": step} if isinstance(step, int) else actions.message_of(step) for step in steps]

    def as_json(self) -> dict[str, object]:
        """Return the result as JSON values."""
        acts = None if self.found is None else [act.text for act in self.found]
        return {"acts": acts, "after_ns": self.after_ns, "tries": self.tries}


def acts_for(bench: Rack, link: CauseLink, tag: str, requested: object) -> Acts | None:
    """Return what a user could do to change a value; None on a system that can't fork a process.

    Args:
        bench: the bench at the scan of the question; it does not change. It must not be recording: a copy
            would also write.
        link: the chain of the present value; acts on its ends are tried first.
    """
    if not can_copy():
        return None
    return next(every_act(bench, link, tag, requested))


def every_act(bench: Rack, link: CauseLink, tag: str, requested: object) -> Iterator[Acts]:
    """Yield the smallest results. If nothing was found, yield one result without acts."""
    tries, known = 0, list[set[str]]()
    for chosen in _sets(list(_acts(bench, link))):
        texts = {act.text for act in chosen}
        if tries == MOST_TRIES or any(known_texts <= texts for known_texts in known):
            continue
        tries += 1
        outcome = _tried(bench, chosen, tag, requested)
        if outcome is not None:
            known.append(texts)
            yield Acts(tag, requested, chosen, *outcome, tries)
    if not known:
        yield Acts(tag, requested, None, 0, "", tries)


def _sets(acts: Sequence[Act]) -> Iterator[tuple[Act, ...]]:
    """Yield no act, each act, and each pair of acts on two objects; pairs that end with a button first."""
    for count in range(MOST_ACTS + 1):
        chosen = [
            ordering for ordering in permutations(acts, count) if len({act.on for act in ordering}) == count
        ]
        yield from sorted(
            chosen, key=lambda each: [act.is_press for act in each] != [False] * (count - 1) + [True]
        )


def _tried(bench: Rack, acts: Sequence[Act], tag: str, requested: object) -> tuple[int, str] | None:
    """Try acts on a copy; return the time until the tag has the value, ns, and the first stimulus."""
    reply = in_copy(lambda: _done(bench, acts, tag, requested))
    after, _, stimulus = reply.partition(" ")
    return (int(after), stimulus) if reply else None


def _done(bench: Rack, acts: Sequence[Act], tag: str, requested: object) -> str:
    """Carry out acts; return the time until a tag has the value, ns, and the first stimulus; "" if never."""
    begun, noted = bench.now_ns, len(bench.events)
    for act in acts:
        act.do(bench)
        bench.run_for(BETWEEN)
    limit = bench.now_ns + WITHIN_NS
    while bench[tag] != requested:
        if bench.now_ns >= limit:
            return ""
        bench.run_for(LOOKS)
    stimuli = [event.text for event in bench.events[noted:] if event.kind == "stimulus"]
    return f"{bench.now_ns - begun} {stimuli[0] if stimuli else ''}"


# --- what can be done


def _acts(bench: Rack, link: CauseLink) -> Iterator[Act]:
    """Yield each act once, beginning with acts on the ends of the chain."""
    seen: set[str] = set()
    for act in (*_of_links(bench, link), *_of_panels(bench)):
        if act.text not in seen:
            seen.add(act.text)
            yield act


def _of_links(bench: Rack, link: CauseLink) -> Iterator[Act]:
    for cause in link.walk():
        terminal = _TERMINAL.search(cause.text)
        slot = _SLOT.match(cause.text)
        if cause.kind == "force":
            yield _of_force(cause.name)
        elif cause.kind == "mode":
            turn = actions.Mode("run")
            yield Act("turn the key to run", "the key", lambda bench: bench.run_mode(), orders=(turn,))
        elif cause.kind in ("input", "operator") and terminal is not None:
            yield from _of_input(bench, int(terminal[1]), (terminal[2] or terminal[3]).lower())
        elif cause.kind == "operator" and isinstance(cause.value, bool):
            yield _of_tag(cause.name, not cause.value)
        elif cause.kind == "incident" and slot is not None:
            yield _of_link(int(slot[1]))


def _of_force(name: str) -> Act:
    order = actions.Unforce(name)
    return Act(f"take the force off {name}", name, lambda bench: bench.unforce(name), orders=(order,))


def _of_link(number: int) -> Act:
    text = f"restore the link to slot {number}"
    return Act(text, f"slot {number}", lambda bench: bench.slot[number].inject(None))


def _of_tag(name: str, value: bool) -> Act:
    def put(bench: Any) -> None:
        bench[name] = value

    return Act(f"set {name} to {shown(value)}", name, put, orders=(actions.Write(name, value),))


def _of_panels(bench: Rack) -> Iterator[Act]:
    """Yield acts on the named inputs of cards, buttons and switches, and on the inputs of axes.

    A 3601 names its inputs, so the chain has the inputs that are off; a drive has a function for each.
    """
    for slot in bench.spec.slot:
        for name in (slot.options or {}).get("inputs") or ():
            yield from _of_input(bench, slot.number, str(name))
        if slot.has(Trait.MACHINE) and not slot.is_live:
            on, named = bench.slot[slot.number].energized, is_stepper(slot.words)
            for name in slot.record.machine_inputs(slot.options or {}):
                if name in on or not named:
                    yield from _of_input(bench, slot.number, name)


def _of_input(bench: Rack, number: int, name: str) -> Iterator[Act]:
    """Yield the acts on an input that the machine does not operate."""
    slot = next(slot_spec for slot_spec in bench.spec.slot if slot_spec.number == number)
    own = ""  # the name of a drive's terminal
    if slot.has(Trait.MACHINE) and name in INPUT_NAMES:
        if slot.machine.fed_inputs & INPUT_NAMES[name].value:
            return
        own = slot.record.machine_inputs(slot.options or {}).get(name, "")
        is_on = name in bench.slot[number].energized
    else:
        is_on = bool(bench[f"slot{number}.input.{name}"])
    terminal = f"{name} (slot {number}{own and ' '}{own})"
    off, on = (actions.Press(number, name, closed) for closed in (False, True))
    if is_on:
        yield Act(f"open {terminal}", terminal, _by_hand(off), orders=(off,))
        return
    press = (on, parse_duration(PRESS), off)
    yield Act(f"press {terminal} for {PRESS}", terminal, _by_hand(*press), True, press)
    yield Act(f"close {terminal}", terminal, _by_hand(on), orders=(on,))


def _by_hand(*steps: actions.Action | int) -> Callable[[Any], None]:
    """Return a function that gives a bench orders, with waits between them in ns."""

    def do(bench: Any) -> None:
        hands = OperatorActions(bench.cpu, bench.cpu.rack, None)
        for step in steps:
            if isinstance(step, int):
                bench.run_for(f"{step} ns")
            else:
                hands.act(step, bench.now_ns, bench.scans)

    return do


def _becomes(requested: object) -> str:
    if isinstance(requested, bool):
        return "comes on" if requested else "goes off"
    return f"becomes {requested}"
