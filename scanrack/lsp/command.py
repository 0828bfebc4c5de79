"""`scanrack editor lsp`: the language server on standard input and output."""

from __future__ import annotations

from importlib.util import find_spec

import typer
from scanrack.io_images.installing import how_to_install
from scanrack.terminal.status import BAD_INPUT, complain


def lsp_command() -> None:
    """Serve an editor by LSP.

    The language server speaks on standard input and output.

    It marks what `scanrack check` finds in unsaved .rung, .st, .steps and rack files and programs in Python,
    explains instructions, tags and keys, completes them, and finds declarations. It needs the extra
    `editor`: `scanrack doctor` says how to install it. A module in Python is run for a check only where the
    editor says that its folder is trusted.

    Exit status: 0 the editor has ended it; 2 the extra is missing.
    """
    if find_spec("pygls") is None:
        text = f"the language server needs the extra editor: {how_to_install('editor')}"
        raise typer.Exit(complain(text, BAD_INPUT))
    from .server import serve

    serve()
