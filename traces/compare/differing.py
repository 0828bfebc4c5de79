"""Finds the fields that differ in a block of two traces.

Each trace must have the other's values within a window, which is the scans within the time tolerance. A word,
or the level of a bit, must occur in the window. A count must be between the least and the greatest count in
the window, plus or minus the tolerance in counts. An edge may therefore be early or late by up to the time
tolerance.

If scans are paired by number, the window is a single scan and every bit is compared.
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
        counts: allowed difference between a count and its window; None = every bit is compared.
    """
    differences = []
    for _, group in groupby(fields, lambda field: (field.stem, field is TIME)):
        image_fields = list(group)  # all fields of one image
        images_a, images_b = block.side_a.images(image_fields[0]), block.side_b.images(image_fields[0])
        unequal_a = _unequal_images(images_a, images_b, block.windows_a)
        unequal_b = _unequal_images(images_b, images_a, block.windows_b)
        if not (len(unequal_a.own) or len(unequal_b.own)):
            continue
        for field in image_fields:
            missing_in_b = _missing(field, unequal_a, counts)
            missing_in_a = _missing(field, unequal_b, counts)
            if len(missing_in_b.rows_a) or len(missing_in_a.rows_a):
                differences.append(_merged(missing_in_b, missing_in_a))
    return differences


class _UnequalImages(NamedTuple):
    """Scans of one trace whose image differs from the image in force in the other trace."""

    windows: Windows  # the scans, and their windows
    own: Array  # the images of the scans
    in_force: Array  # the images in force in the other trace
    others: Array  # all images of the other trace in memory, to which the windows' rows refer


def _unequal_images(own: Array, other: Array, windows: Windows) -> _UnequalImages:
    """Return the scans whose image differs from the image in force in the other trace."""
    own_images, images_in_force = own[windows.rows], other[windows.in_force]
    is_unequal = own_images != images_in_force
    unequal = np.flatnonzero(is_unequal if is_unequal.ndim == 1 else is_unequal.any(axis=1))
    return _UnequalImages(windows.at(unequal), own_images[unequal], images_in_force[unequal], other)


def _missing(field: Field, images: _UnequalImages, counts: int | None) -> FieldDifference:
    """Return the scans whose value is missing from the other trace within the tolerance, as `rows_a`."""
    keys, keys_in_force = field.key(images.own), field.key(images.in_force)
    unequal = np.flatnonzero(keys != keys_in_force)
    keys, keys_in_force, windows = keys[unequal], keys_in_force[unequal], images.windows.at(unequal)
    window = windows.first, windows.end
    # each window is the scan in force, whose value is unequal
    is_single = bool((windows.end - windows.first == 1).all())
    bits = None
    if field.kind is FieldKind.BITS:
        differing_bits = keys ^ keys_in_force
        bits = differing_bits if is_single else _missing_bits(keys, field.key(images.others), *window)
        is_missing = bits != 0
        bits = bits[is_missing]
    elif field.kind is FieldKind.COUNT and counts is not None and len(unequal):
        is_missing = _beyond(field.values(images.own[unequal]), field.values(images.others), *window, counts)
    elif is_single:
        is_missing = np.ones(len(unequal), bool)
    else:
        is_missing = ~occurs(keys, field.key(images.others), *window)
    return FieldDifference(field, windows.rows[is_missing], windows.in_force[is_missing], bits)


def _missing_bits(searched: Array, values: Array, first: Rows, end: Rows) -> Array:
    """Return the bits whose level does not occur in the window."""
    never_set = ~over_windows(values, first, end, np.bitwise_or)
    always_set = over_windows(values, first, end, np.bitwise_and)
    missing_bits: Array = (searched & never_set) | (~searched & always_set)
    return missing_bits


def _beyond(searched: Array, values: Array, first: Rows, end: Rows, counts: int) -> Array:
    """Return whether each count is outside the range of its window; False for a missing count."""
    lowest = over_windows(values, first, end, np.fmin)
    highest = over_windows(values, first, end, np.fmax)
    is_beyond: Array = (searched < lowest - counts) | (searched > highest + counts)
    return is_beyond


def _merged(missing_in_b: FieldDifference, missing_in_a: FieldDifference) -> FieldDifference:
    """Merge the differences from both directions; each row of the first trace occurs once.

    Args:
        missing_in_a: its `rows_a` are rows of the second trace, because the traces are swapped.
    """
    if not len(missing_in_a.rows_a):
        return missing_in_b
    rows_a = np.concatenate((missing_in_b.rows_a, missing_in_a.rows_b))
    rows_b = np.concatenate((missing_in_b.rows_b, missing_in_a.rows_a))
    unique_rows_a, first_indexes = np.unique(rows_a, return_index=True)
    bits = None
    if missing_in_b.bits is not None and missing_in_a.bits is not None:
        bits = np.zeros(len(unique_rows_a), np.uint16)
        all_bits = np.concatenate((missing_in_b.bits, missing_in_a.bits))
        np.bitwise_or.at(bits, np.searchsorted(unique_rows_a, rows_a), all_bits)
    return FieldDifference(missing_in_b.field, unique_rows_a, rows_b[first_indexes], bits)


def over_windows(values: Array, first: Rows, end: Rows, join: np.ufunc) -> Array:
    """Return the result of `join` over each window of some values, such as the least or greatest value.

    A window of any length is covered by two windows whose length is a power of two and which may overlap.
    Values
    of longer windows are computed from values of windows half as long:

    >>> values = np.array([5, 3, 8, 1])
    >>> over_windows(values, np.array([0, 1, 0]), np.array([2, 4, 4]), np.minimum).tolist()
    [3, 1, 1]

    Args:
        first: first row of each window.
        end: end row of each window, greater than `first`.
        join: combines two values; for two equal values it must return this value, because windows overlap.
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
    """Return whether each window of rows contains the searched value.

    Every row gets a key that orders the rows by value and then by row. The rows in a window that have the
    same value are then a range of keys.

    >>> occurs(np.array([8, 8]), np.array([5, 3, 8, 1]), np.array([0, 1]), np.array([2, 4])).tolist()
    [False, True]
    """
    sorted_rows = np.argsort(values, kind="stable")  # by value, then by row
    distinct_values = np.unique(values)
    keys_per_value = len(values) + 1
    keys = np.searchsorted(distinct_values, values[sorted_rows]) * keys_per_value + sorted_rows
    ranks = np.minimum(np.searchsorted(distinct_values, searched), len(distinct_values) - 1)
    first_keys = ranks * keys_per_value
    is_in_window = np.searchsorted(keys, first_keys + end) > np.searchsorted(keys, first_keys + first)
    is_found: Array = (distinct_values[ranks] == searched) & is_in_window
    return is_found
