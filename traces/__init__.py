"""The flight recorder: schema, recorder and reader of MCAP traces.

This package knows only `io_images`: the recorder receives the rack's memory block, and
the loop calls it with scans and events as a listener.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from .format import hooks

TYPE_CHECKING = False  # type checkers treat it as true

if TYPE_CHECKING:  # type checkers import these lines, `__getattr__` reads them
    from .format.layout import SlotInfo
    from .format.records import TraceError
    from .format.tagplan import Tag
    from .read.arrays import read_columns
    from .read.columns import Columns
    from .read.reader import Scan, Trace, TraceEvent, open_trace
    from .write.recorder import Attachment, ScanRecorder


def _imported(module: str, name: str) -> Callable[..., Any]:
    """Return a function that imports a function when it is called, and calls it."""
    return lambda *args: getattr(import_module(module, __name__), name)(*args)


hooks.to_pandas = _imported(".export.frames", "to_pandas")
hooks.to_polars = _imported(".export.frames", "to_polars")
hooks.read_columns = _imported(".read.arrays", "read_columns")
hooks.short_text = _imported(".read.notebook", "short_text")
hooks.as_html = _imported(".read.notebook", "as_html")


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
