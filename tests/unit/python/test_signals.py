"""Inputs and outputs by address, by meaning and by name: the same bit whatever it is called."""

import pytest
from scanrack import Axis3601, Input, InputWord, Logic, Output, OutputWord, State, sequence
from scanrack.io_images.amci3601 import WORDS_3601
from scanrack.io_images.cards import KINDS
from scanrack.io_images.module_words import PLAIN_WORDS
from scanrack.ladder.python.sequences.places import find_bit, find_word
from scanrack.runtime.modules.cards.card_options import CardOptions
from sequence_bench import CARD_WORDS, SETUP, SequenceBench

ANALOG = CardOptions(inputs={"level": 0}).words(KINDS["1769-IF4"])
RACK = {1: WORDS_3601, 2: CARD_WORDS, 3: ANALOG, 4: PLAIN_WORDS}


@pytest.mark.parametrize(
    "text",
    [
        "Local:2:I.Data.1",
        "Local:2:I.Data[0].1",
        "Local:2:I.Data0.1",
        "I:2.0/1",
        "slot2.input.stop",
        "stop",
        "STOP",
    ],
)
def test_ways_to_write_one_bit(text):
    assert str(find_bit(text, "I", RACK)) == "Local:2:I.Data[0].1"


@pytest.mark.parametrize("text", ["slot1.status.IN_ESTOP", "Local:1:I.Data[1].3", "I:1.1/3", "in_estop"])
def test_ways_to_write_a_status_bit(text):
    assert str(find_bit(text, "I", RACK)) == "Local:1:I.Data[1].3"


@pytest.mark.parametrize("text", ["Local:3:I.Ch0Data", "Local:3:I.Data[0]", "I:3.0", "level"])
def test_ways_to_write_a_word(text):
    assert str(find_word(text, "I", RACK)) == "Local:3:I.Data[0]"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is not an address"),
        ("Local:2:I.Data.16", "bit 16 does not exist: bits are 0 to 15"),
        ("Local:2:I.Data[8].0", "word 8 does not exist: words are 0 to 7"),
        ("slot2.status.start", "no 'status' in slot 2"),
        ("starts", r"no input 'starts'; did you mean start\?"),
    ],
)
def test_what_is_no_bit(text, says):
    with pytest.raises(ValueError, match=says):
        find_bit(text, "I", RACK)


def test_a_name_in_several_slots_is_refused():
    with pytest.raises(ValueError, match=r"write one of Local:2:I\.Data\[0\]\.0, Local:5:I\.Data\[0\]\.0"):
        find_bit("start", "I", {**RACK, 5: CARD_WORDS})


class Copying(Logic):
    """Copies inputs to outputs in each scan."""

    start = Input("start")
    last = Input("Local:2:I.Data.15")
    level = InputWord("Local:2:I.Data[1]")
    lamp: Output = Output("Local:2:O.Data.0")
    sign: Output = Output("Local:2:O.Data.15")
    value: OutputWord = OutputWord("Local:2:O.Data[1]")
    seen = None

    def every_scan(self):
        self.lamp = self.start
        self.sign = self.last
        self.value = self.level
        self.seen = (self.lamp, self.sign, self.value)


@pytest.mark.parametrize("level", [0, 1, -1, 32_767, -32_768])
@pytest.mark.parametrize("lamp", [False, True])
@pytest.mark.parametrize("sign", [False, True])
def test_bits_and_words_as_they_stand(lamp, sign, level):
    bench = SequenceBench(Copying)
    bench.press(0, lamp).press(15, sign).card.inputs[1] = level
    bench.scan()
    assert bench.logic.seen == (lamp, sign, level)
    outputs = bench.rack.slots[2].outputs
    assert (outputs.bit(0, 0), outputs.bit(0, 15), outputs[1]) == (lamp, sign, level)
    bench.press(0, not lamp).press(15, not sign).scan()
    assert (outputs.bit(0, 0), outputs.bit(0, 15)) == (not lamp, not sign)


def test_a_status_bit_by_meaning_is_off_in_configuration_mode():
    """There the module mirrors the configuration: bits 1 to 5 of word 0 are inputs used [chapter 3]."""

    class Mirrored(Logic):
        axis = Axis3601(1, SETUP)
        moving = Input("slot1.status.MOVING_CCW")
        raw = Input("Local:1:I.Data[0].1")
        level = Input("slot1.status.IN_HOME")
        mode = Input("slot1.status.MODE_CONFIG")

        def __init__(self):
            self.seen = []

        def every_scan(self):
            self.seen.append((bool(self.mode), bool(self.moving), bool(self.raw), bool(self.level)))

        @sequence
        async def cycle(self):
            await self.axis.configure()

    bench = SequenceBench(Mirrored).scan(20)
    assert (True, False, True, False) in bench.logic.seen
    assert (True, True, True, True) not in bench.logic.seen
    assert bench.logic.axis.state is State.STANDSTILL


def test_outputs_before_the_first_scan_are_refused():
    class Early(Logic):
        lamp: Output = Output("Local:2:O.Data.0")

        def __init__(self):
            self.lamp = True

    with pytest.raises(ValueError, match="lamp has no slot before the first scan"):
        Early()


def test_inputs_before_the_first_scan_are_refused():
    class Early(Logic):
        start = Input("start")

        def __init__(self):
            self.pressed = bool(self.start)

    with pytest.raises(ValueError, match="start has no slot before the first scan"):
        Early()


def test_the_same_instance_may_move_to_another_rack():
    """Its parts are attached anew, and all begins anew."""
    first = SequenceBench(Copying).press(0).scan()
    assert first.lamp(0)
    second = SequenceBench(first.logic).scan()
    assert not second.lamp(0)
    second.press(0).scan()
    assert (first.lamp(0), second.lamp(0)) == (True, True)
