"""Clients of tags and drives that others wrote: `@pytest.mark.peer("pycomm3")` says which one a test tries.

With `SCANRACK_TRIED=FILE` each test that passes adds a line, the client and its version, to a file:
`python -m tests.tools.clients_tried` makes docs/clients-tried.toml of them.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import distributions, version
from pathlib import Path
from typing import Any, NamedTuple

import pytest

TRIED = "SCANRACK_TRIED"
PEERS_FOLDER = Path(__file__).parents[1] / "peers"
TIMEOUT_S = 120


class Peer(NamedTuple):
    """A client.

    Attributes:
        protocol: how it reaches the tags.
        tried: what the tests do with it.
        version: finds its version by its name.
    """

    protocol: str
    tried: str
    version: Callable[[str], str]


def npm_package(name: str) -> Path | None:
    """Return the folder of a package of npm, where node finds it; None without it."""
    folders = os.environ.get("NODE_PATH", "").split(os.pathsep)
    found = (Path(each, name) for each in folders if each)
    return next((each for each in found if (each / "package.json").is_file()), None)


def npm_version(name: str) -> str:
    """Return the version of a package of npm."""
    folder = npm_package(name)
    assert folder is not None
    return str(json.loads((folder / "package.json").read_text("utf-8"))["version"])


def plctag() -> str | None:
    """Return the path of libplctag: `LIBPLCTAG` names it, or the system has it."""
    return os.environ.get("LIBPLCTAG") or ctypes.util.find_library("plctag")


def _plctag_version(_name: str) -> str:
    library = ctypes.CDLL(plctag() or "libplctag.so")
    parts = (
        library.plc_tag_get_int_attribute(0, b"version_" + each, 0) for each in (b"major", b"minor", b"patch")
    )
    return ".".join(map(str, parts))


def _mbpoll_version(name: str) -> str:
    return subprocess.run([name, "-V"], capture_output=True, encoding="utf-8").stdout.strip()


def scanner_folder(name: str) -> Path | None:
    """Return the folder of an EtherNet/IP scanner below `SCANNERS`; both are a package `ethernetip`."""
    folder = Path(os.environ.get("SCANNERS", ""), name)
    return folder if (folder / "ethernetip").is_dir() else None


def scanner(name: str, script: str, *words: object) -> Any:
    """Run a script of tests/peers with a scanner; return the JSON that it prints. Skip without it."""
    folder = scanner_folder(name)
    if folder is None:
        pytest.skip(f"{name} is not installed: pip install --target SCANNERS/{name} {name}")
    done = subprocess.run(
        [sys.executable, PEERS_FOLDER / script, *map(str, words)],
        capture_output=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        env={**os.environ, "PYTHONPATH": str(folder)},
    )
    assert done.returncode == 0, done.stderr + done.stdout
    return json.loads(done.stdout)


def _scanner_version(name: str) -> str:
    [found] = distributions(name=name, path=[str(scanner_folder(name))])
    return found.version


def _node_red_version(_name: str) -> str:
    return f"{npm_version('node-red')}, nodes {npm_version('node-red-contrib-cip-ethernet-ip')}"


ENIP, PCCC, UA, MODBUS = "EtherNet/IP", "PCCC", "OPC UA", "Modbus TCP"

PEERS: dict[str, Peer] = {
    "pycomm3": Peer(ENIP, "list, templates, every type, batches, 12,000 bytes; SLCDriver: files", version),
    "ciplink": Peer(ENIP, "list, every type, batches, 12,000 bytes, refusals", version),
    "pylogix": Peer(ENIP, "list, templates, every type, connections of 4,002 and 504 bytes", version),
    "libplctag": Peer(
        ENIP, "list, templates, values, bits, 12,000 bytes, refusals; files of an .SLC", _plctag_version
    ),
    "st-ethernet-ip": Peer(ENIP, "list, templates, values, structures, texts", npm_version),
    "Node-RED": Peer(ENIP, "the flow of `scanrack tags` unchanged, the end of a run", _node_red_version),
    "nodepccc": Peer(PCCC, "files N, F, B, L, T, ST, O, S; what it can't write", npm_version),
    "asyncua": Peer(UA, "browsing, values, arrays, subscriptions, status codes, encryption, users", version),
    "node-opcua-client": Peer(
        UA, "the same; a subscription after a restart of the server and a cut", npm_version
    ),
    "pymodbus": Peer(MODBUS, "coils, registers, functions 16h and 17h; every function at a drive", version),
    "mbpoll": Peer(MODBUS, "coils, registers; at a drive, too", _mbpoll_version),
    "modbus-serial": Peer(MODBUS, "coils, registers; at a drive, too", npm_version),
    "ethernetip": Peer(ENIP, "a drive: identity, class 1 with a configuration, a move", _scanner_version),
    "cm-ethernetip": Peer(ENIP, "a drive: identity, explicit reads, class 1, a move", _scanner_version),
}
"""By the name in the mark, in the order of the page."""


def note(item: pytest.Item) -> None:
    """Add the clients of a test that has passed to the file of `SCANRACK_TRIED`."""
    path = os.environ.get(TRIED)
    if path is None:
        return
    with Path(path).open("a", encoding="utf-8") as file:
        for mark in item.iter_markers("peer"):
            for name in mark.args:
                file.write(json.dumps([name, PEERS[name].version(name)]) + "\n")


def node_program(package: str) -> str:
    """Return the path of Node.js; skip without it or without a package."""
    program = shutil.which("node")
    if program is None:
        pytest.skip("node is not installed")
    if npm_package(package) is None:
        pytest.skip(f"the npm package {package} is not installed where node finds it (NODE_PATH)")
    return program


def node(package: str, script: str, *words: object, env: dict[str, str] | None = None) -> Any:
    """Run a script of tests/peers in Node.js; return the JSON that it prints last. Skip without it."""
    done = subprocess.run(
        [node_program(package), PEERS_FOLDER / script, *map(str, words)],
        capture_output=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        env={**os.environ, **(env or {})},
    )
    assert done.returncode == 0, done.stderr + done.stdout
    return json.loads(done.stdout.splitlines()[-1])
