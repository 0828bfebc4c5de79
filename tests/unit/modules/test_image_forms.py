"""Relatives of a 3601 with other images: a 3401 [manual 2.0, pages 29, 34], a 3502 [manual 1.0, page 1].

Broken on purpose: status bits that stay in words 0 and 1, positions foreseen at a 3601's places, a sign that
is lost, a command that is carried out although no page tells it: a test turns red.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from scanrack import open_trace
from scanrack.commands import build
from scanrack.io_images import Image, signed_word
from scanrack.io_images.amci3601 import Configuration
from scanrack.modules import ImageForm, ModuleRecord
from scanrack.runtime.machine import MachineSpec
from scanrack.runtime.modules.amci3601.record import RECORD as AMCI3601
from scanrack.testing.modules import check_module, record_in
from typer.testing import CliRunner

FAMILY = Path(__file__).parents[3] / "examples" / "family"
MS = 1_000_000
CONFIGURE = tuple(Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500).to_image())
IDLE = (0,) * 8
MODULE_OK, COMMAND_ERROR, MOVE_COMPLETE = 1 << 14, 1 << 12, 1 << 7
RELATIVE, RESET, MANUAL_CW, PRESET_ENCODER = 2, 1 << 11, 1 << 7, 1 << 10


def record(file: str, name: str = "RECORD") -> ModuleRecord:
    return record_in(FAMILY / f"{file}.py", name)


def made(of: ModuleRecord) -> Any:
    return of.make(firmware="4.1", machine=MachineSpec(), seed=0, options={}, wiring=None)


class Played:
    """A module that is given words, 50 ms each if no time is said."""

    def __init__(self, of: ModuleRecord) -> None:
        self.module, self.now_ns, self.outputs = made(of), 0, Image()
        self.module.plc_run(True)

    def give(self, words: tuple[int, ...], ms: int = 50) -> list[int]:
        self.outputs.load(Image(words))
        for _ in range(ms // 2):
            self.now_ns += 2 * MS
            shown = self.module.update(self.now_ns, self.outputs)
        return list(shown)

    @property
    def refused(self) -> list[str]:
        return [each.text for each in self.module.events if each.kind == "refusal"]


def configured(of: ModuleRecord) -> Played:
    played = Played(of)
    played.give(CONFIGURE)
    played.give(IDLE)
    return played


@pytest.mark.parametrize(
    ("file", "name", "zeros"), [("amci3401", "RECORD", 0), ("amci3401", "CONTROLLOGIX", 2)]
)
def test_a_3401_shows_the_first_four_words_of_a_3601(file: str, name: str, zeros: int) -> None:
    own, model = configured(record(file, name)), configured(AMCI3601)
    for words in [
        (RELATIVE, 0, -12, -345, 5, 0, 100, 100),
        IDLE,
        (RELATIVE, 0, 13, 345, 5, 0, 100, 100),
        IDLE,
    ]:
        for _ in range(20):
            shown, expected = own.give(words, 200), model.give(words, 200)
            assert shown == [0] * zeros + expected[:4]
    assert shown[-2:] == [1, 0]
    assert shown[zeros] & MOVE_COMPLETE


def test_the_status_bits_of_a_3401_go_with_their_words() -> None:
    for name, word in (("RECORD", 0), ("CONTROLLOGIX", 2)):
        of = record("amci3401", name)
        places = of.words({}).groups["status"]
        assert places["MODULE_OK"] == ("I", word, 14)
        assert places["IN_HOME"] == ("I", word + 1, 2)
        shown = Image(configured(of).give(IDLE), size=len(of.words({}).inputs))
        assert of.status(shown, of.words({})).MODULE_OK


RACK = """\
program = "line.py"
scan_ms = 2

[modules]
amci3401 = "{}"

[[slot]]
number = 1
module = "amci3401"
"""

LINE = f"""\
def logic(scan):
    words = {CONFIGURE} if scan.number < 5 else (0,) * 8 if scan.number < 10 else (2, 0, 12, 0, 1, 0, 50, 50)
    for word, value in enumerate(words):
        scan.slot[1].outputs[word] = value
"""


@pytest.mark.parametrize(("name", "zeros"), [("RECORD", 0), ("CONTROLLOGIX", 2)])
def test_foreseen_scans_of_a_3401_are_those_of_single_updates(
    name: str, zeros: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """12,000 steps at 1,000 steps/s: the scan loop copies most positions from a prediction."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.py").write_text(LINE, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK.format(f"{FAMILY}/amci3401.py:{name}"), encoding="utf-8")
    done = CliRunner().invoke(build(), ["run", "rack.toml", "--record", "t.mcap", "-q", "--for", "14s"])
    assert done.exit_code == 0, done.output
    with open_trace("t.mcap") as trace:
        outputs, inputs = zip(*((scan.outputs(1), scan.inputs(1)) for scan in trace.scans()), strict=True)
    module = made(record("amci3401", name))
    sent = Image()
    for number, (given, shown) in enumerate(zip(outputs, inputs, strict=True)):
        if number == 1:
            module.plc_run(True)
        assert list(module.update(2 * MS * number, sent)) == list(shown), number
        sent = given
    assert list(inputs[-1])[zeros + 2 :] == [12, 0]


def test_a_trace_of_a_3401_has_its_words_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.py").write_text(LINE, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK.format(f"{FAMILY}/amci3401.py"), encoding="utf-8")
    run = CliRunner()
    assert run.invoke(build(), ["run", "rack.toml", "--record", "t.mcap", "-q", "--for", "1s"]).exit_code == 0
    for words, says in (
        (["show", "t.mcap"], "+MOVING_CW"),
        (["query", "t.mcap", "slot1.in.position_msw >= 0 and slot1.status.MOVING_CW"], "lasted"),
        (["check", "rack.toml"], "finding"),
    ):
        done = run.invoke(build(), words)
        assert says in done.output, done.output


@pytest.mark.parametrize(
    ("value", "msw", "lsw"),
    [(-12_345, 0x800C, 345), (12_000, 12, 0), (-12_000, 0x800C, 0), (345, 0, 345), (-345, 0x8000, 345)],
)
def test_a_3502_takes_and_shows_numbers_by_sign_and_magnitude(value: int, msw: int, lsw: int) -> None:
    """The table of page 1."""
    played = configured(record("amci3502"))
    words = (RELATIVE, 0, signed_word(msw), lsw, 5, 0, 500, 500)
    shown = played.give(words, 6_000)
    assert shown[2:4] == [signed_word(msw), lsw], value
    assert played.module.machine.shaft == value
    assert shown[0] & MOVE_COMPLETE


@pytest.mark.parametrize(("msw", "lsw"), [(-1, -345), (0, 1_000), (1, -1)])
def test_a_3502_refuses_a_pair_that_is_none(msw: int, lsw: int) -> None:
    played = configured(record("amci3502"))
    shown = played.give((RELATIVE, 0, msw, lsw, 5, 0, 500, 500))
    assert shown[0] & COMMAND_ERROR
    assert shown[2:4] == [0, 0]


@pytest.mark.parametrize("file", ["amci3401", "amci3502"])
@pytest.mark.parametrize(
    ("words", "name"),
    [
        ((MANUAL_CW, 0), "MANUAL_CW"),
        ((PRESET_ENCODER, 0), "PRESET_ENCODER"),
        ((0, 1 << 7), "ENC_FOLLOWER"),
        ((0, 1 << 8), "BLEND_PROGRAM"),
        ((RELATIVE, 1), "S_CURVE"),
    ],
)
def test_what_the_pages_do_not_tell_is_refused_by_name(file: str, words: tuple[int, int], name: str) -> None:
    played = configured(record(file))
    shown = played.give((*words, 1, 0, 5, 0, 100, 100))
    assert shown[0] & COMMAND_ERROR
    assert shown[2:4] == [0, 0], "nothing moves"
    message = f"the manual of a {file.title()} does not describe {name}"
    assert any(message in each for each in played.refused), played.refused
    played.give(IDLE)
    shown = played.give((RESET, *IDLE[1:]))
    assert not shown[0] & COMMAND_ERROR


@pytest.mark.parametrize(
    ("file", "name"), [("amci3401", "RECORD"), ("amci3401", "CONTROLLOGIX"), ("amci3502", "RECORD")]
)
def test_they_keep_the_contract_of_a_module(file: str, name: str) -> None:
    check_module(record(file, name), seeds=range(8))


@pytest.mark.parametrize(
    ("inputs", "says"),
    [
        (("status_lsw", "position_msw"), "status_msw is missing"),
        (("status_msw", "status_lsw", "zero", "zero"), "a name occurs twice"),
    ],
)
def test_a_form_without_status_or_with_a_name_twice_is_refused(inputs: tuple[str, ...], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        ImageForm(inputs)
