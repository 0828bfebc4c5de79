"""The golden library is what the module does now, and what the manual says of it.

Each scenario states the rules that fire, the bits and the position at its end; these come from the
manual (chapter 6's lists, chapter 2's arithmetic), not from a run. Recordings and texts are then
held to be what a run gives, byte for byte with the same versions of the libraries.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from golden import app
from golden_library import Library, Made, changes, index_of, left_over, load_library, make
from scanrack.commands import build
from scanrack.io_images.amci3601 import RULES
from typer.testing import CliRunner, Result

GOLDEN = Path(__file__).parents[2] / "tests" / "golden" / "recordings"
LISTED = ("CMD-", "PRF-", "HOM-", "INP-", "POS-", "CER-")
"""Prefixes of the rows of chapter 6's lists of errors."""

NO_RECORDING = {
    "PRF-03",  # no profile overflows here; the table says why
    "POS-01",  # fires in every start
}


@pytest.fixture(scope="module")
def library() -> Library:
    return load_library(GOLDEN)


@pytest.fixture(scope="module")
def all_made(library: Library, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Made]:
    folder = tmp_path_factory.mktemp("made")
    return {scenario.name: make(library, scenario, folder) for scenario in library.scenario}


def names() -> Iterator[str]:
    return (scenario.name for scenario in load_library(GOLDEN).scenario)


@pytest.mark.parametrize("name", list(names()))
def test_a_recording_is_what_the_module_does(name: str, all_made: dict[str, Made]) -> None:
    made = all_made[name]
    assert made.wrong == ()
    assert changes(made, GOLDEN) == []


def test_every_row_of_the_error_lists_has_a_recording(library: Library) -> None:
    shown = {rule for scenario in library.scenario for rule in scenario.rules}
    rows = {rule for rule in RULES if rule.startswith(LISTED)}
    assert rows - shown == NO_RECORDING
    assert shown <= set(RULES)


def test_the_same_bytes_come_out_again(library: Library, all_made: dict[str, Made], tmp_path: Path) -> None:
    for scenario in library.scenario[::20]:
        again = make(library, scenario, tmp_path)
        assert again.trace.read_bytes() == all_made[scenario.name].trace.read_bytes()
        assert again.text == all_made[scenario.name].text


def test_a_recording_can_be_run_again_by_whoever_gets_it(tmp_path: Path) -> None:
    shutil.copy(GOLDEN / "one-shot.mcap", tmp_path)
    result = CliRunner().invoke(build(), ["replay", "--into", "session", str(tmp_path / "one-shot.mcap")])
    assert result.exit_code == 0, result.output


def test_the_index_tells_them_all_and_nothing_is_left_over(library: Library) -> None:
    assert (GOLDEN / "index.md").read_text("utf-8") == index_of(library)
    assert left_over(library, GOLDEN) == []


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A library of one scenario, not made yet."""
    text = (GOLDEN / "scenarios.toml").read_text("utf-8")
    start = text[text.index("[start]") : text.index("[[scenario]]")]
    (tmp_path / "scenarios.toml").write_text(
        start + '[[scenario]]\nname = "hold"\ngroup = "One"\nsays = "Nothing to hold."\n'
        'steps = "HOLD_MOVE"\nrun_ms = 60\nrules = ["CMD-07"]\nbits = ["COMMAND_ERROR"]\nposition = 0\n',
        "utf-8",
    )
    return tmp_path


def golden(*arguments: object) -> tuple[int, str]:
    result = invoke(*arguments)
    return result.exit_code, result.output


def invoke(*arguments: object) -> Result:
    """Call `tests/tools/golden.py`."""
    return CliRunner().invoke(app, list(map(str, arguments)))


def test_what_has_changed_is_shown_and_written_on_demand(small: Path) -> None:
    assert golden(small) == (1, "hold: it is new\nindex.md: it differs\n1 recordings, not all as they were\n")
    assert golden(small, "--update")[0] == 0
    assert golden(small) == (0, "1 recordings, as they were\n")
    resume = "RESUME_MOVE speed 5000 acceleration 100 deceleration 100"  # faultless but for CMD-08
    change(small, 'steps = "HOLD_MOVE"', f'steps = "{resume}"')
    change(small, "CMD-07", "CMD-08")
    status, says = golden(small)
    assert status == 1
    assert "hold: library and now differ, first in scan 4 at 16 ms" in says
    assert "slot1.out.RESUME_MOVE" in says
    assert "hold: -   4   0.016     1  out                     HOLD_MOVE\n" in says
    assert golden(small, "--update")[0] == 0
    assert golden(small)[0] == 0


def test_what_is_not_as_the_scenario_says_is_never_written(small: Path) -> None:
    change(small, "CMD-07", "CMD-08")
    status, says = golden(small, "--update")
    assert status == 1
    assert "hold: rules CMD-07 fired, not CMD-08" in says
    assert not (small / "hold.mcap").exists()


def test_recordings_that_no_scenario_makes_are_told_and_removed(small: Path) -> None:
    golden(small, "--update")
    shutil.copy(small / "hold.mcap", small / "old.mcap")
    assert "old.mcap: no scenario makes it" in golden(small)[1]
    golden(small, "--update")
    assert not (small / "old.mcap").exists()


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[start]", "[start", "scenarios.toml: this is not TOML"),
        ("run_ms = 60", "run = 60", "scenarios.toml: scenario.0.run_ms: Field required"),
        ('steps = "HOLD_MOVE"', 'steps = "HOLD"', "HOLD is not a command bit"),
        ("run_ms = 60", 'run_ms = 60\nstart = "not"', "hold: start 'not' is none of the starts"),
    ],
)
def test_scenarios_that_cannot_be_used_are_told(small: Path, old: str, new: str, says: str) -> None:
    change(small, old, new)
    result = invoke(small)
    assert result.exit_code == 2
    assert says in result.stderr


def test_a_folder_without_scenarios_is_told(tmp_path: Path) -> None:
    result = invoke(tmp_path)
    assert (result.exit_code, "scenarios.toml: the scenarios can't be read" in result.stderr) == (2, True)


def change(folder: Path, old: str, new: str) -> None:
    path = folder / "scenarios.toml"
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")
