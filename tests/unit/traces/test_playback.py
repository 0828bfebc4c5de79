"""What a recording puts in place of modules, logic and stimuli."""

from __future__ import annotations

import numpy as np
import pytest
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import build_rack
from scanrack.jobs.replay.input_levels import recorded_levels
from scanrack.jobs.run.build import build_playback
from scanrack.jobs.run.playback import RecordedInputs, ReplayPlan, Stimulus, recorded_outputs, stimulated
from scanrack.runtime import RackSpec, SlotSpec
from scanrack.runtime.loop.scan import LogicScan
from scanrack.runtime.machine import MachineSpec, Station, Switch, TimelineEntry
from scanrack.traces import SlotInfo
from scanrack.traces.read import packed
from scanrack.traces.read.columns import Columns
from scanrack.traces.read.packed import PackedScans
from scanrack.traces.replay import PackedTrace

MS = 1_000_000
RUN, FIRST, FORCED = 1, 4, 8


class Heard:
    """A listener that notes scans."""

    def __init__(self, memory: bytearray) -> None:
        self.scans: list[tuple[int, int, int]] = []
        self.outputs: list[int] = []
        self.memory = memory

    def event(self, *_: object) -> None:
        pass

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        self.scans.append((scan, now_ns, flags))
        self.outputs.append(int.from_bytes(self.memory[:2], "little"))

    def close(self) -> None:
        pass


def play(score: ReplayPlan, memory: list[bytes]) -> tuple[Heard, list[bool]]:
    """Play a recording into a 3601; return what a listener heard, and `first` of the scans with logic."""
    spec = RackSpec(program=print, slot=(SlotSpec(number=1, module="amci3601"),))
    rack = build_rack(spec)
    heard, firsts = Heard(rack.memory), []
    written = recorded_outputs(score, memory, rack.layout)

    def logic(scan: LogicScan) -> None:
        firsts.append(scan.first)
        written(scan)

    build_playback(spec, score, logic, rack, listeners=[heard]).play()
    return heard, firsts


def test_numbers_times_modes_and_forces_are_those_of_the_recording() -> None:
    numbers, times = [7, 8, 9, 12, 13], [20 * MS, 23 * MS, 24 * MS, 31 * MS, 32 * MS]
    flags = [RUN, RUN | FORCED, 0, RUN | FIRST | FORCED, RUN | FORCED]
    memory = [bytes([scan, 0]) + bytes(30) for scan in range(5)]
    heard, firsts = play(ReplayPlan(numbers, times, flags, {8: {"slot1.status.IN_HOME": 1}}), memory)
    # In program mode input forces hold, so the flag is theirs in scan 9 as well.
    assert heard.scans == [
        (number, time, flag | (FORCED if number == 9 else 0))
        for number, time, flag in zip(numbers, times, flags, strict=True)
    ]
    assert heard.outputs == [0, 1, 1, 3, 4], "in program mode the outputs stay"
    assert firsts == [False, False, True, False]


def test_recorded_inputs_show_the_image_in_force() -> None:
    module = RecordedInputs([Image([number]).raw.tobytes() for number in (1, 2, 3)], [0, 2 * MS, 5 * MS])
    shown = [module.update(at * MS, Image())[0] for at in (0, 1, 2, 4, 5, 9)]
    assert shown == [1, 1, 2, 2, 3, 3]


def test_recorded_stimuli_take_the_place_of_timeline_and_stations() -> None:
    machine = MachineSpec(
        switches=(Switch(InputBit.HOME, 0, 9),),
        timeline=(TimelineEntry(1, InputBit.EXTERNAL, True),),
        stations=(Station(4000, InputBit.CAPTURE, 1, 1),),
    )
    stimuli = [
        Stimulus(5, 1, InputBit.CAPTURE, True),
        Stimulus(6, 1, InputBit.CAPTURE, None),  # a broken wire that has been repaired
        Stimulus(7, 1, InputBit.HOME, None),
    ]
    acted = stimulated(machine, stimuli)
    assert (acted.stations, acted.switches) == ((), machine.switches)
    assert [(entry.at_ns, entry.energized) for entry in acted.timeline] == [(5, True), (6, False), (7, None)]
    bare = stimulated(machine, stimuli[:1], switches=False)
    assert (bare.switches, len(bare.timeline)) == ((), 1)


@pytest.mark.parametrize("chunk", [1, 2, 3, 4096])
@pytest.mark.parametrize(("levels", "energized"), [(0x3F, True), (0x3B, False)])
def test_levels_are_what_the_status_bits_show_by_the_active_level(
    levels: int, energized: bool, chunk: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Home active from the fourth scan on; energized if it is configured active high [chapter 3]."""
    monkeypatch.setattr(packed, "CHUNK_SCANS", chunk)
    words = np.zeros((6, 16), np.int16)
    words[0, :2] = -0x8000, levels  # a configuration; the module's own mode follows a scan later
    words[1, 8] = -0x8000
    words[3:, 9] = InputBit.HOME.value
    scans = np.arange(6, dtype=np.int64)
    columns = Columns(scans, scans * 2 * MS, np.ones(6, np.uint32), words)
    recording = PackedTrace((SlotInfo(1, "amci3601"),), PackedScans.of(16, [columns]), ())
    stimuli = list(recorded_levels(recording))
    home = [(each.at_ns, each.energized) for each in stimuli if each.input is InputBit.HOME]
    assert home[-1] == (5 * MS, energized), "half-way between the scans at 4 and 6 ms"
    assert home[-2][1] is not energized
    assert {each.input for each in stimuli} == set(InputBit), "every level is told at the beginning"
