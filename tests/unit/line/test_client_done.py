"""What says done has seen it: controllers that answer and do nothing, and answers that come late."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from faultyline import BusLink, Fault, FaultyDevice
from scanrack.commands import build
from scanrack.commands.wire import link_commands
from scanrack.io_images.pcl601 import Code, Error, Register
from scanrack.io_images.pmc006.status import Status1
from scanrack.runtime import Contact
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.line.clients.link import LinkError, RefusedError, StoppedError, UnconfirmedMotionError
from scanrack.runtime.line.clients.modbus import RtuLine
from scanrack.runtime.line.clients.pcl601 import Pcl601Client
from scanrack.runtime.line.clients.pmc006 import Pmc006Client
from typer.testing import CliRunner

MS = 1_000_000


def pcl601_client(device: Pcl601) -> Pcl601Client:
    return Pcl601Client(RtuLine(BusLink(device)))


def idle_pcl601() -> Pcl601:
    """Return a controller that answers commands and outputs, and does nothing."""
    device = Pcl601()
    device.controller.do = lambda code: True  # type: ignore[method-assign]
    device.controller.set_outputs = lambda outputs, mask=0xFF: True  # type: ignore[method-assign]
    return device


def idle_pmc006(but_for: str = "") -> Pmc006Controller:
    """Return a controller that answers actions and speed mode, and does nothing but some of them."""
    controller = Pmc006Controller()
    execute = controller.execute
    idle = {ord(char) for char in "8INbls"} - {ord(char) for char in but_for}
    controller.execute = lambda code, data: 0 if code in idle else execute(code, data)  # type: ignore[method-assign]
    return controller


NO_MOTION = "was answered, but no motion was seen: the position is still 0"
PCL601_DEEDS: dict[str, tuple[Callable[[Pcl601Client], object], type[LinkError], str]] = {
    "home": (lambda client: client.home(1), UnconfirmedMotionError, f"HOME_TYPE_1 {NO_MOTION}"),
    "move": (lambda client: client.move(100), UnconfirmedMotionError, f"GO {NO_MOTION}"),
    "start_move": (lambda client: client.start_move(-5), UnconfirmedMotionError, f"GO {NO_MOTION}"),
    "command": (lambda client: client.command(Code.GO_SLEW), UnconfirmedMotionError, f"GO_SLEW {NO_MOTION}"),
    "set_output": (
        lambda client: client.set_output(3, True),
        RefusedError,
        "output 3 was switched on, but reads off",
    ),
    "clear": (
        lambda client: client.clear(),
        RefusedError,
        "the errors were cleared, but are still set; MODE: ",
    ),
}
PMC006_DEEDS: dict[str, tuple[Callable[[Pmc006Client], object], type[LinkError], str]] = {
    "home": (lambda client: client.home(500), StoppedError, "zero-back ended at 0 without the switch"),
    "move": (lambda client: client.move(100), UnconfirmedMotionError, f"step {NO_MOTION}"),
    "start_move": (lambda client: client.start_move(-5), UnconfirmedMotionError, f"step {NO_MOTION}"),
    "run": (lambda client: client.run(), UnconfirmedMotionError, f"speed_mode {NO_MOTION}"),
}
ELSEWHERE = {"set", "stop"}
"""Tested below, and `set`, which reads back, in `test_client_pcl601` and `test_client_pmc006`."""

UNSEEN = {"do", "save"}
"""Nothing that can be read shows whether a PMC006 has carried them out."""

PARTS = {"begin", "check_end", "check_errors", "halt", "look", "pause", "read", "reasons", "wait", "watch"}


@pytest.mark.parametrize("name", PCL601_DEEDS)
def test_an_answer_alone_is_no_deed_of_a_pcl601(name: str) -> None:
    deed, error, said = PCL601_DEEDS[name]
    device = idle_pcl601()
    device.controller.errors = Error.MODE if name == "clear" else Error(0)
    with pytest.raises(error, match=said):
        deed(pcl601_client(device))


@pytest.mark.parametrize("name", PMC006_DEEDS)
def test_an_answer_alone_is_no_deed_of_a_pmc006(name: str) -> None:
    deed, error, said = PMC006_DEEDS[name]
    with pytest.raises(error, match=said):
        deed(Pmc006Client(BusLink(Pmc006(idle_pmc006()))))


def test_every_deed_of_a_client_is_tested() -> None:
    """What a client gains later has to be put into a table above, or to be shown to read only."""
    for client, deeds in (
        (Pcl601Client, PCL601_DEEDS),
        (Pmc006Client, {*PMC006_DEEDS, "clear", "slow_down"}),
    ):
        methods = {name for name in dir(client) if callable(getattr(client, name)) and name[0] != "_"}
        assert methods == set(deeds) | ELSEWHERE | PARTS | (UNSEEN if client is Pmc006Client else set())


def test_a_stop_counts_when_the_motor_was_seen_to_stand() -> None:
    device = Pcl601()
    client = pcl601_client(device)
    client.start_move(100_000)
    device.controller.do = lambda code: True  # type: ignore[method-assign]
    with pytest.raises(RefusedError, match="the stop was answered, but the motor still moves"):
        client.stop()
    controller = idle_pmc006(but_for="sN")
    turning = Pmc006Client(BusLink(Pmc006(controller)))
    turning.run()
    with pytest.raises(RefusedError, match="the stop was answered, but the motor still moves"):
        turning.stop()


def test_speed_mode_is_left_when_the_status_says_so() -> None:
    controller = Pmc006Controller()
    client = Pmc006Client(BusLink(Pmc006(controller)))
    client.run()
    execute = controller.execute
    controller.execute = lambda code, data: 0 if code == ord("N") else execute(code, data)  # type: ignore[method-assign]
    with pytest.raises(RefusedError, match="the motor is still in speed mode"):
        client.slow_down()


def test_emergency_stops_are_cleared_when_the_status_says_so() -> None:
    controller = idle_pmc006()
    controller.axis.flags = Status1.EXT1 | Status1.EXT2
    client = Pmc006Client(BusLink(Pmc006(controller)))
    with pytest.raises(RefusedError, match="were cleared, but are still set: EXT1, EXT2"):
        client.clear()


def test_the_command_says_what_was_not_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_commands, "open_link", lambda *_: BusLink(idle_pcl601()))
    result = CliRunner().invoke(build(), ["device", "pcl601", "--serial", "x", "home"])
    assert (result.exit_code, result.output) == (1, f"scanrack: HOME_TYPE_1 {NO_MOTION}\n")


def test_an_error_on_the_way_is_no_success() -> None:
    device = Pcl601()
    device.controller.errors = Error.MODE
    client = pcl601_client(device)

    def trouble(position: int) -> None:
        if position > 100:
            device.controller.report(Error.TRANSMIT)

    with pytest.raises(StoppedError, match="the move ended at 700 with an error; TRANSMIT: "):
        client.move(700, trouble)


def test_a_search_for_home_that_ends_with_an_error_has_not_found_it() -> None:
    device = Pcl601()
    device.controller.pins.connect("home", Contact(low=300))

    def trouble(position: int) -> None:
        device.controller.report(Error.MODE)

    with pytest.raises(StoppedError, match="the search for home ended at 300 with an error; MODE: "):
        pcl601_client(device).home(0, trouble)


LATE_MS = (522, 543, 585, 606, 627, 697)
"""Times after which an answer comes that counts as missing after 200, and is waited for up to 500."""


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["PCL601", "PMC006"])
def test_an_answer_that_is_older_than_its_question_never_counts_as_rest(
    controller: str, request: pytest.FixtureRequest
) -> None:
    """One answer comes late, and the ones after it in time: whichever it is, the move ends at its target."""
    thorough = request.config.getoption("--long")
    for late in range(22) if thorough else (0, 1, 2, 5):
        for delay_ms in range(480, 760, 3) if thorough else LATE_MS:
            plan = {late: Fault.DELAYED}
            if controller == "PCL601":
                device = Pcl601()
                device.controller.values[Register.ACCEL] = 50_000
                line = BusLink(FaultyDevice(device, plan, delay_ms * MS))
                assert Pcl601Client(RtuLine(line)).move(2500) == 2500, (late, delay_ms)
                assert not device.controller.busy
            else:
                turned = Pmc006Controller()
                link = BusLink(FaultyDevice(Pmc006(turned), plan, delay_ms * MS))
                assert Pmc006Client(link).move(2500) == 2500, (late, delay_ms)
                assert not turned.axis.moving
