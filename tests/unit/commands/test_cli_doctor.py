"""`scanrack doctor`: what there is, what is missing, how to fix it, and the exit status of it."""

from __future__ import annotations

import json
import os
import shutil
import sys
from importlib.metadata import metadata

import pytest
from scanrack.commands import build
from scanrack.jobs.start import doctor
from scanrack.jobs.start.doctor import GIVES, Diagnosis, Health, examined
from serial.tools import list_ports
from typer.testing import CliRunner


def report(*words: str) -> tuple[int, str]:
    done = CliRunner().invoke(build(), ["doctor", *words])
    return done.exit_code, done.output


def observed(name: str) -> list[Diagnosis]:
    return [each for each in examined() if each.name == name]


def test_each_extra_says_what_it_gives() -> None:
    extras = set(metadata("scanrack").get_all("Provides-Extra") or ())
    assert extras - {"test", "dev", "docs"} == set(GIVES)


def test_nothing_broken_is_status_0_and_json_has_every_line() -> None:
    status, text = report()
    assert status == 0
    assert text.startswith("ok      Python ")
    rows = json.loads(report("--json")[1])
    assert {row["name"] for row in rows} >= {
        "Python",
        "scanrack",
        "extra plot",
        "real time",
        "browser",
        "tshark",
    }
    assert all(row["remedy"] for row in rows if row["state"] != "ok")


def test_a_missing_extra_is_absent_and_names_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_installed", lambda name: name != "polars")
    (frames,) = observed("extra frames")
    assert (frames.state, frames.says) == (Health.ABSENT, "polars missing")
    assert frames.remedy.startswith('pip install ".[frames]" in a checkout of scanrack for ')
    assert report()[0] == 0


def test_a_missing_package_or_a_foreign_python_is_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_installed", lambda name: name != "numpy")
    assert observed("scanrack")[0].says.endswith(", without numpy")
    assert report()[0] == 1
    monkeypatch.undo()
    monkeypatch.setattr(sys, "version_info", (3, 9, 0))
    assert observed("Python")[0].remedy == "use Python 3.11 to 3.14"
    monkeypatch.undo()


def test_a_port_that_may_not_be_opened_says_which_group(monkeypatch: pytest.MonkeyPatch) -> None:
    class Device:
        device = "/dev/ttyUSB7"

    monkeypatch.setattr(list_ports, "comports", lambda: [Device])
    monkeypatch.setattr(os, "access", lambda *_: False)
    (port,) = observed("serial port")
    assert (port.state, port.says) == (Health.ABSENT, "/dev/ttyUSB7 can't be opened")
    assert "dialout" in port.remedy
    monkeypatch.setattr(list_ports, "comports", list)
    assert observed("serial ports")[0].says == "none found"


def test_programs_are_looked_for_on_the_path(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr(sys, "platform", "linux")
    assert {each.state for name in ("browser", "tshark", "gtkwave") for each in observed(name)} == {
        Health.ABSENT
    }
