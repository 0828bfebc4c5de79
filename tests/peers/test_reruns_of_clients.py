"""500 writes of clients that others wrote, over Modbus and OPC UA: a rerun is the same, byte for byte."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import pytest
from pymodbus.client import ModbusTcpClient
from rerun_orders import rerun, run_while
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.run.servers.kinds import ServerAddress
from scanrack.jobs.run.servers.tag_service import TagService
from scanrack.traces import open_trace
from served_tags import write_rack

WRITES = 500
MAP = """
[server.modbus]
coils = [{ address = 0, tag = "aBool" }]
holding_registers = [{ address = 0, tag = "aDint" }, { address = 2, tag = "aReal" }]
"""


def over_modbus(port: int) -> None:
    with ModbusTcpClient("127.0.0.1", port=port, timeout=120) as client:
        for number in range(WRITES):
            if number % 3:
                answer = client.write_registers(2 * (number % 3 - 1), [number, 2 * number])
            else:
                answer = client.write_coil(0, number % 2 == 0)
            assert not answer.isError()


def over_opc_ua(port: int) -> None:
    from asyncua import Client, ua

    async def work() -> None:
        async with Client(f"opc.tcp://127.0.0.1:{port}/scanrack", timeout=120) as client:
            count, flag = (client.get_node(f"ns=2;s={name}") for name in ("aDint", "aBool"))
            for number in range(WRITES):
                if number % 3:
                    await count.write_value(ua.Variant(number, ua.VariantType.Int32))
                else:
                    await flag.write_value(ua.Variant(number % 2 == 0, ua.VariantType.Boolean))

    asyncio.run(work())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("server", "client"),
    [
        pytest.param("modbus-tcp:0", over_modbus, id="Modbus"),
        pytest.param("opc-ua:0", over_opc_ua, id="OPC UA", marks=pytest.mark.extra("opcua")),
    ],
)
def test_a_rerun_is_the_same(tmp_path: Path, server: str, client: Callable[[int], None]) -> None:
    rack = write_rack(tmp_path)
    text = rack.read_text("utf-8")
    rack.write_text(text.replace("[[slot]]", f"{MAP}\n[[slot]]"), "utf-8")
    job, trace = load_job(str(rack)), tmp_path / "run.mcap"
    mistakes: list[Exception] = []
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions(trace=trace, handled=True))
        service = TagService(job, ServerAddress.parse(server), print, writes=True)
        ports.callback(service.end)
        desk = service.serve(run)

        def work() -> None:
            try:
                client(service.port)
            except Exception as mistake:
                mistakes.append(mistake)

        run_while(run, desk, threading.Thread(target=work))
    assert mistakes == []
    with open_trace(trace) as recorded:
        assert sum(event.topic == "/orders" for event in recorded.events()) == WRITES
    rerun(job, trace, tmp_path / "again.mcap")
    assert (tmp_path / "again.mcap").read_bytes() == trace.read_bytes()
