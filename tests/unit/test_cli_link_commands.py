"""Ctrl-C during a move on a controller: the exchange is finished, then the motor is stopped."""

from __future__ import annotations

import signal

import pytest
import typer
from faultyline import BusLink
from scanrack.runtime.cli.link_commands import INTERRUPTED, shown_travel, stopped_by_interrupt
from scanrack.runtime.clients.pmc006 import Pmc006Client
from scanrack.runtime.pmc006.controller import Controller
from scanrack.runtime.pmc006.line import Pmc006


def test_ctrl_c_stops_the_motor_after_the_present_exchange(capsys: pytest.CaptureFixture[str]) -> None:
    controller = Controller()
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
    assert link.questions[-1][2] == ord("I")
    assert not controller.axis.moving
    assert 5000 < controller.axis.position < 6000
    assert client.faults == 0
    assert "the motor was stopped" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGINT) is handler


def test_ctrl_c_before_the_move_keeps_it_from_starting() -> None:
    client = Pmc006Client(link := BusLink(Pmc006(Controller())))

    def interrupted() -> None:
        with stopped_by_interrupt(client.stop) as look:
            signal.raise_signal(signal.SIGINT)
            with shown_travel(0, 50_000, look, quiet=True) as progress:
                client.move(50_000, progress)

    with pytest.raises(typer.Exit):
        interrupted()
    assert [question[2] for question in link.questions] == [ord("I")]
