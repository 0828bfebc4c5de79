"""Program, run, test and single-scan mode, and what the modules are told of them."""

from scanrack.runtime import Cpu, CpuMode, ScanFlag
from scanrack.runtime.loop.exchange import EveryRpi

MS = 1_000_000


def counting(scan):
    scan.slot[1].outputs[0] += 1


def test_in_program_mode_logic_rests_and_modules_know_from_power_up(rack, module, diary):
    cpu = Cpu(rack, counting, 2 * MS, mode=CpuMode.PROGRAM, listeners=[diary])
    cpu.run(2)
    assert module.log[0] == ("plc_run", False)
    assert module.updates == [(0, 0), (2 * MS, 0)]
    assert [flags for _, _, flags in diary.scans] == [CpuMode.PROGRAM, CpuMode.PROGRAM]
    assert diary.word(1, inputs=True) == 2


def test_in_test_mode_logic_runs_and_outputs_stay_here(rack, module, diary):
    Cpu(rack, counting, 2 * MS, mode=CpuMode.TEST, listeners=[diary]).run(3)
    assert [diary.word(scan) for scan in range(3)] == [1, 2, 3]
    assert [sent for _, sent in module.updates] == [0, 0, 0]
    assert ("plc_run", True) not in module.log


def test_a_mode_asked_for_in_a_scan_takes_effect_in_its_housekeeping(rack, module, diary):
    def logic(scan):
        counting(scan)
        if scan.number == 1:
            cpu.mode = CpuMode.TEST
            assert cpu.mode is CpuMode.RUN

    cpu = Cpu(rack, logic, 2 * MS, listeners=[diary])
    cpu.run(4)
    assert [flags & 3 for _, _, flags in diary.scans] == [1, 1, 2, 2]
    # scan 1 still sends its 2; scans 2 and 3 count on to 4 without sending
    assert [sent for _, sent in module.updates] == [0, 1, 2, 2]
    assert diary.word(3) == 4
    assert diary.topic("/cpu") == [(0, 0, {"mode": "run"}), (2, 4 * MS, {"mode": "test"})]
    log = [entry for entry in module.log if entry[0] != "event"]
    assert log.index(("plc_run", False)) == log.index(("scan", 1)) + 1


def test_run_mode_begins_for_a_module_with_the_first_outputs(rack, module, diary):
    cpu = Cpu(rack, counting, 2 * MS, listeners=[diary])
    cpu.run(1)
    cpu.mode = CpuMode.TEST
    cpu.run(1)
    cpu.mode = CpuMode.RUN
    assert module.log[-1] == ("scan", 1)
    cpu.run(2)
    # what was sent last (1) stays in force, unread, until scan 2 sends its 3 and the news with it
    told = [entry for entry in module.log if entry[0] in ("update", "plc_run")]
    assert told == [
        ("update", 0, 0),
        ("plc_run", False),
        ("update", 2 * MS, 1),
        ("update", 4 * MS, 1),
        ("plc_run", True),
        ("update", 6 * MS, 3),
    ]


def test_on_a_compactlogix_run_mode_begins_with_the_exchange_that_carries_the_outputs(rack, module):
    cpu = Cpu(rack, counting, 2 * MS, exchange=EveryRpi(5 * MS), mode=CpuMode.PROGRAM)
    cpu.mode = CpuMode.RUN
    cpu.run(5)
    # scans at 0 2 4 6 8 ms, exchanges at 0 and 5 ms; the one at 5 ms carries the 3 written at 4 ms
    assert module.log == [("plc_run", False), ("update", 0, 0), ("update", 5 * MS, 0), ("plc_run", True)]


def test_leaving_run_mode_before_the_exchange_takes_the_news_back(rack, module):
    def logic(scan):
        if scan.number == 0:
            cpu.mode = CpuMode.TEST

    cpu = Cpu(rack, logic, 2 * MS, exchange=EveryRpi(5 * MS), mode=CpuMode.PROGRAM)
    cpu.mode = CpuMode.RUN
    cpu.run(5)
    assert ("plc_run", True) not in module.log


def single_scan(cpu):
    cpu.mode = CpuMode.SINGLE_SCAN
    cpu.run(1)


def test_single_scan_is_one_scan_as_in_test_mode(rack, module, diary):
    cpu = Cpu(rack, counting, 2 * MS, mode=CpuMode.PROGRAM, listeners=[diary])
    cpu.run(1)
    single_scan(cpu)
    assert cpu.mode is CpuMode.PROGRAM
    single_scan(cpu)
    cpu.run(1)
    assert [flags & 3 for _, _, flags in diary.scans] == [0, 3, 3, 0]
    assert [diary.word(scan) for scan in range(4)] == [0, 1, 2, 2]
    assert {sent for _, sent in module.updates} == {0}
    # told with a scan is the mode of that scan: there was none in program mode between the two
    modes = [fields["mode"] for _, _, fields in diary.topic("/cpu")]
    assert modes == ["program", "single scan", "single scan", "program"]


def test_single_scan_by_mode_returns_to_program_mode(rack, diary):
    cpu = Cpu(rack, counting, mode=CpuMode.SINGLE_SCAN, listeners=[diary])
    cpu.run(3)
    assert [flags & 3 for _, _, flags in diary.scans] == [3, 0, 0]


def test_first_means_since_program_mode_was_left_but_not_with_every_single_scan(rack, diary):
    firsts = []
    cpu = Cpu(rack, lambda scan: firsts.append(scan.first), mode=CpuMode.PROGRAM, listeners=[diary])
    cpu.run(1)
    single_scan(cpu)  # the first since power-up
    single_scan(cpu)
    cpu.mode = CpuMode.RUN
    cpu.run(2)
    cpu.mode = CpuMode.TEST
    cpu.run(1)
    assert firsts == [True, False, True, False, False]
    flagged = [scan for scan, _, flags in diary.scans if flags & ScanFlag.FIRST_SCAN]
    assert flagged == [1, 3]
