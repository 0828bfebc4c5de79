"""Comparing by time: what one trace shows, the other has to show within a tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .blocks import TimedBlock
from .differing import Differing, by_image
from .fields import TIME, Field, Kind
from .pairing import Rows, Windows, occurs, over_windows
from .tolerance import Tolerance

Array = NDArray[Any]


def tolerantly(fields: Sequence[Field], block: TimedBlock, tolerance: Tolerance) -> list[Differing]:
    """Compare a block of two traces by time: what one shows, the other shows within the tolerance.

    A word, or the level of a bit, has to be there at some time within the tolerance; a count may
    lie between those that are. So an edge may be early or late by the tolerance, and a position
    that moves may be off by as much as it moves meanwhile and the tolerance in counts.
    """
    one, other = block.one, block.other
    found = []
    for image, parts in by_image([field for field in fields if field is not TIME]):
        images = one.images(image), other.images(image)
        ahead = _otherwise(images[0], images[1], block.there)
        behind = _otherwise(images[1], images[0], block.back)
        for field in parts:
            a = _missing(field, ahead, images[1], tolerance)
            b = _missing(field, behind, images[0], tolerance)
            if len(a.a) or len(b.a):
                found.append(_merged(field, a, b))
    return found


class _Question(NamedTuple):
    """Scans of one trace whose image is another one than that in force in the other trace.

    Attributes:
        rows: the scans.
        held: the scans in force in the other trace.
        first: the first scan of the other trace within the tolerance.
        end: the one after the last.
        own: the images of `rows`.
        others: the images of `held`.
    """

    rows: Rows
    held: Rows
    first: Rows
    end: Rows
    own: Array
    others: Array


def _otherwise(own: Array, other: Array, windows: Windows) -> _Question:
    """Return the scans in which anything can be missing, as far as they can be judged."""
    rows, held = windows.rows[windows.whole], windows.held[windows.whole]
    mine, others = own[rows], other[held]
    unequal = mine != others
    there = np.flatnonzero(unequal if unequal.ndim == 1 else unequal.any(axis=1))
    first, end = windows.first[windows.whole], windows.end[windows.whole]
    return _Question(*(column[there] for column in (rows, held, first, end, mine, others)))


def _missing(field: Field, asked: _Question, other: Array, tolerance: Tolerance) -> Differing:
    """Return the scans whose value the other trace does not have within the tolerance.

    Args:
        field: the field.
        asked: the scans.
        other: the images of the other trace, all of them that the windows reach.
        tolerance: what may differ.
    """
    wanted = field.key(asked.own)
    rows = np.flatnonzero(wanted != field.key(asked.others))
    wanted, first, end = wanted[rows], asked.first[rows], asked.end[rows]
    bits = None
    if field.kind is Kind.BITS:
        bits = _missing_bits(wanted, field.key(other), first, end) if len(rows) else np.zeros(0, np.uint16)
        missing = bits != 0
        bits = bits[missing]
    elif not len(rows):
        missing = np.zeros(0, bool)
    elif field.kind is Kind.COUNT:
        missing = _beyond(field.values(asked.own[rows]), field.values(other), first, end, tolerance.counts)
    else:
        missing = ~occurs(wanted, field.key(other), first, end)
    return Differing(field, asked.rows[rows[missing]], asked.held[rows[missing]], bits)


def _missing_bits(wanted: Array, values: Array, first: Rows, end: Rows) -> Array:
    """Return which bits differ throughout the window."""
    never_set = ~over_windows(values, first, end, np.bitwise_or)
    always_set = over_windows(values, first, end, np.bitwise_and)
    missing: Array = (wanted & never_set) | (~wanted & always_set)
    return missing


def _beyond(wanted: Array, values: Array, first: Rows, end: Rows, counts: int) -> Array:
    """Return which counts lie outside what the window spans; nothing does where there are none."""
    least = over_windows(values, first, end, np.fmin)
    most = over_windows(values, first, end, np.fmax)
    beyond: Array = (wanted < least - counts) | (wanted > most + counts)
    return beyond


def _merged(field: Field, there: Differing, back: Differing) -> Differing:
    """Join the findings of both directions, by rows of the first trace; a row once."""
    a, b = np.concatenate((there.a, back.b)), np.concatenate((there.b, back.a))
    rows, place = np.unique(a, return_index=True)
    if there.bits is None or back.bits is None:
        return Differing(field, rows, b[place])
    bits = np.zeros(len(rows), np.uint16)
    np.bitwise_or.at(bits, np.searchsorted(rows, a), np.concatenate((there.bits, back.bits)))
    return Differing(field, rows, b[place], bits)
