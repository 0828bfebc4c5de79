"""A chunk that unpacks to more, and a file of more empty records, than a limit allows is refused.

The limits of these tests are small, so that a step beyond them is no load for any reader.
"""

import struct
import zlib
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from made_traces import idle, record
from mcap.opcode import Opcode
from scanrack.commands import build
from scanrack.traces import open_trace
from scanrack.traces.format.limits import Limits, limited
from scanrack.traces.format.records import RECORD_HEAD, TraceLimitError
from typer.testing import CliRunner

MIB = 1024 * 1024
EMPTY = RECORD_HEAD.pack(0x90, 0)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return record(tmp_path / "run.mcap", idle(100))


def with_chunk(path: Path, size: int, data: bytes, crc: int = 0, name: bytes = b"zstd") -> Path:
    """Put a chunk before the chunks of a trace that says that it unpacks to so many bytes."""
    content = path.read_bytes()
    with open_trace(path) as trace:
        place = trace.sections[0].span.offset
    head = struct.pack("<QQQI", 0, 0, size, crc) + struct.pack("<I", len(name)) + name
    chunk = head + struct.pack("<Q", len(data)) + data
    path.write_bytes(content[:place] + RECORD_HEAD.pack(Opcode.CHUNK, len(chunk)) + chunk + content[place:])
    return path


def run(*arguments: object) -> tuple[int, str]:
    result = CliRunner().invoke(build(), [str(argument) for argument in arguments])
    return result.exit_code, result.stderr


@pytest.mark.parametrize("command", ["show", "repair", "query", "export"])
def test_a_chunk_that_unpacks_to_too_much_is_refused_by_every_command(path: Path, command: str) -> None:
    with_chunk(path, MIB + 1, zstandard.compress(bytes(MIB + 1)))
    words: dict[str, list[object]] = {
        "query": ["slot1.in.MODULE_OK"],
        "export": ["--csv", path.with_suffix(".csv")],
    }
    status, err = run("--max-chunk", 1, command, path, *words.get(command, []))
    assert status == 2
    assert "unpacks to 1,048,577 bytes; the limit is 1,048,576" in err
    assert err.endswith("'scanrack --max-chunk N COMMAND ...' raises the limit\n")
    assert err.count("\n") == 1


@pytest.mark.slow
def test_the_limit_can_be_raised(path: Path) -> None:
    """A MiB of empty private records: not damaged, and nothing of ours."""
    data = EMPTY * (MIB // len(EMPTY))
    with_chunk(path, len(data), zstandard.compress(data), zlib.crc32(data))
    with limited(Limits(chunk_bytes=MIB // 2)), open_trace(path) as trace, pytest.raises(TraceLimitError):
        list(trace)
    with limited(Limits(chunk_bytes=2 * MIB)), open_trace(path) as trace:
        assert len(list(trace.scans())) == 100
    assert run("--max-chunk", 2, "show", path)[0] == 0


@pytest.mark.parametrize("size", [101, 2 * MIB])
def test_a_chunk_that_only_claims_to_be_large_is_damaged(path: Path, size: int) -> None:
    """What its data say of themselves is another size: a bit of its head has flipped."""
    with_chunk(path, size, zstandard.compress(bytes(100)))
    status, err = run("show", path)
    assert (status, err) == (0, "")
    with open_trace(path) as trace:
        assert len(list(trace.scans())) == 100
        assert f"it has 100 bytes instead of {size:,}" in trace.notes[-1]


@pytest.mark.parametrize("name", [b"lz4", b"zstd"])
def test_a_chunk_that_claims_to_be_small_unpacks_no_further(path: Path, name: bytes) -> None:
    if name == b"lz4":
        data = lz4.frame.compress(bytes(2_000), store_size=False)
    else:
        data = zstandard.ZstdCompressor(write_content_size=False).compress(bytes(2_000))
    with_chunk(path, 1000, data, name=name)
    with open_trace(path) as trace:
        assert len(list(trace.scans())) == 100
        assert "it has more than 1,000 bytes instead of 1,000" in trace.notes[-1]


@pytest.mark.parametrize("command", ["show", "repair"])
@pytest.mark.parametrize("inside", [True, False])
def test_more_empty_records_than_the_limit(path: Path, command: str, inside: bool) -> None:
    data = EMPTY * 1_001
    if inside:
        with_chunk(path, len(data), zstandard.compress(data), zlib.crc32(data))
    else:
        content = path.read_bytes()
        with open_trace(path) as trace:
            place = trace.sections[0].span.offset
        path.write_bytes(content[:place] + data + content[place:])
    status, err = run("--max-records", 1_000, command, path)
    assert status == 2
    assert "has more than 1,000 records, most of them empty" in err
    assert "'scanrack --max-records N COMMAND ...' raises the limit" in err


def test_as_many_records_as_there_are_messages_are_no_matter() -> None:
    """Other tools write traces without chunks, and long ones have millions of messages."""
    assert not Limits().too_many(10_000_000, 31 * 10_000_000)
