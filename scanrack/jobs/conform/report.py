"""The result as a JSON file and as text, with words sent and read but without the owner's identity."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from scanrack.io_images.amci3601 import RULES, status_names
from scanrack.io_images.doors import json_value
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind

from .findings import UNDECIDED, ConformResult, ConformVerdict, Difference, SceneVerdict
from .moments import ImageWords, PlayedScene, Timing, from_rows, to_rows, words_text
from .plan import BUILT_IN, ScenePlan, load_plan
from .rules_apart.scales import FittedScale, either

FORMAT = "scanrack conform 1"

MOST_SCENES = 40
"""Number of scenes above which scenes that agree with the manual are only counted."""


@dataclass(frozen=True, slots=True)
class PlayedPlan:
    """A played plan and its module, without the owner's identity.

    Attributes:
        slot: slot of the module.
        controller: product and revision of the controller; "" if unknown.
        date: date by the clock of the recording; "" if unknown.
        plan: name of the plan; "" for a trace.
    """

    firmware: str
    timing: Timing
    scenes: Sequence[PlayedScene]
    slot: int = 1
    controller: str = ""
    date: str = ""
    plan: str = ""

    @property
    def reads(self) -> int:
        """Number of images that were read."""
        return sum(scene.reads for scene in self.scenes)


def as_object(recorded: PlayedPlan, result: ConformResult) -> dict[str, Any]:
    """Return the result as the object of a JSON file."""
    return {
        "format": FORMAT,
        **{name: getattr(recorded, name) for name in ("plan", "firmware", "slot", "controller", "date")},
        "timing": asdict(recorded.timing),
        "scenes": [asdict(scene) for scene in result.scenes],
        "rules": {rule: asdict(finding) for rule, finding in result.rules.items()},
        "readings": {number: asdict(finding) for number, finding in result.readings.items()},
        "moments": [
            {"scene": scene.name, "note": scene.note, "rows": to_rows(scene.moments)}
            for scene in recorded.scenes
        ],
    }


def load_played(path: Path) -> PlayedPlan:
    """Load the played plan from a result file.

    Raises:
        ValueError: the file is not a result, or is damaged.
    """
    try:
        document = json_value(read_input_text(path, TextKind.RESULT), TextKind.RESULT)
        if not isinstance(document, dict) or document.get("format") != FORMAT:
            raise ValueError(f"not a result of conform: its format must be {FORMAT!r}")
        timing = Timing(**{name: _whole_number(value) for name, value in document["timing"].items()})
        scenes = [
            PlayedScene(str(scene["scene"]), from_rows(scene["rows"]), str(scene["note"]))
            for scene in document["moments"]
        ]
        texts = {name: str(document.get(name, "")) for name in ("controller", "date", "plan")}
        slot = _whole_number(document.get("slot", 1))
        return PlayedPlan(str(document["firmware"]), timing, scenes, slot, **texts)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from error
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{path}: damaged: {type(error).__name__} {error}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _whole_number(value: Any) -> int:
    if not isinstance(value, int) or not 0 <= value <= 10**12:
        raise ValueError(f"invalid time or slot {value!r}: must be a whole number from 0 to 10^12")
    return value


def lines(result: ConformResult, reads: int) -> Iterator[str]:
    """Yield the lines of the result as text."""
    scenes = result.scenes
    if len(scenes) > MOST_SCENES:
        scenes = [scene for scene in scenes if scene.verdict is not ConformVerdict.AS_MANUAL]
        yield f"{len(result.scenes) - len(scenes):,} scenes are as the manual"
    for scene in scenes:
        yield from _scene_lines(scene, result)
    yield ""
    yield _counts("rules", (finding.verdict for finding in result.rules.values()))
    for rule, finding in result.rules.items():
        if finding.verdict is ConformVerdict.DIFFERS:
            yield f"    {rule} differs [{finding.scene}]: {finding.why} The manual: {RULES[rule].text}"
    yield _counts("interpretations", (finding.verdict for finding in result.readings.values()))
    for number, finding in result.readings.items():
        if finding.verdict not in UNDECIDED:
            yield f"    {number} {finding.verdict} [{finding.scene}]: {finding.why}"
    yield f"{reads:,} images were read"


def _scene_lines(scene: SceneVerdict, result: ConformResult) -> Iterator[str]:
    """Yield the lines of a scene: its verdict, its difference, and the explanations."""
    yield f"{scene.name}: {scene.verdict}, {scene.why or f'{scene.reads:,} reads'}"
    if scene.difference is not None:
        yield from (f"    {line}" for line in difference_lines(scene.difference))
    for number in scene.readings:
        yield f"    explained by another interpretation: {number}: {result.readings[number].why}"
    if scene.rules:
        yield f"    explained without {', '.join(scene.rules)}"
    if scene.scales:
        yield f"    explained by another scale: {either(scene.scales)}"


def _counts(kind: str, verdicts: Iterable[ConformVerdict]) -> str:
    return f"{kind}: " + ", ".join(f"{count} {verdict}" for verdict, count in counted(verdicts).items())


def counted(verdicts: Iterable[ConformVerdict]) -> dict[ConformVerdict, int]:
    """Return the number of verdicts of each kind."""
    counts = Counter(verdicts)
    return {verdict: counts[verdict] for verdict in ConformVerdict}


def difference_lines(difference: Difference) -> Iterator[str]:
    """Yield the first read that differs, and the images of the model."""
    yield f"{difference.at_ns / 1e6:.1f} ms after the words {words_text(difference.sent)}"
    yield f"read   {_image(difference.read)}"
    yield f"model  {_image(difference.shown[0])}"
    if difference.shown[1] != difference.shown[0]:
        yield f"to     {_image(difference.shown[1])}"


def _image(words: ImageWords) -> str:
    names = " ".join(status_names(words[0] & 0xFFFF, words[1] & 0xFFFF))
    return f"{words_text(words)}  {names}"


def next_steps(recorded: PlayedPlan, result: ConformResult, name: str) -> Iterator[str]:
    """Yield suggestions, one sentence each.

    Args:
        name: name of the result file; "" if none is written.
    """
    for scene in filter(_is_unexplained, result.scenes):
        yield _unexplained(scene, recorded)
    widest = max((scale.high - scale.low for scale in fitted_scales(result)), default=0)
    if widest > WIDE_FACTOR:
        yield "A long move at constant rates, such as the scene 'a longer move' of hour, narrows the factor."
    if any(scene.verdict is ConformVerdict.OPEN for scene in result.scenes) and recorded.timing.scan_ns:
        yield "Scenes are open: a counter of scans in the program settles more scenes, see --print-counter."
    if recorded.plan == "quick":
        yield "Play the plan hour: it settles rules that are not in quick."
    if recorded.plan in BUILT_IN:
        yield from _unplayed(load_plan(recorded.plan), {scene.name for scene in recorded.scenes})
    if result.differs:
        action = f"Send {name}: it" if name else "--out FILE writes a result to send: it"
        yield f"{action} has every word and image, and none of your names."


def _is_unexplained(scene: SceneVerdict) -> bool:
    return scene.verdict is ConformVerdict.DIFFERS and not (scene.readings or scene.rules or scene.scales)


def _unexplained(scene: SceneVerdict, recorded: PlayedPlan) -> str:
    """Return a sentence with advice on a scene that differs without an explanation."""
    retry = f"Play it again with --scene '{scene.name}'. " if recorded.plan else ""
    return (
        f"{scene.name}: no known alternative explains it. {retry}Check whether a program also writes the "
        f"words, whether an input is wired, and whether the firmware is {recorded.firmware}."
    )


WIDE_FACTOR = 0.02
"""Relative uncertainty of a factor above which a longer move is suggested."""

_EQUIPMENT = {
    "inputs": "wire inputs and use --wire",
    "encoder": "connect an encoder that does not turn, and use --encoder",
}
"""Equipment and option for each need of a scene."""


def _unplayed(plan: ScenePlan, played: set[str]) -> Iterator[str]:
    """Yield the equipment for scenes of a plan that were not played."""
    for need, equipment in _EQUIPMENT.items():
        names = [scene.name for scene in plan.scenes if need in scene.needs and scene.name not in played]
        if names:
            yield f"To play {', '.join(names)}: {equipment}."


def fitted_scales(result: ConformResult) -> list[FittedScale]:
    """Return the factors of all scenes. Scenes that agree share one factor with a narrower range."""
    scales: list[FittedScale] = []
    for scale in chain.from_iterable(scene.scales for scene in result.scenes):
        for number, earlier in enumerate(scales):
            common = earlier.within(scale)
            if common is not None:
                scales[number] = common
                break
        else:
            scales.append(scale)
    return scales


def factor_sentences(result: ConformResult) -> list[str]:
    """Return the sentences about factors, each once. Factors that a scene can't distinguish share one."""
    scales = fitted_scales(result)
    sentences = dict[str, None]()
    for scene in result.scenes:
        if scene.scales:
            fitting = [next(common for common in scales if common.within(scale)) for scale in scene.scales]
            sentences[either(fitting)] = None
    return list(sentences)
