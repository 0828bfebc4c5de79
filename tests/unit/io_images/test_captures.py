"""Captures of a network: both formats, every layer, and files that lie about their lengths."""

from __future__ import annotations

from io import BytesIO
from itertools import pairwise
from struct import pack

import pytest
from captured import SERVER, SYN, Frame, block, ethernet, pcap, pcapng, segment
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.captures.packets import Capture, CaptureError, Packet
from scanrack.io_images.captures.segments import segment_in
from scanrack.io_images.captures.streams import Chunk, Streams

FRAMES = [Frame(1_700_000_000_123_456_789, b"one"), Frame(1_700_000_001_000_000_000, b"second")]


def packets(data: bytes) -> tuple[list[Packet], int | None]:
    capture = Capture(BytesIO(data))
    return list(capture.packets()), capture.cut_off


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("make", [pcap, pcapng])
def test_both_formats_in_both_byte_orders(make, order: str) -> None:
    found, cut_off = packets(make(FRAMES, order))
    assert [(each.at_ns, each.link_type, each.data) for each in found] == [
        (at_ns, 1, data) for at_ns, data in FRAMES
    ]
    assert cut_off is None


def test_times_of_microseconds() -> None:
    for data in (pcap(FRAMES, nanoseconds=False), pcapng(FRAMES, decimals=6)):
        assert [each.at_ns for each in packets(data)[0]] == [1_700_000_000_123_456_000, FRAMES[1].at_ns]


@pytest.mark.parametrize("make", [pcap, pcapng])
def test_a_file_that_was_cut_off_has_its_whole_packets(make) -> None:
    whole = make(FRAMES)
    for size in range(len(make(FRAMES[:1])) + 1, len(whole)):
        found, cut_off = packets(whole[:size])
        assert len(found) == 1
        assert cut_off == len(make(FRAMES[:1]))


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "it is not a capture: it begins with nothing"),
        (b"PK\3\4", "it is not a capture: it begins with 50 4b 03 04"),
        (pcap([])[:24] + pack("<IIII", 0, 0, 1 << 31, 0), "byte 24: a packet of 2,147,483,648 bytes"),
        (pack("<II", 0x0A0D0D0A, 30) + pack("<I", 0x1A2B3C4D), "byte 0: a block of 30 bytes"),
        (pack("<II", 0x0A0D0D0A, 12) + pack("<I", 0x1A2B3C4D), "byte 0: a block of 12 bytes"),
        (pack("<II", 0x0A0D0D0A, 28) + b"nope", "byte 0: a section with the byte order"),
        (pcapng([]) + pack("<II", 6, 0xFFFFFFFC), "a block of 4,294,967,292 bytes"),
        (pcapng([]) + block(1, b""), "an interface of 0 bytes; must be at least 8"),
        (pcapng([]) + block(6, b""), "a packet block of 0 bytes; must be at least 20"),
        (pcapng([]) + block(6, pack("<IIIII", 1, 0, 0, 0, 0)), "a packet of interface 1; must be below 1"),
        (pcapng([]) + block(6, pack("<IIIII", 0, 0, 0, 9, 9) + b"1234"), "a packet of 9 bytes in a block"),
        (pcapng([]) + block(3, pack("<I", 0)), "a packet without a time"),
        (pcapng([]) + block(5, b"")[:-1] + b"\1", "the length 12 at its beginning, 16,777,228 at its end"),
        (pcapng([]) + block(1, pack("<HHIHHBxxx", 1, 0, 0, 9, 1, 99)), "unsupported unit of time, 10**-99 s"),
    ],
)
def test_lengths_and_numbers_that_are_refused(data: bytes, said: str) -> None:
    with pytest.raises(CaptureError) as refused:
        packets(data)
    assert said in str(refused.value)


def test_too_many_interfaces_are_refused() -> None:
    with pytest.raises(CaptureError, match="more than 1,024 interfaces"):
        packets(pcapng([]) + 1024 * block(1, pack("<HHI", 1, 0, 0)))


@given(st.sampled_from([pcap, pcapng]), st.lists(st.tuples(st.integers(0, 200), st.integers(0, 255))))
def test_no_byte_of_a_file_breaks_the_reader(make, changes: list[tuple[int, int]]) -> None:
    data = bytearray(make([Frame(at_ns, ethernet(segment(b"abc", 7))) for at_ns, _ in FRAMES]))
    for at, value in changes:
        data[at % len(data)] = value
    capture = Capture(BytesIO(bytes(data)))
    try:
        for packet in capture.packets():
            segment_in(packet)
    except CaptureError:
        pass


# -- segments ----------------------------------------------------------------------------------------


def ipv6(payload: bytes, following: int = 6) -> bytes:
    ends = bytes(15) + b"\1" + bytes(15) + b"\2"
    return pack(">IHBB", 6 << 28, len(payload), following, 64) + ends + payload


TCP = segment(b"abc", 7)[20:]


@pytest.mark.parametrize(
    ("link", "data", "source"),
    [
        (1, ethernet(segment(b"abc", 7)), "10.0.0.1"),
        (1, ethernet(segment(b"abc", 7) + bytes(6)), "10.0.0.1"),  # padding of a short frame
        (1, ethernet(segment(b"abc", 7), vlans=[1, 2]), "10.0.0.1"),
        (0, pack("<I", 2) + segment(b"abc", 7), "10.0.0.1"),
        (101, segment(b"abc", 7), "10.0.0.1"),
        (113, bytes(14) + b"\x08\x00" + segment(b"abc", 7), "10.0.0.1"),
        (276, b"\x08\x00" + bytes(18) + segment(b"abc", 7), "10.0.0.1"),
        (1, ethernet(ipv6(TCP), 0x86DD), "::1"),
        (1, ethernet(ipv6(bytes((6, 0)) + bytes(6) + TCP, 0), 0x86DD), "::1"),
    ],
)
def test_a_segment_is_found_behind_every_link_layer(link: int, data: bytes, source: str) -> None:
    found = segment_in(Packet(5, link, data))
    assert found is not None
    assert (found.source, found.target[1], found.sequence, found.data) == ((source, 50_000), 502, 7, b"abc")


@pytest.mark.parametrize(
    "data",
    [
        b"",
        ethernet(b""),
        ethernet(b"\x45"),
        ethernet(segment(b"abc", 7), kind=0x0806),
        ethernet(segment(b"abc", 7)[:-1]),  # the capture cut it short
        ethernet(segment(b"abc", 7, fragment=0x2000)),
        ethernet(segment(b"abc", 7, fragment=1)),
        ethernet(segment(b"abc", 7).replace(b"\x40\x06", b"\x40\x11", 1)),  # UDP
        ethernet(b"\x41" + segment(b"abc", 7)[1:]),  # a header of four bytes
        ethernet(segment(b"abc", 7)[:32] + b"\xf0" + segment(b"abc", 7)[33:]),  # TCP's of sixty
        ethernet(ipv6(bytes((0, 255)), 0), 0x86DD),
        ethernet(segment(b"abc", 7), vlans=range(9)),
    ],
)
def test_what_is_no_whole_segment_is_passed_over(data: bytes) -> None:
    assert segment_in(Packet(0, 1, data)) is None


@pytest.mark.parametrize("make", [pcap, pcapng])
def test_a_frame_that_the_capture_cut_is_a_segment_without_its_data(make) -> None:
    """54 bytes are headers; a frame without data is whole in 60."""
    frames = [Frame(0, ethernet(segment(data, 7, acknowledged=9))) for data in (b"abcdef", b"1234567", b"")]
    capture = Capture(BytesIO(make(frames, snap=60)))
    found = [segment_in(packet) for packet in capture.packets()]
    assert [(each.data, each.cut, each.acknowledged) for each in found if each is not None] == [
        (b"abcdef", False, 9),
        (b"", True, 9),
        (b"", False, 9),
    ]
    assert str(capture.cut_frames) == "1 at 60 bytes"
    assert [segment_in(packet) for packet in Capture(BytesIO(make(frames, snap=47))).packets()] == [None] * 3


# -- streams -----------------------------------------------------------------------------------------


def stream(*parts: tuple[int, bytes], syn: int | None = None) -> tuple[list[tuple[bytes, bool]], Streams]:
    """Return the chunks of segments of one direction, each at a sequence number."""
    frames = [] if syn is None else [segment(b"", syn, flags=SYN)]
    chunks, streams = in_order(frames + [segment(data, sequence) for sequence, data in parts])
    return [(each.data, each.after_gap) for each in chunks], streams


def in_order(frames: list[bytes]) -> tuple[list[Chunk], Streams]:
    """Return the chunks of IP packets; the time of each is its number."""
    found = [segment_in(Packet(at, 101, data)) for at, data in enumerate(frames)]
    streams = Streams()
    return list(streams.chunks(each for each in found if each is not None)), streams


def test_early_segments_wait_for_those_before_them() -> None:
    assert stream((1, b"a"), (3, b"c"), (4, b"d"), (2, b"b"), syn=0)[0] == [(b"a", True), (b"bcd", False)]


def test_what_comes_again_is_passed_on_once() -> None:
    chunks, streams = stream((1, b"abc"), (1, b"abc"), (2, b"bcde"), (1, b"ab"), syn=0)
    assert chunks == [(b"abc", True), (b"de", False)]
    assert streams.repeated == 3 + 2 + 2


def test_sequence_numbers_go_round() -> None:
    assert stream((2**32 - 2, b"ab"), (0, b"cd"), syn=2**32 - 3)[0] == [(b"ab", True), (b"cd", False)]


def test_without_its_beginning_a_connection_begins_with_its_first_segment() -> None:
    assert stream((77, b"a"), (78, b"b"))[0] == [(b"a", True), (b"b", False)]


def test_bytes_that_never_come_are_a_gap() -> None:
    """Each has its own time, though only the end shows that none comes."""
    frames = [segment(data, at) for at, data in ((0, b"a"), (4, b"e"), (5, b"f"), (8, b"i"))]
    chunks, streams = in_order(frames)
    said = [(each.data, each.after_gap, each.at_ns) for each in chunks]
    assert said == [(b"a", True, 0), (b"e", True, 1), (b"f", False, 2), (b"i", True, 3)]
    assert streams.gaps == 2


def test_what_the_other_end_acknowledges_and_nobody_saw_is_missing() -> None:
    """Bytes 4 to 6 of the server are lost; what the client sends next says that it has all up to 9."""
    chunks, streams = in_order(
        [
            segment(b"abc", 1, asked=False),
            segment(b"ask", 1, acknowledged=4),
            segment(b"ghi", 7, asked=False, acknowledged=4),
            segment(b"", 4, acknowledged=10),  # without data: the bytes may still come, in another order
            segment(b"ask", 4, acknowledged=10),
            segment(b"jkl", 10, asked=False, acknowledged=7),
        ]
    )
    said = [(each.data, each.after_gap, each.at_ns) for each in chunks if each.source == SERVER]
    assert said == [(b"abc", True, 0), (b"ghi", True, 2), (b"jkl", False, 5)]
    assert [each.data for each in chunks] == [b"abc", b"ask", b"ghi", b"ask", b"jkl"]
    assert streams.gaps == 1


def test_bytes_up_to_an_acknowledged_one_are_missing_although_none_waits() -> None:
    chunks, streams = in_order(
        [
            segment(b"abc", 2**32 - 3, asked=False),
            segment(b"ask", 1, acknowledged=3),
            segment(b"ghi", 3, asked=False),
            segment(b"ask", 4, acknowledged=0),  # an old one says nothing new
        ]
    )
    said = [(each.data, each.after_gap, each.at_ns) for each in chunks if each.source == SERVER]
    assert said == [(b"abc", True, 0), (b"ghi", True, 2)]
    assert streams.gaps == 1


def test_a_new_connection_of_the_same_ends_begins_anew() -> None:
    frames = [segment(b"", 0, flags=SYN), segment(b"a", 1), segment(b"", 900, flags=SYN), segment(b"b", 901)]
    found = [segment_in(Packet(0, 101, data)) for data in frames]
    chunks = Streams().chunks(each for each in found if each is not None)
    assert [(each.data, each.after_gap) for each in chunks] == [(b"a", True), (b"b", True)]


def test_what_waits_is_bounded() -> None:
    """65 segments wait for a byte that never comes: one too many."""
    chunks, streams = stream((1, b"a"), *((3 + 2 * at, b"x") for at in range(66)), syn=0)
    assert streams.gaps == 66
    assert len(chunks) == 67


def test_connections_are_bounded() -> None:
    """1,025 clients send half of their bytes: the first one is forgotten, and begins anew."""
    frames = [segment(b"a", 1, source=("10.0.0.1", port), target=SERVER) for port in range(1025)]
    found = [segment_in(Packet(0, 101, data)) for data in [*frames, *frames[:1], *frames[-1:]]]
    streams = Streams()
    assert len(list(streams.chunks(each for each in found if each is not None))) == 1025 + 1
    assert streams.repeated == 1


@given(st.data())
def test_any_order_with_repetitions_gives_the_same_bytes(data: st.DataObject) -> None:
    whole = bytes(range(60))
    cuts = sorted(data.draw(st.sets(st.integers(1, 59), max_size=10)) | {0, 60})
    parts = [(1 + begin, whole[begin:end]) for begin, end in pairwise(cuts)]
    again = data.draw(st.lists(st.sampled_from(parts), max_size=5))
    mixed = data.draw(st.permutations(parts + again))
    chunks, streams = stream(*mixed, syn=0)
    assert b"".join(chunk for chunk, _ in chunks) == whole
    assert streams.gaps == 0
