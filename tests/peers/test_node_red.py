"""Node-RED with the flow of `scanrack tags --for node-red`, imported unchanged: the path of a newcomer."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import pytest
from peers import PEERS_FOLDER, TIMEOUT_S, node_program, npm_package
from scanrack.jobs.run.servers.tag_formats import FORMATS
from scanrack.runtime.tag_servers.tag_list import tag_rows
from served_tags import served, write_rack
from websockets.sync.client import connect

NODES = "node-red-contrib-cip-ethernet-ip"
pytestmark = [pytest.mark.peer("Node-RED"), pytest.mark.slow]


@contextmanager
def node_red(folder: Path, enip_port: int) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
    """Run Node-RED with a folder of its own; yield its process and port."""
    node_program(NODES)
    node, package = node_program("node-red"), npm_package("node-red")
    assert package is not None
    (folder / "node_modules").symlink_to((npm_package(NODES) or package).parent)
    (folder / "package.json").write_text(json.dumps({"name": "test", "dependencies": {NODES: "*"}}), "utf-8")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    redirected = {"NODE_OPTIONS": f"--require {PEERS_FOLDER / 'enip_port.cjs'}", "ENIP_PORT": str(enip_port)}
    with (folder / "log").open("wb") as log:
        process = subprocess.Popen(
            [node, package / "red.js", "-u", folder, "-p", str(port)],
            stdout=log,
            stderr=log,
            env={**os.environ, **redirected},
        )
    try:
        yield process, port
    finally:
        process.kill()
        process.wait()


def asked(port: int, flow: Any = None) -> None:
    """Deploy a flow, or read the present one."""
    data = None if flow is None else json.dumps(flow).encode()
    with urlopen(Request(f"http://127.0.0.1:{port}/flows", data, {"Content-Type": "application/json"})):
        pass


def wait_for(port: int, process: subprocess.Popen[bytes]) -> None:
    """Wait until Node-RED answers."""
    end = time.monotonic() + TIMEOUT_S
    while time.monotonic() < end and process.poll() is None:
        with suppress(OSError):
            return asked(port)
        time.sleep(0.1)
    pytest.fail("Node-RED does not begin")


def first(comms: Any, topic: str, fits: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """Return the first message of a topic that fits: what the debug node shows, or the status of a node."""
    while True:
        for each in json.loads(comms.recv(TIMEOUT_S)):
            if each.get("topic", "").partition("/")[0] == topic:
                found = each["data"] if topic == "status" else json.loads(each["data"]["msg"])
                if fits(found):
                    return found


def test_the_flow_shows_values_and_outlives_the_rack(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    with ExitStack() as stack:
        on = stack.enter_context(ExitStack())
        rack, enip_port = on.enter_context(served(write_rack(tmp_path)))
        process, port = stack.enter_context(node_red(home, enip_port))
        wait_for(port, process)
        comms = stack.enter_context(connect(f"ws://127.0.0.1:{port}/comms"))
        comms.send(json.dumps({"subscribe": "debug"}))
        comms.send(json.dumps({"subscribe": "status/#"}))
        asked(port, json.loads(FORMATS["node-red"](list(tag_rows(rack.setup.database)), "bench").text))
        tags = rack.debugger.tags
        tags["Grid[1,2]"], tags["Flags[35]"] = 4711, True
        payload = first(
            comms, "debug", lambda found: None not in found.values() and found["Grid[1,2]"] == 4711
        )
        names = ("aDint", "aReal", "aSint", "Flags[34]", "Flags[35]", "Many[2].Bits[3]", "Fill.PRE")
        assert [payload[each] for each in names] == [tags[each] for each in names]
        on.close()
        assert first(comms, "status", lambda found: found["text"] != "online")["text"] == "offline"
        time.sleep(0.5)  # it broke down right after its node had gone offline
        assert process.poll() is None, (home / "log").read_text("utf-8")
