"""Every mistake in a rack file: one message with file, line, key, value and what is allowed."""

# ruff: noqa: E501 - messages are one line each

import pytest
from scanrack.runtime import RackFileError, load_rack_file
from scanrack.runtime.config import rackfile

GOOD = """\
name = "line"
program = "line.py"
scan_ms = 2.0
controller = "compactlogix"
rpi_ms = 2
watchdog_ms = 500
run_for_s = 10
trace = "line.mcap"
seed = 3
mode = "run"

[[slot]]
number = 1
module = "amci3601"
firmware = "4.1"

[slot.options]
input_scan_us = 250

[slot.machine]
switches = [
  { input = "home", first = 3000, last = 3500 },
  { input = "cw_limit", first = 9000, normally_closed = false },
]
slips = [{ at = 100, steps = 5 }]
jams = [{ at = 20000, direction = 1 }]

[slot.machine.encoder]
counts_per_step = 0.5
direction = -1

[[slot.machine.timeline]]
at_s = 3.2
input = "estop"
for_ms = 50

[[slot.machine.stations]]
position = 4000
input = "external"
work_ms = 250
pulse_ms = 20

[[slot]]
number = 2
module = "amci3601"

[[force]]
address = "slot1.status.IN_CAPTURE"
value = 1
"""

MISTAKES = {
    # line that is replaced, what replaces it, line number and text of the message
    "unknown key at the top": (
        "seed = 3",
        "sead = 3",
        9,
        "sead: unknown key; did you mean seed? Choose from program, name, scan_ms, controller, rpi_ms, "
        "watchdog_ms, run_for_s, trace, keep_traces, tags, stubs, axes, prove, fuzz, export, server, seed, mode, modules, slot,",
    ),
    "unknown key of a slot": (
        'firmware = "4.1"',
        'firmwear = "4.1"',
        15,
        "slot.firmwear: unknown key; did you mean firmware? Choose from number, module, firmware, needs_firmware, "
        "options, machine, wiring, port, address",
    ),
    "unknown key of a machine": (
        "slips = [{ at = 100, steps = 5 }]",
        "slip = [{ at = 100, steps = 5 }]",
        25,
        "slot.machine.slip: unknown key; did you mean slips? Choose from switches, timeline, encoder, slips, "
        "jams, stations",
    ),
    "unknown key of a switch": (
        '  { input = "home", first = 3000, last = 3500 },',
        '  { input = "home", first = 3000, lst = 3500 },',
        22,
        "slot.machine.switches.lst: unknown key; did you mean last? Choose from input, first, last, "
        "normally_closed",
    ),
    "unknown key of a jam": (
        "jams = [{ at = 20000, direction = 1 }]",
        "jams = [{ at = 20000, direction = 1, hard = true }]",
        26,
        "slot.machine.jams.hard: unknown key; choose from at, direction",
    ),
    "unknown key of a force": ("value = 1", "value = 1\nbit = 3", 50, "force.bit: unknown key; choose from"),
    "wrong type, number": ("scan_ms = 2.0", 'scan_ms = "2 ms"', 3, 'scan_ms = "2 ms": must be a number'),
    "wrong type, whole number": (
        "number = 2",
        "number = 2.5",
        44,
        "slot.number = 2.5: must be a whole number",
    ),
    "wrong type, text": ('name = "line"', "name = 7", 1, "name = 7: must be text in quotes"),
    "wrong type, path": ('program = "line.py"', "program = 7", 2, "program = 7: must be a path in quotes"),
    "wrong type, yes or no": (
        '  { input = "cw_limit", first = 9000, normally_closed = false },',
        '  { input = "cw_limit", first = 9000, normally_closed = 0 },',
        23,
        "slot.machine.switches.normally_closed = 0: must be true or false",
    ),
    "wrong type, array": (
        "jams = [{ at = 20000, direction = 1 }]",
        "jams = 20000",
        26,
        "slot.machine.jams = 20000: must be an array",
    ),
    "wrong type, table": (
        "[slot.machine.encoder]\ncounts_per_step = 0.5\ndirection = -1",
        "encoder = 3",
        28,
        "slot.machine.encoder = 3: must be a table",
    ),
    "a firmware that is a number": (
        'firmware = "4.1"',
        "firmware = 4.1",
        15,
        'slot.firmware = 4.1: must be text in quotes, such as "4.1"',
    ),
    "options that are no table": (
        "[slot.options]\ninput_scan_us = 250",
        "options = 5",
        17,
        "slot.options = 5: must be a table",
    ),
    "a period out of range": (
        "scan_ms = 2.0",
        "scan_ms = 0.009",
        3,
        "scan_ms = 0.009: must be 0.01 to 1000",
    ),
    "a period that is not a whole number of ns": (
        "scan_ms = 2.0",
        "scan_ms = 2.0000001",
        3,
        "scan_ms = 2.0000001: scan_ms of 2.0000001 ms is not a whole number of nanoseconds",
    ),
    "a period that is not a number at all": (
        "scan_ms = 2.0",
        "scan_ms = nan",
        3,
        "scan_ms = NaN: must be a number",
    ),
    "an RPI out of range": ("rpi_ms = 2", "rpi_ms = 1001", 5, "rpi_ms = 1001: must be 0.01 to 1000"),
    "an RPI without a CompactLogix": (
        'controller = "compactlogix"',
        'controller = "micrologix"',
        5,
        'rpi_ms = 2: goes with controller = "compactlogix" only',
    ),
    "a watchdog out of range": (
        "watchdog_ms = 500",
        "watchdog_ms = -1",
        6,
        "watchdog_ms = -1: must be 0 to 3600000",
    ),
    "a run of no time": (
        "run_for_s = 10",
        "run_for_s = 0",
        7,
        "run_for_s = 0: must be 0.00001 to 1000000000",
    ),
    "a seed out of range": ("seed = 3", "seed = -3", 9, "seed = -3: must be 0 or more"),
    "a mode that is none": (
        'mode = "run"',
        'mode = "running"',
        10,
        "mode = \"running\": must be 'run', 'program' or 'test'",
    ),
    "a controller that is none": (
        'controller = "compactlogix"',
        'controller = "slc"',
        4,
        "controller = \"slc\": must be 'micrologix' or 'compactlogix'",
    ),
    "a slot out of range": ("number = 2", "number = 0", 44, "slot.number = 0: must be 1 or more"),
    "a slot used twice": ("number = 2", "number = 1", 44, "slot.number = 1: slot 1 is used twice"),
    "a module that is none": (
        'number = 2\nmodule = "amci3601"',
        'number = 2\nmodule = "amci3602"',
        45,
        'slot.module = "amci3602": did you mean amci3601? Choose from amci3601',
    ),
    "a firmware that is none": (
        'firmware = "4.1"',
        'firmware = "4.2"',
        15,
        "slot.firmware = \"4.2\": unknown 3601 firmware '4.2'; choose from 2.0, 2.1, 2.2, 3.1, 4.1",
    ),
    "an option that is none": (
        "input_scan_us = 250",
        "input_scan_ms = 250",
        18,
        "slot.options.input_scan_ms = 250: option input_scan_ms: the simulated 3601 has no such option; did you "
        "mean input_scan_us?",
    ),
    "an option out of range": (
        "input_scan_us = 250",
        "input_scan_us = 49",
        18,
        "slot.options.input_scan_us = 49: option input_scan_us: 49 is out of range: 50 to 250000",
    ),
    "an option of another type": (
        "input_scan_us = 250",
        "input_scan_us = 2.5",
        18,
        "slot.options.input_scan_us = 2.5: option input_scan_us: 2.5 is not a whole number",
    ),
    "a wiring that is none": (
        'firmware = "4.1"',
        'wiring = "diag"',
        15,
        "slot.wiring = \"diag\": must be 'diagnostic'",
    ),
    "an input that is none, switch": (
        '  { input = "home", first = 3000, last = 3500 },',
        '  { input = "hone", first = 3000, last = 3500 },',
        22,
        'slot.machine.switches.input = "hone": did you mean home? Choose from capture, external, home, estop, '
        "cw_limit, ccw_limit",
    ),
    "an input that is none, timeline": (
        'input = "estop"',
        'input = "e_stop"',
        34,
        'slot.machine.timeline.input = "e_stop": did you mean estop? Choose from',
    ),
    "an input that is not a name": (
        'input = "external"',
        "input = 2",
        39,
        "slot.machine.stations.input = 2: choose from capture, external",
    ),
    "a range the wrong way round": (
        '  { input = "home", first = 3000, last = 3500 },',
        '  { input = "home", first = 3000, last = 2999 },',
        22,
        "slot.machine.switches.last = 2999: Switch.last is 2999; allowed: 3000 (first) or more, or None",
    ),
    "a time that is missing": (
        "at_s = 3.2",
        "",
        32,
        "slot.machine.timeline: write one of at_ms and at_s, not none",
    ),
    "a time that is there twice": (
        "work_ms = 250",
        "work_ms = 250\nwork_s = 1",
        40,
        "slot.machine.stations.work_ms = 250: write one of work_ms and work_s, not both",
    ),
    "a time out of range": (
        "pulse_ms = 20",
        "pulse_ms = -20",
        41,
        "slot.machine.stations.pulse_ms = -20: must be 0 to 1000000000",
    ),
    "a time that is not a whole number of ns": (
        "for_ms = 50",
        "for_ms = 0.0000005",
        35,
        "slot.machine.timeline.for_ms = 5E-7: for_ms of 5E-7 ms is not a whole number of nanoseconds",
    ),
    "a level that is none": (
        "for_ms = 50",
        'energized = "on"',
        35,
        'slot.machine.timeline.energized = "on": must be true, false or "wired"',
    ),
    "a wired button": (
        "for_ms = 50",
        'energized = "wired"\nfor_ms = 50',
        35,
        'slot.machine.timeline.energized = "wired": energized = "wired" has no end: remove for_ms and for_s',
    ),
    "a ratio that is none": (
        "counts_per_step = 0.5",
        'counts_per_step = "4/0"',
        29,
        'slot.machine.encoder.counts_per_step = "4/0": must be a number, or a fraction such as "4/3"',
    ),
    "a ratio out of range": (
        "counts_per_step = 0.5",
        "counts_per_step = -2",
        29,
        "slot.machine.encoder.counts_per_step = -2: EncoderSpec.counts_per_step is",
    ),
    "a direction that is none": (
        "direction = -1",
        "direction = 2",
        30,
        "slot.machine.encoder.direction = 2: EncoderSpec.direction is 2; allowed: 1, -1",
    ),
    "parts that do not go together": (
        'input = "external"',
        'input = "home"',
        37,
        "slot.machine.stations: MachineSpec.stations is",
    ),
    "a force on an empty slot": (
        'address = "slot1.status.IN_CAPTURE"',
        'address = "I:3.0/14"',
        48,
        'force.address = "I:3.0/14": slot 3 is empty; choose from 1, 2',
    ),
    "a force on a bit that is none": (
        'address = "slot1.status.IN_CAPTURE"',
        'address = "slot1.status.CAPTURE"',
        48,
        "force.address = \"slot1.status.CAPTURE\": slot 1 has no status bit 'CAPTURE'; did "
        "you mean IN_CAPTURE?",
    ),
    "a force out of range": (
        "value = 1",
        "value = 2",
        49,
        "force.value = 2: 'slot1.status.IN_CAPTURE' cannot be forced to 2: a bit is 0 to 1",
    ),
    "an axis on an empty slot": (
        "[[force]]",
        "[axes.Feed]\nslot = 9\n[[force]]",
        48,
        "axes.Feed.slot = 9: this slot is empty: modules sit in 1, 2",
    ),
    "a key of a 3601 without a slot": (
        "[[force]]",
        "[axes.Feed]\ncounts_per_unit = 10\n[[force]]",
        48,
        "axes.Feed.counts_per_unit = 10: only an axis with a slot has this key",
    ),
    "a slot of two axes": (
        "[[force]]",
        "[axes.Feed]\nslot = 2\n[axes.Cut]\nslot = 2\n[[force]]",
        50,
        "axes.Cut.slot = 2: Feed has this slot already",
    ),
    "scan times of a proof": (
        "[[force]]",
        "[prove]\nscan_ms = [5, 2]\n[[force]]",
        48,
        "prove.scan_ms: must be shortest and longest, milliseconds from 1 to 1000",
    ),
    "two claims of a property": (
        "[[force]]",
        '[[prove.property]]\nname = "one"\nnever = "A"\nalways = "B"\n[[force]]',
        50,
        'prove.property.always = "B": this property has never already: write one of never, always, reachable',
    ),
    "a property without a claim": (
        "[[force]]",
        '[[prove.property]]\nname = "one"\n[[force]]',
        48,
        'prove.property.name = "one": this property has no condition: write one of never, always, reachable',
    ),
    "an empty condition of a property": (
        "[[force]]",
        '[[prove.property]]\nname = "one"\nnever = " "\n[[force]]',
        49,
        'prove.property.never = " ": must be a condition of structured text',
    ),
    "two properties of one name": (
        "[[force]]",
        '[[prove.property]]\nname = "one"\nnever = "A"\n[[prove.property]]\nname = "One"\nnever = "B"\n[[force]]',
        51,
        'prove.property.name = "One": another property has this name',
    ),
    "a name without end": (
        "seed = 3",
        f"seed.{'a.' * 15}a = 3",
        9,
        "a name of more than 16 parts",
    ),
    "no program": ('program = "line.py"', "", 1, "program: this key is missing"),
    "no slots": (
        '[[slot]]\nnumber = 2\nmodule = "amci3601"',
        "[[slots]]",
        43,
        "slots: unknown key; did you mean slot?",
    ),
    "no slot number": ("number = 2", "", 43, "slot.number: this key is missing"),
    "no station position": ("position = 4000", "", 37, "slot.machine.stations.position: this key is missing"),
    "no number": ("scan_ms = 2.0", "scan_ms = nan", 3, "scan_ms = NaN: must be a number"),
    "no TOML": ("scan_ms = 2.0", "scan_ms = ", 3, "this is not TOML: Invalid value in column 11"),
    "a key given twice": ("seed = 3", "seed = 3\nseed = 4", 10, "this is not TOML: Cannot overwrite a value"),
}


@pytest.mark.parametrize(("old", "new", "line", "told"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_is_told_with_its_place_and_what_is_allowed(tmp_path, old, new, line, told):
    assert GOOD.count(old) == 1
    path = tmp_path / "line.toml"
    path.write_text(GOOD.replace(old, new), "utf-8")
    with pytest.raises(RackFileError) as caught:
        load_rack_file(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:{line}: {told}")
    assert "\n" not in message


def test_several_mistakes_are_told_in_the_order_of_their_lines(tmp_path):
    path = tmp_path / "line.toml"
    text = (
        GOOD.replace("number = 2", "number = -2")
        .replace("scan_ms = 2.0", "scan_ms = 0")
        .replace("seed = 3", "s = 3")
    )
    path.write_text(text, "utf-8")
    with pytest.raises(RackFileError) as caught:
        load_rack_file(path)
    starts = [message.split(": ")[:2] for message in str(caught.value).split("\n")]
    assert starts == [
        [f"{path}:3", "scan_ms = 0"],
        [f"{path}:9", "s"],
        [f"{path}:44", "slot.number = -2"],
    ]


def test_an_array_without_entries_is_told_beside_the_mistakes_of_another(tmp_path):
    path = tmp_path / "line.toml"
    path.write_text('program = "line.py"\nslot = []\n[[force]]\nvalue = 1\n', "utf-8")
    with pytest.raises(RackFileError) as caught:
        load_rack_file(path)
    assert str(caught.value).splitlines() == [
        f"{path}:2: slot: must be an array of 1 or more",
        f"{path}:3: force.address: this key is missing",
    ]


def test_an_old_firmware_behind_a_micrologix(tmp_path):
    path = tmp_path / "line.toml"
    text = GOOD.replace('controller = "compactlogix"', 'controller = "micrologix"').replace(
        "rpi_ms = 2\n", ""
    )
    path.write_text(text.replace('firmware = "4.1"', 'firmware = "2.1"'), "utf-8")
    told = r':14: slot.firmware = "2.1": firmware 2.1 does not run in a MicroLogix rack: must be 2.2 or later'
    with pytest.raises(RackFileError, match=told):
        load_rack_file(path)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(RackFileError, match=r"lime.toml: no such rack file$"):
        load_rack_file(tmp_path / "lime.toml")


def test_a_folder(tmp_path):
    with pytest.raises(RackFileError, match="the rack file can't be read: Is a directory"):
        load_rack_file(tmp_path)


def test_a_file_that_is_no_text(tmp_path):
    path = tmp_path / "line.toml"
    path.write_bytes(b"name = '\xff'")
    with pytest.raises(RackFileError, match="the rack file is not text in UTF-8: invalid start byte"):
        load_rack_file(path)


def test_a_value_that_only_later_turns_out_to_be_wrong(tmp_path):
    path = tmp_path / "line.toml"
    path.write_text(GOOD, "utf-8")
    refusal = load_rack_file(path).refusal("program", "no such program file")
    assert str(refusal) == f'{path}:2: program = "line.py": no such program file'


def test_of_many_mistakes_the_first_are_explained(tmp_path):
    most, path = rackfile.MISTAKES, tmp_path / "rack.toml"
    path.write_text("".join(f"a{number} = 1\n" for number in range(most + 7)) + GOOD, encoding="utf-8")
    with pytest.raises(RackFileError) as refused:
        load_rack_file(path)
    *explained, more = str(refused.value).splitlines()
    assert len(explained) == most
    assert more == f"{path}: and 7 more mistakes"
