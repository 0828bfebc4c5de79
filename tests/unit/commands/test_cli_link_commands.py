"""Moves that Ctrl-C or a line that fails breaks off: the motor is stopped, or may still be moving."""

from __future__ import annotations

import signal

import pytest
import typer
from faultyline import BusLink, Fault
from scanrack.commands import build
from scanrack.commands.wire import link_commands
from scanrack.commands.wire.link_commands import INTERRUPTED, shown_travel, stopped_by_interrupt
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.line.clients.link import LinkError
from scanrack.runtime.line.clients.pmc006 import Pmc006Client
from scanrack.runtime.line.clients.watching import MonitoringLostError
from typer.testing import CliRunner, Result

STOP_AND_LOOK = ["I", "j", "c"]


def test_ctrl_c_stops_the_motor_after_the_present_exchange(capsys: pytest.CaptureFixture[str]) -> None:
    controller = Pmc006Controller()
    link = BusLink(Pmc006(controller))
    client = Pmc006Client(link)
    handler = signal.getsignal(signal.SIGINT)

    def interrupted() -> None:
        with (
            stopped_by_interrupt(client.stop) as look,
            shown_travel(0, 50_000, look, quiet=True) as progress,
        ):

            def travel(position: int) -> None:
                if position > 5000:
                    signal.raise_signal(signal.SIGINT)
                progress(position)

            client.move(50_000, travel)

    with pytest.raises(typer.Exit) as ended:
        interrupted()
    assert ended.value.exit_code == INTERRUPTED
    assert [chr(question[2]) for question in link.questions[-3:]] == STOP_AND_LOOK
    assert not controller.axis.moving
    assert 5000 < controller.axis.position < 6000
    assert client.faults == 0
    assert "the motor was stopped" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGINT) is handler


def test_ctrl_c_before_the_move_keeps_it_from_starting() -> None:
    client = Pmc006Client(link := BusLink(Pmc006(Pmc006Controller())))

    def interrupted() -> None:
        with stopped_by_interrupt(client.stop) as look:
            signal.raise_signal(signal.SIGINT)
            with shown_travel(0, 50_000, look, quiet=True) as progress:
                client.move(50_000, progress)

    with pytest.raises(typer.Exit):
        interrupted()
    assert [chr(question[2]) for question in link.questions] == STOP_AND_LOOK


def test_ctrl_c_whose_stop_is_not_answered_says_that_the_motor_may_move_on() -> None:
    controller = Pmc006Controller()
    drop_all_from = 14
    client = Pmc006Client(
        BusLink(Pmc006(controller), dict.fromkeys(range(drop_all_from, 100), Fault.DROPPED))
    )
    client.start_move(100_000)

    def interrupted() -> None:
        with stopped_by_interrupt(client.stop) as look:
            while True:
                client.read("microstepping")
                if client._link.questions[drop_all_from - 1 :]:  # type: ignore[attr-defined]
                    signal.raise_signal(signal.SIGINT)
                look()

    with pytest.raises(
        MonitoringLostError, match="Ctrl-C; a stop was not confirmed: THE MOTOR MAY STILL BE MOVING"
    ):
        interrupted()
    assert controller.axis.moving


class CutLink(BusLink):
    """A line that is closed at the far end after so many questions."""

    lasts = 14

    def send(self, data: bytes) -> None:
        if len(self.questions) >= self.lasts:
            raise LinkError("the far end has closed the connection")
        super().send(data)


def moved_over(monkeypatch: pytest.MonkeyPatch, links: list[BusLink]) -> Result:
    """Return what a move prints; the links are what is opened, one after the other, then nothing can be."""

    def opened(*_: object) -> BusLink:
        if not links:
            raise LinkError("nothing listens there any more")
        return links.pop(0)

    monkeypatch.setattr(link_commands, "open_link", opened)
    monkeypatch.setattr(link_commands, "REOPEN_S", 0.001)
    return CliRunner().invoke(build(), ["device", "pmc006", "--serial", "x", "move", "100000"])


def test_a_connection_that_is_closed_during_a_move_is_opened_again_to_stop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    controller = Pmc006Controller()
    first = CutLink(device := Pmc006(controller))
    again = BusLink(device)
    again.bus.run_until(10_000_000_000)  # later than all that the first has said
    result = moved_over(monkeypatch, [first, again])
    assert result.stderr == "scanrack: the far end has closed the connection; the motor was stopped\n"
    assert result.exit_code == 1
    assert [chr(question[2]) for question in again.questions] == STOP_AND_LOOK
    assert not controller.axis.moving


def test_a_connection_that_stays_closed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    controller = Pmc006Controller()
    result = moved_over(monkeypatch, [CutLink(Pmc006(controller))])
    assert "closed the connection; a stop was not confirmed: THE MOTOR MAY STILL BE MOVING" in result.stderr
    assert (result.exit_code, controller.axis.moving) == (1, True)
