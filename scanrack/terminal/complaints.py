"""Messages of commands that fail: one line on standard error, and an exit status of `terminal.status`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import typer
from scanrack.traces.format.records import TraceLimitError

from .status import BAD_INPUT, CANNOT_WRITE, complain, reason

RAISED_BY = {"chunk_bytes": "--max-chunk", "records": "--max-records"}
"""The option that raises each of the limits for reading traces, see traces.limits."""


@contextmanager
def reported_mistakes() -> Iterator[None]:
    """Report a user error or a disk error, and end the command."""
    try:
        yield
    except TraceLimitError as error:
        text = f"{error}; 'scanrack {RAISED_BY[error.limit]} N COMMAND ...' raises the limit"
        raise typer.Exit(complain(text, BAD_INPUT)) from error
    except (ValueError, ImportError) as error:
        raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    except OSError as error:
        raise typer.Exit(complain(reason(error), CANNOT_WRITE)) from error
