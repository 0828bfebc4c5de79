"""Plain words of `scanrack run` and `why` mean what typer takes them for."""

from pathlib import Path
from typing import Any

import pytest
import typer
from amounts import amount
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scanrack.commands.programs import run, why
from scanrack.commands.programs.run_command import WORDS, RunArguments
from scanrack.commands.programs.why_arguments import WhyArguments
from scanrack.commands.programs.why_command import WORDS as WHY_WORDS

taken: list[Any] = []


@pytest.fixture(scope="module")
def by_typer() -> Any:
    """The command, which only notes its arguments."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "run_command", note)
        patch.setattr(why, "why_command", note)
        app = typer.Typer()
        run.register(app)
        why.register(app)
        yield typer.main.get_group(app).commands


def note(options: RunArguments | WhyArguments) -> None:
    taken.append(options)


WORD = st.one_of(
    st.sampled_from([*WORDS.flags, *WORDS.values, *WHY_WORDS.flags, *WHY_WORDS.values]),
    st.sampled_from(["--spin", "--for=3 s", "--help", "--", "-", "-qq", "line.toml"]),
    st.sampled_from(
        ["10", "0", "007", "+5", "1_0", " 7", "٣", "1e3", "10 s", "", "a b.toml", "\n", "@x", "~/x"]
    ),
    st.text(max_size=4),
)


@settings(max_examples=amount(8))
@given(st.lists(WORD, max_size=6))
@example(["line.toml"])
@example(["--quiet", "line.toml", "--for", "10 s", "--record", "a.mcap", "--replace", "--json"])
@example(["line.toml", "--scans", "12", "--no-record", "-q"])
@example(["line.toml", "--record", "~/a.mcap", "--for", ""])
def test_plain_words_mean_what_typer_takes_them_for(by_typer: Any, words: list[str]) -> None:
    plain, question = WORDS.read(words), WHY_WORDS.read(words)
    taken.clear()
    if plain is not None:
        by_typer["run"].main(list(words), standalone_mode=False)
        assert taken.pop() == RunArguments(**plain)
    if question is not None:
        by_typer["why"].main(list(words), standalone_mode=False)
        assert taken.pop() == WhyArguments(**question)


def test_words_are_read() -> None:
    words = ["--quiet", "line.toml", "--for", "10s", "--record", "a.mcap", "--replace", "--json"]
    assert WORDS.read(words) == {
        "rack": "line.toml",
        "duration": "10s",
        "record": Path("a.mcap"),
        "replace": True,
        "as_json": True,
        "quiet": True,
    }
    assert WHY_WORDS.read(["a.mcap", "Run", "--at", "3"]) == {"file": "a.mcap", "what": "Run", "at": "3"}


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
    assert WORDS.read(words.split()) is None
