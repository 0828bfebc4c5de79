"""Traces cut and damaged at random: nothing but a TraceError gets out, and nothing wrong is given."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_traces import record
from mcap.reader import make_reader
from scanrack.commands import build
from scanrack.traces import TraceError, open_trace, read_columns
from scanrack.traces.read.arrays import Columns, extent, scan_at
from scanrack.traces.repair import repair
from typer.testing import CliRunner

SCANS = 60
WORDS = np.arange(SCANS * 16).reshape(SCANS, 16)
EVENTS = {scan: ("/stimuli", {"name": f"button {scan}"}) for scan in (0, 31)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fuzz")
    record(folder / "whole.mcap", WORDS, events=EVENTS, chunk_scans=20)
    return folder


@cache
def whole(folder: Path) -> bytes:
    return (folder / "whole.mcap").read_bytes()


places = st.integers(0, 1_000_000)
damages = st.tuples(
    st.none() | places,
    st.lists(st.tuples(places, st.integers(1, 255)), max_size=4),
    st.binary(max_size=12),
)
"""Where it is cut, which bytes are flipped and how, and what is appended; places modulo the size."""


def damaged(folder: Path, damage: tuple[int | None, list[tuple[int, int]], bytes]) -> Path:
    cut, flips, more = damage
    content = bytearray(whole(folder))
    for place, mask in flips:
        content[place % len(content)] ^= mask
    path = folder / "damaged.mcap"
    path.write_bytes(content[: None if cut is None else cut % len(content)] + more)
    return path


def check(columns: Columns) -> None:
    """Every scan that is given is one that was recorded."""
    assert columns.words.tolist() == WORDS[columns.scan].tolist()
    assert columns.time_ns.tolist() == (columns.scan * 2_000_000).tolist()


@given(damage=damages)
def test_a_damaged_trace_gives_what_is_whole_or_says_why_not(folder: Path, damage) -> None:
    path = damaged(folder, damage)
    try:
        with open_trace(path) as trace:
            columns = read_columns(trace)
            check(columns)
            assert [scan.scan for scan in trace.scans()] == columns.scan.tolist()
            assert {event.scan for event in trace.events()} <= EVENTS.keys()
            assert (
                extent(trace).scan.tolist() == columns.scan[[0, -1]].tolist() if len(columns.scan) else True
            )
            for scan in columns.scan.tolist()[::7]:
                assert scan_at(trace, scan).scan == scan
            trace.attachments()
    except TraceError as error:
        refused = str(error)
    else:
        refused = f"{path}: "
    assert refused.startswith(f"{path}: ")
    assert "\n" not in refused


@given(damage=damages)
def test_a_repaired_trace_is_whole(folder: Path, damage) -> None:
    path, target = damaged(folder, damage), folder / "repaired.mcap"
    target.unlink(missing_ok=True)
    try:
        result = repair(path, target)
    except TraceError:
        return
    with open_trace(target if result.needed else path) as trace:
        columns = read_columns(trace)
        check(columns)
        assert trace.notes == []
        assert len(columns.scan) == result.scans
    if result.needed and not in_the_head(folder, damage):
        with target.open("rb") as file:
            scans = list(make_reader(file, validate_crcs=True).iter_messages("/scan"))
        assert len(scans) == result.scans


def in_the_head(folder: Path, damage) -> bool:
    """Return whether something is damaged before the first chunk: no checksum guards that."""
    content = whole(folder)
    first_chunk = content.index(b"\x04\0\0\0zstd") - 37
    return any(place % len(content) < first_chunk for place, _ in damage[1])


COMMANDS = (
    ("show",),
    ("query", "slot1.in.COMMAND_ERROR"),
    ("export", "--csv", "out.csv"),
    ("plot", "--out", "out.html"),
    ("compare", "whole.mcap"),
)


@pytest.mark.slow
@given(damage=damages, command=st.sampled_from(COMMANDS))
def test_every_command_tells_it_in_one_line(folder: Path, damage, command) -> None:
    path = damaged(folder, damage)
    name, *options = command
    arguments = [str(folder / option) if "." in option[-5:] else option for option in options]
    result = CliRunner().invoke(build(), [name, str(path), *arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    assert result.exit_code in (0, 1, 2)
    if result.exit_code == 2:
        assert result.stderr.count("\n") == 1
