"""A 3601 as remote I/O: a PLC between two scans, its silence, and the recording of it all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from struct import pack, unpack

import pytest
from scanrack.io_images.amci3601 import StatusMsw
from scanrack.jobs import JobRun, RunOptions
from scanrack.jobs.serve.remote import ExternalPlc, remote_job
from scanrack.runtime import FreeRun
from scanrack.runtime.loop.scan import CpuMode
from scanrack.traces import open_trace

pytestmark = pytest.mark.slow  # together they take seconds

CONFIGURE = [0x843C, 0x3C, 0, 500, 0, 0, 0, 0]
IDLE = [0] * 8
MOVE = [0x0002, 0, 3, 0, 2, 500, 5, 5]
"""A relative move of 3000 steps at 2500 steps/s: words 2 and 3, 4 and 5 are thousands and the rest."""

READ = bytes.fromhex("04 0000 000b")


def writing(words: list[int], first: int = 0) -> bytes:
    return pack(f">BHHB{len(words)}H", 0x10, first, len(words), 2 * len(words), *words)


class ScriptedPace(FreeRun):
    """Between two scans a PLC does its next step."""

    free = False

    def __init__(self, script: Iterator[None]) -> None:
        super().__init__()
        self._script = script

    def wait(self) -> bool:
        next(self._script, None)
        return False


def run(
    script: Callable[[ExternalPlc], Iterator[None]],
    scans: int,
    trace: Path | None = None,
    whole: bool = False,
) -> tuple[ExternalPlc, JobRun]:
    with remote_job(None, None, 100, whole=whole) as (job, plc), ExitStack() as ports:
        made = JobRun(job, ports, RunOptions(trace, pacer=ScriptedPace(script(plc)), listeners=[plc]))
        plc.attach(made.cpu)
        made.run(scans)
    return plc, made


def test_ten_thousand_exchanges_none_torn_and_half_writes_counted(tmp_path: Path) -> None:
    """All words of an exchange are equal, ten exchanges between two scans: in no scan do two words differ."""

    def script(plc: ExternalPlc) -> Iterator[None]:
        for scan in range(1000):
            for at in range(10):
                plc.answer(writing([10 * scan + at] * 8))
            yield
        for _ in range(7):
            plc.answer(writing([0, 0]))
        yield

    plc, _ = run(script, 1003, tmp_path / "t.mcap")
    assert (plc.words.exchanges, plc.words.torn) == (10_007, 7)
    with open_trace(tmp_path / "t.mcap") as trace:
        images = [tuple(scan.outputs(1).words) for scan in trace.scans()][:1000]
    assert [len(set(words)) for words in images] == [1] * 1000
    assert images[-1][0] == 9999


def test_a_plc_moves_the_shaft_of_the_rack() -> None:
    """3000 steps at 2500 steps/s are over before scan 1000, at 2 s."""

    def script(plc: ExternalPlc) -> Iterator[None]:
        for words in [CONFIGURE] * 20 + [IDLE] * 20 + [MOVE] * 1000:
            plc.answer(writing(words))
            yield

    plc, _ = run(script, 1000)
    facts = unpack(">11H", plc.answer(READ)[2:])
    assert (facts[2] * 1000 + facts[3], facts[8:10]) == (3000, (1000, 0))


def test_a_silent_plc_leaves_run_mode_and_its_next_write_returns_to_it() -> None:
    """The limit is 100 ms, 50 scans; the module stops its move, whose position becomes invalid."""
    modes: list[CpuMode] = []

    def script(plc: ExternalPlc) -> Iterator[None]:
        cpu = plc.cpu
        for words in [CONFIGURE] * 20 + [IDLE] * 20 + [MOVE] * 20:
            plc.answer(writing(words))
            yield
            modes.append(cpu.mode)
        for _ in range(60):
            plc.answer(READ)  # a reader is no writer
            yield
            modes.append(cpu.mode)
        plc.answer(writing(IDLE))
        yield
        modes.append(cpu.mode)

    plc, made = run(script, 123)
    changes = [at for at in range(1, len(modes)) if modes[at] is not modes[at - 1]]
    assert [modes[at] for at in changes][-2:] == [CpuMode.PROGRAM, CpuMode.RUN]
    assert changes[-2] - 60 in (49, 50, 51, 52)
    assert plc.silences == 1
    status = made.rack.slots[1].inputs[0] & 0xFFFF
    assert status & StatusMsw.POSITION_INVALID


def test_the_cpu_waits_in_program_mode_for_the_first_write() -> None:
    plc, made = run(lambda plc: iter([None] * 5), 5)
    assert made.cpu.mode is CpuMode.PROGRAM
    assert plc.silences == 0


@pytest.mark.parametrize(
    ("slot", "silence", "said"),
    [
        (2, 500.0, "--slot 2: no amci3601; slots with an amci3601: 1"),
        (None, 0.0, "--silence 0: must be above 0, at most 3,600,000"),
    ],
)
def test_what_can_not_be_served(slot: int | None, silence: float, said: str) -> None:
    with pytest.raises(ValueError, match=said), remote_job(None, slot, silence, whole=False):
        pass


def test_a_rack_with_two_stepper_modules_needs_the_slot(tmp_path: Path) -> None:
    slots = "".join(f'[[slot]]\nnumber = {n}\nmodule = "amci3601"\n' for n in (1, 3))
    (tmp_path / "two.toml").write_text('program = "none.py"\n' + slots, encoding="utf-8")
    rack = str(tmp_path / "two.toml")
    with remote_job(rack, 3, 500, whole=False) as (_, plc):
        assert plc.slot == 3
    with (
        pytest.raises(ValueError, match="--slot is needed; slots with an amci3601: 1, 3"),
        remote_job(rack, None, 500, whole=False),
    ):
        pass


def test_a_rack_without_a_program_is_served(tmp_path: Path) -> None:
    rack = tmp_path / "bare.toml"
    rack.write_text('[[slot]]\nnumber = 4\nmodule = "amci3601"\n', encoding="utf-8")
    with remote_job(str(rack), None, 500, whole=False) as (job, plc):
        assert (plc.slot, job.rack_file) == (4, rack)
