"""The simulated PCL601 against Modbus clients that others wrote.

mbpoll (libmodbus), minimalmodbus and pymodbus's client in Python, modbus-serial in JavaScript (found through
NODE_PATH). On a pseudo-terminal there is no parity.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from pymodbus import FramerType
from pymodbus.client import ModbusTcpClient
from serving601 import Serving, serving

minimalmodbus = pytest.importorskip("minimalmodbus")

TIMEOUT_S = 120
DEFAULTS = {4: 1000, 5: 0, 6: 500, 7: 5000, 8: 5000, 9: 1, 10: 1, 12: 1}
"""Registers at first: acceleration, base, maximum, jog speed [tutorial's values], CW, address, current on."""


@pytest.fixture(scope="module")
def pty() -> Iterator[Serving]:
    with serving(1, 2, pty=True) as server:
        yield server


@pytest.fixture(scope="module")
def tcp() -> Iterator[Serving]:
    with serving(tcp="0") as server:
        yield server


# -- mbpoll ------------------------------------------------------------------------------------------


def mbpoll(server: Serving, *arguments: str, address: int = 1) -> dict[int, int]:
    """Run mbpoll once; return what it read, by reference."""
    program = shutil.which("mbpoll")
    if program is None:
        pytest.skip("mbpoll is not installed")
    options = [word for word in arguments if word.startswith("-")]
    values = [word for word in arguments if not word.startswith("-")]
    serial = server.place.startswith("/")
    link = ["-m", "rtu", "-b", "38400", "-P", "none"] if serial else ["-m", "tcp", "-p", str(server.port)]
    where = server.place if serial else "127.0.0.1"
    words = [program, *link, "-a", str(address), "-o", "10", "-1", *options, where, *values]
    done = subprocess.run(
        words, capture_output=True, text=True, timeout=TIMEOUT_S, check=False, encoding="utf-8"
    )
    assert done.returncode == 0, done.stdout + done.stderr
    lines = [line for line in done.stdout.splitlines() if line.startswith("[")]
    return {int(line[1 : line.index("]")]): int(line.split()[1]) for line in lines}


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_mbpoll_reads_all_registers_and_writes(kind: str, request: pytest.FixtureRequest) -> None:
    server: Serving = request.getfixturevalue(kind)
    registers = mbpoll(server, "-t4", "-r1", "-c38")
    assert len(registers) == 38
    assert {n: registers[n] for n in DEFAULTS} == DEFAULTS
    mbpoll(server, "-t4", "-r6", "750")
    mbpoll(server, "-t4", "-r4", "2000", "0")
    assert mbpoll(server, "-t4", "-r4", "-c3") == {4: 2000, 5: 0, 6: 750}
    mbpoll(server, "-t4", "-r6", "500")
    mbpoll(server, "-t4", "-r4", "1000", "0")


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_mbpoll_switches_outputs_and_reads_inputs(kind: str, request: pytest.FixtureRequest) -> None:
    server: Serving = request.getfixturevalue(kind)
    mbpoll(server, "-t0", "-r3", "1")
    assert mbpoll(server, "-t0", "-r1", "-c8") == {n: int(n == 3) for n in range(1, 9)}
    mbpoll(server, "-t0", "-r1", *"00000000")
    assert mbpoll(server, "-t0", "-r3", "-c1") == {3: 0}
    assert set(mbpoll(server, "-t1", "-r1", "-c8").values()) == {0}
    assert mbpoll(server, "-t3", "-r1", "-c1") == {1: 0}


def test_mbpoll_finds_two_units_on_one_line(pty: Serving) -> None:
    mbpoll(pty, "-t4", "-r7", "4000", address=2)
    assert mbpoll(pty, "-t4", "-r7", "-c1", address=2) == {7: 4000}
    assert mbpoll(pty, "-t4", "-r7", "-c1") == {7: 5000}


# -- minimalmodbus -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_minimalmodbus_over_the_pseudo_terminal(pty: Serving) -> None:
    unit = minimalmodbus.Instrument(pty.place, 1)
    unit.serial.baudrate, unit.serial.timeout = 38_400, TIMEOUT_S
    assert unit.read_registers(3, 6) == [DEFAULTS[n] for n in range(4, 10)]
    unit.write_registers(12, [0xF448, 0xFFFF])
    low_word_first = minimalmodbus.BYTEORDER_LITTLE_SWAP
    assert unit.read_long(12, signed=True, byteorder=low_word_first) == -3000
    unit.write_long(12, 0, signed=True, byteorder=low_word_first)
    unit.write_bit(7, 1)
    assert unit.read_bits(0, 8, functioncode=1) == [0] * 7 + [1]
    unit.write_bit(7, 0)
    unit.serial.close()


# -- pymodbus ----------------------------------------------------------------------------------------


def test_pymodbus_over_modbus_tcp(tcp: Serving) -> None:
    with ModbusTcpClient("127.0.0.1", port=tcp.port, retries=0, timeout=TIMEOUT_S) as client:
        assert client.read_holding_registers(3, count=6, device_id=1).registers[0] == 1000
        assert client.write_coils(0, [True, False, True], device_id=1).count == 3
        assert client.read_coils(0, count=8, device_id=1).bits == [True, False, True] + [False] * 5
        client.write_coils(0, [False] * 8, device_id=1)
        assert client.write_register(34, 1, device_id=1).exception_code == 2
        assert client.read_holding_registers(38, count=1, device_id=1).exception_code == 2
        assert client.read_holding_registers(0, count=39, device_id=1).exception_code == 2


def test_pymodbus_over_rtu_over_tcp() -> None:
    with (
        serving(tcp="0", rtu_over_tcp=True) as server,
        ModbusTcpClient(
            "127.0.0.1", port=server.port, framer=FramerType.RTU, retries=0, timeout=TIMEOUT_S
        ) as client,
    ):
        for value in range(100, 130):
            assert client.write_register(5, value, device_id=1).registers == [value]
            assert client.read_holding_registers(5, count=1, device_id=1).registers == [value]


# -- modbus-serial (Node.js) -------------------------------------------------------------------------

SCRIPT = """
const ModbusRTU = require("modbus-serial");
const client = new ModbusRTU();
(async () => {
  await client.connectTCP("127.0.0.1", { port: Number(process.argv[2]) });
  client.setID(1);
  client.setTimeout(120000);
  await client.writeRegister(7, 4321);
  const registers = (await client.readHoldingRegisters(3, 6)).data;
  await client.writeCoil(1, true);
  const outputs = (await client.readCoils(0, 8)).data;
  await client.writeCoil(1, false);
  await client.writeRegister(7, 5000);
  console.log(JSON.stringify({ registers, outputs }));
  client.close(() => process.exit(0));
})();
"""


@pytest.mark.slow
def test_modbus_serial_in_javascript(tcp: Serving, tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    found = subprocess.run([node, "-e", 'require.resolve("modbus-serial")'], capture_output=True, check=False)
    if found.returncode:
        pytest.skip("the npm package modbus-serial is not installed where node finds it (NODE_PATH)")
    environment = {**os.environ, "NO_COLOR": "1"}
    words = [node, "-e", SCRIPT, "--", "client", str(tcp.port)]
    done = subprocess.run(
        words,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
        env=environment,
        encoding="utf-8",
    )
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said == {"registers": [1000, 0, 500, 5000, 4321, 1], "outputs": [False, True] + [False] * 6}


# -- tshark ------------------------------------------------------------------------------------------


def exchanges(server: Serving) -> list[tuple[bytes, bytes]]:
    """Speak all nine functions, and two that are refused; return request and reply, headers included."""
    pdus = [
        "01 0000 0008",
        "02 0000 0008",
        "03 0000 0026",
        "04 0000 0001",
        "05 0000 FF00",
        "06 0005 01F4",
        "0F 0000 0008 01 00",
        "10 0003 0002 04 03E8 0000",
        "11",
        "03 0026 0001",
        "08 0000 0000",
    ]
    pairs = []
    with socket.create_connection(("127.0.0.1", server.port), timeout=TIMEOUT_S) as client:
        for number, pdu in enumerate(map(bytes.fromhex, pdus)):
            request = b"".join(n.to_bytes(2) for n in (number, 0, len(pdu) + 1)) + b"\x01" + pdu
            client.sendall(request)
            pairs.append((request, client.recv(300)))
    return pairs


@pytest.mark.slow
def test_tshark_dissects_every_exchange_without_complaint(tcp: Serving, tmp_path: Path) -> None:
    """Every frame is Modbus/TCP for tshark, none malformed, none with a note of the expert's."""
    tshark, text2pcap = shutil.which("tshark"), shutil.which("text2pcap")
    if tshark is None or text2pcap is None:
        pytest.skip("tshark is not installed")
    pairs = exchanges(tcp)
    text, capture = tmp_path / "hex.txt", tmp_path / "modbus.pcap"
    lines = [
        f"{sign} 000000 {data.hex(' ')}\n" for pair in pairs for sign, data in zip("OI", pair, strict=True)
    ]
    text.write_text("".join(lines), encoding="utf-8")
    subprocess.run(
        [text2pcap, "-q", "-D", "-T", "502,40000", str(text), str(capture)],
        check=True,
        capture_output=True,
        timeout=TIMEOUT_S,
    )
    fields = ["modbus.func_code", "modbus.exception_code", "_ws.malformed", "_ws.expert.message"]
    words = [tshark, "-r", str(capture), "-T", "json", *(w for field in fields for w in ("-e", field))]
    done = subprocess.run(
        words, check=True, capture_output=True, text=True, timeout=TIMEOUT_S, encoding="utf-8"
    )
    layers = [packet["_source"]["layers"] for packet in json.loads(done.stdout)]
    codes = [1, 2, 3, 4, 5, 6, 15, 16, 17, 3, 8]
    assert [int(layer["modbus.func_code"][0]) for layer in layers] == [code for code in codes for _ in "IO"]
    assert [layer["modbus.exception_code"][0] for layer in layers if "modbus.exception_code" in layer] == [
        "2",
        "1",
    ]
    assert not [layer for layer in layers if "_ws.malformed" in layer]
    assert not [layer for layer in layers if "_ws.expert.message" in layer]
