"""Progress bars on standard error, drawn by rich."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from rich.console import Console
from rich.progress import Progress, ProgressColumn


@contextmanager
def shown_bar(
    *columns: ProgressColumn,
    quiet: bool,
    total: Callable[[], float | None] = lambda: None,
    transient: bool = True,
    **fields: Any,
) -> Iterator[Callable[..., None]]:
    """Show a bar if standard error is a terminal; yield a function that updates it, see `Progress.update`.

    Args:
        total: returns the value at the end of the bar; None if it is unknown. It is not called without a bar.
        transient: whether the bar disappears at the end.
        fields: initial values of the fields that the columns show.
    """
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield lambda **_: None
        return
    with Progress(*columns, console=console, transient=transient) as bar:
        yield partial(bar.update, bar.add_task("", total=total(), **fields))
