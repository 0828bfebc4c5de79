"""Random worlds and scripts for scans by rows: motion, forces, incidents, and who acts on a rack."""

from __future__ import annotations

from ahead3601 import TICK_NS, World
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime import FaultKind, InjectedFault
from scanrack.runtime.loop.incidents import TROUBLES
from scanrack.runtime.machine import Jam, Slip
from stories3601 import scripts

MS = 1_000_000
PERIODS = [2 * MS, 10 * MS, MS, TICK_NS, 333_333, 7 * MS]
RPIS = [None, None, 2 * MS, 3 * MS]


class Touch:
    """A step: act on the rack, or look at it, and wait."""

    def __init__(self, name, *arguments):
        self.name, self.arguments = name, arguments

    def play(self, bench):
        getattr(bench, self.name)(*self.arguments)
        bench.run(60)


TOUCHES = [
    *(Touch("force", "I:1.1/2", 1), Touch("force", "I:1.3", 77), Touch("force", "I:1.7", 5)),
    *(Touch("force", "O:1.0/3", 0), Touch("force", "O:1.7", 5), Touch("force", "", None)),
    *(Touch("operate", InputBit.HOME, True), Touch("operate", InputBit.HOME, None), Touch("look")),
    *(Touch("happen", FaultKind.LINK_LOST, 20 * MS), Touch("happen", FaultKind.POWER_CYCLE, 0)),
]


@st.composite
def incidents(draw):
    """Up to three incidents of slot 1, and perhaps a turn of the key."""
    kinds = [FaultKind.POWER_CYCLE, FaultKind.TORN_UPDATE, FaultKind.PROGRAM_MODE, *TROUBLES]
    found = []
    for what in draw(st.lists(st.sampled_from(kinds), max_size=3)):
        at_ns = draw(st.integers(0, 2_000)) * MS + draw(st.sampled_from([0, 1, 123_456]))
        slot = 0 if what is FaultKind.PROGRAM_MODE else 1
        words = (1, 2, 3) if what is FaultKind.TORN_UPDATE else ()
        for_ns = 0 if what is FaultKind.POWER_CYCLE else draw(st.integers(1, 300)) * MS
        found.append(InjectedFault(at_ns, what, slot, for_ns, words))
    return found


@st.composite
def stories(draw, theme):
    """A world and a script for it."""
    setting, steps = draw(scripts(theme))
    for touch in draw(st.lists(st.sampled_from(TOUCHES), max_size=4)):
        steps.insert(draw(st.integers(0, len(steps))), touch)
    positions = st.integers(-60, 400)
    world = World(
        setting,
        period_ns=draw(st.sampled_from(PERIODS)),
        rpi_ns=draw(st.sampled_from(RPIS)),
        slips=draw(st.lists(st.builds(Slip, positions, st.integers(1, 9), times=st.none()), max_size=2)),
        jams=draw(st.lists(st.builds(Jam, positions, st.sampled_from([1, -1])), max_size=1)),
        incidents=draw(incidents()),
        neighbors=draw(st.booleans()),
    )
    return world, steps
