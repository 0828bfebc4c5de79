"""The result: a JSON file to send, and text to read; what was sent and read, and no name of the owner's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ...io_images.amci3601 import RULES, status_names
from ...io_images.doors import json_value
from ...io_images.input_files import read_input_text
from ...io_images.text_limits import TextKind
from .moments import ImageWords, PlayedScene, Timing, from_rows, to_rows, words_text
from .verdicts import UNDECIDED, ConformResult, ConformVerdict, Difference

FORMAT = "scanrack conform 1"


def as_object(
    plan: str, firmware: str, timing: Timing, played: Sequence[PlayedScene], result: ConformResult
) -> dict[str, Any]:
    """Return the result as an object of a JSON file."""
    return {
        "format": FORMAT,
        "plan": plan,
        "firmware": firmware,
        "timing": asdict(timing),
        "scenes": [asdict(each) for each in result.scenes],
        "rules": {rule: asdict(each) for rule, each in result.rules.items()},
        "readings": {number: asdict(each) for number, each in result.readings.items()},
        "moments": [
            {"scene": each.name, "note": each.note, "rows": to_rows(each.moments)} for each in played
        ],
    }


def load_played(path: Path) -> tuple[str, Timing, list[PlayedScene]]:
    """Read the scenes of a result again: firmware, timing, scenes.

    Raises:
        ValueError: it is no result, or damaged.
    """
    try:
        whole = json_value(read_input_text(path, TextKind.RESULT), TextKind.RESULT)
        if not isinstance(whole, dict) or whole.get("format") != FORMAT:
            raise ValueError(f"not a result of conform: its format must be {FORMAT!r}")
        timing = Timing(**{name: _whole(value) for name, value in whole["timing"].items()})
        scenes = [
            PlayedScene(str(each["scene"]), from_rows(each["rows"]), str(each["note"]))
            for each in whole["moments"]
        ]
        return str(whole["firmware"]), timing, scenes
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from error
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{path}: damaged: {type(error).__name__} {error}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _whole(value: Any) -> int:
    if not isinstance(value, int) or not 0 <= value <= 10**12:
        raise ValueError(f"timing has {value!r}: a whole number of ns is allowed")
    return value


def lines(result: ConformResult, reads: int) -> Iterator[str]:
    """Return the result as text."""
    for scene in result.scenes:
        yield f"{scene.name}: {scene.verdict}" + (
            f", {scene.why}" if scene.why else f", {scene.reads:,} reads"
        )
        if scene.difference is not None:
            yield from _difference_lines(scene.difference)
        for number in scene.readings:
            yield f"    explained by another reading: {number}: {result.readings[number].why}"
        if scene.rules:
            yield f"    explained without {', '.join(scene.rules)}"
        for scale in scene.scales:
            yield f"    explained by another scale: {scale.sentence}"
    yield ""
    yield from _counts("rules", {rule: each.verdict for rule, each in result.rules.items()})
    for rule, found in result.rules.items():
        if found.verdict is ConformVerdict.DIFFERS:
            yield f"    {rule} differs [{found.scene}]: {found.why} The manual: {RULES[rule].text}"
    yield from _counts("readings", {number: each.verdict for number, each in result.readings.items()})
    for number, found in result.readings.items():
        if found.verdict not in UNDECIDED:
            yield f"    {number} {found.verdict} [{found.scene}]: {found.why}"
    yield f"{reads:,} images were read"


def _counts(what: str, verdicts: dict[str, ConformVerdict]) -> Iterator[str]:
    counts = {verdict: sum(each is verdict for each in verdicts.values()) for verdict in ConformVerdict}
    yield f"{what}: " + ", ".join(f"{count} {verdict}" for verdict, count in counts.items())


def _difference_lines(found: Difference) -> Iterator[str]:
    yield f"    {found.at_ns / 1e6:.1f} ms after the words {words_text(found.sent)}"
    yield f"    read   {_image(found.read)}"
    yield f"    model  {_image(found.shown[0])}"
    if found.shown[1] != found.shown[0]:
        yield f"    to     {_image(found.shown[1])}"


def _image(words: ImageWords) -> str:
    names = " ".join(status_names(words[0] & 0xFFFF, words[1] & 0xFFFF))
    return f"{words_text(words)}  {names}"
