"""`scanrack editor lsp`: the language server on standard input and output."""

from __future__ import annotations

from importlib.util import find_spec

import typer
from scanrack.io_images.installing import how_to_install
from scanrack.terminal.status import BAD_INPUT, complain


def lsp_command() -> None:
    """Serve an editor by LSP.

    The language server speaks on standard input and output.

    It marks the findings of `scanrack check` in unsaved .rung, .st, .steps, .py and rack files. It explains
    and completes instructions, tags and keys, and finds declarations. A check runs Python only if the editor
    trusts the folder. The server needs the extra `editor`; `scanrack doctor` prints how to install it.

    Exit status: 0 the editor has ended it; 2 the extra is missing.
    """
    if find_spec("pygls") is None:
        text = f"the language server needs the extra editor: {how_to_install('editor')}"
        raise typer.Exit(complain(text, BAD_INPUT))
    from .server import serve

    serve()
