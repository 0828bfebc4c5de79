"""Exchanges in captures and logs, the traces made of them, and where a real controller differs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from captured import Frame, conversation, modbus_tcp, pcap, pcapng
from scanrack.commands import build
from scanrack.io_images.pmc006.frame import command, reply
from scanrack.io_images.pmc006.instructions import BY_NAME
from scanrack.jobs.captures.modeling import simulated
from scanrack.jobs.captures.pairing import ModbusTcpPairing, PairedExchange, Pairing, PmcPairing, RtuPairing
from scanrack.jobs.captures.reading import read_capture
from scanrack.jobs.captures.recording import statements_of
from scanrack.runtime.line.rtu import frame
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner

MS = 1_000_000
READ_BASE = bytes.fromhex("03 0005 0001")
BASE_500 = bytes.fromhex("03 02 01f4")
"""Register 4x6, the base speed, 500 at first."""

WRITE_BASE = bytes.fromhex("06 0005 0064")


def fed(pairing: Pairing, *parts: tuple[int, bool, bytes]) -> list[tuple[bytes, bytes | None]]:
    found = [
        each
        for at, to_device, data in parts
        for each in pairing.feed(at, data, to_device=to_device, fresh=False)
    ]
    return [(each.request, each.reply) for each in [*found, *pairing.finish()]]


def test_modbus_tcp_pairs_by_transaction_whatever_the_order_and_the_cuts() -> None:
    asked = modbus_tcp(1, "03 0005 0001") + modbus_tcp(2, "06 0005 0064")
    answered = modbus_tcp(2, "06 0005 0064") + modbus_tcp(1, "03 02 01f4")
    parts = [(0, True, asked[:5]), (1, True, asked[5:]), (2, False, answered[:20]), (3, False, answered[20:])]
    assert fed(ModbusTcpPairing(), *parts) == [(WRITE_BASE, WRITE_BASE), (READ_BASE, BASE_500)]


def test_modbus_tcp_without_a_reply_and_with_nonsense_between() -> None:
    """A transaction number used again ends the request before; bytes that are no frame are dropped."""
    parts = [
        (0, True, modbus_tcp(1, "03 0005 0001")),
        (1, True, modbus_tcp(1, "06 0005 0064")),
        (2, True, b"GET / HTTP/1.1\r\n\r\n"),
        (3, False, modbus_tcp(1, "06 0005 0064")),
        (4, False, modbus_tcp(9, "06 0005 0064")),
    ]
    assert fed(ModbusTcpPairing(), *parts) == [(READ_BASE, None), (WRITE_BASE, WRITE_BASE)]


def test_open_requests_are_bounded() -> None:
    pairing = ModbusTcpPairing()
    parts = [(at, True, modbus_tcp(at, "03 0005 0001")) for at in range(300)]
    found = [
        each
        for at, to_device, data in parts
        for each in pairing.feed(at, data, to_device=to_device, fresh=False)
    ]
    assert len(found) == 300 - 256


def test_rtu_pairs_a_request_with_the_frame_behind_it() -> None:
    read, answer, write = frame(1, READ_BASE), frame(1, BASE_500), frame(1, WRITE_BASE)
    exception = frame(1, b"\x86\x02")
    parts = [
        (0, True, read[:3]),
        (1, True, read[3:]),
        (2, False, answer[:1]),
        (3, False, answer[1:]),
        (4, True, write),
        (5, True, read),  # the write was not answered
        (6, False, answer[:-1] + b"?"),
        (7, True, write),
        (8, False, exception),
    ]
    assert fed(RtuPairing(), *parts) == [
        (READ_BASE, BASE_500),
        (WRITE_BASE, None),
        (READ_BASE, None),
        (WRITE_BASE, b"\x86\x02"),
    ]


def test_a_pmc006_is_paired_in_order() -> None:
    read, step = (BY_NAME[name].code for name in ("read_position", "step"))
    parts = [
        (0, True, command(1, read)),
        (1, False, b"\0" + reply(1, -5)),
        (2, True, command(1, step, 9)),
        (3, True, command(1, read)),
        (4, False, reply(1, 4)),
    ]
    signed = (-5).to_bytes(4, "little", signed=True)
    assert fed(PmcPairing(), *parts) == [
        (bytes((read, 0, 0, 0, 0)), signed),
        (bytes((step, 9, 0, 0, 0)), None),
        (bytes((read, 0, 0, 0, 0)), b"\4\0\0\0"),
    ]


TALK = [
    (True, modbus_tcp(1, "03 0005 0001")),
    (False, modbus_tcp(1, "03 02 01f4")),
    (True, modbus_tcp(2, "06 0005 0064")),
    (False, modbus_tcp(2, "06 0005 0064")),
    (True, modbus_tcp(3, "03 000c 0002")),
    (False, modbus_tcp(3, "03 04 fffe ffff")),
    (True, modbus_tcp(4, "06 0022 0001")),
    (False, modbus_tcp(4, "86 02")),
]
"""Base speed read and written, position -2, a refused write of Busy; a part every millisecond."""


def columns_of(path: Path) -> tuple[list[int], Any]:
    """Return the times of a trace's scans, and its tags."""
    with open_trace(path) as trace:
        columns = read_columns(trace, tags=True)
    return columns.time_ns.tolist(), columns.tags


@pytest.mark.parametrize("make", [pcap, pcapng])
def test_a_capture_becomes_a_trace(tmp_path: Path, make) -> None:
    (tmp_path / "line.pcapng").write_bytes(make(conversation(TALK)))
    out = tmp_path / "line.mcap"
    done = CliRunner().invoke(build(), ["import", str(tmp_path / "line.pcapng"), "--out", str(out)])
    assert (done.exit_code, done.stdout) == (0, f"{out}: 4 exchanges with unit 1\n")
    times, tags = columns_of(out)
    assert times == [1 * MS, 3 * MS, 5 * MS, 7 * MS]
    assert tags["base_speed"].tolist() == [500, 100, 100, 100]
    assert tags["position"].tolist() == [0, 0, -2, -2]
    assert tags["exception"].tolist() == [0, 0, 0, 2]
    assert tags["function"].tolist() == [3, 6, 3, 6]
    assert tags["reply_ms"].tolist() == [1.0] * 4


def test_a_log_of_frames_becomes_a_trace(tmp_path: Path) -> None:
    log = tmp_path / "line.log"
    lines = [
        "# a remark",
        f"12:00:00.250 TX: {frame(1, READ_BASE).hex(' ')}",
        f"12:00:00,257 rx: {frame(1, BASE_500).hex()}",
    ]
    log.write_text("\n".join(lines), encoding="utf-8")
    out = tmp_path / "line.mcap"
    done = CliRunner().invoke(build(), ["import", str(log), "--rtu-over-tcp", "--out", str(out)])
    assert (done.exit_code, done.stderr) == (0, "scanrack: note: lines without a frame: 1\n")
    times, tags = columns_of(out)
    assert (times, tags["base_speed"].tolist()) == ([7 * MS], [500])


@pytest.mark.parametrize(
    ("arguments", "content", "said"),
    [
        ([], b"nonsense", "not a capture; for a log of frames of a serial line"),
        (["--as", "pmc006"], b"nonsense", "neither a capture nor a log of frames"),
        ([], pcap([])[:30], "no exchange at port 502"),
        (["--port", "503"], pcap(conversation(TALK)), "no exchange at port 503; its ports are 502"),
        (["--address", "9"], pcap(conversation(TALK)), "no unit 9; it has 1"),
        (
            [],
            pcap(conversation([*TALK, (True, modbus_tcp(5, "03 0005 0001", unit=4))])),
            "several units (1, 4): give --address",
        ),
        (["--out", "line.bin"], pcap(conversation(TALK)), "line.bin is the capture"),
    ],
)
def test_what_cannot_be_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], content: bytes, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("line.bin").write_bytes(content)
    done = CliRunner().invoke(build(), ["import", "line.bin", *arguments])
    assert done.exit_code == 2
    assert said in done.stderr
    assert [each.name for each in tmp_path.iterdir()] == ["line.bin"]


PMC_READ = BY_NAME["read_position"].code

SPOKEN: dict[str, tuple[Callable[[int], tuple[bytes, bytes]], Callable[[], Pairing]]] = {
    "Modbus TCP": (
        lambda at: (modbus_tcp(at, "03 0005 0001"), modbus_tcp(at, f"03 02 {at:04x}")),
        ModbusTcpPairing,
    ),
    "RTU over TCP": (
        lambda at: (frame(1, READ_BASE), frame(1, b"\x03\x02" + at.to_bytes(2, "big"))),
        RtuPairing,
    ),
    "PMC006": (lambda at: (command(1, PMC_READ), reply(1, at)), PmcPairing),
}
"""A request and its reply by their number, and what finds them."""


@pytest.mark.parametrize("lost", [(3,), (5, 6, 7), (1,), (12,)], ids=str)
@pytest.mark.parametrize("spoken", SPOKEN)
def test_a_lost_reply_has_no_part_in_the_times_of_the_others(
    tmp_path: Path, spoken: str, lost: tuple[int, ...]
) -> None:
    """A request every 50 ms, each answered after 4 ms; some replies are not in the capture."""
    said, pairing = SPOKEN[spoken]
    talk = [part for at in range(1, 13) for part in zip((True, False), said(at), strict=True)]
    handshake, frames = conversation(talk)[:2], conversation(talk)[2:]
    there = [
        Frame((number // 2 * 50 + number % 2 * 4) * MS, each.data)
        for number, each in enumerate(frames)
        if number % 2 == 0 or number // 2 + 1 not in lost
    ]
    (tmp_path / "a.pcap").write_bytes(pcap([*handshake, *there]))
    captured = read_capture(tmp_path / "a.pcap", pairing)
    assert [(each.answered_ns - each.requested_ns) // MS for each in captured.exchanges if each.reply] == [
        4
    ] * (12 - len(lost))
    assert [each.requested_ns // MS // 50 + 1 for each in captured.exchanges if each.reply is None] == list(
        lost
    )
    places = 0 if lost[-1] == 12 else 1  # no later request says that the last one is lacking
    assert captured.notes == [
        *([f"gaps in the captured bytes: {places}"] if places else []),
        f"requests without a valid reply: {len(lost)}",
    ]


@pytest.mark.parametrize("make", [pcap, pcapng])
def test_frames_that_the_snap_length_cut_are_told(tmp_path: Path, make) -> None:
    """Requests have 66 bytes, replies up to 67; the handshake 54."""
    capture = tmp_path / "a.pcap"

    def imported(snap: int, *options: str) -> tuple[int, str]:
        capture.write_bytes(make(conversation(TALK), snap=snap))
        done = CliRunner().invoke(
            build(), ["import", str(capture), "--out", str(tmp_path / "a.mcap"), *options]
        )
        return done.exit_code, done.stderr

    whole = "; capture whole frames, with a snap length of 0\n"
    assert imported(66) == (
        0,
        f"scanrack: note: truncated frames: 1 at 66 bytes{whole}"
        "scanrack: note: gaps in the captured bytes: 1\n"
        "scanrack: note: requests without a valid reply: 1\n",
    )
    for snap, frames in ((60, "8 at 60 bytes"), (40, "10 at 40 bytes")):
        status, said = imported(snap)
        assert status == 2
        assert said.endswith(f"no complete exchange at port 502: truncated frames: {frames}{whole}")
    status, said = imported(66, "--as", "amci3601")
    assert status == 2
    assert "truncated frames: 1 at 66 bytes" in said


def test_a_truncated_capture_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.pcap").write_bytes(pcap(conversation(TALK))[:-1])
    captured = read_capture(tmp_path / "a.pcap", ModbusTcpPairing)
    assert len(captured.exchanges) == 4
    assert captured.notes[0].startswith("the file ends within a packet, at byte ")
    assert captured.notes[1] == "requests without a valid reply: 1"


def test_words_of_remote_io_become_scans(tmp_path: Path) -> None:
    """Written before the first read, read by 04 and 17h; a refused write and other registers are no words."""
    talk = [
        (True, modbus_tcp(1, "10 0000 0002 04 0001 0002")),
        (False, modbus_tcp(1, "10 0000 0002")),
        (True, modbus_tcp(2, "04 0000 0009")),
        (False, modbus_tcp(2, "04 12" + "".join(f"{word:04x}" for word in range(101, 110)))),
        (True, modbus_tcp(3, "06 0007 ffff")),
        (False, modbus_tcp(3, "06 0007 ffff")),
        (True, modbus_tcp(4, "06 0000 0007")),
        (False, modbus_tcp(4, "86 02")),
        (True, modbus_tcp(5, "17 0009 0001 0001 0001 02 0009")),
        (False, modbus_tcp(5, "17 02 0033")),
        (True, modbus_tcp(6, "03 0000 0008")),
        (False, modbus_tcp(6, "03 10" + 16 * "00")),
    ]
    (tmp_path / "line.pcap").write_bytes(pcap(conversation(talk)))
    out = tmp_path / "line.mcap"
    words = ["import", str(tmp_path / "line.pcap"), "--as", "amci3601", "--out", str(out)]
    done = CliRunner().invoke(build(), words)
    assert (done.exit_code, done.stdout) == (0, f"{out}: 2 scans of a PLC\n")
    with open_trace(out) as trace:
        scans = [
            (each.now_ns, list(each.outputs(1).words), list(each.inputs(1).words)) for each in trace.scans()
        ]
    inputs = list(range(101, 109))
    assert scans == [
        (3 * MS, [1, 2, 0, 0, 0, 0, 0, -1], inputs),
        (9 * MS, [1, 9, 0, 0, 0, 0, 0, -1], [101, 0x33, *inputs[2:]]),
    ]


def test_without_input_words_there_are_no_scans(tmp_path: Path) -> None:
    (tmp_path / "line.pcap").write_bytes(pcap(conversation(TALK[2:4])))
    done = CliRunner().invoke(build(), ["import", str(tmp_path / "line.pcap"), "--as", "amci3601"])
    assert done.exit_code == 2
    assert "no reads of input words" in done.stderr


# -- the model ---------------------------------------------------------------------------------------


def exchange(asked_ms: int, answered_ms: int, request: str, answer: str | None) -> PairedExchange:
    reply_ = None if answer is None else bytes.fromhex(answer)
    return PairedExchange(asked_ms * MS, answered_ms * MS, 1, bytes.fromhex(request), reply_)


def modeled(*exchanges: PairedExchange) -> list[dict[str, int]]:
    return [each.values for each in simulated("pcl601", statements_of("pcl601", exchanges))]


START = [
    exchange(0, 10, "06 0006 03e8", "06 0006 03e8"),  # at most 1000 steps/s
    exchange(20, 30, "06 0005 03e7", "06 0005 03e7"),  # 999 from the first step on
    exchange(40, 50, "10 0001 0002 04 2710 0000", "10 0001 0002"),  # 10,000 steps
    exchange(60, 80, "06 0000 0001", "06 0000 0001"),  # go
]


@pytest.mark.parametrize(
    ("real", "model"), [(120, 120), (125, 125), (139, 139), (141, 140), (90, 100), (0, 100), (9999, 140)]
)
def test_a_position_within_the_window_is_explained(real: int, model: int) -> None:
    """Go acts between 60 and 80 ms, the read between 180 and 200: 1000 steps/s for 100 to 140 ms."""
    read = exchange(180, 200, "03 000c 0002", f"03 04 {real:04x} 0000")
    assert modeled(*START, read)[-1]["position"] == pytest.approx(model, abs=1)


def test_a_register_that_differs_is_told() -> None:
    read = exchange(0, 10, "03 0005 0001", "03 02 01f5")
    assert modeled(read) == [{"base_speed": 500}]


def test_a_write_without_a_reply_has_acted() -> None:
    write = exchange(0, 0, "06 0005 0064", None)
    assert modeled(write, exchange(5, 9, "03 0005 0001", "03 02 0064")) == [{}, {"base_speed": 100}]


def test_a_pmc006_is_modeled_too() -> None:
    read = PairedExchange(0, MS, 1, bytes((BY_NAME["read_position"].code, 0, 0, 0, 0)), b"\7\0\0\0")
    [said] = simulated("pmc006", statements_of("pmc006", [read]))
    assert said.values == {"read_position": 0}


def test_the_two_traces_are_compared(tmp_path: Path) -> None:
    """The real controller says base speed 501 in its first exchange; later ones are as the model's."""
    talk = [(asked, data.replace(b"\x01\xf4", b"\x01\xf5")) for asked, data in TALK[:4]]
    (tmp_path / "line.pcap").write_bytes(pcap(conversation(talk)))
    real, model = str(tmp_path / "real.mcap"), str(tmp_path / "model.mcap")
    run = CliRunner()
    words = ["import", str(tmp_path / "line.pcap"), "--out", real, "--simulated", model, "--quiet"]
    assert run.invoke(build(), words).exit_code == 0
    told = run.invoke(build(), ["compare", real, model])
    assert told.exit_code == 1
    assert "differ, first in scan 0" in told.stdout
    assert "base_speed" in told.stdout
    assert "1 of 2 scans differ" in told.stdout
