"""A served SMD23E2 and clients that others wrote: Modbus masters, and scanners of EtherNet/IP."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess

import pytest
from drive_served import TIMEOUT_S, serving
from drive_unit import VALID
from peers import node, scanner, scanner_folder
from pymodbus.client import ModbusTcpClient

TEN = [0, 0x8000, 1, 2, 3, 4, 5, 6, 7, 8]
STATUS = 0x6408


@pytest.mark.slow
@pytest.mark.peer("pymodbus")
def test_pymodbus_uses_every_function() -> None:
    with serving("smd23e2", "--tcp", "0") as served, ModbusTcpClient("127.0.0.1", port=served.port) as client:
        assert client.write_registers(1024, TEN).count == 10
        assert client.read_holding_registers(1024, count=10).registers == TEN
        assert client.read_input_registers(0, count=1).registers == [STATUS]
        assert client.read_holding_registers(0, count=1).registers == [STATUS]
        assert client.read_discrete_inputs(0, count=16).bits == [bool(STATUS >> at & 1) for at in range(16)]
        assert client.write_register(1026, 9).registers == [9]
        assert client.write_coil(16384 + 16 * 3, True).bits[0]
        assert client.write_coils(16384 + 16 * 4, [True, True]).count == 2
        assert client.read_coils(16384 + 16 * 4, count=3).bits[:3] == [True, True, False]
        assert client.mask_write_register(address=1028, and_mask=0xFF00, or_mask=0x0012).or_mask == 0x12
        both = client.readwrite_registers(read_address=1024, read_count=10, write_address=1032, values=[1, 2])
        assert both.registers == [0, 0x8000, 9, 3, 0x12, 4, 5, 6, 7, 8]
        assert client.read_holding_registers(1032, count=2).registers == [1, 2]
        assert client.read_input_registers(10, count=1).exception_code == 2


@pytest.mark.slow
@pytest.mark.peer("modbus-serial")
def test_modbus_serial_uses_every_function_that_it_has() -> None:
    with serving("smd23e2", "--tcp", "0") as served:
        said = node("modbus-serial", "drive_port.cjs", served.port)
    assert said == {"words": [0, 0, 7, 2, 9, 0, 0, 0, 0, 0], "coils": [True, True, False], "status": STATUS}


@pytest.mark.slow
@pytest.mark.peer("mbpoll")
def test_mbpoll_reads_and_writes() -> None:
    """Its references begin at 1."""
    mbpoll = shutil.which("mbpoll")
    if mbpoll is None:
        pytest.skip("mbpoll is not installed")

    def run(kind: str, first: int, count: int, *values: str) -> list[int]:
        words = [mbpoll, "-m", "tcp", "-p", str(served.port), "-t", kind, "-r", str(first), "-1", "127.0.0.1"]
        words += values or ["-c", str(count)]
        done = subprocess.run(words, capture_output=True, encoding="utf-8", timeout=TIMEOUT_S, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return [int(line.split()[1]) for line in done.stdout.splitlines() if line.startswith("[")]

    with serving("smd23e2", "--tcp", "0") as served:
        run("4", 1027, 3, "1", "2", "3")
        assert run("4", 1027, 3) == [1, 2, 3]
        assert run("3", 1, 1) == [STATUS]
        assert run("1", 4, 1) == [1]
        run("0", 16385 + 16 * 5, 2, "1", "1")
        assert run("0", 16385 + 16 * 5, 3) == [1, 1, 0]


@pytest.mark.slow
@pytest.mark.peer("pycomm3")
def test_pycomm3_reads_identity_and_assemblies() -> None:
    pycomm3 = pytest.importorskip("pycomm3")
    with serving("smd23e2", "--ethernet-ip", "0", "--io-port", "0") as served:
        port = int(served.line.split()[0].rpartition(":")[2])
        driver = pycomm3.CIPDriver("127.0.0.1")
        driver._cfg["port"] = port  # it has no other way to name one
        with driver:
            found = driver.generic_message(service=1, class_code=1, instance=1, connected=False)
            assert found.value[:8] == bytes.fromhex("0a00 0c00 1d00 0106")
            read = driver.generic_message(
                service=0x0E, class_code=4, instance=100, attribute=3, connected=False
            )
            assert read.value[:2] == STATUS.to_bytes(2, "little")


@pytest.mark.slow
@pytest.mark.peer("ethernetip")
def test_the_scanner_ethernetip_moves_the_drive() -> None:
    """It knows the ports 44818 and 2222 only."""
    if scanner_folder("ethernetip") is not None and not free(44818):
        pytest.skip("the port 44818 is in use")
    with serving("smd23e2", "--ethernet-ip", "44818"):
        said = scanner("ethernetip", "scan_drive.py", "127.0.0.1")
    assert said == {"name": "SMD23E2", "opened": 0, "position": [3, 0], "closed": 0}


@pytest.mark.slow
@pytest.mark.peer("cm-ethernetip")
def test_the_scanner_cm_ethernetip_moves_the_drive() -> None:
    with serving("smd23e2", "--ethernet-ip", "0", "--io-port", "0") as served:
        port = served.line.split()[0].rpartition(":")[2]
        said = scanner("cm-ethernetip", "scan_drive_cm.py", "127.0.0.1", port, json.dumps(VALID))
    assert said == {"name": "SMD23E2", "status": [0x08, 0x64], "position": [3, 0]}


def free(port: int) -> bool:
    """Whether nothing listens at a port."""
    with socket.socket() as opened:
        return opened.connect_ex(("127.0.0.1", port)) != 0
