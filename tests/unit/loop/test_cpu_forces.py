"""Forces: by word and bit, from scan to scan, until they are removed."""

import re

import pytest
from scanrack.runtime import Cpu, CpuMode, ScanFlag

MS = 1_000_000


def test_input_forces_hold_bits_whatever_the_module_says(rack, module, diary):
    module.script = lambda now_ns: 0b0101
    seen = []
    cpu = Cpu(rack, lambda scan: seen.append(scan.slot[1].inputs[0]), 2 * MS, listeners=[diary])
    cpu.run(1)
    cpu.forces.set("I:1.0/1", 1)
    cpu.forces.set("I:1.0/2", 0)
    cpu.run(2)
    cpu.forces.remove("Local:1:I.Data[0].2")
    cpu.run(1)
    cpu.forces.clear()
    cpu.run(1)
    # 0101 -> bit 1 on, bit 2 off: 0011 -> bit 2 let go: 0111 -> 0101
    assert seen == [0b0101, 0b0011, 0b0011, 0b0111, 0b0101]
    assert [diary.word(scan, inputs=True) for scan in range(5)] == seen


def test_output_forces_are_sent_and_recorded_while_the_logic_keeps_its_own(rack, module, diary):
    before = []

    def latching(scan):
        outputs = scan.slot[1].outputs
        before.append(outputs[0])
        outputs[0] |= 1

    cpu = Cpu(rack, latching, 2 * MS, listeners=[diary])
    cpu.forces.set("O:1.0/0", 0)
    cpu.forces.set("O:1.0/9", 1)
    cpu.run(2)
    cpu.forces.clear()
    cpu.run(2)
    # sent: the 1 of the logic under the forces is 512; without them it is there again
    assert [diary.word(scan) for scan in range(4)] == [512, 512, 1, 1]
    assert module.updates[1:] == [(2 * MS, 512), (4 * MS, 512), (6 * MS, 1)]
    assert before == [0, 1, 1, 1]


def test_a_word_is_forced_as_a_whole_in_either_reading(rack, diary):
    cpu = Cpu(rack, lambda scan: None, listeners=[diary])
    cpu.forces.set("Local:1:O.Data[2]", -2)
    cpu.forces.set("Local:1:O.Data3", 65_534)
    cpu.run(1)
    assert (diary.word(0, 2), diary.word(0, 3)) == (-2, -2)


def test_the_latest_force_wins_where_two_meet(rack, diary):
    cpu = Cpu(rack, lambda scan: None, listeners=[diary])
    cpu.forces.set("O:1.0/3", 1)
    cpu.forces.set("O:1.0", 0b0110)
    cpu.run(1)
    cpu.forces.set("O:1.0/3", 1)
    cpu.run(1)
    assert [diary.word(scan) for scan in range(2)] == [0b0110, 0b1110]
    assert list(cpu.forces.active) == ["Local:1:O.Data[0]", "Local:1:O.Data[0].3"]


def test_forces_by_the_names_of_status_and_command_bits(rack, module, diary):
    module.script = lambda now_ns: 0
    cpu = Cpu(rack, lambda scan: None, listeners=[diary])
    cpu.forces.set("slot1.status.MOVE_COMPLETE", 1)  # input word 0, bit 7
    cpu.forces.set("slot1.status.in_home", 1)  # input word 1, bit 2
    cpu.forces.set("slot1.command.HOLD_MOVE", True)  # output word 0, bit 2
    cpu.forces.set("slot1.command.ENC_FOLLOWER", 1)  # output word 1, bit 7
    cpu.run(1)
    assert (diary.word(0, inputs=True), diary.word(0, 1, inputs=True)) == (1 << 7, 1 << 2)
    assert (diary.word(0, 0), diary.word(0, 1)) == (1 << 2, 1 << 7)


def test_forces_are_told_in_full_with_the_first_scan_that_shows_them(rack, diary):
    cpu = Cpu(rack, lambda scan: None, 2 * MS, listeners=[diary])
    cpu.run(1)
    cpu.forces.set("I:1.0/1", 1)
    cpu.forces.set("O:1.2", 5)
    cpu.run(2)
    cpu.forces.remove("I:1.0/1")
    cpu.run(1)
    assert diary.topic("/forces") == [
        (1, 2 * MS, {"Local:1:I.Data[0].1": 1, "Local:1:O.Data[2]": 5}),
        (3, 6 * MS, {"Local:1:O.Data[2]": 5}),
    ]
    both = ScanFlag.INPUT_FORCES | ScanFlag.OUTPUT_FORCES
    assert [flags & both for _, _, flags in diary.scans] == [0, both, both, ScanFlag.OUTPUT_FORCES]


def test_a_force_changed_during_a_scan_waits_for_the_next(rack, diary):
    def logic(scan):
        scan.slot[1].outputs[0] = 1
        if scan.number == 1:
            cpu.forces.set("O:1.0/4", 1)
        if scan.number == 2:
            cpu.forces.clear()
            cpu.forces.set("O:1.0/5", 1)

    cpu = Cpu(rack, logic, listeners=[diary])
    cpu.run(4)
    assert [diary.word(scan) for scan in range(4)] == [1, 1, 0b1_0001, 0b10_0001]


def test_program_mode_forces_inputs_only(rack, module, diary):
    module.script = lambda now_ns: 0
    cpu = Cpu(rack, lambda scan: None, mode=CpuMode.PROGRAM, listeners=[diary])
    cpu.forces.set("I:1.0/1", 1)
    cpu.forces.set("O:1.0/1", 1)
    cpu.run(1)
    assert (diary.word(0, inputs=True), diary.word(0)) == (2, 0)
    assert diary.scans[0][2] == ScanFlag.INPUT_FORCES


@pytest.mark.parametrize(
    ("address", "told"),
    [
        ("I:2.0/14", "slot 2 is empty; choose from 1"),
        ("Local:3:O.Data[1]", "slot 3 is empty; choose from 1"),
        ("I:1.8", "word 8 does not exist: words are 0 to 7"),
        ("Local:1:I.Data[0].16", "bit 16 does not exist: bits are 0 to 15"),
        (
            "N7:0",
            "not an address: write it like Local:1:I.Data[0].14, I:1.0/14 or slot1.status.MOVE_COMPLETE",
        ),
        ("slot1.status.MOVE_COMPLET", "did you mean MOVE_COMPLETE?"),
        ("slot1.command.MOVE_COMPLETE", "slot 1 has no command bit 'MOVE_COMPLETE'"),
        ("slot1.state.MOVE_COMPLETE", "did you mean status? Choose from command, status"),
    ],
)
def test_what_does_not_exist_is_refused_with_what_does(rack, address, told):
    cpu = Cpu(rack, lambda scan: None)
    with pytest.raises(ValueError, match=re.escape(told)) as refusal:
        cpu.forces.set(address, 1)
    assert str(refusal.value).startswith(f"{address!r}")


@pytest.mark.parametrize(
    ("address", "value", "allowed"),
    [
        ("I:1.0/14", 2, "a bit is 0 to 1"),
        ("I:1.0", 65_536, "a word is -32768 to 65535"),
        ("I:1.0", -32_769, "a word is -32768 to 65535"),
        ("I:1.0", 1.5, "a word is -32768 to 65535"),
    ],
)
def test_values_that_do_not_fit_are_refused(rack, address, value, allowed):
    with pytest.raises(ValueError, match=allowed):
        Cpu(rack, lambda scan: None).forces.set(address, value)


def test_only_what_is_forced_can_be_removed(rack):
    cpu = Cpu(rack, lambda scan: None)
    cpu.forces.set("I:1.0/3", 1)
    with pytest.raises(ValueError, match=r"'I:1.0/4' is not forced; current forces: Local:1:I.Data\[0\].3"):
        cpu.forces.remove("I:1.0/4")
