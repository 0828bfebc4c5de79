"""Finds the fields that differ in a block of two traces.

Each trace must show the other's values within the tolerance: a word, or the level of a bit, at some time
within it; a count may be between counts that are shown. An edge may therefore be early or late by the
tolerance, and a moving position may be off by its motion in that time plus the tolerance in counts.

Paired by number, a window is one scan and every bit of it counts: the tolerance is zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np

from .blocks import ComparedBlock, Windows
from .fields import TIME, Array, Field, FieldKind
from .findings import FieldDifference
from .stream import Rows


def differing(fields: Sequence[Field], block: ComparedBlock, counts: int | None) -> list[FieldDifference]:
    """Return the fields that differ in a block.

    Args:
        counts: allowed difference between a count and its window; None = every bit counts.
    """
    own_side, other_side = block.one, block.other
    differences = []
    for _, group in groupby(fields, lambda field: (field.stem, field is TIME)):
        image_fields = list(group)  # all fields of one image
        images = own_side.images(image_fields[0]), other_side.images(image_fields[0])
        ahead = _otherwise(images[0], images[1], block.there)
        behind = _otherwise(images[1], images[0], block.back)
        for field in image_fields if len(ahead.own) or len(behind.own) else ():
            there_difference, back_difference = (
                _missing(field, ahead, counts),
                _missing(field, behind, counts),
            )
            if len(there_difference.a) or len(back_difference.a):
                differences.append(_merged(there_difference, back_difference))
    return differences


class _Question(NamedTuple):
    """Scans of one trace whose image differs from the image in force in the other trace."""

    windows: Windows  # the scans, and their windows
    own: Array  # the images of the scans
    held: Array  # the images in force in the other trace
    others: Array  # all images of the other trace that the windows reach


def _otherwise(own: Array, other: Array, windows: Windows) -> _Question:
    """Return the scans whose images differ, so that the other trace may lack their values."""
    values, held_values = own[windows.rows], other[windows.held]
    is_unequal = values != held_values
    unequal_places = np.flatnonzero(is_unequal if is_unequal.ndim == 1 else is_unequal.any(axis=1))
    return _Question(windows.at(unequal_places), values[unequal_places], held_values[unequal_places], other)


def _missing(field: Field, question: _Question, counts: int | None) -> FieldDifference:
    """Return the scans whose value the other trace lacks within the tolerance."""
    searched_keys, held_keys = field.key(question.own), field.key(question.held)
    rows = np.flatnonzero(searched_keys != held_keys)
    searched_keys, windows = searched_keys[rows], question.windows.at(rows)
    span = windows.first, windows.end
    # only the scan in force is within the tolerance
    is_single = bool((windows.end - windows.first == 1).all())
    bits = None
    if field.kind is FieldKind.BITS:
        bits = (
            searched_keys ^ held_keys[rows]
            if is_single
            else _missing_bits(searched_keys, field.key(question.others), *span)
        )
        is_missing = bits != 0
        bits = bits[is_missing]
    elif field.kind is FieldKind.COUNT and counts is not None and len(rows):
        is_missing = _beyond(field.values(question.own[rows]), field.values(question.others), *span, counts)
    else:
        is_missing = (
            np.ones(len(rows), bool)
            if is_single
            else ~occurs(searched_keys, field.key(question.others), *span)
        )
    return FieldDifference(field, windows.rows[is_missing], windows.held[is_missing], bits)


def _missing_bits(searched: Array, values: Array, first: Rows, end: Rows) -> Array:
    """Return the bits that differ throughout the window."""
    never_set = ~over_windows(values, first, end, np.bitwise_or)
    always_set = over_windows(values, first, end, np.bitwise_and)
    missing_bits: Array = (searched & never_set) | (~searched & always_set)
    return missing_bits


def _beyond(searched: Array, values: Array, first: Rows, end: Rows, counts: int) -> Array:
    """Return a mask of the counts outside the range of their window; missing counts are inside."""
    lowest = over_windows(values, first, end, np.fmin)
    highest = over_windows(values, first, end, np.fmax)
    is_beyond: Array = (searched < lowest - counts) | (searched > highest + counts)
    return is_beyond


def _merged(there: FieldDifference, back: FieldDifference) -> FieldDifference:
    """Merge the findings of both directions, by rows of the first trace; each row occurs once."""
    if not len(back.a):
        return there
    rows_a, rows_b = np.concatenate((there.a, back.b)), np.concatenate((there.b, back.a))
    rows, first_places = np.unique(rows_a, return_index=True)
    if there.bits is None or back.bits is None:
        return FieldDifference(there.field, rows, rows_b[first_places])
    bits = np.zeros(len(rows), np.uint16)
    np.bitwise_or.at(bits, np.searchsorted(rows, rows_a), np.concatenate((there.bits, back.bits)))
    return FieldDifference(there.field, rows, rows_b[first_places], bits)


def over_windows(values: Array, first: Rows, end: Rows, join: np.ufunc) -> Array:
    """Return the result of `join` over each window of some values, such as the least or greatest value.

    A window of any length is covered by two windows with a power of two as length, which may overlap. Values
    of longer windows are computed from values of windows half as long:

    >>> values = np.array([5, 3, 8, 1])
    >>> over_windows(values, np.array([0, 1, 0]), np.array([2, 4, 4]), np.minimum).tolist()
    [3, 1, 1]

    Args:
        first: first row of each window.
        end: the row after its last; more than `first`.
        join: combines two values; two equal values must give the same value.
    """
    result = values[first]
    width = end - first
    step, level = 1, values
    while 2 * step <= width.max(initial=1):
        level = join(level[:-step], level[step:])  # results of windows 2 * step long
        step *= 2
        fitting = np.flatnonzero((width >= step) & (width < 2 * step))
        result[fitting] = join(level[first[fitting]], level[end[fitting] - step])
    return result


def occurs(searched: Array, values: Array, first: Rows, end: Rows) -> Array:
    """Return for each window of some values whether it contains the searched value.

    >>> occurs(np.array([8, 8]), np.array([5, 3, 8, 1]), np.array([0, 1]), np.array([2, 4])).tolist()
    [False, True]
    """
    sorted_order = np.argsort(values, kind="stable")  # by value, then by row
    ranked = values[sorted_order]
    start, stop = (np.searchsorted(ranked, searched, side) for side in ("left", "right"))
    rows = len(values) + 1
    group = np.searchsorted(np.unique(values), values[sorted_order])
    keys = group * rows + sorted_order  # ascending, as both summands are
    is_known = stop > start
    question = group[np.minimum(start, len(values) - 1)] * rows
    is_found = np.searchsorted(keys, question + end) > np.searchsorted(keys, question + first)
    return is_known & is_found
