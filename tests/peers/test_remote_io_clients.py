"""The 3601 as remote I/O of Modbus masters that others wrote: pymodbus, modbus-serial, mbpoll."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator

import forked
import pytest
from pymodbus.client import ModbusTcpClient

TIMEOUT_S = 120
ONES = [1] * 8
JAVASCRIPT = """
const Modbus = require("modbus-serial"), client = new Modbus();
(async () => {
  await client.connectTCP("127.0.0.1", {port: +process.argv[1]});
  client.setID(1);
  await client.writeRegisters(0, [3, 3, 3, 3, 3, 3, 3, 3]);
  await client.writeRegister(2, 3);
  const own = await client.readHoldingRegisters(0, 8), facts = await client.readInputRegisters(8, 2);
  console.log(JSON.stringify([...own.data, ...facts.data]));
  process.exit(0);
})();
"""


@pytest.fixture
def port() -> Iterator[int]:
    words = [sys.executable, "-m", "scanrack", "serve", "amci3601", "--tcp", "0", "--quiet"]
    process = forked.start(
        words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, encoding="utf-8"
    )
    try:
        assert process.stdout is not None
        yield int(process.stdout.readline().split("  ")[0].split(":")[1])
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=TIMEOUT_S)
        assert process.returncode == 130
    finally:
        process.kill()
        process.communicate()


@pytest.mark.slow
def test_pymodbus_exchanges_by_function_17h(port: int) -> None:
    with ModbusTcpClient("127.0.0.1", port=port, timeout=TIMEOUT_S) as client:
        for _ in range(100):
            both = client.readwrite_registers(read_address=0, read_count=8, write_address=0, values=ONES)
            assert both.registers == ONES
        assert client.read_input_registers(8, count=2).registers == [100, 0]


@pytest.mark.slow
def test_modbus_serial_writes_eight_words_and_one(port: int) -> None:
    node = shutil.which("node")
    if node is None or not os.environ.get("NODE_PATH"):
        pytest.skip("node with modbus-serial under NODE_PATH is not installed")
    words = [node, "-e", JAVASCRIPT, str(port)]
    done = subprocess.run(
        words, capture_output=True, text=True, timeout=TIMEOUT_S, check=False, encoding="utf-8"
    )
    if "Cannot find module" in done.stderr:
        pytest.skip("modbus-serial is not installed under NODE_PATH")
    assert done.stdout.strip() == "[3,3,3,3,3,3,3,3,2,1]", done.stderr


@pytest.mark.slow
def test_mbpoll_writes_and_reads_the_output_words(port: int) -> None:
    """Its references begin at 1: 4x1 to 4x8 are the output words."""
    mbpoll = shutil.which("mbpoll")
    if mbpoll is None:
        pytest.skip("mbpoll is not installed")
    head = [mbpoll, "-m", "tcp", "-p", str(port), "-a", "1", "-t", "4", "-r", "1", "-o", "10", "-1"]
    for more in (["127.0.0.1", *"12345678"], ["-c", "8", "127.0.0.1"]):
        done = subprocess.run(
            [*head, *more], capture_output=True, text=True, timeout=TIMEOUT_S, check=False, encoding="utf-8"
        )
        assert done.returncode == 0, done.stdout + done.stderr
    read = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("[")]
    assert read == list("12345678")
