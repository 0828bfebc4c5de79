"""The rack's memory and its slots."""

import pytest
from scanrack.io_images.image import Image
from scanrack.runtime import Card, Rack


class Absent:
    """A module that is only sitting there."""

    def __init__(self):
        self.events = []

    def update(self, now_ns, outputs):
        return Image()

    def plc_run(self, running):
        pass

    def power_cycle(self):
        pass


def test_images_are_views_of_one_block_in_slot_order():
    rack = Rack([Card(7, Absent(), "amci3601", "4.1"), Card(2, Absent())])
    assert list(rack.slots) == [2, 7]
    rack.slots[2].outputs[0] = 0x0102
    rack.slots[2].inputs[7] = -1
    rack.slots[7].outputs[1] = 3
    rack.slots[7].inputs[0] = 4
    expected = bytearray(64)
    expected[0:2] = b"\x02\x01"  # slot 2, output word 0, low byte first
    expected[30:32] = b"\xff\xff"  # slot 2, input word 7
    expected[34] = 3  # slot 7, output word 1
    expected[48] = 4  # slot 7, input word 0
    assert rack.memory == expected
    slot = rack.slots[7]
    assert (slot.number, slot.catalog, slot.firmware) == (7, "amci3601", "4.1")


def test_an_empty_rack_is_a_rack():
    rack = Rack([])
    assert (len(rack.memory), dict(rack.slots)) == (0, {})
    with pytest.raises(ValueError, match="slot 1 is empty: modules sit in none"):
        rack.slots[1]


@pytest.mark.parametrize("number", [0, -1, 1.0, "1", True])
def test_slot_numbers_are_positive_whole_numbers(number):
    with pytest.raises(ValueError, match=f"slot number {number!r}: must be a whole number, 1 or more"):
        Rack([Card(number, Absent())])


def test_a_slot_holds_one_module():
    with pytest.raises(ValueError, match="slot 3 is used twice"):
        Rack([Card(3, Absent()), Card(1, Absent()), Card(3, Absent())])
