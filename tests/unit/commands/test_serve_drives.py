"""`scanrack serve smd23e2` and the other networked drives, over sockets."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from struct import pack, unpack
from time import monotonic, sleep
from typing import ClassVar

import pytest
from drive_served import TIMEOUT_S, ControlLine, serving
from drive_unit import ENABLE, VALID
from scanrack.io_images.drives.models import MODELS
from scanrack.jobs.serve.drives import DriveService
from scanrack.jobs.serve.line import wire
from scanrack.runtime import Clock

STOPPED, ACKNOWLEDGE = 0x0008, 0x2000
SECONDS = 20


@pytest.fixture(autouse=True)
def _closed() -> Iterator[None]:
    yield
    for each in Client.opened:
        each.close()
    Client.opened.clear()


class Client:
    """A plain client of Modbus TCP: frames by hand."""

    opened: ClassVar[list[socket.socket]] = []

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=TIMEOUT_S)
        self.opened.append(self.socket)

    def ask(self, form: str, *values: int) -> bytes:
        pdu = pack(">" + form, *values)
        self.socket.sendall(pack(">HHHB", 7, 0, len(pdu) + 1, 1) + pdu)
        head = self._read(7)
        assert head[:4] == b"\0\7\0\0"
        return self._read(int.from_bytes(head[4:6], "big") - 1)

    def _read(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            more = self.socket.recv(count - len(data))
            assert more
            data += more
        return data

    def read(self, first: int = 0, count: int = 10) -> tuple[int, ...]:
        reply = self.ask("BHH", 4, first, count)
        assert reply[0] == 4, reply.hex(" ")
        return unpack(f">{count}H", reply[2:])

    def write(self, first: int, *words: int) -> None:
        reply = self.ask(f"BHHB{len(words)}H", 16, first, len(words), 2 * len(words), *words)
        assert reply[0] == 16, reply.hex(" ")

    def until(self, mask: int, value: int) -> tuple[int, ...]:
        end = monotonic() + SECONDS
        while (words := self.read())[0] & mask != value:
            assert monotonic() < end, [f"{word:04x}" for word in words]
        return words

    def configure(self, at: int = 1024) -> None:
        self.write(at, *VALID)
        self.write(at, 0, ENABLE, *(0,) * 8)
        self.write(at, 0x0200, ENABLE, *(0,) * 8)
        self.write(at, 0, ENABLE, *(0,) * 8)


def closed(port: int) -> bool:
    """Whether a new connection is ended at once."""
    with socket.create_connection(("127.0.0.1", port), timeout=TIMEOUT_S) as client:
        try:
            return client.recv(1) == b""
        except ConnectionResetError:
            return True


def test_a_drive_is_configured_and_moves_in_step_with_the_clock() -> None:
    with serving("smd23e2", "--tcp", "0", "--time-scale", "20") as served:
        assert served.line.split("  ")[1].startswith("smd23e2; ")
        client = Client(served.port)
        assert client.read(0, 1) == (0x6408,)
        client.configure()
        client.write(1024, 1, ENABLE, 3, 0, 5, 0, 20, 20, 0, 0)
        assert client.until(STOPPED | 0x0080, STOPPED | 0x0080)[2:4] == (3, 0)


def test_a_seventh_connection_is_refused_and_costs_the_others_nothing() -> None:
    with serving("smd23e2", "--tcp", "0") as served:
        clients = [Client(served.port) for _ in range(6)]
        for each in clients:
            each.read()
        assert closed(served.port)
        for each in clients:
            each.read()
        clients.pop().socket.close()
        end = monotonic() + SECONDS
        while closed_or_served(served.port) is None:
            assert monotonic() < end


def closed_or_served(port: int) -> tuple[int, ...] | None:
    try:
        return Client(port).read()
    except (AssertionError, OSError):
        sleep(0.01)
        return None


@pytest.mark.parametrize(
    "noise",
    [b"\0\1\0\5\0\6\1\4\0\0\0\1", b"\0\1\0\0\0\0\1\4", b"\0\1\0\0\xff\xff\1\4", b"GET / HTTP/1.1\r\n\r\n"],
    ids=["protocol", "no length", "length", "text"],
)
def test_bytes_that_are_no_frame_end_their_connection_only(noise: bytes) -> None:
    with serving("smd23e2", "--tcp", "0") as served:
        good, bad = Client(served.port), Client(served.port)
        good.read()
        bad.socket.sendall(noise)
        assert bad.socket.recv(1) == b""
        assert good.read(0, 1) == (0x6408,)


def test_a_cut_frame_waits_and_costs_the_others_nothing() -> None:
    with serving("smd23e2", "--tcp", "0") as served:
        cut, good = Client(served.port), Client(served.port)
        frame = b"\0\1\0\0\0\6\1\4\0\0\0\1"
        cut.socket.sendall(frame[:5])
        assert good.read(0, 1) == (0x6408,)
        cut.socket.sendall(frame[5:])
        assert cut.socket.recv(64)[7:] == b"\4\2\x64\x08"


def test_exceptions_of_the_protocol() -> None:
    with serving("smd23e2", "--tcp", "0") as served:
        client = Client(served.port)
        assert client.ask("B", 7) == b"\x87\1"
        assert client.ask("BHH", 4, 10, 1) == b"\x84\2"
        assert client.ask("BHH", 6, 1034, 1) == b"\x86\2"
        assert client.ask("BHH", 4, 0, 0) == b"\x84\3"
        assert client.read(0, 1) == (0x6408,)


def test_every_unit_number_is_the_drives() -> None:
    """A reply repeats the unit of its request."""
    with serving("smd23e2", "--tcp", "0") as served:
        client = Client(served.port)
        for unit in (0, 1, 0xF7, 0xFF):
            client.socket.sendall(b"\0\1\0\0\0\6" + bytes((unit,)) + b"\4\0\0\0\1")
            assert client.socket.recv(64) == b"\0\1\0\0\0\5" + bytes((unit,)) + b"\4\2\x64\x08"


def test_a_configuration_in_six_pieces_is_the_drives_business() -> None:
    """SMDS writes word 0 second and the numbers after it [clients of the family]."""
    with serving("smd23e2", "--tcp", "0") as served:
        client = Client(served.port)
        for at in (1, 0, 2, 3, 4, 6, 7, 8):
            client.ask("BHH", 6, 1024 + at, VALID[at])
        client.write(1024, 0, ENABLE)
        assert client.read(0, 1)[0] & 0x2000 == 0


def test_a_stack_has_ten_registers_for_each_axis() -> None:
    with serving("anf2", "--tcp", "0", "--axes", "12") as served:
        assert "anf2 with 12 axes" in served.line
        client = Client(served.port)
        assert len(client.read(0, 120)) == 120
        assert client.ask("BHH", 4, 120, 1) == b"\x84\2"


def test_the_flash_outlives_the_service(tmp_path: Path) -> None:
    words = ("smd23e2", "--tcp", "0", "--memory", "drive.json")
    with serving(*words, cwd=tmp_path) as served:
        client = Client(served.port)
        client.write(1024, 0x8000, 0x4003, *VALID[2:])
        client.write(1024, 0, ENABLE)
    kept = json.loads((tmp_path / "drive.json").read_text("utf-8"))
    assert (kept["controller"], kept["units"][0]["writes"]) == ("smd23e2", 1)
    with serving(*words, cwd=tmp_path) as served:
        assert Client(served.port).read(0, 1)[0] & 0x2000 == 0


def test_pins_by_json_lines_and_the_state(tmp_path: Path) -> None:
    with (
        serving("smd23e2", "--tcp", "0", "--test-port", "0", "--record", "line.mcap", cwd=tmp_path) as served,
        closing(ControlLine(served.line)) as control,
    ):
        assert control.ask(pin="cable=lost") == {"ok": True}
        assert control.ask(pin="cable=connected") == {"ok": True}
        assert control.ask(pin="in9=on") == {
            "error": "no in9 at the SMD23E2; choose from in1, in2, driver_fault, encoder_error, cable, "
            "connection, stall, power, temperature, encoder"
        }
        state = control.ask(state=1)["state"]
        assert isinstance(state, dict)
        assert state["in.status_1"] & 0x0040
        assert state["flash_writes"] == 0


# without a process


def service(model: str = "smd23e2", axes: int = 1, machines: tuple[str, ...] = ()) -> DriveService:
    return DriveService(MODELS[model], Clock(), axes, machines, None)


@pytest.mark.parametrize(
    ("text", "word", "mask"),
    [
        ("in1=on", 1, 1),
        ("in2=on", 1, 2),
        ("in1=-5..5", 1, 1),
        ("temperature=95", 1, 0x10),
        ("encoder_error=on", 1, 0x1000),
        ("driver_fault=on", 1, 0x80),
    ],
)
def test_a_pin_shows_in_its_status_bit(text: str, word: int, mask: int) -> None:
    drives = service()
    drives.registers.answer(pack(">BHHB10H", 16, 1024, 10, 20, *VALID))
    drives.registers.answer(pack(">BHHB10H", 16, 1024, 10, 20, 0, ENABLE, *(0,) * 8))
    assert not drives.axes[0].inputs()[word] & mask
    wire(drives.units, text)
    drives.advance(drives.axes[0].now_ns + 1_000_000)
    assert drives.axes[0].inputs()[word] & mask


def test_the_encoder_is_turned_by_hand() -> None:
    drives = service()
    wire(drives.units, "encoder=-400")
    drives.advance(drives.axes[0].now_ns + 1_000_000)
    assert drives.axes[0].figures()[1] == -400


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("in1=high", "in1=high: must be on, off, or positions such as 9000.. or ..-3000 or 5..10"),
        ("cable=on", "cable=on: must be lost or connected"),
        ("temperature=hot", "temperature=hot: must be -273 to 1,000"),
        ("3:in1=on", "'3:in1=on' does not set an input: must be NAME=STATE, or ADDRESS:NAME=STATE"),
    ],
)
def test_a_pin_that_is_none(text: str, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        wire(service("ang1", 2).units, text)


@pytest.mark.parametrize(
    ("model", "axes", "allowed"), [("smd23e2", 2, "1"), ("ang1", 7, "1 to 6"), ("anf2", 0, "1 to 12")]
)
def test_a_stack_that_is_none(model: str, axes: int, allowed: str) -> None:
    with pytest.raises(ValueError, match=f"--axes {axes}: a stack of the {model.upper()} has {allowed}$"):
        service(model, axes)


RACK = """name = "bench"
program = "none.py"

[[slot]]
number = 1
module = "{module}"

[[slot.machine.switches]]
input = "home"
first = -10
last = 10
"""


@pytest.mark.parametrize("module", ["smd23e2", "amci3601"])
def test_a_machine_of_a_rack_acts_on_the_inputs(module: str, tmp_path: Path) -> None:
    rack = tmp_path / "rack.toml"
    rack.write_text(RACK.format(module=module), encoding="utf-8", newline="\n")
    drives = service(machines=(str(rack),))
    assert drives.axes[0].inputs()[1] & 1
    with pytest.raises(ValueError, match=r"in1 is wired to the machine \(home\)"):
        wire(drives.units, "in1=off")
