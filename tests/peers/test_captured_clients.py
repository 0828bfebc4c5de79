"""What pycomm3 and pylogix read and write of a module's images, imported from a capture of their talk.

The clients decode the same packets on their own: what they return is what the trace must hold.
"""

from __future__ import annotations

import socket
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

import pytest
from captured import conversation, pcap
from logix_clients import pycomm3_client, pylogix_client
from scanrack.commands import build
from scanrack.traces import open_trace
from served_tags import served, write_rack
from typer.testing import CliRunner

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    pycomm3 = pytest.importorskip("pycomm3", reason="pycomm3 is not installed")

Talk = list[tuple[bool, bytes]]
WAIT_S = 120


@contextmanager
def tapped(port: int, talk: Talk) -> Iterator[int]:
    """Pass one connection on to a port, and note its bytes."""

    def relay(source: socket.socket, target: socket.socket, *, asked: bool) -> None:
        with closing(target), suppress(OSError):  # the other end has closed
            while data := source.recv(65_536):
                talk.append((asked, data))
                target.sendall(data)

    def serve() -> None:
        client, _ = listener.accept()
        server = socket.create_connection(("127.0.0.1", port), WAIT_S)
        back = threading.Thread(target=relay, args=(server, client), kwargs={"asked": False})
        back.start()
        relay(client, server, asked=True)
        back.join(WAIT_S)

    with closing(socket.create_server(("127.0.0.1", 0))) as listener:
        thread = threading.Thread(target=serve)
        thread.start()
        yield listener.getsockname()[1]
        thread.join(WAIT_S)
        assert not thread.is_alive()


def seen_by_pycomm3(port: int) -> list[list[int]]:
    with pycomm3_client(pycomm3.LogixDriver, port) as plc:
        first = plc.read("Local:1:I.Data{8}").value
        assert plc.write("Local:1:O.Data{8}", [-32768, 2, 3, 4, 5, 6, 7, 8]).error is None
        outputs = plc.read("Local:1:O.Data{8}").value
        for _ in range(3):
            last = plc.read("Local:1:I").value["Data"]
    return [first, outputs, last]


def seen_by_pylogix(port: int) -> list[list[int]]:
    with pylogix_client(port) as plc:
        first = plc.Read("Local:1:I.Data[0]", 8).Value
        assert plc.Write("Local:1:O.Data[0]", [-32768, 2, 3, 4, 5, 6, 7, 8]).Status == "Success"
        outputs = plc.Read("Local:1:O.Data[0]", 8).Value
        names = [f"Local:1:I.Data[{word}]" for word in range(8)]
        for _ in range(3):
            last = [each.Value for each in plc.Read(names)]
    return [first, outputs, last]


@pytest.mark.slow
@pytest.mark.parametrize("client", [seen_by_pycomm3, seen_by_pylogix])
def test_the_trace_has_what_the_client_has_seen(
    tmp_path: Path, client: Callable[[int], list[list[int]]]
) -> None:
    talk: Talk = []
    with served(write_rack(tmp_path)) as (_, port), tapped(port, talk) as near:
        first, outputs, last = client(near)
    capture, out = tmp_path / "line.pcap", tmp_path / "line.mcap"
    capture.write_bytes(pcap(conversation(talk)))
    words = ["import", str(capture), "--as", "compactlogix", "--port", "502", "--out", str(out)]
    said = CliRunner().invoke(build(), words)
    assert said.exit_code == 0, said.output
    with open_trace(out) as trace:
        seen = [(list(each.inputs(1).words), list(each.outputs(1).words)) for each in trace.scans()]
    early = seen[:2]  # pylogix asks for a tag's type first, with its first word
    assert (first, outputs) in early
    assert seen[-1] == (last, outputs)
    assert first != last
