"""A program with sequences that is edited while it runs: the old one is closed, the new one begins anew.

Broken on purpose: the old program is not closed, the new one is not attached before it takes over.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.record.program_versions import ProgramVersions, version_of
from scanrack.runtime import Edit
from scanrack.traces import TraceEvent, open_trace
from typer.testing import CliRunner

RACK = """\
program = "line.py"
scan_ms = 2
trace = "line.mcap"

[[slot]]
number = 1
module = "amci3601"

[[slot]]
number = 2
module = "1762-IQ8"

[slot.options]
inputs = { start = 0 }

[[slot]]
number = 3
module = "1762-OW8"

[slot.options]
outputs = { ended = 0 }
"""

PROGRAM = """\
from scanrack import Axis3601, Configuration, Direction, Input, Logic, Output, dwell, sequence


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=0x2C, step_and_direction=True, starting_speed=500))
    start = Input("start")
    ended: Output = Output("ended")

    @sequence
    async def cycle(self) -> None:
        try:
            await self.axis.configure()
            await self.axis.set_position(0)
            self.axis.run(5000, acceleration=10, deceleration=10)
            await self.start.rises
        finally:
            self.ended = True
"""

NEXT = """\
            await self.axis.move_to(300, speed=2000, acceleration=10, deceleration=10)
"""
RUN = """\
            self.axis.run(5000, acceleration=10, deceleration=10)
"""

CONFIGURE = """\
            await self.axis.configure()
"""
STOP = """\
            await self.axis.stop()
"""

SCANS = 500


@pytest.fixture
def line(tmp_path: Path) -> Iterator[tuple[Path, JobRun, ProgramVersions]]:
    """Run the program for a second: the axis runs, the sequence waits for the button."""
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "line.py").write_text(PROGRAM, encoding="utf-8")
    job = load_job(str(tmp_path / "rack.toml"))
    editions = ProgramVersions(tmp_path / "editions", str(tmp_path / "rack.toml"))
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions(trace=tmp_path / "line.mcap", handled=True, editions=editions))
        run.cpu.run(SCANS)
        yield tmp_path, run, editions
        run.cpu.close()


def save(line: tuple[Path, JobRun, ProgramVersions], text: str, restart: str = "") -> None:
    """Save another program, and order it before the next scan; `restart`: sequences that begin anew."""
    folder, run, editions = line
    (folder / "line.py").write_text(text, encoding="utf-8")
    job = load_job(str(folder / "rack.toml"))
    number = run.program.edits + 1
    editions.keep(number, version_of(job), job)
    run.hands.act(Edit(number, "line.py:logic", restart), run.cpu.scan * run.cpu.period_ns, run.cpu.scan)


def waits(trace: Path) -> list[TraceEvent]:
    with open_trace(trace) as opened:
        return [event for event in opened.events() if event.topic == "/sequences"]


def test_a_sequence_begins_anew_in_mid_wait_and_mid_move(
    line: tuple[Path, JobRun, ProgramVersions],
) -> None:
    _, run, _ = line
    slots = run.rack.slots
    assert slots[1].outputs[0] != 0  # the command of the run
    save(line, PROGRAM.replace(CONFIGURE, STOP).replace(RUN, NEXT), "cycle")
    run.cpu.run(SCANS)
    assert slots[3].outputs[0] == 1  # its `finally` has run
    position = 1000 * slots[1].inputs[2] + slots[1].inputs[3]
    assert position == 300
    assert run.program.logic.cycle.waits_for == "start rises"  # type: ignore[attr-defined]


def test_a_line_ahead_moves_the_line_that_waits_and_no_field(
    line: tuple[Path, JobRun, ProgramVersions],
) -> None:
    folder, run, _ = line
    save(line, "# a new line ahead\n" + PROGRAM)
    run.cpu.run(1)
    run.cpu.close()
    first, *_, last = waits(folder / "line.mcap")
    assert (first.fields["wait"], first.fields["line"], first.scan) == ("axis.configure()", 12, 0)
    assert (last.fields["wait"], last.fields["line"], last.scan) == ("start rises", 16, SCANS)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('Input("start")', 'Input("strat")', r"line\.py:6: start: no input 'strat'"),
        ("Axis3601(1", "Axis3601(2", "slot 2 has .*, which has neither a 3601's words nor a drive's"),
    ],
)
def test_one_that_does_not_fit_the_rack_is_refused_and_the_other_goes_on(
    line: tuple[Path, JobRun, ProgramVersions], old: str, new: str, says: str
) -> None:
    _, run, _ = line
    with pytest.raises(ValueError, match=says):
        save(line, PROGRAM.replace(old, new))
    run.cpu.run(SCANS)
    assert run.program.logic.cycle.line == 15  # type: ignore[attr-defined]
    assert run.program.edits == 0


def test_a_session_with_such_an_edit_runs_again_byte_for_byte(
    line: tuple[Path, JobRun, ProgramVersions],
) -> None:
    folder, run, _ = line
    save(line, PROGRAM.replace(CONFIGURE, STOP).replace(RUN, NEXT), "cycle")
    run.cpu.run(SCANS)
    run.cpu.close()
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(folder / "line.mcap"), "--trust"])
    assert done.exit_code == 0, done.output
    assert "identical byte for byte" in done.output
