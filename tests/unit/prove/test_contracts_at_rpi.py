"""Contracts of two images that are exchanged every RPI: the module's model keeps them, proofs use them."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from struct import unpack
from typing import Any

import pytest
from scanrack.io_images.amci3601 import CommandMsw
from scanrack.io_images.amci3601.contracts import contracts_of
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.prove.subject import subject_of
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ProgramSystem
from scanrack.ladder.prove.algebra.evaluation import Evaluator
from scanrack.ladder.prove.contracts import KeptBy
from scanrack.ladder.prove.induction import VerdictKind, prove
from scanrack.ladder.prove.monitors import monitored
from scanrack.ladder.prove.questions import ask
from scanrack.runtime.loop.listeners import QuietListener

pytestmark = pytest.mark.extra("prove")

FEEDER = Path(__file__).parents[3] / "examples" / "feeder"
REMEMBERS = """
PROGRAM remembers
TAG Go : BOOL
TAG Homed : BOOL
SLOT axis : 1
ROUTINE Main
XIC(axis.status.AT_HOME)OTL(Homed);
[XIC(axis.status.STOPPED),XIC(axis.status.HOME_INVALID),XIC(axis.status.CONFIG_ERROR),XIC(axis.status.MODE_CONFIG),XIO(axis.status.MODULE_OK)]OTU(Homed);
XIC(Homed)XIC(Go)OTE(axis.command.ABSOLUTE_MOVE);
END
"""
"""Keeps Homed until one of the bits with which a position is lost: chapter 6, Position Invalid 1 to 6."""

MODULE = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


class Images(QuietListener):
    """Notes the inputs of each scan, and the outputs that the scan before it left."""

    def __init__(self, slot):
        self._slot, self.left, self.scans = slot, (0,) * 8, []

    def scan(self, scan, now_ns, flags):
        self.scans.append((unpack("<8h", self._slot.inputs.raw), self.left))
        self.left = unpack("<8h", self._slot.outputs.raw)


class Shown:
    """An engine whose memory shows a scan's images."""

    def __init__(self):
        self.lowered, self.layout, self.memory, self.scan = self, self, self, ((0,) * 8, (0,) * 8)

    def image(self, slot, *, output):
        return output

    def read(self, output, word):
        return self.scan[output][word]


def of_a_run(scan_ms, folder):
    """The images of a feeder behind a CompactLogix, its emergency stop pressed in a stroke."""
    (folder / "feeder.rung").write_bytes((FEEDER / "feeder.rung").read_bytes())
    text = (FEEDER / "feeder.toml").read_text(encoding="utf-8")
    head = f'controller = "compactlogix"\nrpi_ms = 3\nscan_ms = {scan_ms}'
    text = text.replace("scan_ms = 2", head).replace("at_s = 8.0", "at_s = 1.0")
    (folder / "feeder.toml").write_text(text, encoding="utf-8")
    with ExitStack() as ports:
        run = JobRun(load_job(str(folder / "feeder.toml")), ports, RunOptions())
        images = Images(run.cpu.rack.slots[1])
        run.cpu.add_listener(images)
        run.run(int(3000 / scan_ms))
    return images.scans


def breaking(scans, *, at_rpi):
    """The first scan that breaks the contracts."""
    shown: Any = Shown()
    keeps = KeptBy(1, contracts_of(), at_rpi).watch(shown)
    for number, shown.scan in enumerate(scans):
        if not keeps():
            return number
    return None


@pytest.mark.slow
@pytest.mark.parametrize("scan_ms", [2, 3])
def test_a_run_with_scans_up_to_the_rpi_keeps_the_contracts(scan_ms, tmp_path):
    assert breaking(of_a_run(scan_ms, tmp_path), at_rpi=True) is None


def test_outputs_wait_for_one_exchange_and_count_in_the_next():
    """Preset Position for one scan: its exchange is seen in scan 1, what it does in scan 2."""
    invalid, valid = (0x4400, *(0,) * 7), (0x4000, *(0,) * 7)
    nothing, preset = (0,) * 8, (CommandMsw.PRESET_POSITION.value, *(0,) * 7)
    scans = [(invalid, nothing), (invalid, preset), (valid, nothing)]
    assert breaking(scans, at_rpi=True) is None
    assert breaking(scans, at_rpi=False) == 2
    assert breaking([scans[0], (invalid, nothing), scans[2]], at_rpi=True) == 2


def verdict_of(rack, folder):
    (folder / "remembers.rung").write_text(REMEMBERS, encoding="utf-8")
    lost = "axis.command.ABSOLUTE_MOVE AND axis.status.POSITION_INVALID"
    claim = f'[[prove.property]]\nname = "lost"\nnever = "{lost}"\n'
    (folder / "rack.toml").write_text(
        f'program = "remembers.rung"\n{rack}\n{claim}{MODULE}', encoding="utf-8"
    )
    subject = subject_of(str(folder / "rack.toml"))
    return prove(subject.problem, subject.program.properties[0].bit)


AT_RPI = 'controller = "compactlogix"\nrpi_ms = 5\nscan_ms = 2\n[prove]\nhappens = []\nscan_ms = '


def test_scans_up_to_the_rpi_prove_what_needs_two_images(tmp_path):
    assert verdict_of(AT_RPI + "[1, 5]", tmp_path).kind is VerdictKind.PROVED


def test_longer_scans_may_miss_an_image(tmp_path):
    """Between two of them the module may have stopped and gone on."""
    assert verdict_of(AT_RPI + "[1, 6]", tmp_path).kind is VerdictKind.REFUTED


def test_a_scan_without_an_exchange_shows_the_same_inputs_and_keeps_nothing_else():
    """A motion with the emergency stop active: of an exchange only a manual move may show that."""
    moving, other = {0: 0x4001, 1: 0x0008}, {0: 0x4002, 1: 0x0008}
    made = monitored(parse_program(REMEMBERS))
    kept = Evaluator([KeptBy(1, contracts_of(), at_rpi=True)(ProgramSystem(made.program))])

    def keeps(now, *, exchanged):
        values = {f"LOCAL:1:I.DATA[{word}]": value for word, value in now.items()}
        for word, value in moving.items():
            values[f"~was:LOCAL:1:I.DATA[{word}]"] = value
            values |= {f"~was:LOCAL:1:I.DATA[{word}].{bit}": bool(value >> bit & 1) for bit in range(16)}
        return kept({**values, "~was:~begun:1": True, "~exchanged:1": exchanged})[0]

    assert keeps(moving, exchanged=False)
    assert not keeps(moving, exchanged=True)
    assert not keeps(other, exchanged=False)


def test_built_in_questions_keep_the_contracts():
    """An axis in command mode never moves both ways: the coil is never on."""
    never = "XIC(axis.status.MODULE_OK)XIO(axis.status.MODE_CONFIG)"
    both = "XIC(axis.status.MOVING_CW)XIC(axis.status.MOVING_CCW)OTE(Homed);"
    text = f"PROGRAM both\nTAG Homed : BOOL\nSLOT axis : 1\nROUTINE Main\n{never}{both}\nEND\n"

    def never_on(*contracts):
        made = monitored(parse_program(text), slots=[1])
        found = ask(ProgramSystem(made.program, contracts=contracts), ["never-on"]).findings
        return [each.text for each in found]

    assert never_on(KeptBy(1, contracts_of())) == ["Homed is never on"]
    assert never_on() == []
