"""Modbus clients that others wrote, against tags as coils and registers: pymodbus, mbpoll, modbus-serial."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Iterator

import pytest
from pymodbus.client import ModbusTcpClient
from scanrack.runtime.config.server_table import ModbusTable
from served_tags import ServedRack, served, write_rack

MAP = ModbusTable.model_validate(
    {
        "coils": ({"address": 0, "tag": "aBool"}, {"address": 8, "tag": "Flags"}),
        "discrete_inputs": ({"address": 0, "tag": "Locked.0"},),
        "input_registers": ({"address": 0, "tag": "Locked"},),
        "holding_registers": (
            {"address": 0, "tag": "aDint"},
            {"address": 2, "tag": "aReal"},
            {"address": 4, "tag": "anInt"},
            {"address": 6, "tag": "Locked"},
        ),
    }
)
SCRIPT = """
const Client = require("modbus-serial");
(async () => {
  const client = new Client();
  await client.connectTCP("127.0.0.1", { port: Number(process.argv[1]) });
  client.setID(1);
  await client.writeRegisters(0, [0, 770]);
  await client.writeCoil(8, true);
  const told = {
    registers: (await client.readHoldingRegisters(0, 5)).data,
    coils: (await client.readCoils(8, 3)).data,
    inputs: (await client.readInputRegisters(0, 2)).data,
    discrete: (await client.readDiscreteInputs(0, 1)).data,
  };
  told.refused = await client.writeRegisters(6, [0, 1]).catch((error) => error.modbusCode);
  client.close(() => console.log(JSON.stringify(told)));
})();
"""


@pytest.fixture
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[ServedRack, int]]:
    with served(write_rack(tmp_path_factory.mktemp("bench")), MAP) as (rack, port):
        yield rack, port


@pytest.mark.peer("pymodbus")
def test_pymodbus_reads_and_writes_tags(bench: tuple[ServedRack, int]) -> None:
    rack, port = bench
    kinds = ModbusTcpClient.DATATYPE
    with ModbusTcpClient("127.0.0.1", port=port, timeout=120) as client:
        for address, kind, value in ((0, kinds.INT32, -70_000), (2, kinds.FLOAT32, -0.25)):
            words = client.convert_to_registers(value, kind)
            assert not client.write_registers(address, words).isError()
            found = client.read_holding_registers(address, count=2).registers
            assert client.convert_from_registers(found, kind) == value
        assert not client.write_coils(8, [True, False, True]).isError()
        assert client.read_coils(8, count=3).bits[:3] == [True, False, True]
        assert client.read_discrete_inputs(0, count=1).bits[0]
        assert client.read_input_registers(0, count=2).registers == [0, 7]
        assert not client.mask_write_register(address=4, and_mask=0xFF, or_mask=0x100).isError()
        both = client.readwrite_registers(read_address=0, read_count=2, write_address=4, values=[9])
        assert both.registers == [0xFFFE, 0xEE90]  # -70,000
        assert client.write_registers(6, [0, 1]).exception_code == 2
        assert client.read_holding_registers(5, count=1).exception_code == 2
    tags = rack.debugger.tags
    assert [tags[name] for name in ("aDint", "aReal", "anInt", "Locked")] == [-70_000, -0.25, 9, 7]


@pytest.mark.peer("mbpoll")
def test_mbpoll_reads_and_writes_tags(bench: tuple[ServedRack, int]) -> None:
    program = shutil.which("mbpoll")
    if program is None:
        pytest.skip("mbpoll is not installed")
    rack, port = bench

    def poll(*words: str) -> list[str]:
        values = [word for word in words if not word.startswith("-")]
        options = [word for word in words if word.startswith("-")]
        link = [program, "-m", "tcp", "-p", str(port), "-0", "-o", "10", "-1", *options, "127.0.0.1", *values]
        done = subprocess.run(link, capture_output=True, text=True, timeout=120, encoding="utf-8")
        assert done.returncode == 0, done.stdout + done.stderr
        return [line.split()[1] for line in done.stdout.splitlines() if line.startswith("[")]

    poll("-t4:int", "-B", "-r0", "70001")
    assert poll("-t4:int", "-B", "-r0", "-c1") == ["70001"]
    poll("-t0", "-r8", "1", "0", "1")
    assert poll("-t0", "-r8", "-c3") == ["1", "0", "1"]
    assert poll("-t4:float", "-B", "-r2", "-c1") == ["1.5"]
    assert poll("-t3", "-r0", "-c2") == ["0", "7"]
    assert rack.debugger.tags["aDint"] == 70_001


@pytest.mark.peer("modbus-serial")
@pytest.mark.slow
def test_modbus_serial_reads_and_writes_tags(bench: tuple[ServedRack, int]) -> None:
    program = shutil.which("node")
    if program is None:
        pytest.skip("node is not installed")
    found = subprocess.run(
        [program, "-e", "require.resolve('modbus-serial')"], capture_output=True, timeout=120
    )
    if found.returncode:
        pytest.skip("the npm package modbus-serial is not installed where node finds it (NODE_PATH)")
    _, port = bench
    done = subprocess.run(
        [program, "-e", SCRIPT, str(port)], capture_output=True, text=True, timeout=120, encoding="utf-8"
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {
        "registers": [0, 770, 0x3FC0, 0, -1234 & 0xFFFF],
        "coils": [True, False, False] + [False] * 5,
        "inputs": [0, 7],
        "discrete": [True] + [False] * 7,
        "refused": 2,
    }
