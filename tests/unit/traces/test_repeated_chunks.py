"""A chunk that stands twice in a trace, as somebody copied it there: it counts once, and a note says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_traces import idle, record
from mcap.opcode import Opcode
from scanrack.commands import build
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner


def doubled(path: Path, chunk: int, *, with_indexes: bool, at_end: bool) -> tuple[Path, int]:
    """Copy a chunk of a trace to the place behind it, or behind the last one; return the place, too."""
    data = path.read_bytes()
    with open_trace(path) as trace:
        spans = trace.spans
    chunks = [place for place, span in enumerate(spans) if span.opcode == Opcode.CHUNK]

    def end(place: int) -> int:
        after = place + 1
        while spans[after].opcode == Opcode.MESSAGE_INDEX:
            after += 1
        return spans[after - 1].end

    first = spans[chunks[chunk]]
    piece = data[first.offset : end(chunks[chunk]) if with_indexes else first.end]
    at = end(chunks[-1] if at_end else chunks[chunk])
    forged = path.with_name("forged.mcap")
    forged.write_bytes(data[:at] + piece + data[at:])
    return forged, at


@pytest.mark.parametrize("at_end", [False, True])
@pytest.mark.parametrize("with_indexes", [False, True])
@pytest.mark.parametrize("chunk", [0, 3, 9])
def test_a_chunk_that_stands_twice_counts_once(
    tmp_path: Path, chunk: int, with_indexes: bool, at_end: bool
) -> None:
    whole = record(tmp_path / "whole.mcap", idle(481), chunk_scans=50)
    forged, at = doubled(whole, chunk, with_indexes=with_indexes, at_end=at_end)
    with open_trace(forged) as trace:
        assert [each.scan for each in trace.scans()] == list(range(481))
        assert read_columns(trace).scan.tolist() == list(range(481))
        (note,) = (each for each in trace.notes if "repeats an earlier one" in each)
    assert note.startswith(f"the chunk at byte {at:,} repeats an earlier one: ")
    for words in ([], ["--limit", "1"]):
        said = CliRunner().invoke(build(), ["show", str(forged), *words])
        assert "481 scans, 0 to 480, up to 0.960 s" in said.output
