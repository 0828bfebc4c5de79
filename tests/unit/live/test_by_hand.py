"""A person at a panel ends the card's timeline; the page draws positions on the shaft's scale."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from live_sessions import FEEDER, LiveSession
from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.amci3601.words import WORDS_3601
from scanrack.io_images.image import Image, signed_word
from scanrack.io_images.thousands import split_reported
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.traces import open_trace, read_columns
from scanrack.watch.history.watched_machines import MachineFigures

PANEL = FEEDER.parents[1] / "three_stations_panel" / "line.toml"
MOVING = StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW
START = {"do": "press", "slot": 2, "name": "start"}


def start_levels(path: Path) -> list[int]:
    with open_trace(path) as trace:
        words = read_columns(trace).words
    return (words[:, 16 + 8] & 1).tolist()  # input word 0 of slot 2


def test_a_button_pressed_by_hand_stays_pressed_until_it_is_released_by_hand(tmp_path):
    """The rack file presses start from 0.5 s to 0.7 s: scans 250 to 350."""
    path = tmp_path / "live.mcap"
    session = LiveSession([(0, {**START, "on": True}), (400, {**START, "on": False})], path, PANEL).play(500)
    pressed, released = (each["scan"] for each in session.answers)
    assert start_levels(path) == [0] * pressed + [1] * (released - pressed) + [0] * (500 - released)
    assert (pressed, released) == (1, 401)


def test_the_other_buttons_of_the_panel_are_the_person_s_too(tmp_path):
    """The rack file presses stop at 9 s: scan 4,500."""
    path = tmp_path / "live.mcap"
    LiveSession([(0, {**START, "on": True})], path, PANEL).play(4600)
    with open_trace(path) as trace:
        stop = read_columns(trace).words[:, 16 + 8] >> 1 & 1
        events = [event.fields["text"] for event in trace.events(topics={"/orders"})]
    assert stop.all()  # normally closed
    assert events == ["Slot 2: the start input is energized. The timeline of slot 2 ends."]


def test_without_a_person_the_timeline_presses(tmp_path):
    path = tmp_path / "live.mcap"
    LiveSession((), path, PANEL).play(500)
    assert start_levels(path) == [0] * 250 + [1] * 100 + [0] * 150


class Reader(QuietListener):
    """Reads the figures every 20 scans: whether the axis rests, shaft, zero, position."""

    def __init__(self, rack):
        self.figures, self.inputs, self.seen = MachineFigures(rack), rack.slots[1].inputs, []

    def scan(self, scan, now_ns, flags):
        if scan % 20 == 0 and self.inputs[0] >= 0:
            shaft, _, _, zero = self.figures.read(now_ns)
            position = self.inputs[2] * 1000 + self.inputs[3]
            self.seen.append((not self.inputs[0] & MOVING, shaft, zero, position))


def test_the_position_lies_on_the_shaft_after_homing():
    """Home is at -1,300 of the shaft; the stations are at 0, 4,000 and 8,000 of the module."""
    session = LiveSession((), None, PANEL)
    reader = Reader(session.run.rack)
    session.run.cpu.add_listener(reader)
    session.play(4400)
    at_rest = {(shaft, zero, position) for resting, shaft, zero, position in reader.seen if resting}
    assert at_rest == {(0, 0, 0), (-1300, -1300, 0), (2700, -1300, 4000), (6700, -1300, 8000)}


class Stepper:
    """A stepper whose shaft and image the test sets."""

    shaft = 0
    inputs = Image()

    def figures(self):
        return self.shaft, 0, 0

    def stand(self, shaft, position, bits=0):
        self.shaft = shaft
        self.inputs.load(Image([bits, 0, *split_reported(position)]))


def test_lost_steps_stay_visible_and_a_preset_moves_the_zero():
    stepper = Stepper()
    rack: Any = SimpleNamespace(slots={1: stepper_slot(stepper)})
    figures = MachineFigures(rack)
    zeros = []
    for shaft, position, bits in (
        (0, 0, StatusMsw.POSITION_INVALID),
        (0, 0, 0),
        (400, 400, StatusMsw.MOVING_CW),
        (700, 750, StatusMsw.MOVING_CW),  # 50 steps are lost
        (950, 1000, StatusMsw.MOVE_COMPLETE),
        (950, 5000, StatusMsw.MOVE_COMPLETE),  # Preset Position
        (950, 6000, signed_word(StatusMsw.MODE_CONFIG)),  # a mirror, no position
    ):
        stepper.stand(shaft, position, bits)
        zeros.append(figures.read(0)[3])
    assert zeros == [0, 0, 0, 0, 0, 950 - 5000, 950 - 5000]


def stepper_slot(stepper):
    return SimpleNamespace(number=1, module=stepper, inputs=stepper.inputs, words=WORDS_3601)
