"""Eight words out and eight in as Modbus registers: whole, torn, refused, and nonsense."""

from __future__ import annotations

from struct import pack

import pytest
from scanrack.runtime.line.remote_words import RemoteWords

INPUTS = list(range(101, 109))
WHOLE = [1, 2, 3, 4, 5, 6, 7, 0xFFFF]


def words(*, whole: bool = False) -> RemoteWords:
    return RemoteWords(lambda: INPUTS, whole=whole)


def writing(first: int, values: list[int]) -> bytes:
    return pack(f">BHHB{len(values)}H", 0x10, first, len(values), 2 * len(values), *values)


def reply(function: int, values: list[int]) -> bytes:
    return pack(f">BB{len(values)}H", function, 2 * len(values), *values)


def test_a_write_of_eight_words_is_an_exchange() -> None:
    remote = words()
    assert remote.answer(5, writing(0, WHOLE)) == bytes.fromhex("10 0000 0008")
    assert (remote.outputs, remote.exchanges, remote.torn, remote.heard_ns) == (WHOLE, 1, 0, 5)


def test_input_registers_are_the_inputs_and_three_facts() -> None:
    """3 ms after the only write: 1 exchange, none torn, 3 ms old."""
    remote = words()
    remote.answer(2_000_000, writing(0, WHOLE))
    assert remote.answer(5_999_999, bytes.fromhex("04 0000 000b")) == reply(4, [*INPUTS, 1, 0, 3])


def test_before_the_first_write_the_age_is_the_highest_number() -> None:
    assert words().answer(0, bytes.fromhex("04 000a 0001")) == bytes.fromhex("04 02 ffff")


def test_holding_registers_are_outputs_inputs_and_facts() -> None:
    remote = words()
    remote.answer(0, writing(0, WHOLE))
    assert remote.answer(0, bytes.fromhex("03 0000 0013")) == reply(3, [*WHOLE, *INPUTS, 1, 0, 0])


def test_function_17h_writes_and_then_reads() -> None:
    remote = words()
    request = pack(">BHHHHB8H", 0x17, 0, 16, 0, 8, 16, *WHOLE)
    assert remote.answer(0, request) == reply(0x17, [*WHOLE, *INPUTS])
    assert remote.exchanges == 1


def test_function_17h_with_an_impossible_read_writes_nothing() -> None:
    remote = words()
    assert remote.answer(0, pack(">BHHHHB8H", 0x17, 12, 8, 0, 8, 16, *WHOLE)) == bytes.fromhex("97 02")
    assert remote.outputs == [0] * 8


@pytest.mark.parametrize("torn", [bytes.fromhex("06 0002 0009"), writing(2, [9]), writing(0, [0, 0, 9, 0])])
def test_a_torn_write_is_carried_out_and_counted_or_refused(torn: bytes) -> None:
    loose, strict = words(), words(whole=True)
    assert loose.answer(0, torn)[0] == torn[0]
    assert (loose.outputs[2], loose.exchanges, loose.torn) == (9, 1, 1)
    assert strict.answer(0, torn) == bytes((torn[0] | 0x80, 2))
    assert (strict.outputs, strict.exchanges, strict.torn, strict.heard_ns) == ([0] * 8, 0, 1, None)


@pytest.mark.parametrize(
    ("request_", "code"),
    [
        ("01 0000 0001", 1),
        ("2b 0e 01 00", 1),
        ("03", 3),
        ("03 0000 0001 00", 3),
        ("03 0000 0000", 3),
        ("03 0000 007e", 3),
        ("03 0013 0001", 2),
        ("03 ffff 007d", 2),
        ("04 0008 0004", 2),
        ("06 0008 0000", 2),
        ("10 0000 0001 02", 3),
        ("10 0000 0002 02 0000", 3),
        ("10 0000 0001 02 0000 00", 3),
        ("10 0000 0000 00", 3),
        ("10 0001 0008 10" + 16 * "00", 2),
        ("17 0000 0001 0000 0001 02", 3),
        ("17 0000 0000 0000 0001 02 0000", 3),
        # count or byte count are wrong, and the address: the counts are checked first [6.12, 6.17]
        ("10 0000 007c f8" + 124 * "0000", 3),
        ("10 0000 007d fa" + 125 * "0000", 3),
        ("17 0000 0001 0000 007a f4" + 122 * "0000", 3),
        ("17 0000 0001 0000 007d fa" + 125 * "0000", 3),
        ("17 0013 0001 0000 0001 04 0000 0000", 3),
        ("10 0009 0001 04 0000 0000", 3),
    ],
)
def test_what_is_refused_changes_nothing(request_: str, code: int) -> None:
    """Exceptions 01h function, 02h address, 03h value [Modbus application protocol, section 7]."""
    remote = words()
    request = bytes.fromhex(request_)
    assert remote.answer(0, request) == bytes((request[0] | 0x80, code))
    assert (remote.outputs, remote.exchanges, remote.torn) == ([0] * 8, 0, 0)


def test_counts_go_round_at_65536() -> None:
    remote = words()
    remote.exchanges = remote.torn = 65_537
    assert remote.answer(0, bytes.fromhex("04 0008 0002")) == reply(4, [1, 1])


def test_a_module_of_31_words_has_31_registers_before_its_inputs() -> None:
    words = RemoteWords(lambda: range(1000, 1031), 31)
    written = [0, 0, 0, 31, 62] + [byte for word in range(31) for byte in (0, word)]
    assert words.answer(0, bytes([0x10, *written])) == bytes([0x10, 0, 0, 0, 31])
    assert (words.outputs, words.torn) == (list(range(31)), 0)
    assert words.answer(0, bytes([0x03, 0, 30, 0, 2])) == bytes([3, 4, 0, 30, 0x03, 0xE8])
    assert words.answer(0, bytes([0x04, 0, 30, 0, 1])) == bytes([4, 2, 0x04, 0x06])
    assert words.answer(0, bytes([0x06, 0, 31, 0, 1])) == bytes([0x86, 2])
    assert words.answer(0, bytes([0x06, 0, 30, 0, 9])) == bytes([6, 0, 30, 0, 9])
    assert (words.outputs[30], words.torn) == (9, 1)
