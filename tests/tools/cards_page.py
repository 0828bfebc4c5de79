"""The tables of cards in docs/card-tables.md, from the rows of `io_images/cards.py`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from scanrack.io_images.cards import KINDS, CardKind
from scanrack.io_images.signal_ranges import RANGES

PAGE = Path(__file__).parents[2] / "docs/card-tables.md"
REMEDY = "python -m tests.tools.generate cards"
HEADS = ("| module | in | out | words |", "| channels | ranges | formats | status ")


def tables(kinds: Iterable[CardKind]) -> Mapping[str, list[str]]:
    """Return the rows by the beginning of their table's head."""
    every = list(kinds)
    signals = [signal_row(kind, image) for kind in every for image in kind.bits]
    return {HEADS[0]: [word_row(kind) for kind in every], HEADS[1]: signals}


def word_row(kind: CardKind) -> str:
    counts = [sum(map(int.bit_count, masks)) for masks in (kind.inputs, kind.outputs)]
    cells = []
    for terminals, channels, what in zip(counts, kind.channels.values(), (" contacts", ""), strict=True):
        cells.append(f"{terminals}{what}" if terminals else f"{channels} channels" if channels else "")
    return f"| `{kind.name}` | {cells[0]} | {cells[1]} | {'; '.join(_words(kind))} |"


def _words(kind: CardKind) -> Iterator[str]:
    ins, outs = kind.channels_in or len(kind.inputs), kind.channels_out or len(kind.outputs)
    if ins:
        yield f"input {_numbers('word', range(ins))}"
    if outs:
        yield f"output {_numbers('word', range(outs))}"
    if kind.echo:
        echo = _numbers("word", range(kind.echo_at, kind.echo_at + outs))
        yield f"input {echo} {'repeats' if outs == 1 else 'repeat'} what is in force"
    for bits in kind.bits.values():
        words = sorted({bits.status_word, bits.word})
        yield f"status and range bits in input {_numbers('word', words)}"


def _numbers(what: str, numbers: Sequence[int]) -> str:
    if len(numbers) == 1:
        return f"{what} {numbers[0]}"
    return f"{what}s {numbers[0]} {'and' if len(numbers) == 2 else 'to'} {numbers[-1]}"


def signal_row(kind: CardKind, image: str) -> str:
    bits, channels = kind.bits[image], range(kind.channels[image])
    over = [bits.over_bit(channel) for channel in channels]
    cells = (
        f"{'inputs' if image == 'I' else 'outputs'} of `{kind.name}`",
        "all" if kind.ranges == tuple(RANGES) else ", ".join(kind.ranges),
        "all" if len(kind.formats) == 4 else ", ".join(kind.formats),
        f"word {bits.status_word}, {_numbers('bit', channels)}",
        *(f"word {bits.word}, bits {', '.join(str(bit + under) for bit in over)}" for under in (0, 1)),
    )
    return f"| {' | '.join(cells)} |"


def rows_of(page: str, head: str) -> list[str]:
    """Return the rows of the table with this head in a page."""
    found = re.search(rf"^{re.escape(head)}.*\n\|[-|]+\n((?:\|.*\n)*)", page, re.MULTILINE)
    assert found is not None, head
    return found[1].splitlines()


def missing(page: str) -> list[str]:
    """Return the rows that a page lacks, and those that it has for no card."""
    return [
        f"{what}: {row}"
        for head, wanted in tables(KINDS.values()).items()
        for what, ours, theirs in (
            ("missing", wanted, rows_of(page, head)),
            ("of no card", rows_of(page, head), wanted),
        )
        for row in ours
        if row not in theirs
    ]


def written(page: str) -> str:
    """Return the page with the rows of all cards."""
    for head, rows in tables(KINDS.values()).items():
        text = "".join(f"{row}\n" for row in rows)
        pattern = rf"(^{re.escape(head)}.*\n\|[-|]+\n)(?:\|.*\n)*"
        page = re.sub(pattern, lambda found, text=text: found[1] + text, page, flags=re.MULTILINE)  # type: ignore[misc]
    return page
