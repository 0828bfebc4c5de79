"""A serial port that is unplugged in any call of its users, and threads that go on all the same."""

from __future__ import annotations

import errno
import termios
from collections.abc import Iterator
from contextlib import closing, contextmanager
from threading import Event
from threading import enumerate as running_threads

import pytest
import serial
from scanrack.io_images import Image
from scanrack.runtime import LineFormat
from scanrack.runtime.line.clients.link import LinkError, SerialLink
from scanrack.runtime.line.liveport import LiveLine
from scanrack.runtime.line.pcl601_frames import LINE_FORMAT
from scanrack.runtime.line.ports import PortError, PtyPort, SerialPort
from scanrack.runtime.modules.adapters.live import LiveAdapter
from scanrack.runtime.modules.adapters.pcl601.module import PCL601
from scanrack.runtime.modules.adapters.pcl601.pcl601_options import Pcl601Options

UNPLUGGED = termios.error(errno.EIO, "Input/output error")
"""What tcdrain and tcsetattr raise, by way of pyserial, and what is not an OSError."""

PATIENCE_S = 120
"""The longest that a test waits for another thread."""


class Unplugged(serial.Serial):
    """A serial port that raises `UNPLUGGED` in the calls that are named in `fails`."""

    fails: frozenset[str] = frozenset()

    def flush(self) -> None:
        self._fail("flush")
        super().flush()

    def apply_settings(self, settings: dict[str, object]) -> None:
        self._fail("apply_settings")
        super().apply_settings(settings)

    def _fail(self, call: str) -> None:
        if call in self.fails:
            raise UNPLUGGED


@pytest.fixture
def far_end() -> Iterator[PtyPort]:
    with closing(PtyPort()) as port:
        yield port


@pytest.fixture
def flaky(monkeypatch: pytest.MonkeyPatch) -> type[Unplugged]:
    """Ports that can be unplugged in the place of pyserial's."""

    class Flaky(Unplugged):
        pass

    monkeypatch.setattr(serial, "Serial", Flaky)
    return Flaky


@pytest.mark.parametrize(("call", "failing"), [("send", "flush"), ("follow", "apply_settings")])
def test_an_unplugged_port_is_a_link_error_that_says_why(
    far_end: PtyPort, flaky: type[Unplugged], call: str, failing: str
) -> None:
    with closing(SerialLink(far_end.name, LINE_FORMAT)) as link:
        flaky.fails = frozenset({failing})
        argument = b"x" if call == "send" else LineFormat(9600, "N")
        with pytest.raises(LinkError, match="Input/output error"):
            getattr(link, call)(argument)


def test_a_port_that_goes_while_it_is_opened_is_a_link_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def unplugged(*_: object, **__: object) -> None:
        raise UNPLUGGED

    monkeypatch.setattr(serial, "Serial", unplugged)
    with pytest.raises(LinkError, match="/dev/ttyX can't be opened: Input/output error"):
        SerialLink("/dev/ttyX", LINE_FORMAT)
    with pytest.raises(PortError, match="/dev/ttyX can't be opened: Input/output error"):
        SerialPort("/dev/ttyX", LINE_FORMAT)


def test_a_port_that_goes_while_it_is_set_is_closed(far_end: PtyPort, flaky: type[Unplugged]) -> None:
    flaky.fails = frozenset({"apply_settings"})
    with pytest.raises(PortError, match="Input/output error"):
        SerialPort(far_end.name, LINE_FORMAT)
    flaky.fails = frozenset()
    with closing(SerialPort(far_end.name, LINE_FORMAT)) as port:  # nobody has it any more
        assert port.is_open


@pytest.mark.parametrize(("call", "failing"), [("send", "flush"), ("follow", "apply_settings")])
def test_a_served_port_that_is_unplugged_is_lost_and_opened_again(
    far_end: PtyPort, flaky: type[Unplugged], call: str, failing: str
) -> None:
    with closing(SerialPort(far_end.name, LINE_FORMAT)) as port:
        flaky.fails = frozenset({failing})
        getattr(port, call)(b"x" if call == "send" else LineFormat(9600, "N"))
        assert (port.is_open, port.traffic.lost) == (False, 1)
        flaky.fails = frozenset()
        port.wait(0.0)
        assert port.is_open


# -- the live line -----------------------------------------------------------------------------------


class Wire:
    """A link whose calls raise what a test puts in `raises`, by the call's name."""

    def __init__(self) -> None:
        self.raises: dict[str, Exception] = {}
        self.sent: list[bytes] = []
        self.opened = self.closed = 0

    def open(self) -> Wire:
        self._raise("open")
        self.opened += 1
        return self

    def send(self, data: bytes) -> None:
        self._raise("send")
        self.sent.append(data)

    def receive(self, count: int, seconds: float) -> bytes:
        Event().wait(0.001)
        self._raise("receive")
        return b""

    def follow(self, line_format: LineFormat) -> None:
        self._raise("follow")

    def close(self) -> None:
        self.closed += 1
        self._raise("close")

    def pause(self, seconds: float) -> None: ...

    def _raise(self, call: str) -> None:
        if call in self.raises:
            raise self.raises[call]


@contextmanager
def line_over(wire: Wire, monkeypatch: pytest.MonkeyPatch) -> Iterator[LiveLine]:
    monkeypatch.setattr("scanrack.runtime.line.liveport.REOPEN_S", 0.001)
    with closing(LiveLine(wire.open)) as line:
        yield line
        wire.raises.clear()


def all_losses(line: LiveLine, count: int) -> list[str]:
    """Wait for so many losses, and return their reasons."""
    losses: list[str] = []
    for _ in range(round(PATIENCE_S / 0.002)):
        losses += line.take_losses()
        if len(losses) >= count:
            return losses
        Event().wait(0.002)
    raise AssertionError(f"{losses}, and not {count}")


def sends_again(line: LiveLine, wire: Wire) -> bool:
    """Send until it arrives: what is sent while the port is away is dropped."""
    for _ in range(round(PATIENCE_S / 0.01)):
        line.send(b"stop", LINE_FORMAT)
        Event().wait(0.01)
        if b"stop" in wire.sent:
            return True
    return False


@pytest.mark.parametrize("call", ["send", "follow", "receive"])
@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (LinkError("ttyX is gone: Input/output error"), "ttyX is gone: Input/output error"),
        (RuntimeError("a mistake of ours"), "RuntimeError: a mistake of ours"),
        (UNPLUGGED, "error: (5, 'Input/output error')"),
    ],
    ids=["link error", "mistake", "termios"],
)
def test_whatever_goes_wrong_loses_the_port_and_ends_no_thread(
    monkeypatch: pytest.MonkeyPatch, call: str, error: Exception, reason: str
) -> None:
    wire = Wire()
    with line_over(wire, monkeypatch) as line:
        wire.raises[call] = error
        line.send(b"lost", LINE_FORMAT)
        assert all_losses(line, 1)[0] == reason
        wire.raises.clear()
        assert sends_again(line, wire)
        assert wire.opened >= 2


def test_a_port_that_can_not_be_closed_or_opened_ends_no_thread_either(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wire = Wire()
    with line_over(wire, monkeypatch) as line:
        wire.raises = {"close": RuntimeError("won't close"), "open": RuntimeError("won't open")}
        wire.raises["receive"] = LinkError("gone")
        assert all_losses(line, 3) == ["gone", "RuntimeError: won't close", "RuntimeError: won't open"]
        wire.raises.clear()
        assert sends_again(line, wire)


def test_the_stop_at_the_end_is_sent_after_a_loss(monkeypatch: pytest.MonkeyPatch) -> None:
    """`close` sends what is still to be sent, and leaves no thread behind."""
    wire = Wire()
    before = set(running_threads())
    with line_over(wire, monkeypatch) as line:
        wire.raises["send"] = UNPLUGGED
        line.send(b"lost", LINE_FORMAT)
        all_losses(line, 1)
        wire.raises.clear()
        assert sends_again(line, wire)
        line.send(b"the last stop", LINE_FORMAT)
    assert wire.sent[-1] == b"the last stop"
    assert set(running_threads()) == before


def test_an_event_says_why_the_port_was_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    wire = Wire()
    monkeypatch.setattr("scanrack.runtime.line.liveport.REOPEN_S", 0.001)
    with closing(LiveAdapter(LiveLine(wire.open), PCL601, Pcl601Options.of({}), 1)) as module:
        wire.raises["send"] = UNPLUGGED
        for scan in range(round(PATIENCE_S / 0.002)):
            Event().wait(0.002)
            module.update(scan * 2_000_000, Image())
            events = [event for event in module.events if event.kind == "adapter"]
            if events:
                break
        wire.raises.clear()
    event = events[0]
    assert event.name == "port lost"
    assert event.text == "error: (5, 'Input/output error'); the port is reopened when it is back"
