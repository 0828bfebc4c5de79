"""Shared parts of the device commands: options, line faults, and the progress of a move."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import Annotated, Any, Protocol, TypeVar

import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn
from scanrack.jobs.serve.line import socket_address
from scanrack.runtime.line.clients.link import (
    ANSWER_RANGE_S,
    ANSWER_S,
    Link,
    LinkError,
    Progress,
    SerialLink,
    TcpLink,
)
from scanrack.runtime.line.clients.watching import MonitoringLostError, try_to_stop
from scanrack.runtime.line.ports import Stop
from scanrack.runtime.line.wire import LineFormat
from scanrack.runtime.loop.pace import interrupted_by, stopping_on_interrupt
from scanrack.terminal.bars import shown_bar
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.shared_options import QuietOption
from scanrack.terminal.status import INTERRUPTED, NO, complain
from scanrack.terminal.tables import Cells
from scanrack.terminal.terminal import say

PortOption = Annotated[
    str | None, typer.Option("--serial", metavar="DEVICE", help="Serial port, such as /dev/ttyUSB0 or COM3.")
]
NameArgument = Annotated[str, typer.Argument(metavar="NAME", show_default=False)]
ValueArgument = Annotated[int, typer.Argument(metavar="VALUE", show_default=False)]
StepsArgument = Annotated[int, typer.Argument(metavar="STEPS", show_default=False)]
ProgramArgument = Annotated[Path, typer.Argument(metavar="FILE", help="The program.", show_default=False)]
SpeedOption = Annotated[
    int | None, typer.Option("--speed", metavar="V", help="Maximum speed, steps/s. [default: unchanged]")
]

TimeoutOption = Annotated[
    float,
    typer.Option(
        "--timeout",
        metavar="SECONDS",
        help=f"Maximum time of a response, {ANSWER_RANGE_S[0]:g} to {ANSWER_RANGE_S[1]:g}.",
    ),
]
TIMEOUT_S = ANSWER_S
"""Default of --timeout."""

REOPENINGS = 6
"""Number of attempts to reopen a lost line in order to stop the motor."""

REOPEN_S = 0.5
"""Time between two attempts, s."""


class Mover(Protocol):
    """A client of a controller that can move an axis."""

    @property
    def position(self) -> int:
        """Position, steps."""

    def move(self, steps: int, progress: Progress) -> int:
        """Move by a signed number of steps and wait for the end; return the position."""

    def stop(self) -> None:
        """Stop at once."""


@dataclass(frozen=True, slots=True)
class LinkPlace:
    """The address of a controller, from the options that precede the command."""

    port: str | None  # serial port, or None
    tcp: str | None  # HOST:PORT, or None
    address: int  # of the controller on its line
    answer_s: float  # maximum time of a response, s

    def open(self, line_format: LineFormat) -> Link:
        """Open the line; see `open_link`."""
        return open_link(self.port, self.tcp, line_format)


class OpenLine(Protocol):
    """An open line."""

    def close(self) -> None:
        """Release the line."""


Line = TypeVar("Line", bound=OpenLine)
Client = TypeVar("Client", bound=Mover)


def open_link(port: str | None, tcp: str | None, line_format: LineFormat) -> Link:
    """Open the line named by --serial or --tcp.

    Raises:
        ValueError: not exactly one line is named.
        LinkError: the line can't be opened.
    """
    if port is not None and tcp is None:
        return SerialLink(port, line_format)
    if tcp is not None and port is None:
        return TcpLink(*socket_address(tcp))
    raise ValueError("give one of --serial DEVICE and --tcp HOST:PORT before the command")


@contextmanager
def opened_client(open_line: Callable[[], Line], client_on: Callable[[Line], Client]) -> Iterator[Client]:
    """Open the line to a controller and yield its client; report a line fault and end the command.

    If the line is lost while the motor is moving, it is reopened to stop the motor.

    Args:
        open_line: opens the line.
        client_on: makes the client for a line.
    """
    with reported_faults():
        try:
            with closing(open_line()) as line:
                yield client_on(line)
        except MonitoringLostError as lost:
            if lost.stopped or not _stopped_again(lambda: _stop_once(open_line, client_on)):
                raise
            raise MonitoringLostError(lost.why, stopped=True, received=lost.received) from lost


def _stop_once(open_line: Callable[[], Line], client_on: Callable[[Line], Mover]) -> None:
    with closing(open_line()) as line:
        client_on(line).stop()


def _stopped_again(stop: Callable[[], None]) -> bool:
    """Try to stop the motor over a new line until the controller responds; return whether it did."""
    for _ in range(REOPENINGS):
        if try_to_stop(stop):
            return True
        Event().wait(REOPEN_S)
    return False


def show_state(rows: Iterable[tuple[str, str]]) -> None:
    """Print names and values, one pair per line."""
    table = Cells(box=None, show_header=False, pad_edge=False)
    for name, value in rows:
        table.add_row(name, value)
    Console().print(table)


def travel(client: Mover, steps: int, *, quiet: bool) -> None:
    """Move by a signed number of steps, show progress, and print the position; Ctrl-C stops the motor.

    Raises:
        ValueError: the number of steps is not allowed.
        LinkError: the move failed.
    """
    start = client.position
    with (
        stopped_by_interrupt(client.stop) as look,
        shown_travel(start, start + steps, look, quiet=quiet) as progress,
    ):
        position = client.move(steps, progress)
    say(position)


ClientAt = Callable[[typer.Context], AbstractContextManager[Client]]
"""A function that opens the line named by the options of a controller's group."""


def add_read(app: typer.Typer, client_at: ClientAt[Any], summary: str) -> None:
    """Add the command that prints a value by name."""

    @app.command(help=summary)
    def read(context: typer.Context, name: NameArgument) -> None:
        with client_at(context) as client:
            say(client.firmware if name == "firmware" else client.read(name))


def add_move(app: typer.Typer, client_at: ClientAt[Any], example: str) -> None:
    """Add the command that moves."""
    summary = "Move by STEPS and wait for the end; put -- before a negative number."

    @app.command(help=f"{summary}\n\nCtrl-C stops the motor at once.\n\nExamples:\n    {example}")
    def move(
        context: typer.Context, steps: StepsArgument, speed: SpeedOption = None, quiet: QuietOption = False
    ) -> None:
        with client_at(context) as client:
            if speed is not None:
                client.set("max_speed", speed)
            travel(client, steps, quiet=quiet)


def add_stop_and_clear(
    app: typer.Typer, client_at: ClientAt[Any], stop_summary: str, clear_summary: str
) -> None:
    """Add the commands that stop the motor, and clear its errors."""

    @app.command(help=stop_summary)
    def stop(context: typer.Context) -> None:
        with client_at(context) as client:
            client.stop()

    @app.command(help=clear_summary)
    def clear(context: typer.Context) -> None:
        with client_at(context) as client:
            client.clear()


def add_write(app: typer.Typer, count: Callable[[Path], int], unwritten: str) -> None:
    """Add the command that checks a stored program and prints why it does not write the program.

    Args:
        count: reads a program and returns the number of its instructions.
        unwritten: the reason that is printed.
    """

    @app.command(help="Check a program; writing it into a controller is not documented.")
    def write(file: ProgramArgument) -> None:
        with reported_faults():
            raise ValueError(f"{file}: valid, {count(file)} instructions; {unwritten}")


def search_home(client: Mover, find: Callable[[Progress], int], *, quiet: bool) -> None:
    """Find home, show progress, and print the position; Ctrl-C stops the motor."""
    with stopped_by_interrupt(client.stop) as look:
        with shown_travel(client.position, None, look, quiet=quiet) as progress:
            position = find(progress)
        say(position)


@contextmanager
def reported_faults() -> Iterator[None]:
    """Report a user error or a line fault, and end the command."""
    with reported_mistakes():
        try:
            yield
        except LinkError as error:
            raise typer.Exit(complain(str(error), NO)) from None


@contextmanager
def stopped_by_interrupt(stop: Callable[[], None]) -> Iterator[Callable[[], None]]:
    """Stop the motor on Ctrl-C and report it; yield a function that checks for Ctrl-C.

    An exchange in progress is completed first, because a stop can be sent only on a silent line.

    Raises:
        MonitoringLostError: the controller did not respond to the stop.
    """
    interrupt = Stop()

    def look() -> None:
        if interrupt.requested:
            raise KeyboardInterrupt

    try:
        with stopping_on_interrupt(interrupt.request, look.__code__):
            yield look
    except KeyboardInterrupt:
        if not try_to_stop(stop):
            raise MonitoringLostError(interrupted_by(), stopped=False) from None
        raise typer.Exit(complain(f"{interrupted_by()}: the motor was stopped", INTERRUPTED)) from None


@contextmanager
def shown_travel(
    start: int, target: int | None, on_position: Callable[[], None], *, quiet: bool
) -> Iterator[Progress]:
    """Show the progress of a motion on a terminal; yield a function that reports a position.

    Args:
        target: expected end position, steps; None if it is unknown.
        on_position: function called at every position, and once before the first position.
    """
    on_position()
    columns = TextColumn("position"), BarColumn(), TextColumn("{task.fields[position]:,}")
    total = None if target is None else abs(target - start)
    with shown_bar(*columns, quiet=quiet, total=lambda: total, transient=False, position=start) as update:

        def report(position: int) -> None:
            update(completed=abs(position - start), position=position)
            on_position()

        yield report
