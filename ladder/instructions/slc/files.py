"""Shifts, queues and sequencers on words [1747-RM001, chapters "Application specific", "Sequencer", "FIFO"].

An operand is the first word of a file. Shifts move LEN bits, and the bit that is shifted out is stored in UL.
A sequencer starts at step 0, and step 1 follows step LEN.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ...interpreter import Interpreter
from ...interpreter.files import Control, Elements
from ...model.arithmetic import wrap
from ...model.operands import Group, Place, Resolved
from ..sequencers import sequencer_load, sequencer_output

_BITS = 16


def shift(left: bool) -> Callable[..., None]:
    """Return the function of BSL or BSR.

    It shifts LEN bits once when the rung goes true; the other bits do not change.
    """

    def run(
        machine: Interpreter, power: bool, file: Resolved, group: Group, source: Place, *_shown: Resolved
    ) -> None:
        control = Control(machine, group)
        if not power:
            control.set(EN=False, DN=False)
            return
        if control["EN"]:
            return
        control.check()
        length = control["LEN"]
        words = Elements(machine, file)
        word_count = -(-length // _BITS)
        pattern = sum((machine.whole(words[index]) & 0xFFFF) << index * _BITS for index in range(word_count))
        bits = pattern & (1 << length) - 1
        bit_in = machine.whole(machine.truth(machine.get(source)))
        bit_out = bits >> length - 1 & 1 if left and length else bits & 1
        moved = (bits << 1 | bit_in) if left else (bits >> 1 | bit_in << max(length - 1, 0))
        pattern = pattern & ~((1 << length) - 1) | moved & (1 << length) - 1
        for index in range(word_count):
            words[index] = wrap(pattern >> index * _BITS & 0xFFFF, _BITS)
        control.set(EN=True, DN=True, UL=machine.truth(bit_out))

    return run


# --- sequencers


def _advance(control: Control) -> bool:
    """Advance POS on a rising rung; return whether LEN and POS are valid."""
    if control["LEN"] <= 0 or control["POS"] < 0 or control["POS"] > control["LEN"]:
        control.set(ER=True)
        return False
    if not control["EN"]:
        over = control["POS"] >= control["LEN"]
        control.set(EN=True, ER=False, POS=1 if over else control["POS"] + 1)
    control.set(DN=control["POS"] == control["LEN"])
    return True


sequence_output = partial(sequencer_output, step=_advance)
sequence_load = partial(sequencer_load, step=_advance)


def sequence_compare(
    machine: Interpreter,
    power: bool,
    file: Resolved,
    mask: Resolved,
    source: Resolved,
    group: Group,
    *_shown: Resolved,
) -> None:
    """Run SQC: set FD if the source equals the step in the masked bits."""
    control = Control(machine, group)
    if not power:
        control.set(EN=False, FD=False)
    elif _advance(control):
        entry = machine.whole(Elements(machine, file)[control["POS"]])
        control.set(FD=(machine.integer(source) ^ entry) & machine.integer(mask) & 0xFFFF == 0)
