"""Edits of a run without a page: classes of Logic with sequences, refusals, files that are missing.

Broken on purpose: an edited class that is not attached first, the old one's sequences watched on.
"""

from contextlib import ExitStack

import pytest
from scanrack.commands import build
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.record.program_versions import ProgramVersions, version_of
from scanrack.jobs.trust.attachments import attached_files
from scanrack.runtime import Edit
from scanrack.traces import open_trace
from typer.testing import CliRunner

RACK = 'program = "cycle.py"\nscan_ms = 2\n[[slot]]\nnumber = 1\nmodule = "amci3601"\nfirmware = "4.1"\n'
PROGRAM = """\
from scanrack import Input, Logic, dwell, sequence


class Cycle(Logic):
    estop = Input("slotSLOT.status.IN_ESTOP")

    @sequence
    async def cycle(self):
        while True:
            await dwell("PAUSE ms")
"""


def program(slot, pause):
    return PROGRAM.replace("SLOT", str(slot)).replace("PAUSE", str(pause))


class Edited:
    """A run whose program is edited between scans, as a session does it."""

    def __init__(self, folder, record):
        self.folder, self.rack = folder, folder / "rack.toml"
        self.rack.write_text(RACK, encoding="utf-8")
        self.ports = ExitStack()
        self.editions = ProgramVersions(folder / "copies", str(self.rack))
        self.write(program(1, 10))
        job = load_job(str(self.rack))
        self.editions.keep(0, version_of(job), job)
        options = RunOptions(trace=record, handled=True, editions=self.editions)
        self.run = JobRun(self.editions.job(0), self.ports, options)
        self.hands = self.run.hands

    def write(self, text):
        (self.folder / "cycle.py").write_text(text, encoding="utf-8")

    def edit(self, text, restart=""):
        self.write(text)
        job = load_job(str(self.rack))
        order = Edit(self.run.program.edits + 1, version_of(job).program, restart)
        self.editions.keep(order.number, version_of(job), job)
        self.hands.act(order, self.run.cpu.now_ns, self.run.cpu.scan)


def waits_in(path):
    with open_trace(path) as trace:
        return [(each.scan, each.fields["wait"]) for each in trace.events() if each.topic == "/sequences"]


def test_sequences_of_an_edited_class_begin_and_are_recorded(tmp_path):
    record = tmp_path / "run.mcap"
    edited = Edited(tmp_path, record)
    with edited.ports, edited.run.cpu:
        edited.run.cpu.run(8)
        edited.edit(program(1, 6), "cycle")
        edited.run.cpu.run(8)
    waits = waits_in(record)
    assert waits[0][0] == 0
    assert "10 ms" in waits[0][1]
    assert next((scan, "6 ms" in text) for scan, text in waits if scan >= 8) == (8, True)
    with open_trace(record) as trace:
        assert attached_files(trace)["edit-1/cycle.py"].decode() == program(1, 6)
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(record), "--trust"])
    assert "identical byte for byte" in done.output, done.output


def test_an_edited_class_that_does_not_fit_the_rack_is_refused_and_the_old_one_goes_on(tmp_path):
    edited = Edited(tmp_path, tmp_path / "run.mcap")
    with edited.ports, edited.run.cpu:
        edited.run.cpu.run(8)
        before = edited.run.program.logic
        with pytest.raises(ValueError, match="slot 9"):
            edited.edit(program(9, 6))
        edited.run.cpu.run(8)
    assert edited.run.program.logic is before
    assert (edited.run.program.edits, edited.run.cpu.fault) == (0, None)
    assert all(scan == 0 or "10 ms" in text for scan, text in waits_in(tmp_path / "run.mcap"))


def test_a_rerun_without_the_files_of_an_edit_says_which_are_missing(tmp_path):
    record = tmp_path / "run.mcap"
    edited = Edited(tmp_path, record)
    with edited.ports, edited.run.cpu:
        edited.run.cpu.run(3)
        edited.edit(program(1, 6), "cycle")
        edited.run.cpu.run(3)
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(record.read_bytes().replace(b"edit-1/cycle.py", b"edut-1/cycle.py"))
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(damaged), "--trust"])
    assert done.exit_code == 2
