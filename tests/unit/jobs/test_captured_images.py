"""EtherNet/IP in captures: messages made byte by byte [1756-PM020, ODVA volume 2] become a module's words."""

from __future__ import annotations

from pathlib import Path
from struct import pack

import pytest
from captured import conversation, pcap
from scanrack.commands import build
from scanrack.jobs.captures.cip_pairing import CipPairing, _batch_messages
from scanrack.traces import open_trace
from typer.testing import CliRunner

MS = 1_000_000
DATA = bytes.fromhex("91 04") + b"Data"


def image(name: str, *parts: bytes) -> bytes:
    """Return the path of an image and what follows, with its length in words before it."""
    path = pack("<BB", 0x91, len(name)) + name.encode() + bytes(len(name) % 2) + b"".join(parts)
    return pack("<B", len(path) // 2) + path


def element(number: int) -> bytes:
    return pack("<BB", 0x28, number)


INPUTS, OUTPUTS = image("Local:1:I", DATA), image("Local:1:O", DATA)


def unconnected(message: bytes, context: int = 1) -> bytes:
    body = pack("<IHHHHHH", 0, 5, 2, 0, 0, 0xB2, len(message)) + message
    return pack("<HHII8sI", 0x6F, len(body), 7, 0, context.to_bytes(8, "little"), 0) + body


def connected(message: bytes, sequence: int, connection: int) -> bytes:
    data = pack("<H", sequence) + message
    body = pack("<IHHHHIHH", 0, 5, 2, 0xA1, 4, connection, 0xB1, len(data)) + data
    return pack("<HHII8sI", 0x70, len(body), 7, 0, bytes(8), 0) + body


def batch(*messages: bytes) -> bytes:
    first, places = 2 + 2 * len(messages), []
    for each in messages:
        places.append(first)
        first += len(each)
    return pack(f"<H{len(places)}H", len(places), *places) + b"".join(messages)


def done(service: int, data: bytes = b"", status: int = 0) -> bytes:
    return bytes((service | 0x80, 0, status, 0)) + data


def ints(*words: int) -> bytes:
    return pack(f"<H{len(words)}H", 0xC3, *words)


ROUTED = pack("<BB4s", 0x52, 2, bytes.fromhex("20062401"))
READ_ALL = b"\x4c" + INPUTS + b"\x08\x00"
WORDS = (1, 2, 3, 4, 5, 6, 7, 0x8000)


def imported(folder: Path, talk: list[tuple[bool, bytes]], *more: str) -> tuple[int, str]:
    capture = folder / "line.pcap"
    port = ["--port", "502"]  # of the frames that `conversation` makes
    capture.write_bytes(pcap(conversation(talk)))
    words = ["import", str(capture), "--as", "compactlogix", *port, "--out", str(folder / "line.mcap"), *more]
    said = CliRunner().invoke(build(), words)
    return said.exit_code, said.output


def images_in(folder: Path, slot: int = 1) -> tuple[list[int], list[list[int]], list[list[int]]]:
    """Return times, output words and input words of the trace."""
    with open_trace(folder / "line.mcap") as trace:
        scans = [
            (each.now_ns, list(each.outputs(slot).words), list(each.inputs(slot).words))
            for each in trace.scans()
        ]
    times, outputs, inputs = zip(*scans, strict=True)
    return (
        list(times),
        [[word & 0xFFFF for word in each] for each in outputs],
        [[word & 0xFFFF for word in each] for each in inputs],
    )


def test_a_read_of_all_words_and_a_write_behind_it(tmp_path: Path) -> None:
    """Unconnected and connected; the write belongs to the scan before it."""
    write = b"\x4d" + image("Local:1:O", DATA, element(3)) + pack("<HHH", 0xC3, 1, 0xABCD)
    talk = [
        (True, unconnected(READ_ALL)),
        (False, unconnected(done(0x4C, ints(*WORDS)))),
        (True, connected(write, 9, 100)),
        (False, connected(done(0x4D), 9, 200)),
        (True, unconnected(b"\x4c" + image("Local:1:I", DATA, element(0)) + b"\x01\x00", 2)),
        (False, unconnected(done(0x4C, ints(0xFFFF)), 2)),
    ]
    code, said = imported(tmp_path, talk)
    assert code == 0
    assert "output words that no client reads or writes, 0 in the trace: 0, 1, 2, 4, 5, 6, 7" in said
    assert "input words" not in said
    times, outputs, inputs = images_in(tmp_path)
    assert times == [1 * MS, 5 * MS]
    assert outputs == [[0, 0, 0, 0xABCD, 0, 0, 0, 0]] * 2
    assert inputs == [list(WORDS), [0xFFFF, *WORDS[1:]]]


def test_a_batch_is_one_scan_whatever_it_holds(tmp_path: Path) -> None:
    """In an Unconnected Send: a word of inputs, a refused read, a bit, the whole structure of outputs."""
    parts = [
        (b"\x4c" + image("Local:1:I", DATA, element(2)) + b"\x01\x00", done(0x4C, ints(9))),
        (b"\x4c" + image("Nothing") + b"\x01\x00", done(0x4C, b"", 5)),
        (
            b"\x4c" + image("Local:1:I", bytes.fromhex("91 08") + b"ModuleOK") + b"\x01\x00",
            done(0x4C, b"\xc1\x00\x01"),
        ),
        (
            b"\x4c" + image("Local:1:O") + b"\x01\x00",
            done(0x4C, bytes.fromhex("a002 1234") + pack("<8H", *WORDS)),
        ),
    ]
    inner = b"\x0a\x02\x20\x02\x24\x01" + batch(*(asked for asked, _ in parts))
    asked = ROUTED + pack("<BBH", 10, 250, len(inner)) + inner + bytes(len(inner) % 2) + b"\1\0\1\0"
    talk = [(True, unconnected(asked)), (False, unconnected(done(0x0A, batch(*(said for _, said in parts)))))]
    assert imported(tmp_path, talk)[0] == 0
    times, outputs, inputs = images_in(tmp_path)
    assert (times, outputs) == ([1 * MS], [list(WORDS)])
    assert inputs == [[0x4000, 0, 9, 0, 0, 0, 0, 0]]


def test_parts_masks_and_numbers_out_of_the_list_of_tags(tmp_path: Path) -> None:
    """52h from byte 4 on of the structure, which begins with Fault; 4Eh; a tag by its number in the list."""
    symbol = bytes.fromhex("20 6b 25 00 2a 00")
    by_number = b"\x4c" + bytes([len(symbol + DATA + element(7)) // 2]) + symbol + DATA + element(7)
    part = b"\x52" + image("Local:1:I") + pack("<HI", 1, 4)
    line = pack("<IH", 42, 9) + b"Local:1:I" + pack("<H", 0x8123)
    talk = [
        (True, unconnected(b"\x55\x03\x20\x6b\x25\x00\x00\x00" + pack("<HHH", 2, 1, 2))),
        (False, unconnected(done(0x55, line))),
        (True, unconnected(part)),
        (False, unconnected(done(0x52, bytes.fromhex("a002 1234") + pack("<8H", *WORDS)))),
        (True, unconnected(b"\x4e" + image("Local:1:O", DATA, element(1)) + pack("<HHH", 2, 0x8001, 0xFF0F))),
        (False, unconnected(done(0x4E))),
        (True, unconnected(by_number + b"\x01\x00")),
        (False, unconnected(done(0x4C, ints(77)))),
    ]
    assert imported(tmp_path, talk)[0] == 0
    _, outputs, inputs = images_in(tmp_path)
    assert inputs == [list(WORDS), [*WORDS[:7], 77]]
    assert [each[1] for each in outputs] == [0x8001, 0x8001]  # 0 or 8001h, and FF0Fh


def test_a_batch_whose_places_go_back_has_no_messages() -> None:
    """Each would be read again."""
    head, places = b"\x0a\x02\x20\x02\x24\x01", pack("<H3H", 3, 8, 40, 8)
    batched = places.ljust(40, b"x")
    assert not _batch_messages(batched)
    pairing = CipPairing()
    assert not list(pairing.feed(0, unconnected(head + batched), to_device=True, fresh=True))
    assert not list(pairing.feed(1, unconnected(done(0x0A, batched)), to_device=False, fresh=True))


def test_one_slot_of_several(tmp_path: Path) -> None:
    read = b"\x4c" + image("Local:3:I", DATA) + b"\x08\x00"
    talk = [(True, unconnected(READ_ALL)), (False, unconnected(done(0x4C, ints(*WORDS))))]
    talk += [(True, unconnected(read)), (False, unconnected(done(0x4C, ints(*reversed(WORDS)))))]
    code, said = imported(tmp_path, talk)
    assert code == 2
    assert "several units (1, 3): give --address" in said
    assert imported(tmp_path, talk, "--address", "3")[0] == 0
    assert images_in(tmp_path, 3)[2] == [list(reversed(WORDS))]


@pytest.mark.parametrize(
    "reply",
    [
        b"",
        b"\xcc",
        done(0x4C),
        done(0x4C, b"\xc3"),
        done(0x4C, ints()),
        done(0x4D, ints(1)),
        done(0x4C, ints(1), 5),
        bytes((0xCC, 0, 0, 255)),
    ],
)
def test_replies_that_tell_nothing(tmp_path: Path, reply: bytes) -> None:
    code, said = imported(tmp_path, [(True, unconnected(READ_ALL)), (False, unconnected(reply))])
    assert code == 2
    assert "no exchange at port 502" in said


@pytest.mark.slow
def test_every_beginning_of_a_message_and_every_single_byte_changed(tmp_path: Path) -> None:
    """A damaged capture ends with status 0 or 2, never otherwise."""
    asked, answer = unconnected(READ_ALL), unconnected(done(0x4C, ints(*WORDS)))
    talks = [[(True, asked[:end]), (False, answer[:end])] for end in range(0, len(answer), 5)]
    for at in range(0, len(asked), 2):
        damaged = asked[:at] + bytes([asked[at] ^ 0xFF]) + asked[at + 1 :]
        talks.append([(True, damaged), (False, answer), (True, asked), (False, answer)])
    assert {imported(tmp_path, talk)[0] for talk in talks} <= {0, 2}


def test_reads_of_tags_alone_are_counted(tmp_path: Path) -> None:
    """Two of the three name a tag, one a number that the controller gave before the capture began."""
    numbered = b"\x4c\x03" + bytes.fromhex("206b25001200") + b"\x01\x00"
    named = b"\x4c" + image("Run") + b"\x01\x00"
    talk = []
    for context, request in enumerate((named, numbered, named), 1):
        talk += [(True, unconnected(request, context)), (False, unconnected(done(0x4C, ints(1)), context))]
    status, said = imported(tmp_path, talk)
    assert status == 2
    told = "3 reads of tags, 1 of them by numbers without a name in the capture, none of Local:n:I"
    assert told in said
