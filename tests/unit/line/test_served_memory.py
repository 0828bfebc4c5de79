"""What served controllers keep without power stands in a file, and is there after a restart.

What is nonvolatile: axis address, stored program and autorun of a PCL601 [codes 13 and 14, command %]; the
parameters that `t` saves and the user program of a PMC006x3s [4.3.17]. Broken on purpose: the address of the
file taken although one is given, a volatile register kept: a test turns red.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import forked
import pytest
from pymodbus.client import ModbusTcpClient
from scanrack.commands import build
from scanrack.io_images.pcl601 import Code
from scanrack.io_images.pmc006.frame import command
from scanrack.io_images.pmc006.instructions import BY_NAME
from scanrack.jobs.run.served_units import Unit, pcl601_units, pmc006_units
from scanrack.jobs.serve.memory_file import ControllerMemory
from typer.testing import CliRunner

MS = 1_000_000


def served(
    file: Path, units: list[Unit], *, addressed: bool = False, action=lambda _unit: None
) -> list[Unit]:
    """Serve units with a memory for a moment; do something with the first one meanwhile."""
    controller = "pcl601" if units[0].do else "pmc006"
    with ControllerMemory(file, controller, {}) as memory:
        memory.restore(units, addressed=addressed)
        action(units[0])
        memory.look()
    return units


def sample(folder: Path) -> Path:
    file = folder / "unit.pclt"
    examples = Path(__file__).parents[3] / "examples" / "pcl601"
    file.write_text((examples / "sample1.pclt").read_text("utf-8"), encoding="utf-8")
    return file


def test_a_pcl601_keeps_program_and_autorun(tmp_path: Path) -> None:
    file = tmp_path / "memory.json"

    def autorun(unit: Unit) -> None:
        assert unit.do is not None
        unit.do(Code.AUTORUN_ON)

    served(file, pcl601_units([1], [sample(tmp_path)], 1.0), action=autorun)
    (again,) = served(file, pcl601_units([1], [], 1.0))
    assert again.status()["program"] == "running"  # autorun starts it at power-up

    def stopped(unit: Unit) -> None:
        assert unit.do is not None
        unit.do(Code.STOP_MOTION)
        unit.do(Code.AUTORUN_OFF)

    served(file, pcl601_units([1], [], 1.0), action=stopped)
    (again,) = served(file, pcl601_units([1], [], 1.0))
    assert again.status()["program"] == "stored"


def test_a_pcl601_forgets_its_position(tmp_path: Path) -> None:
    def moved(unit: Unit) -> None:
        assert unit.do is not None
        unit.do(Code.GO_SLEW)
        unit.device.advance(1000 * MS)
        assert unit.values()["position"] > 0

    file = tmp_path / "memory.json"
    served(file, pcl601_units([1], [], 1.0), action=moved)
    (again,) = served(file, pcl601_units([1], [], 1.0))
    assert again.values()["position"] == 0


def set_speed(unit: Unit, name: str, value: int, *, save: bool) -> None:
    frames = [command(255, BY_NAME[name].code, value)] + [
        command(255, BY_NAME["save_parameters"].code)
    ] * save
    for number, frame in enumerate(frames):
        unit.device.receive(number * MS, frame)
        unit.device.advance(number * MS)


@pytest.mark.parametrize("save", [True, False])
def test_a_pmc006_keeps_what_t_saves(tmp_path: Path, save: bool) -> None:
    """The start speed of the factory is another one than 777; `t` writes the parameters to the EEPROM."""
    file, name = tmp_path / "memory.json", "start_speed"
    factory = BY_NAME[name].default
    assert factory != 777
    served(file, pmc006_units([], [], 1.0), action=lambda unit: set_speed(unit, name, 777, save=save))
    (again,) = served(file, pmc006_units([], [], 1.0))
    assert again.device.controller.memory[name] == (777 if save else factory)  # type: ignore[attr-defined]


def test_options_are_newer_than_the_file(tmp_path: Path) -> None:
    file = tmp_path / "memory.json"
    served(file, pcl601_units([5], [], 1.0))
    with ControllerMemory(file, "pcl601", {}) as memory:
        assert memory.addresses == [5]
    (given,) = served(file, pcl601_units([7], [], 1.0), addressed=True)
    assert given.status()["address"] == "7"
    assert json.loads(file.read_text("utf-8"))["units"][0]["address"] == 7


def test_an_unchanged_memory_is_not_written_again(tmp_path: Path) -> None:
    file = tmp_path / "memory.json"
    served(file, pcl601_units([1], [], 1.0))
    before = file.stat().st_ino
    served(file, pcl601_units([1], [], 1.0))
    assert file.stat().st_ino == before


HEAD = '{"format": "scanrack memory 1", '


def unit(said: str) -> str:
    return HEAD + f'"controller": "pcl601", "units": [{{{said}}}]}}'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("my notes", "is not the memory of a controller, and would be lost"),
        (HEAD + '"controller": "pmc006", "units": []}', "this is the memory of a pmc006, not of a pcl601"),
        (HEAD + '"controller": "pcl601", "units": []}', "units"),
        (HEAD + '"controller": "pcl601", "units": [{"address": 1', "memory.json"),
        (unit('"address": 100, "autorun": false, "program": []'), "address"),
        (unit('"address": 1, "autorun": false, "program": ["NO"]'), "program"),
        (unit('"address": 1, "autorun": false, "program": [], "x": 1'), "x"),
        (HEAD + '"units": ' + "[" * 9, "memory.json"),
    ],
    ids=["another file", "another controller", "no units", "cut off", "address", "program", "key", "nested"],
)
def test_a_file_that_is_no_memory_is_refused_and_kept(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "memory.json"
    file.write_text(text, encoding="utf-8")
    words = ["serve", "pcl601", "--tcp", "0", "--memory", str(file)]
    done = CliRunner().invoke(build(), words)
    assert (done.exit_code, said in done.stderr) == (2, True), done.stderr
    assert file.read_text("utf-8") == text


def test_two_services_do_not_share_a_memory(tmp_path: Path) -> None:
    file = tmp_path / "memory.json"
    served(file, pcl601_units([1], [], 1.0))
    with ControllerMemory(file, "pcl601", {}):
        done = CliRunner().invoke(build(), ["serve", "pcl601", "--tcp", "0", "--memory", str(file)])
    assert done.exit_code in (2, 3)
    assert "memory.json" in done.stderr


@pytest.mark.slow
def test_what_is_stored_survives_a_kill(tmp_path: Path) -> None:
    file = tmp_path / "memory.json"
    words = [sys.executable, "-m", "scanrack", "serve", "pcl601", "--tcp", "0", "--memory", str(file)]
    process = forked.start(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        assert process.stdout is not None
        host, port = process.stdout.readline().split("  ")[0].split(":")
        client = ModbusTcpClient(host, port=int(port))
        assert client.connect()
        assert not client.write_register(0, int(Code.AUTORUN_ON), device_id=1).isError()
        while not json.loads(file.read_text("utf-8"))["units"][0]["autorun"]:
            assert process.poll() is None
        client.close()
        process.send_signal(signal.SIGKILL)
    finally:
        process.kill()
        process.communicate()
    (again,) = served(file, pcl601_units([1], [], 1.0))
    assert again.device.controller.autorun  # type: ignore[attr-defined]
