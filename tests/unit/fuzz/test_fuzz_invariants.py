"""Invariants: when they count as broken, what is told, and which files are refused."""

from types import SimpleNamespace
from typing import Any

import pytest
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import StatusView
from scanrack.jobs.fuzz import InvariantError, always, eventually, load_invariants, never
from scanrack.jobs.fuzz.invariants.scan_view import Slots

MS = 1_000_000


def watched(invariant, *moments):
    """What a fresh watch says of moments (ms, value) one after the other."""
    watch = invariant.start()
    return [watch(moment(ms, value)) for ms, value in moments]


def moment(ms, value=None, *, resting=False) -> Any:
    return SimpleNamespace(ns=ms * MS, seconds=ms / 1e3, scan=ms, value=value, resting=resting)


def value(now):
    """The value is there."""
    return now.value


def going(now):
    return now.value == "go"


def done(now):
    return now.value == "done"


def test_always_and_never_ask_in_every_scan():
    assert watched(always(value), (0, 1), (2, 0)) == [None, "the condition is false"]
    assert watched(never(value), (0, 1), (2, 0)) == ["the condition is true", None]


def test_the_docstring_is_the_sentence_and_the_name_stands_in_without_one():
    assert (always(value).name, always(value).sentence) == ("value", "The value is there.")

    def no_words(now):
        return True

    assert never(no_words).sentence == "no words"


def test_within_starts_its_clock_once_and_stops_it_when_it_has_come_true():
    stops = eventually("10 ms", after=going)(done)
    assert watched(stops, (0, "go"), (10, "go"), (12, "done"), (30, "")) == [None] * 4
    late = watched(stops, (0, "go"), (5, "go"), (10, ""), (12, ""))
    assert late[:3] == [None] * 3
    assert late[3] == "still false 12 ms after 0 s"


def test_every_run_has_a_clock_of_its_own():
    stops = eventually("10 ms", after=value)(lambda now: False)
    first, second = stops.start(), stops.start()
    assert first(moment(0, True)) is None
    assert second(moment(50, True)) is None


def test_what_a_condition_raises_is_told_with_its_place():
    without_value: Any = SimpleNamespace(ns=2 * MS, seconds=0.002)
    with pytest.raises(InvariantError, match=r"invariant value raised at 0.002 s: AttributeError.*\.py:"):
        always(value).start()(without_value)


def test_a_name_that_is_nearly_right_is_told():
    misspelt: Any = always(lambda now: now.status.MOVE_COMPLET)  # type: ignore[attr-defined]
    status = StatusView(Image())
    with pytest.raises(InvariantError, match=r"did you mean MOVE_COMPLETE\?"):
        misspelt.start()(SimpleNamespace(ns=0, seconds=0, status=status))


def test_a_slot_that_is_not_there_is_told():
    slots: dict[int, Any] = {1: None, 4: None}
    with pytest.raises(LookupError, match="no slot 2; the rack has 1, 4"):
        Slots(slots)[2]


def test_a_limit_needs_a_unit():
    with pytest.raises(ValueError, match="'5' is not a time"):
        eventually("5", after=value)


def test_a_file_gives_its_invariants_in_order(tmp_path):
    file = tmp_path / "must_hold.py"
    file.write_text(
        "from scanrack.jobs.fuzz import always, never\n"
        "@never\ndef second(now):\n    'b'\n\n@always\ndef first(now):\n    'a'\n",
        encoding="utf-8",
    )
    assert [each.name for each in load_invariants(file)] == ["second", "first"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (None, "no such file"),
        ("x = 1\n", "defines no invariant"),
        ("x = 1\nboom\n", r"bad.py:2: NameError"),
        ("def f(:\n", r"SyntaxError"),
        (
            "from scanrack.jobs.fuzz import never\n\n@never\ndef f():\n    pass\n",
            r"bad.py:3: f must accept one argument, the snapshot: too many positional arguments",
        ),
    ],
)
def test_files_that_are_refused(tmp_path, text, says):
    file = tmp_path / "bad.py"
    if text is not None:
        file.write_text(text, encoding="utf-8")
    with pytest.raises(InvariantError, match=says):
        load_invariants(file)
