"""`scanrack debug`: the debug adapter."""

from __future__ import annotations

import hmac
import os
import secrets
import sys
from contextlib import redirect_stdout
from typing import Annotated

import typer
from scanrack.terminal.status import BAD_INPUT, complain

KEY_BYTES = 16


def _debug_command(
    port: Annotated[
        int | None,
        typer.Option(
            "--port",
            metavar="PORT",
            help="Serve one client on this port; 0 = any free one. Prints port and key.",
            min=0,
            max=65535,
            show_default=False,
        ),
    ] = None,
) -> None:
    from .adapter import Adapter
    from .requests import REQUESTS
    from .wire import Wire

    if port is not None:
        raise typer.Exit(_serve_port(port))
    asked, told = os.dup(0), os.dup(1)
    with os.fdopen(asked, "rb") as requests, os.fdopen(told, "wb") as answers, redirect_stdout(sys.stderr):
        Adapter(Wire(requests, answers), REQUESTS).run()


def _serve_port(port: int) -> int:
    """Serve one client on a port; return the exit status."""
    from scanrack.terminal.terminal import say
    from scanrack.watch.gate import HOST, listen

    from .adapter import Adapter
    from .requests import REQUESTS
    from .wire import Wire

    key = secrets.token_hex(KEY_BYTES)
    try:
        listening = listen(port)
    except ValueError as error:
        return complain(str(error), BAD_INPUT)
    say(f"{HOST}:{listening.getsockname()[1]} key {key}")
    while True:
        connection, _address = listening.accept()
        stream = connection.makefile("rb")
        if hmac.compare_digest(stream.readline(200).strip(), f"key {key}".encode()):
            break
        stream.close()
        connection.close()
    with connection, stream, connection.makefile("wb") as answers, redirect_stdout(sys.stderr):
        Adapter(Wire(stream, answers), REQUESTS).run()
    return 0


_HELP = """Debug a rack or a trace in an editor, forwards and backwards.

The debug adapter speaks the Debug Adapter Protocol on standard input and output. An editor starts it. It
steps through rungs, structured text and charts, scan by scan. With --port a client
connects instead, and first sends a line with the printed key: key KEY.

Exit status: 0 the client ended the session, 2 the port can't be used."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("debug", help=_HELP)(_debug_command)
