"""Answers that may be late: how many there are, and how a second one spoils the first."""

from __future__ import annotations

from scanrack.io_images.pmc006.frame import reply
from scanrack.runtime.line.master import LATE_NS, LineTiming, Master, Reply, Script
from scanrack.runtime.line.pmc006_frames import LINE_FORMAT, reading

MS = 1_000_000
PATIENCE_NS, SECOND_NS = 100 * MS, 20 * MS


class Asking(Master):
    """Asks for the status again and again, and keeps what it gets; the first answer does not come."""

    def __init__(self, second_ns: int = SECOND_NS) -> None:
        super().__init__(LineTiming(LINE_FORMAT, 0, PATIENCE_NS, second_ns))
        self.got: list[bytes | None] = []
        self.begin(self._asking())
        assert self.advance(0)
        assert self.advance(self.next_wake_ns)  # the patience is over, and the second question is sent

    def _asking(self) -> Script:
        while True:
            answer = yield reading(1, "read_status1")
            self.got.append(answer.data if isinstance(answer, Reply) else None)


def test_an_answer_that_has_not_come_is_overdue_for_a_second() -> None:
    master = Asking()
    failed_ns = master.now_ns
    assert (master.got, master.overdue) == ([None], 1)
    master.now_ns = failed_ns + LATE_NS - 1
    assert master.overdue == 1
    master.now_ns = failed_ns + LATE_NS
    assert master.overdue == 0


def test_an_answer_counts_when_no_second_one_has_followed() -> None:
    master = Asking()
    came_ns = master.now_ns + 17 * MS
    master.receive(came_ns, reply(1, 5))
    assert master.got == [None]
    master.advance(came_ns + SECOND_NS - 1)
    assert master.got == [None]
    master.advance(came_ns + SECOND_NS)
    assert master.got == [None, reply(1, 5)]


def test_of_two_answers_neither_counts() -> None:
    master = Asking()
    came_ns = master.now_ns + 9 * MS
    master.receive(came_ns, reply(1, 5))
    master.receive(came_ns + 9 * MS, reply(1, 7))
    master.advance(came_ns + SECOND_NS)
    assert master.got == [None, None]


def test_where_an_answer_says_what_it_answers_it_counts_at_once() -> None:
    master = Asking(second_ns=0)
    master.receive(master.now_ns + 17 * MS, reply(1, 5))
    assert master.got == [None, reply(1, 5)]


def test_a_controller_that_has_lost_what_it_was_asked_is_late_with_nothing() -> None:
    master = Asking()
    master.expect_nothing_late()
    master.receive(master.now_ns + 17 * MS, reply(1, 5))
    assert (master.overdue, master.got) == (0, [None, reply(1, 5)])
