"""When images cross the backplane: at the scan's ends, or every RPI whatever the scan does."""

import pytest
from scanrack.runtime import Cpu
from scanrack.runtime.loop.exchange import EndOfScan, EveryRpi

MS = 1_000_000


def numbering(scan):
    """Write 100 + the number of the scan."""
    scan.slot[1].outputs[0] = 100 + scan.number


def seen_inputs(diary, scans):
    return [diary.word(scan, inputs=True) for scan in range(scans)]


def test_micrologix_exchanges_at_the_ends_of_every_scan(rack, module, diary):
    Cpu(rack, numbering, 5 * MS, exchange=EndOfScan(), listeners=[diary]).run(4)
    assert module.updates == [(0, 0), (5 * MS, 100), (10 * MS, 101), (15 * MS, 102)]
    assert seen_inputs(diary, 4) == [0, 5, 10, 15]


def test_scans_slower_than_the_rpi(rack, module, diary):
    # scans      0         5          10          15 ms
    # exchanges  0   2   4    6   8   10   12  14
    # Scan 0's output (100, at 0) waits for the exchange at 2 ms and is in force from there: the
    # module is told of it when it is next advanced, at 4 ms. Scan 1's (101, at 5 ms) crosses at
    # 6 ms, told from 8 ms on; scan 2's (102, at 10 ms, after the exchange of that instant) at 12 ms.
    # Scan 1 sees the inputs of 4 ms, scan 2 those of 10 ms, scan 3 those of 14 ms.
    Cpu(rack, numbering, 5 * MS, exchange=EveryRpi(), listeners=[diary]).run(4)
    assert module.updates == [
        (0, 0),
        (2 * MS, 0),
        (4 * MS, 100),
        (6 * MS, 100),
        (8 * MS, 101),
        (10 * MS, 101),
        (12 * MS, 101),
        (14 * MS, 102),
    ]
    assert seen_inputs(diary, 4) == [0, 4, 10, 14]


def test_scans_faster_than_the_rpi(rack, module, diary):
    # scans      0  1  2  3  4  5 ms
    # exchanges  0     2     4
    # Scans 0 and 1 see the inputs of 0, scans 2 and 3 those of 2 ms. Scan 0's output never gets
    # across: at 2 ms scan 1's has replaced it; it is in force from 2 to 4 ms.
    Cpu(rack, numbering, 1 * MS, exchange=EveryRpi(2 * MS), listeners=[diary]).run(6)
    assert module.updates == [(0, 0), (2 * MS, 0), (4 * MS, 101)]
    assert seen_inputs(diary, 6) == [0, 0, 2, 2, 4, 4]


def test_rpi_and_scan_in_step_cost_one_period_more_than_end_of_scan(rack, module):
    # The exchange at 2 ms comes before the scan at 2 ms: it carries scan 0's output, told at 4 ms.
    Cpu(rack, numbering, 2 * MS, exchange=EveryRpi(2 * MS)).run(4)
    assert module.updates == [(0, 0), (2 * MS, 0), (4 * MS, 100), (6 * MS, 101)]


def test_an_rpi_must_be_positive():
    with pytest.raises(ValueError, match="RPI of 0 ns"):
        EveryRpi(0)
