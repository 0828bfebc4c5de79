"""Requests to all that answers Modbus, and answers to all that asks, valid and spoilt.

The oracles are plain: layouts of `modbus_standard`, and tables of registers and bits written here.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import modbus_standard as standard
import pytest
from bench601 import Bench601
from hypothesis import given
from hypothesis import strategies as st
from modbus_standard import BUSY, ILLEGAL_ADDRESS, ILLEGAL_FUNCTION, ILLEGAL_VALUE, exception
from pymodbus.pdu import ModbusPDU
from scanrack.io_images.pcl601 import MAP, WORDS, Code, Register
from scanrack.runtime.config.server_table import ModbusTable
from scanrack.runtime.line import pcl601_frames as frames
from scanrack.runtime.line import pcl601_pdus as pdus
from scanrack.runtime.line.clients.link import BadResponseError
from scanrack.runtime.line.clients.modbus import AnswerDecoder, ModbusExceptionError, check
from scanrack.runtime.line.master import LineRequest, Reply, Verdict
from scanrack.runtime.line.modbus_pdus import REQUESTS, encoded
from scanrack.runtime.line.remote_words import RemoteWords
from scanrack.runtime.tag_servers.database import Database
from scanrack.runtime.tag_servers.modbus_session import ModbusSession
from scanrack.runtime.tag_servers.register_map import RegisterMap
from scanrack.runtime.tag_servers.tag_snapshot import ReadBytes, TagSnapshot, WriteBytes
from served_tags import ServedRack, write_rack

Maker = Callable[[random.Random], bytes]
REQUESTS_IN_A_ROW = 40
SEEDS = st.integers(0, 2**32 - 1)


def spoilt(draw: random.Random, pdu: bytes) -> bytes:
    """Return a request that may no longer be valid, 1 byte or more."""
    data = bytearray(pdu)
    match draw.randrange(7):
        case 0:
            del data[draw.randrange(1, len(data) + 1) :]
        case 1:
            data += draw.randbytes(draw.randrange(1, 4))
        case 2 | 3:
            for _ in range(draw.randrange(1, 3)):
                data[draw.randrange(len(data))] = draw.randrange(256)
        case 4:
            data[0] = draw.choice([*range(0x19), *range(0x80, 0x98), 0x2B, 0xFF])
        case 5 if len(data) > 5:  # a byte count, if it is a write of several
            at = 9 if data[0] == 0x17 and len(data) > 9 else 5
            data[at] ^= 1 << draw.randrange(8)
        case _:
            return with_a_count_at_its_limit(draw)
    return bytes(data)


def with_a_count_at_its_limit(draw: random.Random) -> bytes:
    """Return a request whose count is the most that is allowed, or near it; address 0."""
    function = draw.choice((0x01, 0x02, 0x03, 0x04, 0x0F, 0x10, 0x17))
    counts = [draw.choice((0, most - 1, most, most + 1)) for _, most in standard.REQUESTS[function].counts]
    if function in (0x0F, 0x10):
        return standard.request(function, 0, data=(0,) * counts[0])
    if function == 0x17:
        return standard.request(function, 0, draw.choice((1, counts[0])), 0, data=(0,) * counts[1])
    return standard.request(function, 0, counts[0])


def played(
    seed: int, make: Maker, answers: Callable[[bytes], tuple[bytes, bytes]], most: int | None = None
) -> None:
    """Ask, in at most so many bytes; each answer and the expected one are equal."""
    draw = random.Random(seed)
    for _ in range(REQUESTS_IN_A_ROW):
        pdu = make(draw)
        assert standard.said(pdu) is not None  # valid as made
        if draw.random() < 0.6:
            pdu = spoilt(draw, pdu)[:most]
        answer, expected = answers(pdu)
        assert answer.hex(" ") == expected.hex(" "), pdu.hex(" ")


# --- the PCL601

PCL601_FUNCTIONS = (0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F, 0x10, 0x11)
OUTPUTS_READ, OUTPUTS, INPUTS = 16, 8, 8
POSITION_AT = 12


def pcl601_request(draw: random.Random) -> bytes:
    function = draw.choice((*PCL601_FUNCTIONS, 0x10, 0x10))
    if function in (0x01, 0x02, 0x03, 0x04):
        size = {0x01: OUTPUTS_READ, 0x02: INPUTS, 0x03: len(WORDS), 0x04: 1}[function]
        first = draw.randrange(size + 1)
        return standard.request(function, first, draw.randint(1, max(1, size - first)))
    if function == 0x05:
        return standard.request(function, draw.randrange(OUTPUTS + 1), draw.choice((0, 0xFF00)))
    if function == 0x0F:
        bits = tuple(draw.randrange(2) for _ in range(draw.randint(1, 9)))
        return standard.request(function, draw.randrange(OUTPUTS), data=bits)
    if function == 0x11:
        return standard.request(function)
    row = draw.choice([*MAP[1:], MAP[0]])
    value = draw.choice((row.low, row.high, row.default, draw.randint(row.low, row.high), row.high + 1))
    words = tuple(value >> 16 * word & 0xFFFF for word in range(row.words))
    if row.register is Register.COMMAND:
        words = (draw.choice((0, Code.STOP_MOTION, Code.CLEAR_ERRORS, Code.GO)),)
    if function == 0x06:
        return standard.request(function, row.address, words[0])
    return standard.request(function, row.address, data=words)


class Pcl601Oracle:
    """A PCL601, and the answers that its manual and the standard give."""

    def __init__(self) -> None:
        self.unit = Bench601().unit
        self.now_ns = 0

    def answers(self, pdu: bytes) -> tuple[bytes, bytes]:
        """Return the unit's answer and the expected one."""
        self.now_ns += 20_000_000
        self.unit.advance(self.now_ns)
        if self.unit.controller.protocol.name == "ASCII":
            self.unit.power_cycle(self.now_ns)
        expected = self._expected(pdu)
        answer = self.unit.answer(pdu)
        assert answer is not None
        if answer == expected and answer[0] in (0x06, 0x0F, 0x05, 0x10):
            self._check_written(pdu)
        return answer, expected

    def _expected(self, pdu: bytes) -> bytes:
        if pdu[0] not in PCL601_FUNCTIONS:
            return exception(pdu, ILLEGAL_FUNCTION)
        found = standard.said(pdu)
        if found is None:
            return exception(pdu, ILLEGAL_VALUE)
        fields, data = found
        if pdu[0] == 0x11:
            return bytes((0x11, 5, self.unit.controller.read()[Register.ADDRESS])) + b"1.00"
        if pdu[0] in (0x01, 0x02, 0x03, 0x04):
            return self._read(pdu, *fields)
        data = data or (int(fields[1] == 0xFF00) if pdu[0] == 0x05 else fields[1],)
        code = self._refusal(pdu[0], fields[0], data)
        return standard.write_reply(pdu) if code is None else exception(pdu, code)

    def _read(self, pdu: bytes, first: int, count: int) -> bytes:
        controller = self.unit.controller
        if pdu[0] == 0x03:
            values = controller.read()
            there = [values[row.register] >> 16 * word & 0xFFFF for row, word in WORDS]
        elif pdu[0] == 0x04:
            there = [controller.inputs.active()]
        elif pdu[0] == 0x01:
            there = [controller.output_pins >> at & 1 for at in range(OUTPUTS_READ)]
        else:
            there = [controller.inputs.active() >> at & 1 for at in range(INPUTS)]
        if first + count > len(there):
            return exception(pdu, ILLEGAL_ADDRESS)
        reply = standard.words_reply if pdu[0] in (0x03, 0x04) else standard.bits_reply
        return reply(pdu[0], tuple(there[first : first + count]))

    def _refusal(self, function: int, first: int, data: standard.Said) -> int | None:
        controller = self.unit.controller
        if function in (0x05, 0x0F):
            return ILLEGAL_ADDRESS if first + len(data) > OUTPUTS else None
        targets = [row for row, _ in WORDS[first : first + len(data)]]
        if len(targets) < len(data) or not all(row.writable for row in targets):
            return ILLEGAL_ADDRESS
        for row, word in zip(targets, data, strict=True):
            if row.locked and controller.busy:
                return BUSY
            if row.words == 1 and not row.low <= word <= row.high:
                return ILLEGAL_VALUE
        if first <= POSITION_AT and first + len(data) >= POSITION_AT + 2:
            low, high = data[POSITION_AT - first : POSITION_AT - first + 2]
            position = (low | high << 16) - (high >> 15 << 32)
            return None if abs(position) <= 8_388_607 else ILLEGAL_VALUE
        return None

    def _check_written(self, pdu: bytes) -> None:
        """What was written is read, but for the command register, which reads 0."""
        found = standard.said(pdu)
        assert found is not None
        fields, data = found
        first = fields[0]
        if pdu[0] in (0x05, 0x0F):
            data = data or (int(fields[1] == 0xFF00),)
            assert self.unit.answer(standard.request(0x01, first, len(data))) == standard.bits_reply(1, data)
            return
        data = data or (fields[1],)
        if first == 0:  # the command may change what was written behind it
            return
        assert self.unit.answer(standard.request(0x03, first, len(data))) == standard.words_reply(3, data)


@given(SEEDS)
def test_a_pcl601_answers_as_its_tables_say(seed: int) -> None:
    played(seed, pcl601_request, Pcl601Oracle().answers)


# --- the tag server

HOLDING = (  # address, tag, registers of a value, values, range of a register, and whether it has bits
    (0, "aDint", 2, 1, None, True),
    (2, "aReal", 2, 1, None, False),
    (4, "anInt", 1, 1, None, True),
    (5, "aSint", 1, 1, (-128, 127), False),
    (6, "Program:Main.Step.Time", 2, 1, None, True),
    (8, "aLint", 4, 1, None, True),
    (60, "aUsint", 1, 1, (0, 255), False),
    (200, "Grid", 1, 12, None, True),
)
READ_ONLY_AT, READ_ONLY_WORDS = 40, 2
COILS = (0, 1, 2, *range(8, 72))
READ_ONLY_COIL = 100
TAG_MAP = {
    "coils": (
        *({"address": at, "tag": tag} for at, tag in enumerate(("aBool", "Hosts.Go", "Hosts.Stop"))),
        {"address": 8, "tag": "Flags"},
        {"address": READ_ONLY_COIL, "tag": "Locked.0"},
    ),
    "discrete_inputs": ({"address": 7, "tag": "Flags[35]"}, {"address": 8, "tag": "Locked.2"}),
    "input_registers": ({"address": 30, "tag": "Locked"}, {"address": 50, "tag": "aLint"}),
    "holding_registers": (
        *({"address": at, "tag": tag} for at, tag, *_ in HOLDING),
        {"address": READ_ONLY_AT, "tag": "Locked"},
    ),
}
TAG_FUNCTIONS = (0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F, 0x10, 0x16, 0x17)


class Memory(TagSnapshot):
    """Bytes of tags, all 0 at first."""

    now_ns, version = 0, 1

    def __init__(self) -> None:
        self._tags: dict[int, bytearray] = {}

    def _bytes(self, tag: int) -> bytearray:
        return self._tags.setdefault(tag, bytearray(64))

    def read(self, wanted: ReadBytes) -> bytes:
        return bytes(self._bytes(wanted.tag)[wanted.offset : wanted.offset + wanted.size])

    def write(self, change: WriteBytes) -> None:
        data = self._bytes(change.tag)
        keep = change.keep or bytes(len(change.data))
        for at, (new, kept) in enumerate(zip(change.data, keep, strict=True), change.offset):
            data[at] = data[at] & kept | new & ~kept & 0xFF


class TagOracle:
    """A register map over empty tags, and plain registers and coils beside it."""

    def __init__(self, registers: RegisterMap) -> None:
        self._session, self._memory = ModbusSession(registers), Memory()
        self.words = {at + place: 0 for at, _, size, many, *_ in HOLDING for place in range(size * many)}
        self.words |= {READ_ONLY_AT + place: 0 for place in range(READ_ONLY_WORDS)}
        self.bits = dict.fromkeys((*COILS, READ_ONLY_COIL), 0)

    def answers(self, pdu: bytes) -> tuple[bytes, bytes]:
        """Return the map's answer and the expected one."""
        head = bytes.fromhex("0009 0000") + (len(pdu) + 1).to_bytes(2, "big") + b"\x07"
        (packet,) = self._session.receive(head + pdu)
        self._session.plan(packet, 1)  # changes nothing
        answer = self._session.reply(packet, self._memory)
        assert answer[:4] + answer[6:7] == head[:4] + head[6:]
        return answer[7:], self._expected(pdu)

    def _expected(self, pdu: bytes) -> bytes:
        if pdu[0] not in TAG_FUNCTIONS:
            return exception(pdu, ILLEGAL_FUNCTION)
        found = standard.said(pdu)
        if found is None:
            return exception(pdu, ILLEGAL_VALUE)
        (first, *more), data = found
        if pdu[0] in (0x01, 0x02, 0x03, 0x04):
            return self._read(pdu, first, more[0])
        if pdu[0] in (0x05, 0x0F):
            return self._write_bits(pdu, first, data or (int(more[0] == 0xFF00),))
        if pdu[0] == 0x16:
            return self._mask(pdu, first, *more)
        if pdu[0] == 0x17 and not all(at in self.words for at in range(first, first + more[0])):
            return exception(pdu, ILLEGAL_ADDRESS)
        at, words = (more[1], data) if pdu[0] == 0x17 else (first, data or (more[0],))
        code = self._refusal(at, words)
        if code is not None:
            return exception(pdu, code)
        self.words |= dict(enumerate(words, at))
        return self._read(pdu, first, more[0]) if pdu[0] == 0x17 else standard.write_reply(pdu)

    def _read(self, pdu: bytes, first: int, count: int) -> bytes:
        tables = {
            0x01: self.bits,
            0x02: {7: self.bits[8 + 35], 8: 0},
            0x04: {30: 0, 31: 0, **{50 + place: self.words[8 + place] for place in range(4)}},
        }
        table = tables.get(pdu[0], self.words)
        span = range(first, first + count)
        if not all(at in table for at in span):
            return exception(pdu, ILLEGAL_ADDRESS)
        reply = standard.bits_reply if pdu[0] in (0x01, 0x02) else standard.words_reply
        return reply(pdu[0], tuple(table[at] for at in span))

    def _write_bits(self, pdu: bytes, first: int, bits: standard.Said) -> bytes:
        if not all(at in COILS for at in range(first, first + len(bits))):
            return exception(pdu, ILLEGAL_ADDRESS)
        self.bits |= dict(enumerate(bits, first))
        return standard.write_reply(pdu)

    def _mask(self, pdu: bytes, at: int, keep: int, on: int) -> bytes:
        rows = [row for row in HOLDING if row[0] <= at < row[0] + row[2] * row[3]]
        if not rows or not rows[0][5]:
            return exception(pdu, ILLEGAL_ADDRESS)
        self.words[at] = self.words[at] & keep | on & ~keep & 0xFFFF
        return standard.write_reply(pdu)

    def _refusal(self, first: int, words: standard.Said) -> int | None:
        """Return why registers can't be written: the first row that does not take its own."""
        last = first + len(words)
        if not all(at in self.words for at in range(first, last)):
            return ILLEGAL_ADDRESS
        locked = READ_ONLY_AT, "Locked", READ_ONLY_WORDS, 1, None, False
        for row in sorted((*HOLDING, locked), key=lambda each: each[0]):
            at, _, size, many, limits, _ = row
            begin, end = max(first, at), min(last, at + size * many)
            if begin >= end:
                continue
            if row is locked or (begin - at) % size or (end - at) % size:
                return ILLEGAL_ADDRESS
            if limits is not None:
                least, most = limits
                signed = words[begin - first] - (words[begin - first] >> 15 << 16 if least < 0 else 0)
                if not least <= signed <= most:
                    return ILLEGAL_VALUE
        return None


def tag_request(draw: random.Random) -> bytes:
    function = draw.choice(TAG_FUNCTIONS)
    if function in (0x01, 0x02, 0x03, 0x04):
        spans = {0x01: ((0, 3), (8, 72), (100, 101)), 0x02: ((7, 9),), 0x04: ((30, 32), (50, 54))}
        low, high = draw.choice(spans.get(function, ((0, 12), (40, 42), (60, 61), (200, 212))))
        first = draw.randrange(low, high)
        return standard.request(function, first, draw.randint(1, high - first + (draw.random() < 0.1)))
    if function == 0x05:
        return standard.request(function, draw.choice((*COILS, READ_ONLY_COIL)), draw.choice((0, 0xFF00)))
    if function == 0x0F:
        first = draw.choice(COILS)
        return standard.request(
            function, first, data=tuple(draw.randrange(2) for _ in range(draw.randint(1, 20)))
        )
    at, _, size, many, limits, _ = draw.choice(HOLDING)
    if function == 0x16:
        return standard.request(function, at, draw.randrange(1 << 16), draw.randrange(1 << 16))
    least, most = limits or (0, 0xFFFF)
    words = tuple(draw.randint(least, most + (draw.random() < 0.1)) & 0xFFFF for _ in range(size * many))
    if function == 0x06:
        return standard.request(function, at, words[0])
    if function == 0x10:
        return standard.request(function, at, data=words)
    return standard.request(function, draw.choice((0, 4, 200)), draw.randint(1, 12), at, data=words)


@pytest.fixture(scope="module")
def registers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RegisterMap]:
    with ExitStack() as ports:
        rack = ServedRack(write_rack(Path(tmp_path_factory.mktemp("rack"))), ports)
        made = RegisterMap(
            Database(rack.desk.listing, rack.setup.writable), ModbusTable.model_validate(TAG_MAP)
        )
        assert made.problems == []
        yield made


@given(seed=SEEDS)
def test_a_tag_server_answers_as_its_map_says(registers: RegisterMap, seed: int) -> None:
    played(seed, tag_request, TagOracle(registers).answers, 253)


# --- remote words

REMOTE_INPUTS = tuple(range(101, 109))


class RemoteOracle:
    """Remote words, and a plain list of them."""

    def __init__(self) -> None:
        self._words = RemoteWords(lambda: REMOTE_INPUTS)
        self._outputs, self._exchanges, self._torn = [0] * 8, 0, 0

    def answers(self, pdu: bytes) -> tuple[bytes, bytes]:
        """Return the answer and the expected one; the time stands still."""
        answer = self._words.answer(0, pdu)
        return answer, self._expected(pdu)

    def _expected(self, pdu: bytes) -> bytes:
        if pdu[0] not in (0x03, 0x04, 0x06, 0x10, 0x17):
            return exception(pdu, ILLEGAL_FUNCTION)
        found = standard.said(pdu)
        if found is None:
            return exception(pdu, ILLEGAL_VALUE)
        (first, *more), data = found
        if pdu[0] in (0x03, 0x04, 0x17) and first + more[0] > (11 if pdu[0] == 0x04 else 19):
            return exception(pdu, ILLEGAL_ADDRESS)
        if pdu[0] in (0x06, 0x10, 0x17):
            at, words = (more[1], data) if pdu[0] == 0x17 else (first, data or (more[0],))
            if at + len(words) > 8:
                return exception(pdu, ILLEGAL_ADDRESS)
            self._outputs[at : at + len(words)] = words
            self._exchanges += 1
            self._torn += len(words) < 8
            if pdu[0] != 0x17:
                return standard.write_reply(pdu)
        facts = self._exchanges, self._torn, 0 if self._exchanges else 0xFFFF
        block = (*(() if pdu[0] == 0x04 else self._outputs), *REMOTE_INPUTS, *facts)
        return standard.words_reply(pdu[0], block[first : first + more[0]])


def remote_request(draw: random.Random) -> bytes:
    function = draw.choice((0x03, 0x04, 0x06, 0x10, 0x17))
    first = draw.randrange(19)
    if function in (0x03, 0x04):
        return standard.request(function, first, draw.randint(1, 20 - first))
    if function == 0x06:
        return standard.request(function, draw.randrange(9), draw.randrange(1 << 16))
    words = tuple(draw.randrange(1 << 16) for _ in range(draw.choice((8, 8, draw.randint(1, 8)))))
    at = draw.choice((0, 0, 8 - len(words), 1))
    if function == 0x10:
        return standard.request(function, at, data=words)
    return standard.request(function, first, draw.randint(1, 20 - first), at, data=words)


@given(SEEDS)
def test_remote_words_answer_as_their_map_says(seed: int) -> None:
    played(seed, remote_request, RemoteOracle().answers)


# --- masters


def any_request(draw: random.Random) -> bytes:
    """Return a valid request of any function that has an echo or a count."""
    function = draw.choice([each for each in standard.REQUESTS if each != 0x11])
    row, word = standard.REQUESTS[function], draw.randrange(1 << 16)
    if function == 0x05:
        return standard.request(function, word, draw.choice((0, 0xFF00)))
    if function in (0x06, 0x16):
        return standard.request(function, word, *(draw.randrange(1 << 16) for _ in row.fields[1:]))
    counts = [draw.choice((1, draw.randint(1, most), most)) for _, most in row.counts]
    if not row.data:
        return standard.request(function, word, counts[0])
    data = tuple(draw.randrange(2 if row.bits else 1 << 16) for _ in range(counts[-1]))
    return standard.request(function, *((word, counts[0]) if function == 0x17 else ()), word, data=data)


def good_answer(draw: random.Random, asked: bytes) -> bytes:
    found = standard.said(asked)
    assert found is not None
    fields, _ = found
    if asked[0] in (0x01, 0x02):
        return bytes((asked[0], -(-fields[1] // 8))) + draw.randbytes(-(-fields[1] // 8))
    if asked[0] in (0x03, 0x04, 0x17):
        return bytes((asked[0], 2 * fields[1])) + draw.randbytes(2 * fields[1])
    return standard.write_reply(asked)


def other_count(draw: random.Random, asked: bytes) -> bytes:
    """Return a whole answer of the same function, but to a request of another count, address or value."""
    answer = bytearray(good_answer(draw, asked))
    if asked[0] in (0x01, 0x02, 0x03, 0x04, 0x17):
        size = draw.choice((answer[1] - 2, answer[1] - 1, answer[1] + 1, answer[1] + 2)) & 0xFF
        return bytes((asked[0], size)) + draw.randbytes(size)
    answer[draw.randrange(1, len(answer))] ^= 1 << draw.randrange(8)
    return bytes(answer)


def judged(request: ModbusPDU, data: bytes) -> str:
    try:
        answer = AnswerDecoder().decode(data)
        answer.dev_id = request.dev_id
        check(request, answer)
    except ModbusExceptionError as refused:
        return "refused" if refused.code == data[1] else "refused with another code"
    except BadResponseError:
        return "bad"
    return "good"


@given(SEEDS)
def test_answers_are_judged_by_their_request(seed: int) -> None:
    draw = random.Random(seed)
    for _ in range(REQUESTS_IN_A_ROW):
        asked = any_request(draw)
        request = REQUESTS.decode(asked)
        assert request is not None
        assert encoded(request) == asked  # in the other direction, too
        answers = good_answer(draw, asked), other_count(draw, asked), exception(asked, draw.randrange(256))
        answer = draw.choice(answers)
        if draw.random() < 0.6:
            answer = spoilt(draw, answer)
        assert judged(request, answer) == standard.judged(asked, answer), (asked.hex(" "), answer.hex(" "))


UNIT = 9


def asked_on_a_line(draw: random.Random) -> LineRequest:
    """Return a request of those that the adapter of a PCL601 sends."""
    register = draw.choice([row.register for row in MAP if row.writable])
    words = [draw.randrange(1 << 16) for _ in range(draw.randint(1, 10))]
    pdu = draw.choice(
        (
            pdus.report_id(),
            pdus.read_input_register(),
            pdus.read_registers(register, draw.randint(1, 5)),
            pdus.write_registers(register, words),
            pdus.command(draw.choice(list(Code))),
            pdus.write_output(draw.randint(1, 8), draw.random() < 0.5),
        )
    )
    return frames.request(UNIT, pdu)


@given(SEEDS)
def test_frames_are_judged_by_their_request(seed: int) -> None:
    """An answer is complete or foreign by its bytes, and unfinished while it is shorter than a good one."""
    draw = random.Random(seed)
    for _ in range(REQUESTS_IN_A_ROW):
        request = asked_on_a_line(draw)
        asked = request.frame[1:-2]
        is_id = asked == b"\x11"
        identity = b"\x11\x05" + bytes((UNIT,)) + draw.randbytes(4)
        good = identity if is_id else good_answer(draw, asked)
        pdu = draw.choice((good, exception(asked, 3), good if is_id else other_count(draw, asked)))
        if draw.random() < 0.6:
            pdu = spoilt(draw, pdu)
        data = standard.rtu(draw.choice((UNIT, UNIT, UNIT, UNIT + 1)), pdu)
        if draw.random() < 0.2:
            data = data[: draw.randrange(len(data))]
        expected = "bad"
        if len(data) >= 4 and standard.rtu(UNIT, data[1:-2]) == data:
            expected = judged_id(pdu) if is_id else standard.judged(asked, pdu)
        found = request.read(data)
        if expected == "bad":
            assert found == (Verdict.UNFINISHED if len(data) < request.size else Verdict.FOREIGN), data.hex(
                " "
            )
        else:
            assert found == Reply(data, pdu[1] if expected == "refused" else None, words_in(asked, pdu))


def judged_id(pdu: bytes) -> str:
    """Judge the answer to 11h: five bytes, the unit's address first, and no run status [Appendix 3, 0x11]."""
    if len(pdu) == 2 and pdu[0] == 0x91:
        return "refused"
    return "good" if len(pdu) == 7 and pdu[:3] == bytes((0x11, 5, UNIT)) else "bad"


def words_in(asked: bytes, pdu: bytes) -> tuple[int, ...]:
    """Return the registers that a frame brings: those read, or the one that 06 repeats."""
    if pdu[0] in (0x03, 0x04):
        return tuple(int.from_bytes(pdu[at : at + 2], "big") for at in range(2, len(pdu), 2))
    return (int.from_bytes(asked[3:5], "big"),) if pdu[0] == 0x06 else ()
