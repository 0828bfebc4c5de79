"""Comparing by number: scans of one number show the same at the same time, bit for bit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..read.columns import Columns
from .blocks import NumberedBlock
from .differing import Differing, by_image
from .fields import Field, Kind
from .pairing import Rows


def exactly(fields: Sequence[Field], block: NumberedBlock) -> list[Differing]:
    """Return the fields that differ in pairs of scans in which every bit counts.

    Args:
        fields: what is compared.
        block: the scans of either trace, and how they are paired.
    """
    rows = _unequal(block)
    if not len(rows):
        return []
    a, b = block.pairs.a[rows], block.pairs.b[rows]
    differing = []
    for image, parts in by_image(fields):
        images = block.one.images(image, a), block.other.images(image, b)
        for field in parts:
            keys = field.key(images[0]), field.key(images[1])
            found = np.flatnonzero(keys[0] != keys[1])
            if len(found):
                bits = (keys[0] ^ keys[1])[found] if field.kind is Kind.BITS else None
                differing.append(Differing(field, a[found], b[found], bits))
    return differing


def _unequal(block: NumberedBlock) -> Rows:
    """Return which pairs differ anywhere."""
    a = _at(block.one.columns, block.pairs.a)
    b = _at(block.other.columns, block.pairs.b)
    unequal = (a.time_ns != b.time_ns) | (a.flags != b.flags)
    if not np.array_equal(a.words, b.words):
        unequal |= (a.words != b.words).any(axis=1)
    if a.tags is not None and b.tags is not None and a.tags.dtype.names:
        unequal |= a.tags != b.tags
    return np.flatnonzero(unequal)


def _at(columns: Columns, rows: Rows) -> Columns:
    """Return some of the rows, ascending; without a copy if none between them is left out."""
    if len(rows) and rows[-1] - rows[0] + 1 == len(rows):
        return columns.rows(rows[0], rows[-1] + 1)
    return columns.at(rows)
