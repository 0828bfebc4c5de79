"""The serial line in virtual time: when a character is complete, who hears it, in which order."""

from __future__ import annotations

import pytest
from scanrack.runtime import LineFormat, SerialBus


class Parrot:
    """Answers every "?" with its name after a while."""

    line_format = LineFormat(9600)

    def __init__(self, name, delay_ns=1_000_000):
        self.name, self.delay_ns = name, delay_ns
        self.next_wake_ns = None
        self.got = []

    def receive(self, now_ns, data):
        self.got.append((now_ns, data))
        if data == b"?":
            self.next_wake_ns = now_ns + self.delay_ns

    def advance(self, now_ns):
        if self.next_wake_ns is None or now_ns < self.next_wake_ns:
            return b""
        self.next_wake_ns = None
        return self.name


@pytest.mark.parametrize(
    ("line_format", "bits"),
    [
        (LineFormat(9600), 10),
        (LineFormat(38_400, "E"), 11),
        (LineFormat(38_400, "N", 2), 11),
        (LineFormat(300, "O", 2, 7), 11),
    ],
)
def test_bits_of_a_character(line_format, bits):
    assert line_format.bits == bits
    assert line_format.span_ns(960) == 960 * bits * 1_000_000_000 // line_format.baud


@pytest.mark.parametrize("wrong", [{"baud": 0}, {"parity": "M"}, {"stop_bits": 3}, {"data_bits": 9}])
def test_no_such_format(wrong):
    with pytest.raises(ValueError, match=r"must be|choose from"):
        LineFormat(**({"baud": 9600} | wrong))


def test_each_character_arrives_when_it_is_complete():
    bird = Parrot(b"x")
    bus = SerialBus(bird)
    assert bus.send(b"abc", LineFormat(1000)) == 30_000_000  # 10 bits at 1000 baud: 10 ms each
    bus.run_until(25_000_000)
    assert bird.got == [(10_000_000, b"a"), (20_000_000, b"b")]
    assert not bus.is_idle
    bus.run_until(100_000_000)
    assert bird.got[2:] == [(30_000_000, b"c")]
    assert (bus.now_ns, bus.quiet_since_ns, bus.is_idle) == (100_000_000, 30_000_000, True)


def test_gaps_between_characters():
    bird = Parrot(b"x")
    bus = SerialBus(bird)
    bus.send(b"ab", LineFormat(1000), gap_ns=5_000_000)
    bus.run_until(10**9)
    assert [when for when, _ in bird.got] == [10_000_000, 25_000_000]


def test_a_reply_is_heard_by_the_master_and_by_the_others():
    one, two = Parrot(b"1"), Parrot(b"22", 1_500_000)
    bus = SerialBus(one, two)
    bus.send(b"?", LineFormat(9600))
    bus.run_until(10**9)
    asked = 10 * 10**9 // 9600
    assert bus.take() == b"122"
    assert bus.take() == b""
    assert one.got[1:] == [
        (asked + 1_500_000 + asked, b"2"),
        (asked + 1_500_000 + 20 * 10**9 // 9600, b"2"),
    ]
    assert two.got[1:] == [(asked + 1_000_000 + asked, b"1")]


def test_a_sender_finishes_before_it_begins_again():
    bus = SerialBus()
    line_format = LineFormat(1000)
    bus.send(b"ab", line_format)
    assert bus.send(b"c", line_format) == 30_000_000


def test_in_pieces_or_at_once():
    def heard(instants):
        birds = Parrot(b"one"), Parrot(b"two", 3_000_000)
        bus = SerialBus(*birds)
        bus.send(b"a?b?", LineFormat(19_200, "E"))
        for instant in instants:
            bus.run_until(instant)
        return bus.take(), birds[0].got, birds[1].got

    assert heard([10**8]) == heard(range(0, 10**8 + 1, 10**5))
