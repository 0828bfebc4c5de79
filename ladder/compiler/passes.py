"""FAL and FSC as Python code, see `instructions.arrays`."""

from __future__ import annotations

from collections.abc import Callable

from ..model.operands import Group, Place, Resolved
from ..model.types import DINT
from .files import ControlText
from .rungs import RungWriter


def _write_passes(
    rungs: RungWriter, power: str, control: ControlText, mode: str, write_element: Callable[[], None]
) -> None:
    """Write the loop that runs in one scan.

    The passes count toward the watchdog's limit; their backward jumps are counted at the end.

    Args:
        mode: ALL for all elements in one scan, INC for one element per rising edge, or a number per scan.
        write_element: writes the code for the element at POS; its `break` ends the loop.
    """
    keep, line, block, site = rungs.values.keep, rungs.writer.line, rungs.writer.block, rungs.values.site
    rises = keep(f"{power} and not {control['EN']}")
    runs = power
    if mode.isdigit():
        runs = keep(f"{power} or {control['EN']} and not {control['DN']}")
    with block(f"if {runs}:"):
        with block(f"if {rises}:"):
            control.set(EN=True, **({} if mode == "INC" else {"POS": 0}))
        waits = f" or not {rises}" if mode == "INC" else ""
        with block(f"if not ({control['DN']} or {control['ER']}{waits}):"):
            control.check()
            passes = keep(control["LEN"] if mode == "ALL" else "1" if mode == "INC" else mode)
            # ends early where the watchdog's limit is reached
            least = keep(f"max({passes} - faults.jumps_left, 0)")
            remaining = rungs.writer.temporary()
            line(f"{remaining} = {passes}")
            with block("try:"):
                with block(f"while {remaining} > {least} and {control['POS']} < {control['LEN']}:"):
                    line(f"{remaining} -= 1")
                    write_element()
                with block("else:"):
                    unfinished = f"{remaining} and {control['POS']} < {control['LEN']}"
                    line(f"if {unfinished}: jumped_back({site}, {passes})")
                    control.set(DN=f"{control['POS']} >= {control['LEN']}")
            line(f"finally: jumped_back({site}, {passes} - {remaining})")
    if power != "True":
        with block("else:"):
            control.begin_again()
            control.set(EN=False)


def write_fal(
    rungs: RungWriter, power: str, group: Group, mode: str, target: Place, expression: Resolved
) -> None:
    """Write FAL; an overflow sets ER and ends the passes."""
    control = ControlText(rungs, group)
    # an InOut can be another name of POS
    writes_pos = target.leaf == group.member("POS").leaf or target.leaf.root
    moves_on = f"wrap({control['POS']} + 1, {DINT.bits})" if writes_pos else f"{control['POS']} + 1"

    def write_element() -> None:
        overflows_before = rungs.values.keep("faults.overflows")
        rungs.values.expression(target, expression)
        fails = rungs.values.keep(f"faults.overflows != {overflows_before}")
        control.set(ER=fails)
        rungs.writer.line(f"if {fails}: break")
        control.set(POS=moves_on)

    _write_passes(rungs, rungs.kept(power), control, mode, write_element)


def write_fsc(rungs: RungWriter, power: str, group: Group, mode: str, expression: Resolved) -> None:
    """Write FSC; after a match, the search waits while IN is set, then continues at the next element."""
    control, power, block = ControlText(rungs, group), rungs.kept(power), rungs.writer.block
    searches = rungs.values.keep("True")
    with block(f"if {control['FD']}:"):
        with block(f"if not {power}:"):
            control.set(FD=False, IN=False)
            control.begin_again()
            control.set(EN=False)
            rungs.writer.line(f"{searches} = False")
        with block(f"elif {control['IN']}:"):
            rungs.writer.line(f"{searches} = False")
        with block("else:"):
            control.set(FD=False, POS=f"wrap({control['POS']} + 1, {DINT.bits})")

    def write_element() -> None:
        with block(f"if {rungs.values.condition(expression)}:"):
            control.set(FD=True, IN=True)
            rungs.writer.line("break")
        control.set(POS=f"{control['POS']} + 1")

    with block(f"if {searches}:"):
        _write_passes(rungs, power, control, mode, write_element)
