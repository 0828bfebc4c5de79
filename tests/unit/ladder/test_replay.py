"""Scans of a program are run again from any source of snapshots and inputs, as far as it knows them.

Broken on purpose: going on from a snapshot instead of from the present scan, a gap that is not seen, a search
that leaves the engine at another scan than it says: a test turns red.
"""

import pytest
from scanrack.ladder.debug.replay import Replayer, Source
from scanrack.ladder.debug.stretch import ScanInputs
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.files import parse_program
from scanrack.ladder.state.snapshots import snapshot

COUNTING = """PROGRAM counting
TAG Start : BOOL
TAG Count : DINT
TAG Late : BOOL
ROUTINE Main
XIC(Start)ADD(Count,1,Count);
GRT(Count,5)OTE(Late);
END
"""
SCANS, EVERY = 20, 6


class Kept(Source):
    """A source in memory; `missing` scans have no inputs."""

    def __init__(self, snapshots, entries, missing=()):
        self.kept, self.entries, self.missing, self.restored = snapshots, entries, set(missing), []

    def snapshots(self, scan):
        return iter([each for each in sorted(self.kept, reverse=True) if each <= scan])

    def snapshot(self, scan):
        self.restored.append(scan)
        return self.kept[scan], {}

    def inputs(self, first, last):
        known = range(first, min([*(each for each in self.missing if each >= first), last + 1, SCANS]))
        return len(known), (self.entries[scan] for scan in known)


def ran():
    """Run the program; return its snapshots, its inputs, and Count after each scan. Start is on from 3 on."""
    program = parse_program(COUNTING)
    engine = WatchedEngine(program.build(), program.scanner)
    start = engine.lowered.layout.leaf("Start")
    snapshots, entries, counts = {}, [], []
    for scan in range(SCANS):
        if scan % EVERY == 0:
            snapshots[scan] = snapshot(engine.memory)
        writes = ((start, 0, True),) if scan == 3 else ()
        entries.append(ScanInputs(scan * 10_000_000, scan == 0, (), writes, {}))
        engine.outside = writes
        engine.do(scan * 10_000_000, first=scan == 0)
        counts.append(engine.tags["Count"])
    return program, snapshots, entries, counts


@pytest.fixture
def replay():
    program, snapshots, entries, counts = ran()

    def make(missing=(), **options):
        source = Kept(snapshots, entries, missing)
        return Replayer(WatchedEngine(program.build(), program.scanner), source, **options), source, counts

    return make


def test_any_scan_is_shown_and_the_next_one_goes_on_from_there(replay):
    replayer, source, counts = replay()
    for scan in (13, 14, 2, 19):
        assert replayer.show(scan)
        assert (replayer.at, replayer.engine.tags["Count"]) == (scan, counts[scan])
        assert replayer.truths["MAIN", 0] == ((True, True) if scan >= 3 else (False, False))
    assert source.restored == [12, 0, 18]


def test_a_scan_is_watched_from_a_snapshot_and_says_what_changed(replay):
    replayer, source, counts = replay()
    assert replayer.show(16)
    engine = replayer.again(16)
    assert [(each.leaf.path, each.after) for each in engine.history] == [("Count", counts[16])]
    assert source.restored == [12, 12]


def test_the_last_change_is_found_and_the_engine_is_where_it_says(replay):
    replayer, _, counts = replay()
    assert replayer.last_change(lambda engine: engine.tags["Late"], SCANS - 1) == counts.index(6)
    assert replayer.last_change(lambda engine: engine.tags["Start"], 2) is None
    assert replayer.last_change(lambda engine: engine.tags["Count"], SCANS - 1) == SCANS - 1
    assert replayer.show(SCANS - 1)
    assert replayer.engine.tags["Count"] == counts[-1]


def test_nothing_is_run_across_a_gap(replay):
    replayer, _, counts = replay(missing=[8])
    assert not replayer.show(10)
    with pytest.raises(ValueError, match="scan 9 can no longer be repeated"):
        replayer.again(9)
    assert list(replayer.walk(4, 15)) == [scan * 10_000_000 for scan in range(4, 8)]
    assert replayer.engine.tags["Count"] == counts[7]
    assert replayer.last_change(lambda engine: engine.tags["Start"], SCANS - 1) == 3


def test_a_scan_too_far_behind_a_snapshot_is_not_run(replay):
    replayer, _, _ = replay(most=3)
    assert replayer.show(9)
    assert not replayer.show(17)
    assert replayer.show(12)


def test_a_change_is_searched_in_the_latest_stretches_only(replay):
    replayer, source, _ = replay(stretches=2)
    assert replayer.last_change(lambda engine: engine.tags["Start"], SCANS - 1) is None
    assert source.restored == [18, 12]
