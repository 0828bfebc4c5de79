"""A scan, phase by phase."""

import pytest
from scanrack.runtime import Card, Cpu, Rack, ScanFlag
from scanrack.runtime.loop.cpu import PHASES
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.phases import ScanPhases

MS = 1_000_000


def test_the_phases_run_in_the_order_of_their_names(rack, log, monkeypatch):
    def noting(owner, name):
        phase = getattr(owner, name)

        def noted(self):
            log.append(name)
            phase(self)

        monkeypatch.setattr(owner, name, noted)

    for name in PHASES[:-1]:
        noting(ScanPhases, name)
    noting(Cpu, PHASES[-1])
    cpu = Cpu(rack, lambda scan: None)
    cpu.forces.set("I:1.7", 1)
    cpu.forces.set("O:1.7", 1)
    cpu.run(2)
    assert [entry for entry in log if entry in PHASES] == [*PHASES, *PHASES]


def test_each_phase_happens_between_its_neighbors(rack, module, diary, log):
    seen = []

    def logic(scan):
        log.append("logic")
        seen.append((scan.slot[1].inputs[0], scan.slot[1].inputs[1]))
        scan.slot[1].outputs[0] = 7
        scan.slot[1].outputs[1] = 8

    cpu = Cpu(rack, logic, 2 * MS, listeners=[diary])
    cpu.forces.set("I:1.1", 55)
    cpu.forces.set("O:1.1", 66)
    module.script = lambda now_ns: 44
    cpu.run(1)
    # input latch (44 from the module), input force (55), logic, output force (66 over 8), record
    assert seen == [(44, 55)]
    assert (diary.word(0, 0), diary.word(0, 1)) == (7, 66)
    assert [entry for entry in log if entry[0] != "event"] == [("update", 0, 0), "logic", ("scan", 0)]


def test_scan_0_is_at_0_with_the_power_up_image_and_scan_n_at_n_periods(rack, module, diary):
    Cpu(rack, lambda scan: None, 2 * MS, listeners=[diary]).run(4)
    assert [(scan, now) for scan, now, _ in diary.scans] == [(0, 0), (1, 2 * MS), (2, 4 * MS), (3, 6 * MS)]
    assert [diary.word(scan, inputs=True) for scan in range(4)] == [0, 2, 4, 6]
    assert module.updates[0] == (0, 0)


def test_outputs_of_a_scan_are_in_force_until_the_next_one(rack, module):
    def logic(scan):
        scan.slot[1].outputs[0] = 100 + scan.number

    Cpu(rack, logic, 2 * MS).run(3)
    # update(t, outputs) names what was in force up to t: the power-up zeros, then scan 0's, then scan 1's
    assert module.updates == [(0, 0), (2 * MS, 100), (4 * MS, 101)]


def test_what_logic_is_told(rack):
    told = []
    cpu = Cpu(rack, lambda scan: told.append((scan.number, scan.now_ns, scan.first, scan.period_ns)), 3 * MS)
    cpu.run(2)
    cpu.run(1)
    assert told == [(0, 0, True, 3 * MS), (1, 3 * MS, False, 3 * MS), (2, 6 * MS, False, 3 * MS)]
    assert (cpu.scan, cpu.now_ns) == (3, 9 * MS)


def test_first_scan_is_flagged_and_the_mode_told_with_it(rack, diary):
    Cpu(rack, lambda scan: None, 2 * MS, listeners=[diary]).run(2)
    assert [flags for _, _, flags in diary.scans] == [ScanFlag.RUN | ScanFlag.FIRST_SCAN, ScanFlag.RUN]
    assert diary.topic("/cpu") == [(0, 0, {"mode": "run"})]
    assert [entry for entry in diary.log if entry[0] != "update"] == [
        ("event", "/cpu"),
        ("scan", 0),
        ("scan", 1),
    ]


def test_an_empty_slot_is_named(rack):
    with pytest.raises(ValueError, match="slot 2 is empty: modules sit in 1"):
        rack.slots[2]


def test_module_events_are_told_in_order_of_time_before_their_scan_and_emptied(new_module, new_diary):
    early, late = new_module(), new_module()
    rack = Rack([Card(1, late), Card(4, early)])
    diary = new_diary(rack.memory)
    cpu = Cpu(rack, lambda scan: None, 2 * MS, listeners=[diary])
    cpu.run(1)
    diary.log.clear()
    late.events.append(Event(1_900_000, "rule", "CMD-03", "Too early.", {"bits": ["COMMAND_ERROR"]}))
    early.events.append(Event(1_200_000, "stimulus", "HOME", "The home input was energized."))
    early.events.append(Event(1_500_000, "move", "relative", "A move began."))
    cpu.run(2)
    assert diary.topic("/events") == [
        (1, 1_500_000, {"slot": 4, "kind": "move", "name": "relative", "text": "A move began."}),
        (
            1,
            1_900_000,
            {"slot": 1, "kind": "rule", "name": "CMD-03", "text": "Too early.", "bits": ["COMMAND_ERROR"]},
        ),
    ]
    assert [(scan, at) for scan, at, _ in diary.topic("/stimuli")] == [(1, 1_200_000)]
    assert diary.log == [
        ("event", "/stimuli"),
        ("event", "/events"),
        ("event", "/events"),
        ("scan", 1),
        ("scan", 2),
    ]
    assert (early.events, late.events) == ([], [])


def test_events_are_emptied_even_if_nobody_listens(rack, module):
    module.events.append(Event(0, "move", "relative", "A move began."))
    Cpu(rack, lambda scan: None).run(1)
    assert module.events == []


def test_stop_takes_effect_between_scans(rack, diary):
    def logic(scan):
        if scan.number == 2:
            cpu.stop()

    cpu = Cpu(rack, logic, listeners=[diary])
    cpu.run()
    assert cpu.stop_requested
    assert [scan for scan, _, _ in diary.scans] == [0, 1, 2]
    cpu.run(1)
    assert diary.scans[-1][0] == 3


def test_listeners_are_closed_once_in_order(rack, new_diary, log):
    first, second = new_diary(rack.memory), new_diary(rack.memory)
    with Cpu(rack, lambda scan: None, listeners=[first]) as cpu:
        cpu.add_listener(second)
        cpu.run(1)
        cpu.close()
    assert (first.closed, second.closed) == (1, 1)
    with pytest.raises(ValueError, match="closed"):
        cpu.run(1)


def test_a_period_must_be_positive(rack):
    with pytest.raises(ValueError, match="of 0 ns: must be at least 1 ns"):
        Cpu(rack, lambda scan: None, 0)
