"""A search in a rack with a networked drive: its own bits, numbers and rules."""

import pytest
from scanrack.io_images.drives.models import MODELS
from scanrack.io_images.drives.rules import rules_of
from scanrack.jobs.fuzz import Scenario, TrialBench, never
from scanrack.jobs.fuzz.explain.unfired import error_rules, rules_in
from scanrack.runtime import RackSpec

WORDS = (0x8000, 0, 1, 0, 2048, 0, 0, 20, 28, 0)
"""A configuration without functions of inputs; starting speed 1000, numbers in thousands."""
BINARY = (0x8000, 0x0300, *WORDS[2:])
"""The same with numbers of 32 bits."""
PRESET = 0x0200


def rack(*modules):
    slots = [{"number": number, "module": module} for number, module in enumerate(modules, 1)]
    return RackSpec.model_validate({"program": "none.py", "slot": slots})


class Presets:
    """It configures the drive, then presets its position."""

    def __init__(self, words, target):
        self.words, self.target, self.scans = words, target, 0

    def __call__(self, scan):
        self.scans += 1
        words = self.words if self.scans <= 10 else (PRESET, 0x8000, *self.target, *(0,) * 6)
        for at, word in enumerate(words):
            scan.slot[1].outputs[at] = word - 0x10000 if word > 0x7FFF else word


def seen(words, target, ask):
    answers = []

    @never
    def watched(now):
        answers.append(ask(now.slot[1]))

    trial = TrialBench(rack("smd23e2"), lambda: Presets(words, target), (watched,), 40)
    assert trial.run(Scenario()).broken is None
    return answers


@pytest.mark.parametrize(("words", "target"), [(WORDS, (-70, -5)), (BINARY, (-2, 61067))])
def test_the_status_of_a_drive_has_its_bits_and_numbers(words, target):
    """-70,005 in thousands; -2 * 65,536 + 61,067 in 32 bits."""
    answers = seen(words, target, lambda slot: (slot.status.ACKNOWLEDGE, slot.status.position, slot.position))
    assert answers[0] == (False, 0, 0)
    assert answers[-1] == (True, -70_005, -70_005)


def test_a_drive_has_no_bits_of_a_3601():
    answers = seen(
        WORDS, (0, 0), lambda slot: (hasattr(slot.status, "INPUT_2"), hasattr(slot.status, "IN_ESTOP"))
    )
    assert set(answers) == {(True, False)}


def test_rules_are_those_of_the_modules_in_the_rack():
    own = {rule.id for rule in rules_of(MODELS["smd23e2"])}
    chapter = {rule.id for rule in error_rules()}
    racks = (("smd23e2",), ("amci3601", "smd23e2"), ("amci3601",))
    drive, both, card = (rules_in(rack(*names).slot) for names in racks)
    assert (drive.owners, set(drive.ids)) == ("the SMD23E2", own)
    assert (both.owners, set(both.ids)) == ("chapter 6 and the SMD23E2", chapter | own)
    assert (card.owners, set(card.ids)) == ("chapter 6", chapter)
