"""Ports that Windows names: pyserial gets the name as it is, and the message says why it can't be opened."""

import os
from pathlib import Path

import pytest
import serial
from scanrack.commands import build
from scanrack.runtime import LineFormat
from scanrack.runtime.line import serialport
from scanrack.runtime.line.clients.link import LinkError, SerialLink
from typer.testing import CliRunner

NAMES = ["COM3", "COM10", r"\\.\COM10"]
BUSY = "PermissionError(13, 'Access is denied.', None, 5)"

RACK = """
program = "line.py"
[[slot]]
number = 1
module = "pcl601-adapter"
port = '{}'
"""


@pytest.fixture
def asked(monkeypatch):
    """What pyserial is asked to open; it refuses as on Windows."""
    names = []

    def refuse(name, *_, **options):
        assert options["exclusive"] is True
        names.append(name)
        raise serial.SerialException(f"could not open port {name!r}: {BUSY}")

    monkeypatch.setattr(serial, "Serial", refuse)
    return names


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("words", "status"),
    [
        ("device pcl601 --serial {} status", 1),
        ("device pmc006 --serial {} status", 1),
        ("device identify {}", 1),
        ("serve pcl601 --serial {}", 2),
        ("run rack.toml --live --realtime --no-record", 2),
    ],
)
def test_a_command_opens_the_port_and_says_why_it_can_not(tmp_path, monkeypatch, asked, words, status, name):
    monkeypatch.chdir(tmp_path)
    Path("line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    Path("rack.toml").write_text(RACK.format(name), encoding="utf-8")
    done = CliRunner().invoke(build(), [each.format(name) for each in words.split()])
    assert done.exit_code == status, done.stderr
    assert f"{name} can't be opened: Access is denied." in done.stderr
    assert set(asked) == {name}


def test_the_name_of_a_port_is_not_resolved_where_that_opens_it(monkeypatch):
    opened: list[str] = []

    def resolved(path: str) -> str:
        opened.append(path)
        return path

    with monkeypatch.context() as on_windows:
        on_windows.setattr(os.path, "exists", lambda _path: False)
        on_windows.setattr(os.path, "realpath", resolved)
        assert serialport.settings("COM3", LineFormat(9600))["parity"] == LineFormat(9600).parity
    assert not opened


def test_an_error_with_a_number_keeps_the_words_of_the_system(monkeypatch):
    def refuse(*_, **_options):
        raise serial.SerialException(2, "could not open port COM77: [Errno 2]")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(LinkError, match=r"^COM77 can't be opened: No such file or directory$"):
        SerialLink("COM77", LineFormat(9600))
