"""Formats a comparison as text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import takewhile

from scanrack.io_images.times import time_text

from ..read.changes import ROW_TITLES, Row
from .comparison import Comparison
from .findings import Detail, Extent, First

Names = tuple[str, str]


def report(comparison: Comparison, names: Names) -> Iterator[str]:
    """Yield the lines of a comparison's report."""
    yield _verdict(comparison, names)
    if comparison.first is not None:
        yield from first_lines(comparison.first, names)
        yield from ("", "How they differ")
        yield from _aligned(
            [("", "scans", "first", "last", "by up to"), *map(_extent, comparison.extents)], "lrrrr"
        )
    other_lines = list(_other_differences(comparison, names))
    if other_lines:
        yield from ("", *other_lines)


def first_lines(first: First, names: Names) -> Iterator[str]:
    """Yield the lines about the first scan that differs, and the changes that led to it."""
    table_rows: list[tuple[str, ...]] = [("", "", "", *names, "")]
    table_rows += [row for detail in first.details for row in _detail(detail)]
    yield from ("", *_aligned(table_rows, "lllrrl"))
    yield from _rules(first, names)
    equal_count = _equal_count(first.before_a, first.before_b)
    if equal_count:
        yield from ("", "Before it, in both")
        yield from _changes(first.before_a[:equal_count])
    for name, rows in zip(names, (first.before_a, first.before_b), strict=True):
        yield from ("", f"{name}, up to it")
        yield from _changes(rows[equal_count:])


def _equal_count(a: Sequence[Row], b: Sequence[Row]) -> int:
    """Return the number of equal rows at the beginning."""
    equal_pairs = takewhile(lambda pair: pair[0] == pair[1], zip(a, b, strict=False))
    return sum(1 for _ in equal_pairs)


def _verdict(comparison: Comparison, names: Names) -> str:
    """Return whether two traces are the same, and in which scan they first differ, as a sentence."""
    if comparison.first is None:
        has_more = (
            comparison.only_a or comparison.only_b or comparison.slots_only_a or comparison.slots_only_b
        )
        verdict = "show the same as far as both go" if has_more else "show the same"
        return f"{names[0]} and {names[1]} {verdict}{_within(comparison, 'within')}: {_scans(comparison)}"
    first = comparison.first
    location = f"scan {first.scan} at {time_text(first.time_ns)}"
    if (first.scan, first.time_ns) != (first.scan_b, first.time_b_ns):
        location += f" (scan {first.scan_b} at {time_text(first.time_b_ns)} of {names[1]})"
    differ = f"differ{_within(comparison, 'by more than')}"
    return f"{names[0]} and {names[1]} {differ}, first in {location}; {_scans(comparison)}"


def _within(comparison: Comparison, word: str) -> str:
    """Return the tolerance as a phrase that begins with a word; "" if none is allowed."""
    if comparison.tolerance.exact:
        return ""
    counts = comparison.tolerance.counts
    return f" {word} {time_text(comparison.tolerance.time_ns)} and {counts:,} count{'s' * (counts != 1)}"


def _scans(comparison: Comparison) -> str:
    """Return the numbers of scans, and how many of them differ, as a phrase."""
    scans = f"{comparison.scans_a:,}"
    if comparison.scans_a != comparison.scans_b:
        scans += f" and {comparison.scans_b:,}"
    return f"{comparison.differing:,} of {scans} scans differ" if comparison.differing else f"{scans} scans"


def _detail(detail: Detail) -> Iterator[tuple[str, ...]]:
    """Yield the table rows for a field, which show its value or word and each bit that differs."""
    location = "cpu" if detail.slot is None else f"slot {detail.slot} {detail.direction}"
    words = _words_text(detail)
    if detail.bits:
        hex_words = (f"{word & 0xFFFF:04X}h" for word in (detail.words_a[0], detail.words_b[0]))
        yield (location, detail.name, "", *hex_words, words)
        for name, bit_a, bit_b in detail.bits:
            yield ("", "", name, str(int(bit_a)), str(int(bit_b)), "")
    elif detail.direction == "tags":
        yield ("tags", detail.name, "", detail.text_a, detail.text_b, "")
    elif detail.name == "time_ns":
        yield (location, "time", "", time_text(detail.words_a[0]), time_text(detail.words_b[0]), "")
    else:
        yield (location, detail.name, "", _value(detail.a), _value(detail.b), words)


def _words_text(detail: Detail) -> str:
    """Return the location of a detail's words, and the values of two words; "" for the CPU and for tags."""
    if detail.slot is None:
        return ""
    if len(detail.words_a) == 1:
        return f"word {detail.word}"
    word_pairs = (f"{msw} {lsw}" for msw, lsw in (detail.words_a, detail.words_b))
    return f"words {detail.word} and {detail.word + 1}: {' / '.join(word_pairs)}"


def _rules(first: First, names: Names) -> Iterator[str]:
    """Yield the rules that fired in the first scan that differs, starting with the rules of both traces."""
    common_rules = [rule for rule in first.rules_a if rule in first.rules_b]
    own_rules = [
        (name, rule)
        for name, rules in zip(names, (first.rules_a, first.rules_b), strict=True)
        for rule in rules
        if rule not in common_rules
    ]
    if common_rules or own_rules:
        yield from ("", "Rules that fired in it")
        yield from (f"in both: {rule}" for rule in common_rules)
        yield from (f"in {name} only: {rule}" for name, rule in own_rules)


def _changes(rows: Sequence[Row]) -> list[str]:
    titles = [title.removesuffix(">") for title in ROW_TITLES]
    sides = "".join("r" if title.endswith(">") else "l" for title in ROW_TITLES)
    return _aligned([titles, *(row.cells for row in rows)], sides) if rows else ["nothing changed"]


def _extent(extent: Extent) -> tuple[str, ...]:
    """Return the table row of a bit, value or word that differs."""
    most = ""
    if extent.most is not None:
        most = time_text(extent.most) if extent.name == "cpu.time_ns" else f"{extent.most:,}"
    return (extent.name, f"{extent.scans:,}", str(extent.first), str(extent.last), most)


def _other_differences(comparison: Comparison, names: Names) -> Iterator[str]:
    """Yield a line for scans, slots, sequences and metadata that differ or that only one trace has."""
    for name, only, slots in (
        (names[0], comparison.only_a, comparison.slots_only_a),
        (names[1], comparison.only_b, comparison.slots_only_b),
    ):
        if only:
            yield f"only in {name}: {only:,} scan{'s' * (only != 1)}"
        if slots:
            yield f"only in {name}: slot {', '.join(map(str, slots))}"
    for name, step_a, step_b in comparison.sequences:
        yield f"sequence {name}: {step_a} / {step_b}"
    for name, value_a, value_b in comparison.heads:
        yield f"{name}: {_shortened(value_a)} / {_shortened(value_b)}"


def _shortened(text: str) -> str:
    if len(text) > 24:
        return f"{text[:12]}..."
    return text or "none"


def _value(value: int | None) -> str:
    return "-" if value is None else f"{value:,}"


def _aligned(rows: Sequence[Sequence[str]], sides: str) -> list[str]:
    """Return rows as lines with aligned columns; `sides` has l (left) or r (right) for each column."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(sides))]
    lines = []
    for row in rows:
        row_cells = [
            cell.ljust(width) if alignment == "l" else cell.rjust(width)
            for cell, width, alignment in zip(row, widths, sides, strict=True)
            if width
        ]
        lines.append("  ".join(row_cells).rstrip())
    return lines
