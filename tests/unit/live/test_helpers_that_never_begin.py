"""A command whose helper process dies at its start says so, and ends with status 3."""

import json
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.jobs.run.servers import kinds, tag_service
from scanrack.runtime.tag_servers.setup import ETHERNET_IP
from scanrack.watch import monitor_supervisor
from typer.testing import CliRunner

FEEDER = Path(__file__).parents[3] / "examples" / "feeder" / "feeder.toml"
pytestmark = pytest.mark.slow

SHORT = ["--for", "20ms", "--server", "ethernet-ip:0"]
NOWHERE = "scanrack.nowhere:main"
SAYS = "scanrack: a helper process has not started: see its error above\n"


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    for each in (monitor_supervisor, tag_service):
        monkeypatch.setattr(each, "PATIENCE_S", 120)


@pytest.fixture
def no_server(monkeypatch):
    row = kinds.ServerKind("EtherNet/IP", NOWHERE, 44818)
    monkeypatch.setattr(kinds, "KINDS", {ETHERNET_IP: row})


def ended(*words):
    done = CliRunner().invoke(build(), list(map(str, words)))
    return done.exit_code, done.stderr


def test_a_page_without_a_monitor(monkeypatch):
    monkeypatch.setattr(monitor_supervisor, "MAIN", NOWHERE)
    status, text = ended("watch", FEEDER, "--for", "20ms", "--time-scale", "max")
    assert (status, text.count(SAYS)) == (3, 1)


@pytest.mark.parametrize("words", [["run", "--no-record"], ["watch", "--time-scale", "max"]], ids=" ".join)
def test_tags_without_a_server(no_server, words):
    status, text = ended(*words, FEEDER, *SHORT)
    assert (status, text.count(SAYS)) == (3, 1)


def test_the_run_itself_was_complete(no_server):
    done = CliRunner().invoke(build(), ["run", "--no-record", "--json", str(FEEDER), *SHORT])
    assert done.exit_code == 3
    assert json.loads(done.stdout)["ended"] == "done"


def test_helpers_that_live_leave_the_status(monkeypatch):
    status, text = ended("watch", FEEDER, "--time-scale", "max", *SHORT)
    assert (status, SAYS in text) == (0, False)
