"""`scanrack debug`: run the debug adapter."""

from __future__ import annotations

import hmac
import os
import secrets
import socket
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack, redirect_stdout, suppress
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer
from scanrack.terminal.status import BAD_INPUT, complain

if TYPE_CHECKING:
    from .wire import Wire

KEY_BYTES = 16
CHUNK = 1 << 16


def _debug_command(  # its help is `_HELP`
    port: Annotated[
        int | None,
        typer.Option(
            "--port",
            metavar="PORT",
            help="Serve one client on this port (0 = any free port); print port and key.",
            min=0,
            max=65535,
            show_default=False,
        ),
    ] = None,
    connect: Annotated[
        int | None,
        typer.Option(
            "--connect",
            metavar="PORT",
            help="Connect to the adapter of a test, see pytest --scanrack-debug.",
            min=1,
            max=65535,
            show_default=False,
        ),
    ] = None,
    key: Annotated[
        str, typer.Option("--key", metavar="KEY", help="Key of the test.", show_default=False)
    ] = "",
) -> None:
    from .adapter import Adapter
    from .requests import REQUESTS
    from .wire import Wire

    if connect is not None:
        raise typer.Exit(_relay(connect, key))
    if port is not None:
        raise typer.Exit(_serve_port(port))
    # what the program prints must not come between the messages on standard output
    stdin_fd, stdout_fd = os.dup(0), os.dup(1)
    with (
        os.fdopen(stdin_fd, "rb") as requests,
        os.fdopen(stdout_fd, "wb") as responses,
        redirect_stdout(sys.stderr),
    ):
        Adapter(Wire(requests, responses), REQUESTS).run()


def _serve_port(port: int) -> int:
    """Serve one client on a port; return the exit status."""
    from scanrack.terminal.terminal import say
    from scanrack.watch.gate import HOST, listen

    from .adapter import Adapter
    from .requests import REQUESTS

    key = key_line()
    with ExitStack() as stack:
        try:
            listening = stack.enter_context(listen(port))
        except ValueError as error:
            return complain(str(error), BAD_INPUT)
        say(f"{HOST}:{listening.getsockname()[1]} {key}")
        wire = client_of(listening, key, stack)
        with redirect_stdout(sys.stderr):
            Adapter(wire, REQUESTS).run()
    return 0


def key_line() -> str:
    """Return a new key, which is a line that a client must send first."""
    return f"key {secrets.token_hex(KEY_BYTES)}"


def client_of(listening: socket.socket, key: str, stack: ExitStack, wait_s: float | None = None) -> Wire:
    """Return the connection to the first client that sends the key.

    Args:
        stack: the stack that closes the connection.
        wait_s: longest wait for each client, s; None means no limit.

    Raises:
        TimeoutError: no client has connected in time.
    """
    from .wire import Wire

    listening.settimeout(wait_s)
    while True:
        connection, _address = listening.accept()
        connection.settimeout(wait_s)
        stream = connection.makefile("rb")
        if hmac.compare_digest(stream.readline(200).strip(), key.encode()):
            break
        stream.close()
        connection.close()
    connection.settimeout(None)
    responses = connection.makefile("wb")
    for resource in (connection, stream, responses):
        stack.enter_context(resource)
    stack.callback(_shut, connection)  # ends the reading thread, for which closing the stream waits
    return Wire(stream, responses)


def _shut(connection: socket.socket, how: int = socket.SHUT_RDWR) -> None:
    with suppress(OSError):  # the other side has disconnected
        connection.shutdown(how)


def _relay(port: int, key: str) -> int:
    """Connect a client on standard input and output to an adapter on a port; return the exit status."""
    from scanrack.watch.gate import HOST

    with socket.create_connection((HOST, port)) as connection:
        connection.sendall(f"key {key}\n".encode())
        threading.Thread(target=_send_input, args=(connection,), daemon=True).start()
        _copy_stream(connection.recv, _write_output)
    return 0


def _send_input(connection: socket.socket) -> None:
    _copy_stream(partial(os.read, sys.stdin.fileno()), connection.sendall)
    _shut(connection, socket.SHUT_WR)


def _write_output(data: bytes) -> None:
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()


def _copy_stream(read: Callable[[int], bytes], write: Callable[[bytes], object]) -> None:
    """Copy bytes until the stream ends."""
    with suppress(OSError):
        while data := read(CHUNK):
            write(data)


_HELP = """Debug a rack or a trace in an editor, forwards and backwards.

The debug adapter speaks the Debug Adapter Protocol on standard input and output. An editor starts it. It
steps through rungs, structured text, charts, sequences, Python and lists of steps, scan by scan.
With --port a client connects to a port. Its first line is the printed key: key KEY.

Examples:
    scanrack debug --port 0

Exit status: 0 the client ended the session, 2 the port can't be used."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("debug", help=_HELP)(_debug_command)
