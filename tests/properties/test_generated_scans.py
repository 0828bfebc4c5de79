"""A logic's generated scan does what its slow and clear one does: images, fields, steps, locals, faults.

Random programs with sequences run twice with the same inputs, edits, restarts, losses of the link and
writes of others.

Broken on purpose: a watch without the mode bit, without the first scan of a level, one that is not noted
again after a turn, a device that is idle in spite of another writer or of new inputs.
"""

from __future__ import annotations

import random
from itertools import product

import edited_sequences
import pytest
from amounts import amount
from bench3601 import CONFIGURATION
from edited_sequences import Author, Run, text_of
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.image import Image
from scanrack.ladder.python.online.editing import edit_logic
from scanrack.ladder.python.online.field_plan import EditRefusal
from scanrack.ladder.python.sequences.coroutine import Sequence
from scanrack.ladder.python.sequences.signals import _reader
from scanrack.runtime import CpuFault

SCANS = 250
GENERATED = "scanrack.ladder.python.sequences.logic.generated_scan"
PARTS = """\
    capture = Input("slot1.status.IN_CAPTURE")
    running = Input("slot1.status.MOVING_CW")
    ready = Input("slot1.status.MODULE_OK")
"""
AWAITS = (
    *edited_sequences.AWAITS,
    "await self.one.on",
    "await self.one.off",
    "await self.capture.rises",
    "await self.capture.falls",
    "await self.capture.on",
    "await self.ready.on",
    'await within("{n}0 ms", self.running.rises)',
    "await self.axis.configure()",
    "await self.axis.move_by({n}, speed=1000, acceleration=20, deceleration=20)",
    "self.axis.halt()",
)


@pytest.fixture(autouse=True)
def _more_waits(monkeypatch):
    monkeypatch.setattr(edited_sequences, "AWAITS", AWAITS)
    head = edited_sequences.HEAD.replace("    late = OnDelay", f"{PARTS}    late = OnDelay")
    monkeypatch.setattr(edited_sequences, "HEAD", head)


class Story:
    """What happens to a run, by chance: the same twice."""

    def __init__(self, seed: int) -> None:
        self.dice = random.Random(seed)
        self.kinds = [self.press, self.press, self.press, self.capture, self.capture, self.restart]
        self.kinds += [self.order, self.order, self.lose, self.write]

    def act(self, run: Run) -> None:
        if self.dice.random() < 0.2:
            self.dice.choice(self.kinds)(run)

    def press(self, run: Run) -> None:
        run.bench.press(self.dice.randint(0, 1), self.dice.random() < 0.5)

    def capture(self, run: Run) -> None:
        run.bench.module.machine.set_input(InputBit.CAPTURE, self.dice.random() < 0.5)
        run.bench.module.look_again()

    def restart(self, run: Run) -> None:
        if self.dice.random() < 0.2:
            run.bench.restart()

    def order(self, run: Run) -> None:
        chosen = self.dice.choice(run.bench.sequences)
        (chosen.abort if self.dice.random() < 0.3 else chosen.restart)()

    def lose(self, run: Run) -> None:
        run.bench.module.linked = self.dice.random() < 0.5

    def write(self, run: Run) -> None:
        """Write into the words of the axis: its drive refuses that."""
        if self.dice.random() < 0.03:
            run.bench.rack.slots[1].outputs[3] = 77


def played(folder, seed: int) -> tuple[Run, str]:
    """Return a run with an edit in the middle, and its fault."""
    author, story = Author(seed), Story(seed)
    program = author.program()
    before, after = (text_of(each, CONFIGURATION) for each in (program, author.edit(program)))
    run = Run(folder, before, seed)
    at = author.dice.randint(1, SCANS)
    try:
        for scan in range(SCANS):
            if scan == at:
                try:
                    edit_logic(run.bench.logic, run.load(after))
                except EditRefusal as refused:
                    run.scans.append(str(refused))
            story.act(run)
            run.scan(1)
    except CpuFault as fault:
        return run, str(fault)
    return run, ""


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:coroutine 'Plant:RuntimeWarning")
def test_generated_scans_do_what_slow_ones_do(tmp_path, monkeypatch):
    stepped: list[int] = []
    step = Sequence.step
    faults = set()

    def counted(self, now_ns):
        stepped[-1] += 1
        step(self, now_ns)

    monkeypatch.setattr(Sequence, "step", counted)
    for seed in range(amount(25)):
        stepped.append(0)
        with monkeypatch.context() as patch:
            patch.setattr(GENERATED, lambda logic, plain: logic._logic_scan_slowly)
            slow, slow_fault = played(tmp_path, seed)
        stepped.append(0)
        fast, fast_fault = played(tmp_path, seed)
        assert fast.scans == slow.scans
        assert fast_fault == slow_fault
        faults.add(fast_fault[-20:])
    assert sum(stepped[1::2]) < sum(stepped[::2]) * 0.7  # otherwise nothing is compared
    assert len(faults) > 1


@pytest.mark.parametrize("guarded", [False, True])
@pytest.mark.parametrize("word", [0, 1, 2])
@pytest.mark.parametrize("bit", [0, 4, 15])
def test_an_input_stays_while_all_that_it_reads_stays(bit, word, guarded):
    image = Image()
    read, place = _reader(image, word, bit, guarded=guarded)
    assert (place is None) == (guarded and word == 2)  # two words too far apart
    words, index, mask = place or (image.words, word, 0)
    seen: dict[int, set[bool]] = {}
    for pair in product((0, 1, 0x10, -1, -32768, 32767, -32752), repeat=2):
        image.words[0], image.words[word] = pair
        seen.setdefault(words[index] & mask, set()).add(read())
    assert place is None or all(len(levels) == 1 for levels in seen.values())
    assert {level for levels in seen.values() for level in levels} == {False, True}
