"""Adapters in a rack file: the same words and the same moves on all three hardwares."""

from __future__ import annotations

import pytest
from scanrack.io_images import Image
from scanrack.io_images.addresses import parse_address
from scanrack.io_images.amci3601 import WORDS_3601, status_names
from scanrack.io_images.thousands import join_reported
from scanrack.jobs.run.result import RunCounters
from scanrack.runtime import SlotSpec
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.machine import Jam, MachineSpec
from scanrack.runtime.modules.registry import words_of

HARDWARES = {"amci3601": {}, "pcl601-adapter": {}, "pmc006-adapter": {"home_stroke": 100_000}}
CONFIGURE = (0x843C, 63, 1, 0)
PRESET = (512,)
MOVES = ((2, 0, 10, 0, 5, 0, 20, 10), (1, 0, -2, -500, 4, 0, 30, 30), (2, 3, 1, 1, 3, 0, 50, 50))
STOPS = (10_000, -2500, -1499)
MS = 1_000_000


@pytest.mark.slow
@pytest.mark.parametrize("name", HARDWARES)
def test_one_list_of_commands_stops_at_the_same_places(name):
    module = SlotSpec(number=1, module=name, options=HARDWARES[name]).make(seed=0)
    now_ns, stops = 0, []
    words: tuple[int, ...]
    for words, ms in ((CONFIGURE, 500), ((), 100), (PRESET, 100), ((), 100)):
        now_ns += ms * MS
        image = module.update(now_ns, Image(words))
    assert status_names(image[0] & 0xFFFF, image[1] & 0xFFFF) == ["MODULE_OK"]
    for move in MOVES:
        for words, ms in ((move, 6000), ((), 100)):
            now_ns += ms * MS
            image = module.update(now_ns, Image(words))
        assert status_names(image[0] & 0xFFFF, image[1] & 0xFFFF) == ["MOVE_COMPLETE", "MODULE_OK"]
        stops.append(join_reported(image[2], image[3]))
    assert tuple(stops) == STOPS


@pytest.mark.parametrize(
    ("slot", "said"),
    [
        ({"module": "pcl601-adapter", "firmware": "2.1"}, "acts as firmware 4.1"),
        ({"module": "pmc006-adapter", "wiring": "diagnostic"}, "has no wiring option; remove it"),
        ({"module": "pcl601-adapter", "options": {"respeed": "yes"}}, "refuse, restart"),
        ({"module": "pmc006-adapter", "options": {"home_strok": 5}}, "did you mean home_stroke"),
        ({"module": "pcl601-adapter", "machine": MachineSpec(jams=(Jam(100, 1),))}, "slips and jams"),
        (
            {"module": "pmc006-adapter", "machine": MachineSpec(master_speed=9)},
            "a master encoder is simulated",
        ),
    ],
)
def test_what_an_adapter_can_not_take_is_named(slot, said):
    with pytest.raises(ValueError, match=said):
        SlotSpec(number=1, **slot)


def test_its_bits_have_the_names_of_the_3601():
    address = parse_address("slot1.status.IN_HOME", {1: WORDS_3601})
    assert (address.word, address.bit) == (1, 2)


@pytest.mark.slow
@pytest.mark.parametrize("name", HARDWARES)
def test_a_blend_move_ends_where_its_segments_end(name):
    options = HARDWARES[name] | ({} if name == "amci3601" else {"blend": "segmented"})
    module = SlotSpec(number=1, module=name, options=options).make(seed=0)
    blocks = [(0, 256 + 512, 2, 0, 0, 20), (0, 256 + 512, 4, 0, 3, 0, 20), (0, 256 + 512, 3, 500, 5, 0, 20)]
    script = [(CONFIGURE, 500), ((), 100), (PRESET, 100), ((), 100)]
    for block in blocks:
        script += [(block, 100), ((0, 256), 100)]
    now_ns = 0
    for words, ms in (*script, ((), 100), ((8192,), 300)):
        now_ns += ms * MS
        image = module.update(now_ns, Image(words))
    assert {"MOVING_CCW", "BLEND_RUNNING"} <= set(status_names(image[0] & 0xFFFF, image[1] & 0xFFFF))
    image = module.update(now_ns + 8000 * MS, Image((8192,)))
    assert status_names(image[0] & 0xFFFF, image[1] & 0xFFFF) == ["MOVE_COMPLETE", "MODULE_OK"]
    assert join_reported(image[2], image[3]) == -7500


def test_its_words_have_the_names_of_the_3601_in_a_trace():
    assert words_of("pmc006-adapter", {}) == words_of("amci3601", {})


def test_the_closing_summary_has_the_reason_of_a_refusal():
    tally = RunCounters()
    fields: dict[str, JsonValue] = {
        "slot": 1,
        "kind": "refusal",
        "name": "speed",
        "bits": ["COMMAND_ERROR"],
        "text": "too fast",
    }
    tally.event(7, 14_000_000, "/events", fields)
    assert [error.text for error in tally.errors.values()] == ["COMMAND_ERROR at scan 7: too fast [speed]"]
