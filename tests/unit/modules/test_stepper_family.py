"""A second stepper of the family, the imaginary 3602 of `tests/support/amci3602.py`, is one file."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from pathlib import Path
from shutil import copy as copy_file
from typing import Any, cast

import amci3602
import pytest
from scanrack import CpuFault, open_bench, open_trace
from scanrack.commands import build
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import Configuration, Move, MoveKind, decode
from scanrack.io_images.amci3601.words import Profile
from scanrack.jobs.drive.targets import module_bench
from scanrack.modules import RULES, WORDS_3601, BitPlace, Rule
from scanrack.runtime.modules.amci3601.module import Amci3601
from scanrack.testing.modules import check_module
from scanrack.watch.monitors.hello import slots_of
from typer.testing import CliRunner

PROFILE = cast(Profile, amci3602.RECORD.words({}))

SENTENCE = "an S curve is used above 1,500,000 steps/s [DRV-01, imaginary]"

RACK = """program = "line.py"
run_for_s = 2.2
[modules]
amci3602 = "amci3602.py"
[[slot]]
number = 1
module = "amci3602"
"""

LINE = """from scanrack import Acceleration, Axis3601, AxisError, Configuration, InputBit, Logic, sequence

USED = InputBit.HOME | InputBit.CW_LIMIT


class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500))

    @sequence
    async def path(self) -> None:
        await self.axis.configure()
        await self.axis.move_by(2_000_000, speed=1_900_000, acceleration=4_000, deceleration=4_000)
        try:
            await self.axis.move_by(100, speed=1_900_000, acceleration=4_000, deceleration=4_000,
                                    shape=Acceleration.TRAPEZOIDAL)
        except AxisError:
            await self.axis.reset()
"""

WORDS = """def logic(scan):
    out = scan.slot[1].outputs
    out[0], out[1], out[4], out[5], out[6], out[7] = 2, 1, 1900, 0, 4000, 4000
"""

NEVER = """from scanrack import never


@never
def drive_error(now):
    return now.slot[1].status.DRIVE_ERROR
"""


@pytest.fixture
def rack(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A rack with a 3602 and a line that moves it, in the current folder."""
    monkeypatch.chdir(tmp_path)
    copy_file(str(amci3602.__file__), "amci3602.py")
    Path("line.py").write_text(LINE, encoding="utf-8")
    Path("line.toml").write_text(RACK, encoding="utf-8")
    return Path("line.toml")


def scanrack(*words: object) -> tuple[int, str]:
    done = CliRunner().invoke(build(), list(map(str, words)))
    return done.exit_code, done.output


def test_it_moves_faster_than_a_3601_and_is_refused_with_its_own_sentence(rack: Path) -> None:
    """Ramps of 0.475 s with 451,250 steps each, and 1,097,500 steps at 1.9 million steps/s: 1.527 s."""
    with open_bench(rack) as bench:
        status = bench.slot[1].status
        bench.run_until("slot1.status.MOVING_CW", within="1 s")
        began_s = bench.now_s
        bench.run_until("slot1.status.MOVE_COMPLETE", within="2 s")
        assert bench.now_s - began_s == pytest.approx(1.527, abs=0.01)
        assert status.position == 2_000_000
        bench.run_until("slot1.status.DRIVE_ERROR", within="1 s")
        assert "DRIVE_ERROR" in str(bench.slot[1])
        assert "DRIVE_ERROR" in repr(status)
        bench.run_until(lambda _now: not status.DRIVE_ERROR, within="1 s")
        assert status.position == 2_000_000


def test_it_is_recorded_shown_queried_and_run_again(rack: Path) -> None:
    assert scanrack("run", rack, "--record", "a.mcap", "-q")[0] == 0
    shown = scanrack("show", "a.mcap")[1]
    assert "+DRIVE_ERROR" in shown
    assert SENTENCE in shown
    assert scanrack("query", "a.mcap", "slot1.in.DRIVE_ERROR")[1].splitlines()[1].split()[0] == "787"
    assert scanrack("compare", "a.mcap", "a.mcap")[0] == 0
    assert scanrack("replay", "--into", "session", "a.mcap")[1].endswith("identical byte for byte\n")
    with open_trace("a.mcap") as trace:
        words = trace.head.slots[0].words
    assert isinstance(words, Profile)
    assert (words.limits, words.further) == (PROFILE.limits, PROFILE.further)
    assert (words.further_errors, words.message) == (1 << 27, "Amci3602")


def test_its_error_is_explained(rack: Path) -> None:
    assert scanrack("run", rack, "--record", "a.mcap", "-q")[0] == 0
    told = scanrack("why", "a.mcap", "slot1.status.DRIVE_ERROR", "--at", 787, "--deep")[1]
    assert "DRIVE_ERROR at scan 787: an S curve is" in told  # the rest is cut to the width


@pytest.mark.slow
def test_its_error_is_plotted(rack: Path) -> None:
    assert scanrack("run", rack, "--record", "a.mcap", "-q")[0] == 0
    assert scanrack("plot", "a.mcap", "-o", "a.svg")[0] == 0
    assert "DRIVE_ERROR" in Path("a.svg").read_text(encoding="utf-8")


def test_check_has_its_limits_and_its_rule(rack: Path) -> None:
    assert scanrack("check", rack)[0] == 0
    Path("line.py").write_text(LINE.replace("speed=1_900_000, acc", "speed=2_000_001, acc"), "utf-8")
    assert "speed 2000001 is out of range: must be 1 to 2000000" in scanrack("check", rack)[1]
    Path("line.py").write_text(WORDS, encoding="utf-8")
    assert "An S curve is used above 1,500,000 steps/s [imaginary]" in scanrack("check", rack)[1]


def test_an_axis_refuses_what_is_beyond_its_profile(rack: Path) -> None:
    Path("line.py").write_text(LINE.replace("speed=1_900_000, acc", "speed=2_000_001, acc"), "utf-8")
    refusal = pytest.raises(CpuFault, match="speed 2000001 is out of range: must be 1 to 2000000")
    with open_bench(rack) as bench, refusal:
        bench.run_for("0.5 s")


@pytest.mark.slow
def test_the_search_draws_it_and_knows_its_rule(rack: Path) -> None:
    Path("must_hold.py").write_text(NEVER, encoding="utf-8")
    command = ("fuzz", rack, "--invariants", "must_hold.py", "--runs", 1, "--jobs", 1, "--out", "out")
    status, said = scanrack(*command)
    assert status == 1
    state = json.loads(Path("out/state.json").read_text(encoding="utf-8"))
    assert "DRV-01" in json.dumps(state)
    assert "DRV-01" in said


def test_the_bench_of_drive_and_the_page_know_its_bit() -> None:
    answer = module_bench(amci3602.RECORD)
    configured = [-31682, 0x3F, 1, 0, 0, 0, 0, 0]
    answer(json.dumps({"out": configured, "for_ms": 10}))
    answer(json.dumps({"out": [0] * 8, "for_ms": 10}))
    request = {"out": [2, 1, 1, 0, 1900, 0, 4000, 4000], "for_ms": 10, "until": {"set": ["DRIVE_ERROR"]}}
    told = answer(json.dumps(request))
    assert (told["met"], told["rules"]) == (True, ["DRV-01"])
    assert "DRIVE_ERROR" in told["bits"]


def test_the_page_gives_no_section_of_the_manual_for_its_bit(rack: Path) -> None:
    with open_bench(rack) as bench:
        (slot,) = slots_of(bench.spec)
    sections = {each["name"]: each["section"] for each in slot["bits"]}
    assert (sections["DRIVE_ERROR"], sections["STOPPED"]) == ("", "chapter 6, Status Bits")


def test_commands_take_the_limits_of_a_profile() -> None:
    move = Move(
        MoveKind.RELATIVE, 5, speed=2_000_000, acceleration=4_000, deceleration=1, limits=PROFILE.limits
    )
    image = move.to_image()
    assert decode(image, PROFILE.limits) == move
    with pytest.raises(ValueError, match="must be 1 to 1000000"):
        decode(image)
    with pytest.raises(ValueError, match="must be 1 to 2000000"):
        Configuration(inputs_used=0x3E, starting_speed=2_000_001, limits=PROFILE.limits)


def test_it_keeps_the_contract_of_modules() -> None:
    check_module(amci3602.RECORD, seeds=range(3))


def test_a_copy_of_a_module_has_the_same_profile() -> None:
    module = Amci3601(profile=PROFILE)
    assert copy.deepcopy(module).profile is PROFILE


def test_a_3601_refuses_what_the_3602_allows() -> None:
    """2,000,000 steps/s is no speed of a 3601 [chapter 5, note 5]."""
    for profile, error in ((PROFILE, False), (amci3602.WORDS_3601, True)):
        module = Amci3601(profile=profile)
        module.update(10_000_000, Image([-31682, 0x3F, 1, 0]))
        module.update(20_000_000, Image())
        inputs = module.update(30_000_000, Image([2, 0, 100, 0, 2000, 0, 100, 100]))
        assert profile.view(inputs).COMMAND_ERROR is error


def test_the_page_shows_its_file() -> None:
    page = (Path(__file__).parents[3] / "docs" / "own-module.md").read_text(encoding="utf-8")
    assert f"```python\n{Path(amci3602.__file__).read_text(encoding='utf-8')}```\n" in page


def test_check_takes_a_firmware_of_a_module_from_a_file(rack: Path) -> None:
    text = rack.read_text(encoding="utf-8")
    rack.write_text(text + 'firmware = "4.1"\n', encoding="utf-8")
    status, said = scanrack("check", rack)
    assert (status, "firmware" in said) == (0, False), said


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (
            {"status": {"BRAKE": BitPlace("I", 1, 10)}},
            "status: MIN_REG_NONZERO and BRAKE are both bit 10 of input word 1; "
            "free bits: 6, 11, 13 to 15 of word 1$",
        ),
        (
            {"status": {"HOT": BitPlace("I", 1, 6), "COLD": BitPlace("I", 1, 6)}},
            "status: HOT and COLD are both bit 6 of input word 1; free bits: 11, 13 to 15 of word 1$",
        ),
        (
            {"status": {"BRAKE": BitPlace("I", 0, 0)}},
            "status: MOVING_CW and BRAKE are both bit 0 of input word 0; "
            "free bits: 6, 11, 13 to 15 of word 1$",
        ),
        (
            {"status": {"BRAKE": BitPlace("O", 1, 11)}},
            "status.BRAKE: .*'O'.*: must be in word 0 or 1 of image I",
        ),
        ({"status": {"BRAKE": BitPlace("I", 2, 0)}}, "status.BRAKE: .*word=2.*: must be in word 0 or 1"),
        ({"status": {"STOPPED": BitPlace("I", 1, 11)}}, "status.STOPPED: .*bit=11.*: must be .*bit=3"),
        ({"errors": ("BREAK",)}, "errors: no status bit 'BREAK'"),
        ({"refuses": "BRK-02"}, "further_refusals: no rule 'BRK-02' in rules"),
        ({"sets": 0}, "rule BRK-01: sets must be named status bits; without a name: none"),
        ({"sets": 1 << 16 + 13}, "rule BRK-01: sets must be named status bits; without a name: 29"),
    ],
)
def test_a_profile_with_a_mistake_is_refused(changed: dict[str, Any], said: str) -> None:
    further = changed.get("status", {"BRAKE": BitPlace("I", 1, 11)})
    rule = Rule("BRK-01", "imaginary", "The brake is on.", sets=changed.get("sets", 1 << 16 + 11))
    status = {**WORDS_3601.groups["status"], **further}
    with pytest.raises(ValueError, match=f"Amci3603: {said}"):
        replace(
            WORDS_3601,
            message="Amci3603",
            groups={**WORDS_3601.groups, "status": status},
            errors=changed.get("errors", WORDS_3601.errors),
            rules={**RULES, rule.id: rule},
            further_refusals=((changed.get("refuses", rule.id), lambda words, move: True),),
        )
