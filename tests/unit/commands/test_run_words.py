"""Plain words of `scanrack run` mean what typer takes them for."""

from pathlib import Path
from typing import Any

import pytest
import typer
from amounts import amount
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scanrack.commands.programs import run
from scanrack.commands.programs.run_command import FLAGS, VALUES, RunArguments, plain_arguments

taken: list[RunArguments] = []


@pytest.fixture(scope="module")
def by_typer() -> Any:
    """The command, which only notes its arguments."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "run_command", note)
        app = typer.Typer()
        run.register(app)
        yield typer.main.get_command(app)


def note(options: RunArguments) -> None:
    taken.append(options)


WORDS = st.one_of(
    st.sampled_from([*FLAGS, *VALUES, "--spin", "--for=3 s", "--help", "--", "-", "-qq", "line.toml"]),
    st.sampled_from(
        ["10", "0", "007", "+5", "1_0", " 7", "٣", "1e3", "10 s", "", "a b.toml", "\n", "@x", "~/x"]
    ),
    st.text(max_size=4),
)


@settings(max_examples=amount(8))
@given(st.lists(WORDS, max_size=6))
@example(["line.toml"])
@example(["--quiet", "line.toml", "--for", "10 s", "--record", "a.mcap", "--replace", "--json"])
@example(["line.toml", "--scans", "12", "--no-record", "-q"])
@example(["line.toml", "--record", "~/a.mcap", "--for", ""])
def test_plain_words_mean_what_typer_takes_them_for(by_typer: Any, words: list[str]) -> None:
    plain = plain_arguments(words)
    if plain is not None:
        taken.clear()
        by_typer.main(list(words), standalone_mode=False)
        assert taken == [plain]


def test_words_are_read() -> None:
    words = ["--quiet", "line.toml", "--for", "10s", "--record", "a.mcap", "--replace", "--json"]
    assert plain_arguments(words) == RunArguments(
        rack="line.toml", duration="10s", record=Path("a.mcap"), replace=True, as_json=True, quiet=True
    )


@pytest.mark.parametrize(
    "words",
    [
        "",
        "a.toml b.toml",
        "--scans 0 a.toml",
        "--scans -5 a.toml",
        "--for",
        "a.toml --for",
        "a.toml --no-such",
        "-- a.toml",
        "a.toml --help",
        "a.toml -q -q",
        "a.toml --for 1s --for 2s",
        "a.toml --for=1s",
        "a.toml --for -q",
        "a.toml -qh",
    ],
)
def test_other_words_are_typers(words: str) -> None:
    assert plain_arguments(words.split()) is None


def test_each_field_is_described() -> None:
    assert list(run.DECLARED) == list(RunArguments.__dataclass_fields__)
