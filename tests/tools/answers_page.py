"""The table of docs/incidents.md: what a PLC sees of a 3601 in trouble: by masks, or measured."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

from bench3601 import Bench
from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.image import WORDS
from scanrack.runtime.loop.module_fault import ModuleFault
from scanrack.runtime.modules.amci3601.trouble import EVERY_BIT, FAULT_IMAGES

PAGE = Path(__file__).parents[2] / "docs/incidents.md"
REMEDY = "python -m tests.tools.generate answers"
COLUMNS = "`link-lost`, `asic-lost`", "`removed`", "`fatal-error`", "`power-cycle`", "`program-mode`"
HEAD = f"| a 3601's input image | {' | '.join(COLUMNS)} |"
TABLE = re.compile(rf"(^{re.escape(HEAD)}\n\|[-|]+\|\n)((?:\|.*\n)*)", re.MULTILINE)
STAYS, AS_EVER = "held", "as usual"


def lines() -> Iterator[str]:
    """Return the rows: status bits, words, and the connection."""
    powered, stopped = Bench.ready().power_cycle().out().run(1).words, after_program_mode()
    for bit in StatusMsw:
        cells = [masked(fault, 0, bit.value) for fault in FAULTS]
        cells.append("1" if powered[0] & bit.value else "0")
        yield row(str(bit.name), [*cells, stopped(bit)])
    for first, last in ((1, 1), (2, WORDS - 1)):
        name = f"word {first}" if first == last else f"words {first} to {last}"
        yield row(name, [*(masked(fault, first, EVERY_BIT) for fault in FAULTS), "0", AS_EVER])
    faults = ["0" if FAULT_IMAGES[fault].linked else "-1" for fault in FAULTS]
    yield row("`Fault` of a CompactLogix", [*faults, "0", "0"])


FAULTS = (ModuleFault.LINK_LOST, ModuleFault.REMOVED, ModuleFault.FATAL_ERROR)
assert FAULT_IMAGES[ModuleFault.LINK_LOST][:2] == FAULT_IMAGES[ModuleFault.ASIC_LOST][:2]


def row(name: str, cells: list[str]) -> str:
    return f"| {name} | {' | '.join(cells)} |"


def masked(fault: ModuleFault, word: int, bits: int) -> str:
    kept = FAULT_IMAGES[fault].kept[word] & bits
    assert kept in (0, bits), "a part of a word has a row of its own"
    return STAYS if kept else "0"


def after_program_mode() -> Callable[[StatusMsw], str]:
    """Return what a module shows that moves, in the words of the table."""
    bench = Bench.ready().relative(10_000).run(10)
    before = bench.words[0]
    bench.module.plc_run(False)
    after = bench.run(10).words[0]

    def cell(bit: StatusMsw) -> str:
        if not (before ^ after) & bit.value and not bit.value & MOTION:
            return AS_EVER
        return f"{1 if after & bit.value else 0} if it moved"

    return cell


MOTION = (StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW | StatusMsw.ACCELERATING | StatusMsw.DECELERATING).value


def written(page: str) -> str:
    """Return the page with the table as it is."""
    assert TABLE.search(page) is not None, "no table of answers"
    text = "".join(f"{line}\n" for line in lines())
    return TABLE.sub(lambda found: found[1] + text, page)
