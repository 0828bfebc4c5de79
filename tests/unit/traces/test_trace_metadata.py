"""What protects the metadata of a trace: a flipped bit in it is told by each reader that trusts it."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from scanrack.commands import build
from scanrack.traces import Trace, TraceError, open_trace
from scanrack.traces.read import reader
from scanrack.traces.read.finding import DATA_DAMAGE
from typer.testing import CliRunner

RACK = """
name = "lamp"
program = "lamp.rung"
scan_ms = 2

[[slot]]
number = 1
module = "amci3601"
"""
PROGRAM = "PROGRAM lamp\nTAG On : BOOL\nROUTINE Main\nXIO(On)OTE(On);\nEND\n"


def run(*words: str | Path) -> tuple[int, str]:
    done = CliRunner().invoke(build(), [str(each) for each in words])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, done.stderr


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("metadata")
    (folder / "lamp.toml").write_text(RACK, encoding="utf-8")
    (folder / "lamp.rung").write_text(PROGRAM, encoding="utf-8")
    trace = folder / "lamp.mcap"
    assert run("run", folder / "lamp.toml", "--scans", "20", "--record", trace, "-q") == (0, "")
    return trace


def metadata_bytes(path: Path) -> list[int]:
    """Return the places of the bytes of the metadata records, their heads included."""
    with open_trace(path) as trace:
        spans = [span for span in trace.spans if span.opcode == Opcode.METADATA]
    return [place for span in spans for place in range(span.offset, span.end)]


def flipped(path: Path, place: int, bit: int = 0) -> bytes:
    content = bytearray(path.read_bytes())
    content[place] ^= 1 << bit
    return bytes(content)


@pytest.mark.slow
def test_each_flipped_bit_of_the_metadata_is_told_as_the_trace_is_opened(recorded: Path) -> None:
    places, untold = metadata_bytes(recorded), []
    assert len(places) > 300
    for place in places:
        for bit in range(8):
            content = flipped(recorded, place, bit)
            try:
                trace = Trace(io.BytesIO(content), len(content))
            except TraceError:
                continue
            if not any("damaged" in note for note in trace.notes):
                untold.append((place, bit))
    assert untold == []


KEYS = ("rack_file", "program_file", "program_sha256")


def in_value(path: Path, key: str) -> int:
    """Return the place of the last byte of an entry's value in the metadata."""
    with open_trace(path) as trace:
        value = trace.head.metadata[key].encode()
    places, content = metadata_bytes(path), path.read_bytes()
    head = content.index(key.encode() + len(value).to_bytes(4, "little") + value, places[0], places[-1])
    return head + len(key) + 4 + len(value) - 1


@pytest.mark.slow
@pytest.mark.parametrize("longest", [reader.CHECKED_BYTES, 0])
@pytest.mark.parametrize("key", KEYS)
@pytest.mark.parametrize(
    "command",
    [
        ("replay", "--into", "rack"),
        ("replay", "--into", "session", "-q"),
        ("why", "On"),
        ("share",),
        ("compare", "lamp.mcap"),
    ],
    ids=lambda command: command[0],
)
def test_each_reader_of_the_metadata_tells_a_flipped_bit(
    recorded: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: tuple[str, ...],
    key: str,
    longest: int,
) -> None:
    """A trace of more than `CHECKED_BYTES` is not checked as it is opened, but before its files are used."""
    monkeypatch.setattr(reader, "CHECKED_BYTES", longest)
    monkeypatch.chdir(recorded.parent)
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(flipped(recorded, in_value(recorded, key)))
    _, told = run(command[0], damaged, *command[1:])
    assert f"note: {DATA_DAMAGE}" in told
    _, told = run(command[0], recorded, *command[1:])
    assert "note: " not in told


def test_damage_that_has_a_place_is_told_instead(recorded: Path, tmp_path: Path) -> None:
    with open_trace(recorded) as trace:
        end = next(span.end for span in trace.spans if span.opcode == Opcode.CHUNK)
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(flipped(recorded, end - 5))
    with open_trace(damaged) as trace:
        assert trace.notes == [DATA_DAMAGE]
        assert list(trace.scans()) == []
        (note,) = trace.notes
        assert note.startswith("damaged chunk at byte ")
