"""`scanrack show`: what it prints of a hand-made trace, and what it refuses."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import typer
from scanrack.commands.recordings.show import new_table, plain_lines, register
from scanrack.io_images.image import Image
from scanrack.io_images.times import seconds_column
from scanrack.terminal.shared_options import parse_range
from scanrack.traces import Attachment, ScanRecorder, SlotInfo
from typer.testing import CliRunner

PERIOD = 2_000_000
NOTHING: list[int] = []
# 843Eh/003Fh: external, home, emergency stop, both limits, step and direction, all active high [chapter 3]
CONFIGURATION = [0x843E, 0x003F, 1, 0]
RELATIVE_MOVE = [0x0002, 0, 10, 0, 5, 0, 20, 10]
TOO_SOON = "A move was started before the previous one was complete."

# scan -> (output image, input image) from there on
STORY: dict[int, tuple[list[int], list[int]]] = {
    0: (NOTHING, [0x6400]),  # power-up: MODULE_OK CONFIG_ERROR POSITION_INVALID
    2: (CONFIGURATION, [0x6400]),
    3: (CONFIGURATION, [0xC43E, 0x003F, 1, 0, 0, 0, 4, 1]),  # echo; firmware 4.1
    4: (NOTHING, [0xC43E, 0x003F, 1, 0, 0, 0, 4, 1]),
    5: (NOTHING, [0x4400]),
    6: (RELATIVE_MOVE, [0x4400]),
    7: (RELATIVE_MOVE, [0x4421, 0, 0, 3]),  # MOVING_CW ACCELERATING
    8: (RELATIVE_MOVE, [0x4421, 0, 0, 11]),
    9: (RELATIVE_MOVE, [0x4421, 0, 0, 19, 0, 40]),
    10: (RELATIVE_MOVE, [0x4421, 0, 1, 500, 0, 40]),
    12: ([0, 0, 10, 0, 5, 500, 20, 10], [0x5401, 0, 1, 600, 0, 41]),
    14: ([0, 0, 10, 0, 5, 500, 20, 10], [0x5401, 1, 1, 700, 0, 41, -1, -999]),  # captured -1,999
}
SCANS = 20


def tell(path: Path) -> Path:
    """Record the story: a 3601 in slot 1, a toy in slot 3."""
    memory = bytearray(64)
    images = [Image(buffer=memoryview(memory)[16 * place : 16 * place + 16]) for place in range(4)]
    recorder = ScanRecorder(
        path,
        memory,
        [SlotInfo(1, "amci3601", "4.1"), SlotInfo(3, "toy")],
        scan_period_ns=PERIOD,
        seed=7,
        program=Attachment("logic.py", b"pass\n"),
    )
    for scan in range(SCANS):
        now_ns = scan * PERIOD
        for image, words in zip(images, STORY.get(scan, ()), strict=False):
            image.load(Image(words))
        images[3][5] = -7 if scan >= 16 else 0
        if scan == 0:
            recorder.event(0, 0, "/cpu", {"mode": "run"})
        if scan == 12:
            rule: dict[str, Any] = {"bits": ["COMMAND_ERROR"], "section": "chapter 6, Command Error 3"}
            rule |= {"slot": 1, "kind": "rule", "name": "CMD-03", "text": TOO_SOON}
            recorder.event(12, now_ns - 750_000, "/events", rule)
        if scan == 14:
            stimulus: dict[str, Any] = {
                "slot": 1,
                "kind": "stimulus",
                "name": "CAPTURE",
                "text": "CAPTURE energized",
            }
            recorder.event(14, now_ns, "/stimuli", stimulus)
            recorder.event(14, now_ns, "/forces", {"slot3.I.5": -7})
        if scan == 19:
            fault = {"cause": "program", "where": "logic.py:3", "text": "ZeroDivisionError: division by zero"}
            recorder.event(19, now_ns, "/faults", fault)
        flags = {0: 0b101, 19: 0b1000001}.get(scan, 1)  # run mode; first scan; fault
        recorder.scan(scan, now_ns, flags)
    recorder.close()
    return path


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tell(tmp_path / "story.mcap")


def run(*arguments: str) -> tuple[int, str, str]:
    app = typer.Typer(rich_markup_mode=None)
    app.callback()(lambda: None)
    register(app)
    result = CliRunner().invoke(app, ["show", *arguments])
    return result.exit_code, result.stdout, result.stderr


def section(text: str, title: str) -> str:
    """Return what stands under a title."""
    return text.split(f"{title}\n", 1)[1].split("\n\n", 1)[0]


def test_head_slots_and_metadata(path: Path) -> None:
    status, out, err = run(str(path))
    assert (status, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].startswith(f"{path}: {path.stat().st_size:,} bytes, written by scanrack ")
    assert lines[1] == "20 scans, 0 to 19, up to 0.038 s of machine time"
    assert lines[3:6] == ["slot  module    firmware", "   1  amci3601  4.1", "   3  toy       -"]
    assert re.search(r"^scan_period_ns  2000000$", out, re.MULTILINE)
    assert re.search(r"^seed            7$", out, re.MULTILINE)
    assert "attached: logic.py    5 bytes\nattached: words.json" in out


def test_what_happened(path: Path) -> None:
    _, out, _ = run(str(path))
    assert section(out, "What happened") == (
        "scan   time s  slot  what\n"
        "   0    0.000        the CPU is in run mode\n"
        "  12  0.02325     1  "
        "COMMAND_ERROR at scan 12: a move was started before the previous one was complete "
        "[CMD-03, chapter 6]\n"
        "  14    0.028     1  CAPTURE energized\n"
        "  14    0.028        forces: slot3.I.5 = -7\n"
        "  19    0.038        "
        "the CPU faulted, by the program: ZeroDivisionError: division by zero [logic.py:3]"
    )


CONFIGURED = (
    "USE_EXTERNAL USE_HOME USE_ESTOP USE_CW_LIMIT USE_CCW_LIMIT STEP_AND_DIRECTION MODE_CONFIG, "
    "active high CAPTURE EXTERNAL HOME ESTOP CW_LIMIT CCW_LIMIT, starting speed 1,000"
)


def test_what_changed(path: Path) -> None:
    _, out, _ = run(str(path))
    assert section(out, "What changed") == (
        "scan  time s  slot       position  encoder  what\n"
        "   0   0.000        cpu                     +run mode +FIRST_SCAN\n"
        "   0   0.000     1  in          0        0  +POSITION_INVALID +CONFIG_ERROR +MODULE_OK\n"
        "   1   0.002        cpu                     -FIRST_SCAN\n"
        f"   2   0.004     1  out                     {CONFIGURED}\n"
        "   3   0.006     1  in                      "
        "+MODE_CONFIG -POSITION_INVALID -CONFIG_ERROR firmware 4.1\n"
        "   4   0.008     1  out                     no command\n"
        "   5   0.010     1  in          0        0  +POSITION_INVALID -MODE_CONFIG\n"
        "   6   0.012     1  out                     "
        "RELATIVE_MOVE, target 10,000, speed 5,000, acceleration 20, deceleration 10\n"
        "   7   0.014     1  in          3        0  +MOVING_CW +ACCELERATING\n"
        "                                            "
        "... 3 scans in which only the position and encoder count changed\n"
        "  12   0.024     1  in      1,600       41  +COMMAND_ERROR -ACCELERATING\n"
        "  12   0.024     1  out                     no command, speed 5,500\n"
        "  14   0.028     1  in      1,700       41  +IN_CAPTURE captured -1,999\n"
        "  16   0.032     3  in                      word5 0 -> -7\n"
        "  19   0.038        cpu                     +FAULT\n"
    )


def test_every_shows_the_rows_that_are_folded(path: Path) -> None:
    _, out, _ = run(str(path), "--every", "--range", "8:12")
    assert section(out, "What changed") == (
        "scan  time s  slot       position  encoder  what\n"
        "   8   0.016     1  in         11        0\n"
        "   9   0.018     1  in         19       40\n"
        "  10   0.020     1  in      1,500       40\n"
        "  12   0.024     1  in      1,600       41  +COMMAND_ERROR -ACCELERATING\n"
        "  12   0.024     1  out                     no command, speed 5,500\n"
    )
    assert "CMD-03" in out  # the events of the range, and no others
    assert "the CPU is in run mode" not in out
    assert "20 scans, 0 to 19" in out


def test_a_range_begins_from_the_scan_before_it(path: Path) -> None:
    _, out, _ = run(str(path), "--range", "9:11")
    assert section(out, "What changed") == (
        "scan  time s  slot    position  encoder  what\n"
        "                                         "
        "... 2 scans in which only the position and encoder count changed\n"
    )


def test_limit_says_what_it_leaves_out(path: Path) -> None:
    _, out, _ = run(str(path), "--limit", "2")
    assert section(out, "What happened").splitlines()[-1] == "... and 3 more events"
    changed = section(out, "What changed").splitlines()
    assert len(changed) == 4  # the titles, two rows, and the rest
    assert changed[-1] == "... and 13 more rows"


def test_a_file_that_cannot_be_read_is_one_message_and_status_2(tmp_path: Path) -> None:
    other = tmp_path / "notes.txt"
    other.write_text("no trace at all, but long enough for one\n", encoding="utf-8")
    assert run(str(other)) == (2, "", f"scanrack: {other}: it is not an MCAP file\n")
    missing = tmp_path / "missing.mcap"
    assert run(str(missing)) == (2, "", f"scanrack: {missing}: No such file or directory\n")


def test_a_killed_trace_is_shown_with_a_note(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-200])
    status, out, _ = run(str(path))
    assert status == 0
    assert re.search(
        r"^note: it has no end: the last whole record ends at byte [\d,]+ of [\d,]+$", out, re.MULTILINE
    )
    assert "20 scans, 0 to 19" in out


def test_a_trace_without_scans_is_shown(tmp_path: Path) -> None:
    path = tmp_path / "empty.mcap"
    ScanRecorder(path, bytearray(32), [SlotInfo(1, "amci3601", "4.1")], scan_period_ns=PERIOD).close()
    status, out, _ = run(str(path))
    assert status == 0
    assert "\nno scans\n" in out
    assert out.endswith("What happened\nnothing beside the scans\n\nWhat changed\nnothing\n")


@pytest.mark.parametrize("text", ["", ":", "5:3", "-1:2", "a:b", "1:2:3", "1.5"])
def test_no_range(text: str) -> None:
    with pytest.raises(ValueError, match=r"^--range '.*': (must be A:B|ends before it begins)"):
        parse_range(text)


def test_no_range_is_a_usage_error(path: Path) -> None:
    status, out, err = run(str(path), "--range", "5:3")
    assert (status, out) == (2, "")
    assert "--range '5:3': ends before it begins" in err


@pytest.mark.parametrize(
    ("time_ns", "text"),
    [(0, "0.000"), (1, "0.000000001"), (250_000, "0.00025"), (600_000_000_000, "600.000")],
)
def test_seconds_are_exact(time_ns: int, text: str) -> None:
    assert seconds_column(time_ns) == text


def test_a_line_of_a_table_is_as_long_as_its_cells() -> None:
    """Wide characters take two columns; a last column without text takes none."""
    table = new_table("scan>", "what", "")
    table.add_row("7", "a move, 速度 5", "")
    table.add_row("1,000", "x" * 300 + "\n", "")
    last = "x" * 300 + "\\n"
    assert plain_lines(table) == [" scan  what", "    7  a move, 速度 5", f"1,000  {last}"]
    table.show_header = False
    table.add_row("8", "速", "end")
    assert plain_lines(table)[-1] == f"    8  速{' ' * (len(last) - 2)}  end"
    assert plain_lines("a sentence") == ["a sentence"]
