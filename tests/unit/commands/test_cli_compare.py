"""`scanrack compare`: what it prints of two hand-made traces, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import made_traces
import numpy as np
import pytest
from scanrack.commands import build
from scanrack.traces import SlotInfo
from typer.testing import CliRunner, Result

SCANS = 40
RULE = {
    "slot": 1,
    "kind": "rule",
    "name": "CMD-03",
    "bits": ["COMMAND_ERROR"],
    "section": "chapter 6, Command Error 3",
    "text": "A move was started before the previous one was complete.",
}


def scanrack(*arguments: object) -> Result:
    return CliRunner().invoke(build(), [str(argument) for argument in arguments])


def story(complete: int) -> np.ndarray:
    """A position that counts from scan 10 on, MOVE_COMPLETE from a scan on."""
    words = made_traces.idle(SCANS)
    words[10:, 11] = np.arange(SCANS - 10)
    words[complete:, 8] |= 0x0080
    return words


@pytest.fixture
def pair(tmp_path: Path) -> tuple[Path, Path]:
    """Two traces of one name: MOVE_COMPLETE in scan 30, and in scan 33 with a rule."""
    for folder in ("old", "new"):
        (tmp_path / folder).mkdir()
    a = made_traces.record(tmp_path / "old" / "x.mcap", story(30), metadata={"name": "press"})
    b = made_traces.record(tmp_path / "new" / "x.mcap", story(33), events={30: ("/events", RULE)})
    return a, b


def test_the_first_scan_that_differs_is_told_with_what_led_to_it(
    pair: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    result = scanrack("compare", "old/x.mcap", "new/x.mcap")
    assert result.exit_code == 1
    assert result.output == (
        "old/x.mcap and new/x.mcap differ, first in scan 30 at 60 ms; 3 of 40 scans differ\n"
        "\n"
        "                                      old/x.mcap  new/x.mcap\n"
        "slot 1 in  status_msw                      4080h       4000h  word 0\n"
        "                       MOVE_COMPLETE           1           0\n"
        "\n"
        "Rules that fired in it\n"
        "in new/x.mcap only: COMMAND_ERROR at scan 30: a move was started before the previous one was "
        "complete [CMD-03, chapter 6]\n"
        "\n"
        "Before it, in both\n"
        "scan  time s  slot      position  encoder  what\n"
        + "".join(
            f"  {scan}   0.0{2 * scan}     1  in        {scan - 10}        0\n" for scan in range(25, 30)
        )
        + "\n"
        "old/x.mcap, up to it\n"
        "scan  time s  slot      position  encoder  what\n"
        "  30   0.060     1  in        20        0  +MOVE_COMPLETE\n"
        "\n"
        "new/x.mcap, up to it\n"
        "scan  time s  slot      position  encoder  what\n"
        "  30   0.060     1  in        20        0\n"
        "\n"
        "How they differ\n"
        "                        scans  first  last  by up to\n"
        "slot1.in.MOVE_COMPLETE      3     30    32\n"
        "\n"
        "name: press / none\n"
    )


@pytest.mark.parametrize(("time", "status"), [("6ms", 0), ("5ms", 1)])
def test_three_scans_of_2_ms_are_six_milliseconds(pair: tuple[Path, Path], time: str, status: int) -> None:
    result = scanrack("compare", *pair, "--tolerance-time", time)
    assert result.exit_code == status, result.output


@pytest.mark.parametrize("chunks", [(16, 16), (16, 10), (7, 100)])
@pytest.mark.parametrize("at", [0, 15, 16, 40, 99])
def test_it_does_not_matter_how_a_trace_is_cut_into_chunks(
    tmp_path: Path, chunks: tuple[int, int], at: int
) -> None:
    words = made_traces.idle(100)
    words[:, 11] = np.arange(100)
    changed = words.copy()
    changed[at, 8] ^= 0x1000
    a = made_traces.record(tmp_path / "a.mcap", words, chunk_scans=chunks[0])
    b = made_traces.record(tmp_path / "b.mcap", changed, chunk_scans=chunks[1])
    same = made_traces.record(tmp_path / "same.mcap", words, chunk_scans=chunks[1])
    said = scanrack("compare", a, b).output
    assert f"first in scan {at} at" in said
    assert "1 of 100 scans differ" in said
    assert scanrack("compare", a, same).output == "a.mcap and same.mcap show the same: 100 scans\n"


def test_slots_are_compared_by_number_not_by_place(tmp_path: Path) -> None:
    """Slot 2 is the second of the one and the first of the other; by place they would be the same."""
    words = made_traces.idle(30, slots=2)
    words[7:, 8 + 16] |= 0x0080
    slots = [SlotInfo(number, "amci3601", "4.1") for number in (1, 2, 3)]
    a = made_traces.record(tmp_path / "a.mcap", words, slots[:2], chunk_scans=5)
    b = made_traces.record(tmp_path / "b.mcap", words, slots[1:], chunk_scans=5)
    result = scanrack("compare", a, b)
    assert "first in scan 7 at" in result.output
    assert "only in a.mcap: slot 1\nonly in b.mcap: slot 3\n" in result.output


def test_a_trace_is_the_same_as_itself(pair: tuple[Path, Path]) -> None:
    result = scanrack("compare", pair[0], pair[0])
    assert (result.exit_code, result.output) == (0, f"{pair[0]} and {pair[0]} show the same: 40 scans\n")


def test_as_json(pair: tuple[Path, Path]) -> None:
    result = scanrack("compare", *pair, "--json")
    found = json.loads(result.output)
    assert result.exit_code == 1
    assert (found["same"], found["first"]["scan"], found["differing"]) == (False, 30, 3)
    assert found["first"]["details"][0]["bits"] == [["MOVE_COMPLETE", True, False]]
    assert found["extents"] == [
        {"name": "slot1.in.MOVE_COMPLETE", "scans": 3, "first": 30, "last": 32, "most": None}
    ]


def test_traces_that_began_at_other_times_are_aligned_at_an_edge(tmp_path: Path) -> None:
    a = made_traces.record(tmp_path / "a.mcap", story(30))
    b = made_traces.record(tmp_path / "b.mcap", story(30)[5:])
    assert scanrack("compare", a, b).exit_code == 1
    aligned = scanrack("compare", a, b, "--align", "slot1.in.MOVE_COMPLETE", "--tolerance-time", "1ms")
    assert aligned.exit_code == 0, "they need not begin together"
    assert aligned.output == (
        "a.mcap and b.mcap show the same as far as both go within 1 ms and 0 counts: 40 and 35 scans\n"
        "\n"
        "only in a.mcap: 5 scans\n"
    )


def test_what_comes_later_each_time_does_not_add_up_if_they_are_realigned(tmp_path: Path) -> None:
    """A bit rises every 20 scans in the one, every 21 in the other: after 5 of them it is 5 scans late."""
    traces = []
    for name, every in (("a", 20), ("b", 21)):
        words = made_traces.idle(6 * every)
        for rise in range(every, 6 * every, every):
            words[rise : rise + 4, 8] |= 0x0080
        traces.append(made_traces.record(tmp_path / f"{name}.mcap", words))
    assert scanrack("compare", *traces, "--tolerance-time", "9ms").exit_code == 1
    realigned = scanrack("compare", *traces, "--tolerance-time", "2ms", "--realign", "slot1.in.MOVE_COMPLETE")
    assert realigned.exit_code == 0, realigned.output
    late = made_traces.idle(126)
    late[21:, 8] |= 0x0080
    other = made_traces.record(tmp_path / "c.mcap", late)
    result = scanrack(
        "compare", traces[0], other, "--tolerance-time", "2ms", "--realign", "slot1.in.MOVE_COMPLETE"
    )
    assert "differ by more than 2 ms and 0 counts, first in scan 24 at" in result.output


def test_a_bit_that_is_set_from_the_beginning_does_not_rise_there(tmp_path: Path) -> None:
    a = made_traces.record(tmp_path / "a.mcap", story(0))
    b = made_traces.record(tmp_path / "b.mcap", story(1))
    late = scanrack("compare", a, b, "--align", "slot1.in.MOVE_COMPLETE")
    assert (late.exit_code, "never rises in one of the traces" in late.stderr) == (2, True)


def test_what_is_the_same_as_far_as_it_goes_is_not_the_same(tmp_path: Path) -> None:
    a = made_traces.record(tmp_path / "a.mcap", story(30))
    b = made_traces.record(tmp_path / "b.mcap", story(30)[:35])
    result = scanrack("compare", a, b)
    assert result.exit_code == 1
    assert "the same as far as both go" in result.output
    assert "only in a.mcap: 5 scans" in result.output


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--tolerance-time", "4"], "4"),
        (["--align", "slot1.in.MOVE_COMPLET"], "did you mean slot1.in.MOVE_COMPLETE"),
        (["--align", "slot1.in.position"], "slot1.in.position is not a bit"),
        (
            ["--align", "start", "--realign", "slot1.in.STOPPED"],
            "--align and --realign: give only one of them",
        ),
        (["--align", "slot1.in.STOPPED"], "slot1.in.STOPPED never rises"),
    ],
)
def test_a_mistake_is_told_in_one_line(pair: tuple[Path, Path], options: list[str], says: str) -> None:
    result = scanrack("compare", *pair, *options)
    assert result.exit_code == 2
    assert says in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_file_that_is_no_trace_is_told(pair: tuple[Path, Path], tmp_path: Path) -> None:
    (tmp_path / "no.mcap").write_text("no trace", encoding="utf-8")
    result = scanrack("compare", pair[0], tmp_path / "no.mcap")
    assert result.exit_code == 2
    assert "no.mcap: it is not an MCAP file" in result.stderr
