"""Tables of the traces that programs and people rely on: flags, limits, ticks, and whose rules are told."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from made_traces import A3601, idle, record
from scanrack.traces import open_trace
from scanrack.traces.compare.findings import rules_in
from scanrack.traces.format import flags, limits
from scanrack.traces.plot.pack import whole
from scanrack.traces.plot.time_axis import STEPS_NS, label

S = 1_000_000_000
MINUTE, HOUR, DAY = 60 * S, 3600 * S, 86_400 * S


@pytest.mark.parametrize(
    ("bit", "name"),
    [(2, "FIRST_SCAN"), (3, "INPUT_FORCES"), (4, "OUTPUT_FORCES"), (5, "OVERRUN"), (6, "FAULT")],
)
def test_each_flag_has_the_bit_that_traces_have_it_at(bit: int, name: str) -> None:
    assert flags.flag_names(1 << bit)[1:] == [name]
    assert flags.flag_names(0b1111100 & ~(1 << bit)).count(name) == 0
    assert flags.flag_names(flags.OVERRUN)[1:] == ["OVERRUN"]


def test_the_limits_are_those_that_docs_traces_md_says() -> None:
    assert (limits.CHUNK_BYTES, limits.RECORDS) == (32 * 2**20, 200_000)


def test_ticks_stand_at_round_times() -> None:
    """A part of a second, a minute, an hour, a day as long as they are less than it; whole days above."""
    assert all(one < other for one, other in pairwise(STEPS_NS))
    for step in STEPS_NS:
        whole = next((unit for unit in (S, MINUTE, HOUR, DAY) if step <= unit), None)
        assert (whole % step if whole else step % DAY) == 0
    assert {S // 1000, 30 * S, 30 * MINUTE, DAY, 100 * DAY} <= set(STEPS_NS)


@pytest.mark.parametrize(
    ("time_ns", "step_ns", "said"),
    [
        (1_230_000_000, 10_000_000, "1.23"),
        (1_000_000_000, 1_000_000_000, "1"),
        (1_000_000_001, 1, "1.000000001"),
        (1_200_000_000, 200_000_000, "1.2"),
    ],
)
def test_a_tick_has_as_many_decimals_as_its_distance_needs(time_ns: int, step_ns: int, said: str) -> None:
    assert label(time_ns, step_ns, "s") == said


def test_values_of_a_chart_are_cut_to_32_bits_and_none_is_taken_for_a_missing_one() -> None:
    most = 2**31 - 1
    values = np.array([most, -most, 3e9, -3e9, np.inf, np.nan, 0.5, 1.5])
    assert whole(values).tolist() == [most, -most, most, -most, most, -most - 1, 0, 2]


def test_the_rules_told_of_a_scan_are_its_own_and_of_these_slots(tmp_path: Path) -> None:
    def rule(name: str, slot: int | None, kind: str = "rule") -> tuple[str, dict[str, object]]:
        return "/events", {"kind": kind, "name": name, "slot": slot, "text": f"{name} fired."}

    events = {2: rule("BEFORE", 1), 3: rule("WANTED", 1), 4: rule("AFTER", 1)}
    path = record(tmp_path / "run.mcap", idle(6), [A3601], events=events)
    with open_trace(path) as trace:
        assert rules_in(trace, 3, 3 * 2_000_000, {1}) == ("rule at scan 3: WANTED fired [WANTED]",)
        assert rules_in(trace, 3, 3 * 2_000_000, {2}) == ()
        assert rules_in(trace, 5, 5 * 2_000_000, {1}) == ()
    path = record(tmp_path / "other.mcap", idle(6), [A3601], events={3: rule("MOVE", 1, "move")})
    with open_trace(path) as trace:
        assert rules_in(trace, 3, 3 * 2_000_000, {1}) == ()
