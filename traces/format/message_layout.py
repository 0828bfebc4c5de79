"""The layout of a scan's message record as a numpy type, for readers and exports; `batch` writes it."""

from __future__ import annotations

from typing import Any

import numpy as np

from .tagplan import FIELD


def message_layout(
    image_bytes: int, tags: np.dtype[np.void] | None = None, rest: np.dtype[np.void] | None = None
) -> np.dtype[np.void]:
    """Return the layout of a scan's message record in a chunk.

    >>> message_layout(32).itemsize
    75

    Args:
        tags: type of the row of tags after the images, or None.
        rest: type of the bytes after the tags, or None.
    """
    tag_fields: list[Any] = [] if tags is None else [(FIELD, tags)]
    tag_fields += [] if rest is None else [("rest", rest)]
    return np.dtype(
        [
            ("opcode", "u1"),
            ("length", "<u8"),
            ("channel", "<u2"),
            ("sequence", "<u4"),
            ("log_time", "<u8"),
            ("publish_time", "<u8"),
            ("prefix", "<u4"),
            ("scan", "<u4"),
            ("flags", "<u4"),
            ("images", f"V{image_bytes}"),
            *tag_fields,
        ]
    )
