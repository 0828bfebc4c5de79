"""The flight recorder: schema, recorder and reader of MCAP traces.

This package knows only `io_images`: the recorder receives the rack's memory block, and
the loop calls it with scans and events as a listener.
"""

from __future__ import annotations

from collections.abc import Sequence

from .format import hooks

TYPE_CHECKING = False  # type checkers treat it as true

if TYPE_CHECKING:  # type checkers import these lines, `__getattr__` reads them
    import pandas
    import polars

    from .format.layout import SlotInfo
    from .format.records import TraceError
    from .format.tagplan import Tag
    from .read.arrays import read_columns
    from .read.columns import Columns
    from .read.reader import Scan, Trace, TraceEvent, open_trace
    from .write.recorder import Attachment, ScanRecorder


def _to_pandas(trace: Trace, signals: Sequence[str]) -> pandas.DataFrame:
    from .export.frames import to_pandas

    return to_pandas(trace, signals)


def _to_polars(trace: Trace, signals: Sequence[str]) -> polars.DataFrame:
    from .export.frames import to_polars

    return to_polars(trace, signals)


def _read_columns(trace: Trace) -> Columns:
    from .read.arrays import read_columns

    return read_columns(trace)


def _short_text(trace: Trace) -> str:
    from .read.notebook import short_text

    return short_text(trace)


def _as_html(trace: Trace) -> str:
    from .read.notebook import as_html

    return as_html(trace)


hooks.to_pandas, hooks.to_polars = _to_pandas, _to_polars
hooks.read_columns, hooks.short_text, hooks.as_html = _read_columns, _short_text, _as_html


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
