"""A rack whose tags are served: without sockets, or in this process at a port of its own.

Each exchange is one scan, so nothing depends on the machine's speed.
"""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.runtime.config.server_table import ModbusTable
from scanrack.runtime.live.mailbox import Mailbox
from scanrack.runtime.live.tag_desk import NoTags, TagDesk
from scanrack.runtime.live.tag_server import ExchangeResults, TagServer
from scanrack.runtime.tag_servers.database import Database
from scanrack.runtime.tag_servers.exchange import ANSWER, Packet, request_of, results_in
from scanrack.runtime.tag_servers.router import Router
from scanrack.runtime.tag_servers.session import ClientSession, Frame
from scanrack.runtime.tag_servers.setup import MODBUS_TCP, TagSetup
from scanrack.runtime.tag_servers.tag_snapshot import Instant

PROGRAM = """CONTROLLER bench
TYPE Inner (Time : DINT, Valve : BOOL, Ready : BOOL, Speed : REAL)
TYPE Recipe (Id : INT, Flag : BOOL, Steps : Inner[3], Name : STRING, Bits : BOOL[64], Total : LREAL)
TYPE Hosted (Host : SINT HIDDEN, Go : BOOL AT Host.0, Stop : BOOL AT Host.1, Level : DINT[2,3])
TAG aBool : BOOL
TAG aSint : SINT := -5
TAG anInt : INT := -1234
TAG aDint : DINT := 123456
TAG aLint : LINT := -5000000000
TAG aUsint : USINT := 200
TAG aUint : UINT := 60000
TAG aUdint : UDINT := 4000000000
TAG aUlint : ULINT := 10000000000
TAG aReal : REAL := 1.5
TAG aLreal : LREAL := 2.25
TAG Dints : DINT[3000]
TAG Grid : INT[3,4] := [[1,2,3,4],[5,6,7,8],[9,10,11,12]]
TAG Flags : BOOL[64]
TAG Fill : TIMER := {"PRE": 5000}
TAG Text : STRING := "hello"
TAG Texts : STRING[3]
TAG One : Recipe
TAG Many : Recipe[4]
TAG Hosts : Hosted
TAG Locked : DINT := 7
TAG Scan : DINT
TAG C1 : DINT
TAG C2 : DINT
TASK Cycle : CONTINUOUS RUNS Main
PROGRAM Main
TAG Step : Inner
ROUTINE Start
ADD(Scan,1,Scan);
MOV(Scan,C1);
MOV(Scan,C2);
XIC(aBool)TON(Fill,5000,0);
END
END PROGRAM
"""

FILES = """PROJECT "feeder"
PROCESSOR "1764-LRP"
SLOT 1 OTHER 3 10 25
LADDER 2 "MAIN"
SOR XIC B3:1/1 TON T4:0 0.01 500 0 EOR
SOR XIC B3:1/2 CTU C5:0 10 3 EOR
DATA N7:0 1 2 3 -4 5 6 7 8 0 0 10 11 12 13 14 15
DATA T4:0 0 500 0 0 20 3
DATA C5:0 0 10 3
DATA R6:0 0 4 1
DATA B3:0 0 5 0 0
DATA F8:0 1.5 -2.25 0 0
DATA ST9:0 "abc" "hello world"
DATA L10:0 100000 -7
END
"""

RACK = """name = "bench"
program = "{program}"
scan_ms = 2

[server]
writable = {writable}

[[slot]]
number = 1
module = "amci3601"
"""

WRITABLE: tuple[str, ...] = (
    "a*",
    "Dints",
    "Grid",
    "Flags",
    "Fill",
    "Text*",
    "One.Steps",
    "One.Name",
    "Many",
    "Hosts",
)
WRITABLE += ("Program:Main.*", "Local:1:O.Data")


def write_rack(
    folder: Path, *, files: bool = False, writable: tuple[str, ...] = WRITABLE, tags: str = ""
) -> Path:
    """Write the bench, with more tags, and its rack file; return the path of that."""
    name = "bench.SLC" if files else "bench.rung"
    program = PROGRAM.replace("TASK Cycle", f"{tags}TASK Cycle")
    (folder / name).write_text(FILES if files else program, "utf-8")
    rack = folder / "bench.toml"
    patterns = ("*",) if files else writable
    rack.write_text(RACK.format(program=name, writable=list(patterns)).replace("'", '"'), "utf-8")
    return rack


class ServedRack:
    """A rack and its desk; an exchange is one scan."""

    def __init__(self, rack: Path, ports: ExitStack, trace: Path | None = None) -> None:
        job = load_job(str(rack))
        self.run = JobRun(job, ports, RunOptions(trace=trace, handled=True))
        mine, theirs = socket.socketpair()
        ports.callback(mine.close)
        ports.callback(theirs.close)
        self._waker = theirs
        self._mailbox = Mailbox()
        ports.callback(self._mailbox.close)
        self.hands = self.run.hands
        self.debugger: Any = self.run.program.debugger  # None: the program has no tags
        self.desk = TagDesk(
            self._mailbox,
            mine,
            self.hands,
            self.run.rack,
            self.run.cpu.period_ns,
            lambda: NoTags() if self.debugger is None else self.debugger.images,
            writes=True,
        )
        self.run.cpu.add_listener(self.desk)
        product = "1764-LRP" if self.desk.listing.files else "1769-L33ER scanrack"
        self.setup = TagSetup(
            self.desk.listing, 1, job.spec.server.writable, "bench", product, b"\x7f\0\0\1", 44818
        )

    def exchange(self, packets: list[Packet]) -> ExchangeResults:
        """Run a scan, behind which the packets are answered."""
        self._mailbox.post_request(request_of(self.desk.version, packets))
        self.run.cpu.run(1)
        self._waker.recv(16)
        data = self._mailbox.reply()
        version, now_ns = ANSWER.unpack_from(data)
        return ExchangeResults(now_ns, version, results_in(data, packets))


class Client:
    """A client without sockets; its messages are answered by a served rack."""

    def __init__(self, rack: ServedRack, address: str = "127.0.0.1:5000") -> None:
        self.rack, self._address = rack, address
        self.session = ClientSession(Router(Database(rack.desk.listing, rack.setup.writable), "bench"))
        self.handle = struct.unpack_from("<I", self.send(frame(0x65, b"\1\0\0\0")), 4)[0]

    def send(self, data: bytes) -> bytes:
        """Send bytes; return what comes back."""
        return b"".join(self._answer(each) for each in self.session.receive(data))

    def _answer(self, packet: Frame) -> bytes:
        plan = self.session.plan(packet, 1)
        found = self.rack.exchange([(self._address, plan.operations)])
        return self.session.reply(packet, Instant(found[2][0], found[0], found[1]))

    def ask(self, message: bytes) -> tuple[int, bytes]:
        """Send a message without a connection; return status and data."""
        reply = self.send(frame(0x6F, unconnected(message), self.handle))[40:]
        assert message[0] == 0x52 or reply[0] == message[0] | 0x80
        return reply[2], reply[4 + 2 * reply[3] :]


def frame(command: int, body: bytes = b"", session: int = 0, length: int | None = None) -> bytes:
    """Return a frame."""
    size = len(body) if length is None else length
    return struct.pack("<HHII8sI", command, size, session, 0, b"context.", 0) + body


def unconnected(message: bytes) -> bytes:
    """Return the body of a frame with a message."""
    return struct.pack("<IHHHHHH", 0, 0, 2, 0, 0, 0xB2, len(message)) + message


def symbol(*names: str | int) -> bytes:
    """Return a path of names and subscripts.

    >>> symbol("Grid", 300).hex(" ")
    '91 04 47 72 69 64 29 00 2c 01'
    """
    path = b""
    for each in names:
        if isinstance(each, int):
            path += b"\x29\0" + struct.pack("<H", each)
        else:
            path += bytes((0x91, len(each))) + each.encode() + b"\0" * (len(each) % 2)
    return path


def message(service: int, path: bytes, data: bytes = b"") -> bytes:
    """Return a message to a path."""
    return bytes((service, len(path) // 2)) + path + data


def batch(messages: list[bytes]) -> bytes:
    """Return a Multiple Service Packet."""
    at, offsets = 2 + 2 * len(messages), []
    for each in messages:
        offsets.append(at)
        at += len(each)
    head = struct.pack(f"<H{len(messages)}H", len(messages), *offsets)
    return message(0x0A, b"\x20\x02\x24\x01", head + b"".join(messages))


@contextmanager
def served(rack: Path, modbus: ModbusTable | None = None) -> Iterator[tuple[ServedRack, int]]:
    """Serve a rack at a port of this machine, in a thread, until the end.

    Args:
        modbus: serve these coils and registers instead.
    """
    with ExitStack() as ports:
        run = ServedRack(rack, ports)
        if modbus is not None:
            run.setup = replace(run.setup, protocol=MODBUS_TCP, modbus=modbus)
        listening = ports.enter_context(socket.create_server(("127.0.0.1", 0)))
        server = TagServer(run.setup, listening, None, run.exchange)
        ending = threading.Event()

        def serve() -> None:
            while not ending.is_set():
                server.step(0.02)

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield run, listening.getsockname()[1]
        finally:
            ending.set()
            thread.join()
            server.close()
