"""Whatever a PLC did, its recording replayed is the recording: modes, forces, words, either exchange.

Broken on purpose: the first scan's flag not restored, forces taken back a scan late, single scans
played as program mode, outputs of scans without logic played as well: each turns it red.
"""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images import Image
from scanrack.jobs import build_cpu, build_rack
from scanrack.jobs.replay.replaying import Replay
from scanrack.jobs.replay.targets import ReplayTarget
from scanrack.runtime import Cpu, RackSpec, SlotSpec
from scanrack.runtime.loop.scan import CpuMode, LogicScan
from scanrack.traces import ScanRecorder, SlotInfo, open_trace
from scanrack.traces.compare import EXACT
from scanrack.traces.replay import PackedTrace

SCANS = 40
WORDS = (
    [0] * 8,
    [-31682, 63, 1, 0, 0, 0, 0, 0],  # a configuration
    [0x0200] + [0] * 7,  # preset
    [0x0002, 0, 0, 90, 5, 0, 100, 100],  # relative move
    [0x0080, 0, 0, 0, 2, 0, 50, 50],  # manual move
    [0x0800] + [0] * 7,  # reset errors
    [0x0004] + [0] * 7,  # hold
)
ACTIONS = st.sampled_from(
    ["program", "run", "test", "single scan", "force in", "force out", "clear", "none", "none"]
)
FORCES = {"force in": "Local:1:I.Data[1].1", "force out": "Local:1:O.Data[0].4"}


def act(cpu: Cpu, action: str) -> None:
    if action in ("program", "run", "test"):
        cpu.mode = CpuMode[action.upper()]
    elif action == "single scan" and cpu.mode is CpuMode.PROGRAM:
        cpu.mode = CpuMode.SINGLE_SCAN
    elif action in FORCES and FORCES[action] not in cpu.forces.active:
        cpu.forces.set(FORCES[action], 1)
    elif action == "clear" and cpu.forces.active:  # what changes nothing is not recorded
        cpu.forces.clear()


def logic_of(choices: list[int]):
    """Return logic that configures the module, and then writes what scan, an input bit and `first` choose."""
    choices = [1, 1, 0, *choices]

    def logic(scan: LogicScan) -> None:
        bit = scan.slot[1].inputs[0] >> 12 & 1
        scan.slot[1].outputs.load(Image(WORDS[choices[(scan.number + bit + scan.first) // 3 % len(choices)]]))

    return logic


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("replay") / "anything.mcap"


@pytest.mark.slow
@settings(max_examples=amount(25))
@given(
    choices=st.lists(st.integers(0, len(WORDS) - 1), min_size=1, max_size=12),
    actions=st.dictionaries(st.integers(0, SCANS - 1), ACTIONS, max_size=8),
    mode=st.sampled_from(["run", "program", "test"]),
    rpi_ms=st.sampled_from([None, 2, 3, 5]),
    begin=st.sampled_from([0, 0, 14]),
)
def test_a_recording_replayed_is_the_recording(
    trace: Path, choices: list[int], actions: dict[int, str], mode: Any, rpi_ms: int | None, begin: int
) -> None:
    if begin:  # in mid-life; what was before is not in the recording
        mode, actions = "run", {scan: action for scan, action in actions.items() if scan > begin}
    exchange: dict[str, Any] = {"controller": "compactlogix", "rpi_ms": rpi_ms} if rpi_ms else {}
    spec = RackSpec(
        program=logic_of(choices),
        mode=mode,
        slot=(SlotSpec(number=1, module="amci3601"),),
        watchdog_ms=Decimal(0),
        **exchange,
    )
    rack = build_rack(spec)
    slots = [SlotInfo(1, "amci3601", "4.1")]
    with build_cpu(spec, logic_of(choices), rack) as cpu:
        for scan in range(SCANS):
            if scan == begin:
                cpu.add_listener(ScanRecorder(trace, rack.memory, slots, scan_period_ns=spec.scan_ns))
            act(cpu, actions.get(scan, "none"))
            cpu.run(1)
    with open_trace(trace) as opened:
        recording = PackedTrace.of(opened)
    for into in (
        (ReplayTarget.MODULE, ReplayTarget.PROGRAM, ReplayTarget.RACK)
        if not begin
        else (ReplayTarget.PROGRAM,)
    ):
        logic = None if into is ReplayTarget.MODULE else logic_of(choices)
        replay = Replay(recording, spec, logic, into, [1])
        found = replay.run(EXACT, to_the_end=False).comparison()
        assert found.same, (into, found.first)
