"""Generates a scan of a logic instance as one function, for its devices and sequences.

It calls only devices that are not idle, and sequences that are due or that depend on a change, see `watch`.
`Logic._logic_scan_slowly` does the same scan in slower but more readable code.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

from .declaring import EVERY_SCAN
from .parts import Device, LogicScan

_HEAD = """\
now_ns = clock.now_ns = scan.now_ns
if scan.first or scan.slot is not slots:
    begin(scan)
    return"""

_SEQUENCE = """\
if {own}._due:
    {own}.step(now_ns)
elif (
    {own}._words[{own}._word] & {own}._mask != {own}._seen
    or {own}._flag.ended
    or now_ns >= {own}._until_ns
):
    {own}.step_after_change(now_ns)"""


def generated_scan(logic: Any, plain: object) -> Callable[[LogicScan], None]:
    """Return the scan of an attached instance.

    Args:
        logic: a `Logic`, whose module imports this one.
        plain: the `every_scan` of the base class, which does nothing.
    """
    names: dict[str, Any] = {
        "clock": logic._logic_clock,
        "slots": logic._logic_slots,
        "begin": logic._logic_begin,
        EVERY_SCAN: logic.every_scan,
    }
    before, after = [], []
    devices = [part for part in logic._logic_parts if isinstance(part, Device)]
    for number, device in enumerate(devices):
        call_before, call_after = _turns(device, f"device{number}", names)
        before.append(call_before)
        after.append(call_after)
    middle = [] if getattr(type(logic), EVERY_SCAN) is plain else [f"{EVERY_SCAN}()"]
    for number, sequence in enumerate(logic._logic_sequences):
        own = f"sequence{number}"
        names[own] = sequence
        middle.append(_SEQUENCE.format(own=own))
    body = "\n".join([_HEAD, *before, *middle, *after])
    make = _compiled(body, tuple(names))
    scan: Callable[[LogicScan], None] = make(**names)
    return scan


def _turns(device: Device, own: str, names: dict[str, Any]) -> Iterator[str]:
    """Yield the Python code that calls a device's actions before and after the logic; add their names."""
    idle = device.idle()
    name_of = {} if idle is None else {name: f"{own}_{name}" for name in idle.names}
    if idle is not None:
        names.update({name_of[name]: value for name, value in idle.names.items()})
    conditions = (None, None) if idle is None else (idle.before, idle.after)
    for phase, turn, condition in zip(("before", "after"), device.turns(), conditions, strict=True):
        names[f"{own}_{phase}"] = turn
        call = f"{own}_{phase}(now_ns)"
        yield call if condition is None else f"if not ({condition.format(**name_of)}): {call}"


@lru_cache(maxsize=256)
def _compiled(body: str, names: tuple[str, ...]) -> Callable[..., Any]:
    """Return a function that creates the scan, given the objects for its names."""
    lines = "\n".join(f"        {line}" for line in body.splitlines())
    text = f"def make({', '.join(names)}):\n    def scan_once(scan):\n{lines}\n    return scan_once\n"
    space: dict[str, Any] = {}
    exec(compile(text, "<scan>", "exec"), space)
    make: Callable[..., Any] = space["make"]
    return make
