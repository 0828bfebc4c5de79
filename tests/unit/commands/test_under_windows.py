"""Each command once as on Windows: its status and output, and neither a file nor a process is left behind.

What `tests/support/windows.py` imitates, and what it does not, is said there.
"""

from __future__ import annotations

import asyncio
import os
import shutil
import signal
import socket
import struct
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from scanrack.commands import COMMANDS
from scanrack.traces import ScanRecorder, SlotInfo
from watching import Watched, page_of
from windows import PATIENCE_S, Windows, start
from windows_files import users
from windows_modules import BREAK

ROOT = Path(__file__).parents[3]
FEEDER = ROOT / "examples/feeder"

PROGRAM = """
def logic(scan):
    scan.slot[1].outputs[4] = 1
"""

INVARIANTS = """
from scanrack import always

@always
def nothing_is_sent(now):
    return now.slot[1].outputs[4] != 1
"""

SMALL = "PROGRAM small\nTAG A : BOOL\nTAG B : BOOL\nROUTINE Main\nXIC(A)OTE(B);\nEND\n"
RACK = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
FILES = {
    "line.py": PROGRAM,
    "line.toml": f'program = "line.py"\n{RACK}',
    "must.py": INVARIANTS,
    "small.rung": SMALL,
    "small.toml": f'program = "small.rung"\n{RACK}',
}


class Row(NamedTuple):
    """A command, and what comes of it."""

    words: str
    status: int
    text: str  # in its output or its messages
    files: str = ""  # new ones in the folder where it runs, or folders


ROWS = [
    Row("new project --from feeder", 0, "project", "project"),
    Row("run feeder.toml --for 20ms --record made.mcap", 0, "made.mcap", "made.mcap"),
    Row(
        "run line.toml --for 20ms --realtime --record live.mcap",
        0,
        "SCHED_FIFO (this system has none): other programs delay scans: close them, or run on Linux",
        "live.mcap",
    ),
    Row("run small.toml --for 20ms --realtime --server ethernet-ip:0", 0, "EtherNet/IP server", "small.mcap"),
    Row("watch feeder.toml --for 20ms --time-scale max", 0, "http://127.0.0.1:"),
    Row("debug", 0, ""),
    Row("share t.mcap --out shared.html", 0, "shared.html", "shared.html"),
    Row("show t.mcap", 0, "+MODE_CONFIG"),
    Row("query t.mcap slot1.in.MODULE_OK", 0, "18 ms or more"),
    Row("plot t.mcap --out t.html", 0, "t.html", "t.html"),
    Row("export t.mcap --csv t.csv", 0, "t.csv", "t.csv"),
    Row("export t.mcap --vcd t.vcd --bits", 0, "t.vcd", "t.vcd"),
    Row("compare t.mcap t.mcap", 0, "show the same: 10 scans"),
    Row("repair cut.mcap", 0, "cut.mcap: repaired, 10 scans"),
    Row("import missing.pcapng", 2, "missing.pcapng: No such file"),
    Row("conform --list", 0, "relative moves"),
    Row("replay t.mcap", 0, "show the same: 10 scans"),
    Row("replay --into session t.mcap", 0, "10 scans, identical byte for byte"),
    Row("replay --into session p.mcap --trust", 0, "10 scans, identical byte for byte"),
    Row("ladder feeder.rung", 0, "║"),
    Row("tags feeder.toml", 0, "Local:1:I.Data"),
    Row("l5x missing.L5X", 2, "missing.L5X"),
    Row("why t.mcap Feeding", 0, "Feeding is off: Main rung 7"),
    Row("why t.mcap Feeding --want 1", 0, "Feeding comes on if"),
    Row("why p.mcap O:1.4 --trust", 0, "O:1.4"),
    Row("why p.mcap O:1.4 --trust --want 1", 0, "O:1.4"),
    Row("xref feeder.toml Feeding", 0, "OTE(Feeding)"),
    Row(
        "fuzz line.toml --for 20ms --runs 4 --jobs 1 --invariants must.py", 1, "nothing_is_sent", "line-fuzz"
    ),
    Row("fuzz small.toml --for 20ms --runs 4 --jobs 2", 0, "runs          4", "small-fuzz"),
    Row("prove small.rung", 0, "5 questions about rungs"),
    Row("drive pcl601", 0, ""),
    Row("serve pcl601 --program missing", 2, "missing"),
    Row("serve pcl601 --pty", 2, "no pseudo-terminals"),
    Row("serve smd23e2 --tcp 0 --axes 2", 2, "--axes 2"),
    Row("device pcl601 --tcp 127.0.0.1:1 status", 1, "127.0.0.1:1"),
    Row("device pmc006 --serial COM77 status", 1, "COM77"),
    Row("device list", 0, ""),
    Row("device identify tcp:127.0.0.1:1", 1, "127.0.0.1:1"),
    Row("check missing.pclt", 2, "missing.pclt"),
    Row("check line.toml", 0, "no findings"),
    Row("editor schema", 0, '"$schema"'),
    Row("editor lsp", 0, ""),
    Row("doctor", 0, "Python"),
    Row("rules amci3601", 0, "IOM-02"),
]


@pytest.fixture(scope="module")
def windows() -> Iterator[Windows]:
    """A process of Windows that runs commands."""
    with Windows() as windows:
        yield windows


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory, windows: Windows) -> Path:
    """A folder with a ladder program, one in Python, and a trace of each."""
    place = tmp_path_factory.mktemp("windows")
    for file in ("feeder.toml", "feeder.rung"):
        shutil.copy(FEEDER / file, place)
    for name, text in FILES.items():
        (place / name).write_text(text, encoding="utf-8")
    for rack, trace in {"feeder.toml": "t.mcap", "line.toml": "p.mcap"}.items():
        done = windows.run(["run", rack, "--for", "20ms", "--record", trace], place)
        assert not done.status, done.err
    (place / "cut.mcap").write_bytes((place / "t.mcap").read_bytes()[:-100])
    return place


@pytest.mark.slow
@pytest.mark.parametrize("row", [pytest.param(each, id=each.words) for each in ROWS])
def test_a_command(windows: Windows, place: Path, row: Row) -> None:
    before = set(place.iterdir())
    done = windows.run(row.words.split(), place)
    assert done.status == row.status, done
    assert row.text in done.out + done.err
    assert not done.left
    made = {each.name for each in {*place.iterdir()} - before} - {"__pycache__"}
    assert made == set(row.files.split())
    assert not [*place.rglob(".*.lock")], "a lock is left behind"


@pytest.mark.slow
def test_two_recorders_on_a_file(windows: Windows, place: Path) -> None:
    path = place / "held.mcap"
    recorder = ScanRecorder(path, bytearray(32), [SlotInfo(1, "amci3601", "4.1")], scan_period_ns=1)
    done = windows.run(["run", "small.toml", "--for", "20ms", "--record", path.name], place)
    recorder.close()
    assert (done.status, done.out) == (2, "")
    assert "held.mcap is being recorded" in done.err
    assert not windows.run(["repair", path.name], place).status


@pytest.mark.slow
def test_a_pipe_has_the_bytes_of_a_file(windows: Windows, place: Path) -> None:
    for kind in ("csv", "vcd"):
        piped = windows.run(["export", "t.mcap", f"--{kind}", "-"], place)
        assert not windows.run(["export", "t.mcap", f"--{kind}", "piped"], place).status
        assert piped.out.encode() == (place / "piped").read_bytes()
        (place / "piped").unlink()


@pytest.mark.slow
def test_a_server_that_ctrl_c_ends(tmp_path: Path) -> None:
    pipe = subprocess.PIPE
    with start(["serve", "pcl601", "--tcp", "0"], cwd=tmp_path, stdout=pipe, stderr=pipe) as server:
        assert server.stdout is not None
        port = int(server.stdout.readline().split()[0].rpartition(b":")[2])
        with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as client:
            client.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, 3, 0, 1))  # read register 0
            assert client.recv(64)[:2] == b"\0\1"  # now it does no more than serve
        server.send_signal(signal.SIGINT)
        out, err = server.communicate()
    assert (server.returncode, out) == (130, b""), err


HELLO_UA = b"HELF" + struct.pack("<6I", 32, 0, 1 << 16, 1 << 16, 0, 0) + struct.pack("<I", 0)
"""Hello of OPC UA, with an empty address [OPC 10000-6, table 72]."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("server", "said", "answer"),
    [
        ("ethernet-ip:0", struct.pack("<HHIIQI", 0x63, 0, 0, 0, 0, 0), b"\x63\0"),  # List Identity
        pytest.param("opc-ua:0", HELLO_UA, b"ACKF", marks=pytest.mark.extra("opcua")),
    ],
)
def test_a_client_of_tags_is_answered(place: Path, server: str, said: bytes, answer: bytes) -> None:
    pipe = subprocess.PIPE
    words = ["run", "small.toml", "--realtime", "--for", "1h", "--no-record", "--server", server]
    with start(words, cwd=place, stdout=pipe, stderr=pipe) as run:
        assert run.stderr is not None
        line = next(each for each in run.stderr if b"server on" in each)
        port = int(line.split(b"127.0.0.1:")[1].split(b":")[0])
        with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as client:
            client.sendall(said)
            assert client.recv(1 << 10).startswith(answer)
        run.send_signal(BREAK)
        out, err = run.communicate()
    assert run.returncode == 130, (out, err)
    assert b"again" not in err


@pytest.mark.slow
def test_a_console_is_read_beside_the_service(tmp_path: Path) -> None:
    console, end = os.openpty()
    with start(["serve", "pcl601", "--tcp", "0"], cwd=tmp_path, stdin=end, stderr=subprocess.PIPE) as server:
        os.write(console, b"in1=nonsense\n")
        assert server.stderr is not None
        assert b"nonsense" in server.stderr.readline()
        server.send_signal(BREAK)
        server.communicate()
    os.close(console)
    os.close(end)
    assert server.returncode == 130


@pytest.mark.slow
def test_a_page_is_served(place: Path) -> None:
    async def look() -> Any:
        async with page_of(session) as page:
            await page.until(lambda seen: seen.frame.get("scan", 0) > 10)
            return await page.ask("pause")

    with start(
        ["watch", "feeder.toml"], cwd=place, stdout=subprocess.PIPE, text=True, encoding="utf-8"
    ) as process:
        assert process.stdout is not None
        session = Watched(process, process.stdout.readline().split()[0])
        assert asyncio.run(look())["ok"]
        assert session.end() == 130


def test_an_open_file_is_seen_behind_a_number_that_is_free(tmp_path: Path) -> None:
    path = tmp_path / "held"
    number = os.open(os.devnull, os.O_RDONLY)
    with path.open("wb"):
        os.close(number)
        assert users(path) == [os.getpid()]
    assert users(path) == []


def test_each_command_has_a_row() -> None:
    assert {row.words.split()[0] for row in ROWS} == set(COMMANDS)
