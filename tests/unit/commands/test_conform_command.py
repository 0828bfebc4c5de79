"""`scanrack conform`: its options, a controller in the test's hands, and one over a socket."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from scanrack.commands import build
from scanrack.commands.wire import conform
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.image import Image
from scanrack.jobs.conform.paths.counter import counter_rung
from scanrack.jobs.conform.paths.logix_path import LogixPath, ModuleTags
from scanrack.rockwell.l5x.importer import import_l5x
from scanrack.rockwell.slc.importer import import_text
from scanrack.runtime.modules.amci3601.module import Amci3601
from served_tags import served, write_rack
from typer.testing import CliRunner

MS = 1_000_000
MOVE = "RELATIVE_MOVE target 200 speed 2500 acceleration 20 deceleration 20   until MOVE_COMPLETE"
PLAN = f"""
scan_ms = 2
begin = '''
zero                     for 40 ms
words 843Fh 3Fh 0 500    for 40 ms
zero                     for 40 ms
'''
[[scene]]
name = "a move"
steps = '''
{MOVE}
zero                                                                  for 40 ms
'''
[[scene]]
name = "input"
needs = ["inputs"]
steps = '''
inputs ESTOP    for 40 ms
inputs          for 40 ms
'''
[[scene]]
name = "an encoder"
needs = ["encoder"]
steps = "zero for 40 ms"
"""


class Answer(NamedTuple):
    tag: str
    value: Any
    error: str | None = None


class FakeController:
    """A CompactLogix whose requests take a scan of 2 ms; an output is wired to the emergency stop."""

    def __init__(self, product: str = "1769-L33ER scanrack", first: int = 0, profile: bool = False) -> None:
        self.info: Mapping[str, Any] = {"product_name": product, "revision": {"major": 32, "minor": 11}}
        self.module = Amci3601()
        self.scans, self._first, self._profile = 1, first, profile
        self._outputs = Image()
        self._words: Sequence[int] = (0,) * 8
        self.written: list[str] = []

    def _scan(self) -> None:
        self.scans += 1
        self._words = tuple(self.module.update(2 * MS * self.scans, self._outputs))

    def read(self, *tags: str) -> Any:
        self._scan()
        found = [self._tag(each) for each in tags]
        return found if len(found) > 1 else found[0]

    def _tag(self, tag: str) -> Answer:
        if tag == "Scan":
            count = self._first + self.scans
            return Answer(tag, (count + 2**31) % 2**32 - 2**31)
        name, _, member = tag.partition(".Data")
        if name != "Local:1:I" or member.startswith("{") is self._profile:
            return Answer(tag, None, "Tag doesn't exist")
        return Answer(tag, list(self._words) if member == "{8}" else self._words[int(member)])

    def write(self, *values: tuple[str, Any]) -> Any:
        self._scan()
        for tag, value in values:
            self.written.append(tag)
            if tag == "Local:1:O.Data{8}":
                self._outputs.load(Image(value))
            else:
                self.module.operate(InputBit.ESTOP, value)
        return [Answer(tag, value) for tag, value in values]

    def close(self) -> None: ...


@pytest.fixture
def plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "plan.toml"
    path.write_text(PLAN, "utf-8")
    return path


def scanrack(words: str) -> tuple[int, str]:
    done = CliRunner().invoke(build(), words.split())
    return done.exit_code, done.output


@pytest.fixture
def controller(monkeypatch: pytest.MonkeyPatch) -> FakeController:
    made = FakeController()
    monkeypatch.setattr(conform, "connect", lambda _path: made)
    return made


@pytest.mark.slow
def test_scenes_are_played_and_judged(plan: Path, controller: FakeController) -> None:
    status, said = scanrack(
        "conform plan.toml --path plc --counter Scan:2 --slot 1 --max-scan-time 2ms --out r.json"
    )
    assert status == 0, said
    assert "a move: as the manual" in said
    assert "input: left out, needs inputs that are wired to outputs (--wire)" in said
    assert "an encoder: left out, needs an encoder (--encoder)" in said
    result = json.loads(Path("r.json").read_text("utf-8"))
    assert result["rules"]["MOV-08"]["verdict"] == "as the manual"
    assert "Local" not in Path("r.json").read_text("utf-8")


@pytest.mark.slow
def test_wired_inputs_and_an_encoder_are_used_and_the_result_is_judged_again(
    plan: Path, controller: FakeController
) -> None:
    plan.write_text(PLAN.replace(MOVE, "zero for 4 ms"), "utf-8")
    words = "conform plan.toml --path plc --counter Scan:2 --wire ESTOP=Local:2:O.Data.0 --encoder -q"
    status, _ = scanrack(words)
    assert status == 0
    assert controller.written.count("Local:2:O.Data.0") == 2
    result = json.loads(Path("conform.json").read_text("utf-8"))
    assert [each["verdict"] for each in result["scenes"]] == ["as the manual"] * 3
    assert result["rules"]["STS-L03"]["verdict"] == "as the manual"
    status, said = scanrack("conform --judge conform.json --out again.json --json")
    assert status == 0
    again = json.loads(said)
    assert again["rules"] == result["rules"]
    assert "moments" not in again


def test_a_real_controller_needs_live_and_control(plan: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = FakeController("1769-L18ER/B LOGIX5318ER")
    monkeypatch.setattr(conform, "connect", lambda _path: real)
    for words in ("", "--live", "--allow-writes"):
        status, said = scanrack(f"conform plan.toml --path plc --counter Scan:2 {words}")
        assert (status, "disable the drive, then" in said) == (2, True)
    assert real.written == []
    words = "conform plan.toml --path plc --counter Scan:2 --live --allow-writes -q --scene input"
    assert scanrack(words)[0] == 0  # it is left out: nothing is wired


def test_an_image_by_the_manufacturers_profile_and_a_counter_that_begins_anew() -> None:
    path = LogixPath(FakeController(first=2**31 - 5, profile=True), ModuleTags(1, "Scan", 2 * MS))
    seen = [path.read() for _ in range(6)]
    assert [each.window.low_ns for each in seen] == [2 * MS * each for each in range(1, 7)]
    assert len(seen[0].words) == 8


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("conform", "give --path HOST"),
        ("conform --path plc --judge x.json", "give --path HOST"),
        ("conform --path a/b", "--path: invalid path 'a/b'; must be HOST"),
        ("conform --path plc --counter Scan", "--counter: invalid 'Scan'; must be TAG:MS"),
        ("conform --path plc --wire ESTOP", "--wire: invalid 'ESTOP'; must be INPUT=TAG"),
        ("conform missing.toml --path plc", "missing.toml: No such file"),
        ("conform --judge plan.toml", "plan.toml"),
        ("conform plan.toml --path plc --scene nine", "no scene 'nine'"),
    ],
)
def test_what_can_not_be_used_is_refused(plan: Path, words: str, says: str) -> None:
    status, said = scanrack(words)
    assert (status, says in said) == (2, True), said


def test_a_damaged_result_is_refused(plan: Path) -> None:
    for text in ('{"format": "x"}', '{"format": "scanrack conform 1"}', "{", '{"a": ' * 2000):
        Path("r.json").write_text(text, "utf-8")
        assert scanrack("conform --judge r.json")[0] == 2


def test_the_counter_is_a_rung_that_imports(plan: Path) -> None:
    for kind in ("l5x", "slc"):
        status, said = scanrack(f"conform --print-counter {kind}")
        assert status == 0
        assert said.strip() == counter_rung(kind).strip()
    Path("counter.L5X").write_text(counter_rung("l5x"), "utf-8")
    assert import_l5x(Path("counter.L5X")).controller is not None
    assert import_text(counter_rung("slc"), "CONFORM").program is not None


def test_scenes_are_listed_with_what_they_settle() -> None:
    status, said = scanrack("conform hour --list")
    assert status == 0
    assert "relative moves: profiles and Move Complete, both ways; a move of no distance [A-35, A-19]" in said


@pytest.mark.slow
def test_a_page_to_send_has_no_name_of_the_owners(plan: Path, controller: FakeController) -> None:
    plan.write_text(PLAN.replace(MOVE, "zero for 4 ms").replace('name = "a move"', 'name = "<b>"'), "utf-8")
    words = (
        "conform plan.toml --path 10.9.8.7 --counter Scan:2 --wire ESTOP=Local:2:O.Data.0 --html r.html -q"
    )
    status, said = scanrack(words)
    assert status == 0, said
    page = Path("r.html").read_text("utf-8")
    for part in (
        "No difference was seen.",
        "1769-L33ER scanrack 32.11",
        "with a counter of scans",
        " UTC</td>",
    ):
        assert part in page
    assert "To play an encoder: give --encoder" not in page  # the plan is the owner's
    for name in ("10.9.8.7", "Local:", "<b>", "plan.toml", "script", "http"):
        assert name not in page.replace('<p class="good"><b>', ""), name
    status, said = scanrack("conform --judge conform.json --out again.json --html again.html -q")
    assert (status, said) == (0, "")
    assert Path("again.html").read_text("utf-8") == page
    Path("again.json").unlink()
    recorded = Path("conform.json").read_bytes()
    status, said = scanrack("conform --judge conform.json --html again.html -q")
    assert (status, said) == (0, ""), "no result takes the place of what was recorded"
    assert Path("conform.json").read_bytes() == recorded
    assert sorted(each.name for each in Path().glob("*.json")) == ["conform.json"]


def test_words_of_a_configuration_go_with_a_trace(plan: Path, controller: FakeController) -> None:
    status, said = scanrack("conform plan.toml --path plc --counter Scan:2 --configuration 843Ch")
    assert (status, "--configuration needs --judge: a plan has a configuration" in said) == (2, True)
    plan.write_text(PLAN.replace(MOVE, "zero for 4 ms"), "utf-8")
    assert scanrack("conform plan.toml --path plc --counter Scan:2 -q")[0] == 0
    status, said = scanrack("conform --judge conform.json --out again.json --configuration 843Ch")
    assert (status, "--configuration needs a trace: a result has a configuration" in said) == (2, True)


@pytest.mark.slow
def test_a_rack_over_ethernet_ip_conforms(plan: Path) -> None:
    pytest.importorskip("pycomm3", reason="pycomm3 is not installed")
    with served(write_rack(plan.parent)) as (_, port):
        status, said = scanrack(f"conform plan.toml --path 127.0.0.1:{port},0 --counter Scan:2 --out r.json")
    assert status == 0, said
    assert "a move: as the manual" in said
