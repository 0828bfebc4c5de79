"""The flight recorder: schema, recorder and reader of MCAP traces.

This package imports only `io_images`: the recorder receives the rack's memory block, and is a listener of
the scan loop, which calls it with scans and events.
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


def _lazy(module: str, name: str) -> Callable[..., Any]:
    """Return a function that imports the named function at each call, and calls it."""
    return lambda *args: getattr(import_module(module, __name__), name)(*args)


hooks.to_pandas = _lazy(".export.frames", "to_pandas")
hooks.to_polars = _lazy(".export.frames", "to_polars")
hooks.read_columns = _lazy(".read.arrays", "read_columns")
hooks.short_text = _lazy(".read.notebook", "short_text")
hooks.as_html = _lazy(".read.notebook", "as_html")


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
