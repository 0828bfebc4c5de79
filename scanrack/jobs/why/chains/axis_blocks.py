"""Finds the module that a block of an axis is bound to."""

from __future__ import annotations

from collections.abc import Iterator

from scanrack.ladder.state.lowered import AddOnCall, LoweredProgram

MODULE = "AMCI3601"
"""The instruction that binds an axis to the words of a slot."""


def slot_of(lowered: LoweredProgram, path: str) -> int | None:
    """Return the slot of the module that a block's axis is bound to; None for any other structure."""
    calls = list(_calls(lowered))
    block = next((call for call in calls if call.instance.path.upper() == path.upper()), None)
    axis = block.handed.get("AXIS") if block is not None else None
    if axis is None:
        return None
    for call in calls:
        if call.name != MODULE or call.handed["AXIS"].text.upper() != axis.text.upper():
            continue
        if inputs := call.handed.get("INPUTS"):
            return getattr(getattr(inputs, "leaf", None), "slot", None)
    return None


def _calls(lowered: LoweredProgram) -> Iterator[AddOnCall]:
    """Yield the Add-On calls of a program's routines; calls inside of Add-On Instructions are left out."""
    for routine in lowered.routines.values():
        for line in routine.lines if not routine.frame else ():
            for step in line.steps:
                if step.operands and isinstance(step.operands[0], AddOnCall):
                    yield step.operands[0]
