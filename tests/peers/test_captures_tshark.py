"""Captures that tshark has written and rewritten, and its own reading of the same frames."""

from __future__ import annotations

import shutil
import subprocess
from collections import Counter
from contextlib import ExitStack
from io import BytesIO
from pathlib import Path

import pytest
from captured import conversation, modbus_tcp, pcap
from scanrack.io_images.captures.packets import Capture
from scanrack.io_images.enip.codes import PORT
from scanrack.jobs.captures.pairing import ModbusTcpPairing
from scanrack.jobs.captures.reading import read_capture
from served_tags import Client, ServedRack, frame, message, unconnected, write_rack

TIMEOUT_S = 120
TALK = [
    part
    for number in range(1, 40)
    for part in (
        (True, modbus_tcp(number, "03 0000 0026" if number % 3 else "06 0005 0064")),
        (False, modbus_tcp(number, "03 4c" + 38 * " 0102" if number % 3 else "06 0005 0064")),
    )
]


def tshark(*arguments: str) -> str:
    program = shutil.which("tshark")
    if program is None:
        pytest.skip("tshark is not installed")
    words = [program, *arguments]
    done = subprocess.run(
        words, capture_output=True, text=True, timeout=TIMEOUT_S, check=False, encoding="utf-8"
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pcapng", "pcap", "nsecpcap"])
def test_files_that_tshark_writes_have_the_same_packets(tmp_path: Path, kind: str) -> None:
    own, theirs = tmp_path / "own.pcap", tmp_path / "theirs"
    own.write_bytes(pcap(conversation(TALK)))
    tshark("-r", str(own), "-F", kind, "-w", str(theirs))
    capture = Capture(BytesIO(theirs.read_bytes()))
    assert list(capture.packets()) == list(Capture(BytesIO(own.read_bytes())).packets())
    assert capture.cut_off is None


@pytest.mark.slow
def test_tshark_dissects_the_same_exchanges(tmp_path: Path) -> None:
    own = tmp_path / "own.pcap"
    own.write_bytes(pcap(conversation(TALK)))
    fields = ["-T", "fields", "-e", "tcp.dstport", "-e", "mbtcp.trans_id", "-e", "modbus.func_code"]
    lines = [line.split() for line in tshark("-r", str(own), "-Y", "mbtcp", *fields).splitlines()]
    theirs = Counter(int(code) for port, _, code in lines if port == "502")
    exchanges = read_capture(own, ModbusTcpPairing).exchanges
    assert Counter(each.request[0] for each in exchanges) == theirs == {3: 26, 6: 13}
    assert all(each.reply is not None for each in exchanges)


@pytest.mark.slow
def test_tshark_dissects_the_network_interface_of_a_tag_server(tmp_path: Path) -> None:
    talk: list[tuple[bool, bytes]] = []
    with ExitStack() as ports:
        client = Client(ServedRack(write_rack(tmp_path), ports))
        for path in ("20f52401", "20f62401"):
            asked = frame(0x6F, unconnected(message(1, bytes.fromhex(path))), client.handle)
            talk += [(True, asked), (False, client.send(asked))]
    own = tmp_path / "own.pcap"
    own.write_bytes(pcap(conversation(talk, target=("10.0.0.2", PORT))))
    names = (
        "tcpip.ip_addr",
        "tcpip.status.interface_config",
        "tcpip.subnet_mask",
        "elink.interface_speed",
        "elink.iflags.link_status",
        "elink.iflags.duplex",
        "elink.iflags.neg_status",
        "elink.physical_address",
    )
    fields = [word for name in names for word in ("-e", f"cip.{name}")]
    found = tshark(
        "-r", str(own), "-Y", "cip.tcpip.ip_addr or cip.elink.interface_speed", "-T", "fields", *fields
    )
    lines = [line.split("\t") for line in found.splitlines()]
    assert lines[0][:3] == ["127.0.0.1", "1", "0.0.0.0"]
    assert lines[1][3:] == ["1000", "1", "1", "3", "02:00:5c:a9:9a:cc"]
    assert not tshark("-r", str(own), "-Y", "_ws.malformed")
