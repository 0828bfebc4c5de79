"""Verdicts on scenes, rules and readings.

| on | verdict | reason |
|---|---|---|
| a rule | as the manual | it fires in all remaining hypotheses, and a module without it is contradicted |
| | differs | a module without it, or a rival of its reading, explains a scene that the model does not |
| | open | it fired, or a read shows its bit, but nothing decides |
| | not in this plan | nothing that was played involves it |
| a reading | as read | every rival is contradicted by a scene that the model explains |
| | otherwise | a rival explains a scene that the model does not |
| | open | a rival acts in some scene, but nothing decides |
| | not in this plan | no rival acts in any scene |
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from operator import or_

from scanrack.io_images.amci3601 import RULES, Firmware, StatusMsw
from scanrack.runtime.modules.amci3601.altered import Alteration, Altered3601
from scanrack.runtime.modules.amci3601.module import Amci3601

from .findings import UNDECIDED, ConformResult, ConformVerdict, Difference, RuleFinding, SceneVerdict
from .hypotheses import MOST, Search, search
from .moments import ImageWords, PlayedScene, SeenImage, Timing, Transmission, words_text
from .rules_apart.rivals import RIVALS
from .rules_apart.scales import either, fitted, without_lesser
from .rules_apart.without import STATEMENTS, without

MOVING = (StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW).value

_SCENES = {
    ConformVerdict.AS_MANUAL: "explained without it as well",
    ConformVerdict.DIFFERS: "not explained",
    ConformVerdict.OPEN: "open",
}
"""How a scene that decides nothing about a rule is described, by the scene's verdict."""


class Judge:
    """Judges scenes one after the other.

    Args:
        firmware: firmware of the module.
        timing: the times of the path.
        most: number of hypotheses at a time above which a scene stays open.
    """

    def __init__(self, firmware: str, timing: Timing, most: int = MOST) -> None:
        self._firmware, self._timing, self._most = firmware, timing, most
        version = Firmware.parse(firmware)
        self.result = ConformResult()
        for rule in RULES.values():
            if rule.applies_to(version):
                why = rule.untestable_because and f"in no image: {rule.untestable_because}"
                self.result.rules[rule.id] = RuleFinding(
                    ConformVerdict.NOT_IN_PLAN, why=why or self._unseen(rule.id)
                )
        self._contradicted: dict[str, set[int]] = {number: set() for number in RIVALS}
        for number in _readings():
            why = "no scene settles it" if number in RIVALS else "no rival of it is known"
            self.result.readings[number] = RuleFinding(ConformVerdict.NOT_IN_PLAN, why=why)

    @staticmethod
    def _unseen(rule: str) -> str:
        return "no scene shows it" if rule in STATEMENTS else "it did not fire in any scene"

    def judge(self, played: PlayedScene) -> SceneVerdict:
        """Judge a scene, and note what it says about rules and readings."""
        result = self._search(played, None)
        verdict = SceneVerdict(played.name, ConformVerdict.OPEN, result.reads, result.most, played.note)
        self.result.scenes.append(verdict)
        if result.many:
            verdict.why = _too_many(result, played, self._timing)
        elif result.overlapping:
            verdict.why = f"{_sent(result.after)} can't have acted after what was sent before: wrong times"
        elif result.unexplained is not None:
            verdict.verdict, verdict.difference = ConformVerdict.DIFFERS, _difference(result)
            self._explain(played, verdict, result)
        elif not result.reads:
            verdict.why = played.note or "no read after its configuration"
        else:
            if not played.note:
                verdict.verdict = ConformVerdict.AS_MANUAL
            self._confirm(played, result)
        self._note_fired(verdict, result)
        return verdict

    def _note_fired(self, verdict: SceneVerdict, result: Search) -> None:
        """Note the rules that fired and that no scene has decided yet."""
        for rule in result.fired_anywhere:
            finding = self.result.rules.get(rule)
            if finding is not None and finding.verdict is ConformVerdict.NOT_IN_PLAN:
                finding.verdict, finding.scene = ConformVerdict.OPEN, verdict.name
                finding.why = f"it may have fired in {verdict.name}, which is {_SCENES[verdict.verdict]}"

    def _search(
        self, played: PlayedScene, alteration: Alteration | None, instants: Sequence[int] | None = None
    ) -> Search:
        return search(played.moments, self._factory(alteration), self._timing, self._most, instants)

    def _factory(self, alteration: Alteration | None) -> Callable[[], Amci3601]:
        if alteration is None:
            return lambda: Amci3601(self._firmware)
        return lambda: Altered3601(alteration, self._firmware)

    # -- scenes that are explained ------------------------------------------------------------

    def _confirm(self, played: PlayedScene, result: Search) -> None:
        scene = _Trail(played, result, _shown_in(played))
        for rule, finding in self.result.rules.items():
            if finding.verdict in UNDECIDED:
                self._confirm_rule(rule, finding, scene)
        for number, rivals in RIVALS.items():
            finding = self.result.readings[number]
            if finding.verdict in UNDECIDED:
                self._confirm_reading(number, rivals, finding, scene)

    def _confirm_rule(self, rule: str, finding: RuleFinding, scene: _Trail) -> None:
        alteration = without(rule, scene.fired)
        if alteration is None:
            if rule in scene.fired:
                finding.verdict, finding.why = ConformVerdict.OPEN, "it fired, and sets no bit"
        elif self._contradicts(scene, alteration):
            finding.verdict, finding.scene = ConformVerdict.AS_MANUAL, scene.played.name
            finding.why = f"contradicted: {alteration.sentence}"
        elif rule in scene.fired:
            finding.verdict = ConformVerdict.OPEN
            finding.why = "it fired, and a module without it shows the same"

    def _confirm_reading(
        self, number: str, rivals: Sequence[Alteration], finding: RuleFinding, scene: _Trail
    ) -> None:
        places = self._contradicted[number]
        for place, rival in enumerate(rivals):
            if place not in places and self._contradicts(scene, rival):
                places.add(place)
                finding.scene = scene.played.name
            if finding.verdict is ConformVerdict.NOT_IN_PLAN and scene.touches(rival):
                finding.verdict = ConformVerdict.OPEN
                finding.why = "a module of the other interpretation shows the same"
        if len(places) == len(rivals):
            finding.verdict = ConformVerdict.AS_MANUAL
            finding.why = "contradicted: " + " ".join(rival.sentence for rival in rivals)
        elif places:
            finding.why = f"{len(places)} of its {len(rivals)} rivals are contradicted"

    def _contradicts(self, scene: _Trail, alteration: Alteration) -> bool:
        """Whether no instants explain a scene with an alteration; those of the model are tried first."""
        if not scene.touches(alteration):
            return False
        if self._search(scene.played, alteration, scene.instants).explains_all:
            return False
        return self._search(scene.played, alteration).unexplained is not None

    # -- scenes that differ -------------------------------------------------------------------

    def _explain(self, played: PlayedScene, verdict: SceneVerdict, result: Search) -> None:
        suspect = _Trail(played, result, _differing(result))
        for number, alteration in _all_rivals():
            if self._may_explain(played, alteration, suspect, result):
                verdict.readings.append(number)
                self._differs_by(number, alteration, played, result)
        if verdict.readings:
            return
        fired = result.fired_anywhere
        for name in [*sorted(fired), *(statement for statement in STATEMENTS if statement not in fired)]:
            without_it = without(name, fired) if name in self.result.rules else None
            if without_it is not None and self._may_explain(played, without_it, suspect, result):
                verdict.rules.append(name)
                self._differs(self.result.rules[name], played.name, without_it.sentence)
        if not verdict.rules and _moves(result):
            verdict.scales += fitted(lambda alteration: self._search(played, alteration))

    def _differs_by(self, number: str, alteration: Alteration, played: PlayedScene, result: Search) -> None:
        """Note, for a reading and its rules that fired, that an altered module explains a scene."""
        self._differs(self.result.readings[number], played.name, alteration.sentence)
        for name in result.fired_anywhere & self.result.rules.keys():
            if number in RULES[name].reading:
                self._differs(self.result.rules[name], played.name, f"{number}: {alteration.sentence}")

    def conclude(self) -> ConformResult:
        """Return the result once all scenes are judged; only together do they show which factors remain."""
        scenes = [scene_result for scene_result in self.result.scenes if scene_result.scales]
        for scene, scales_left in zip(
            scenes, without_lesser([scene_result.scales for scene_result in scenes]), strict=True
        ):
            scene.scales = scales_left
            for scale in scales_left:
                self._differs(self.result.rules[scale.rule], scene.name, either(scales_left))
        return self.result

    def _may_explain(
        self, played: PlayedScene, alteration: Alteration, suspect: _Trail, result: Search
    ) -> bool:
        """Whether an alteration explains a scene; one without effect before the difference is not run."""
        if not suspect.touches(alteration):
            return False
        once = self._search(played, alteration, result.instants)
        if once.unexplained is result.unexplained and once.shown == result.shown:
            return False
        return self._search(played, alteration).explains_all

    @staticmethod
    def _differs(finding: RuleFinding, scene: str, why: str) -> None:
        finding.verdict, finding.scene, finding.why = ConformVerdict.DIFFERS, scene, why


class _Trail:
    """A quick test of whether an alteration may show in a scene, before the scene is run with it.

    Args:
        bits: status bits that may be affected.
    """

    def __init__(self, played: PlayedScene, result: Search, bits: int) -> None:
        self.played, self.fired, self.instants = played, result.fired, result.instants
        self._sent = {
            moment.words
            for moment in played.moments
            if isinstance(moment, Transmission) and moment.words is not None
        }
        self._bits, self._fired_anywhere = bits, result.fired_anywhere

    def touches(self, alteration: Alteration) -> bool:
        """Whether an alteration may show in the scene."""
        if alteration.hidden:
            return bool(alteration.hidden & self._bits)
        rules = alteration.silent | alteration.overlooked | alteration.adds.keys()
        if rules:
            return not self._fired_anywhere.isdisjoint(rules)
        if alteration.hears is not None:
            return any(alteration.hears(words) != words for words in self._sent)
        return True


def _moves(result: Search) -> bool:
    """Return whether module or model moves around the first read that differs."""
    assert result.unexplained is not None
    return any(words[0] & MOVING for words in (result.unexplained.words, *result.shown))


def _too_many(result: Search, played: PlayedScene, timing: Timing) -> str:
    """Return why a scene has too many hypotheses: the time, what was sent, and how to have fewer."""
    transmission = result.after
    assert transmission is not None
    at_ns = transmission.window.low_ns - played.moments[0].window.low_ns
    width_ns = transmission.window.high_ns - transmission.window.low_ns + timing.lag_ns
    fewer = "a counter of scans, see --print-counter," if timing.scan_ns else "a longer wait at rest before"
    return (
        f"too many hypotheses: {result.many:,} after {at_ns / 1e9:.3f} s, with {_sent(transmission)}, "
        f"which may act within {width_ns / 1e6:.1f} ms; it is number {result.moving} since the axis "
        f"was at rest; {fewer} leaves fewer"
    )


def _sent(sent: Transmission | None) -> str:
    if sent is None or sent.words is None:
        return "the inputs"
    return f"the words {words_text(sent.words)}"


def _shown_in(played: PlayedScene) -> int:
    """Return the status bits that any read of a scene shows."""
    return reduce(
        or_, (_status(moment.words) for moment in played.moments if isinstance(moment, SeenImage)), 0
    )


def _differing(result: Search) -> int:
    """Return the status bits in which the first differing read differs."""
    assert result.unexplained is not None
    read = _status(result.unexplained.words)
    return reduce(or_, (_status(words) ^ read for words in result.shown), 0)


def _status(words: ImageWords) -> int:
    return words[0] & 0xFFFF | (words[1] & 0xFFFF) << 16


def _difference(result: Search) -> Difference:
    seen, transmission = result.unexplained, result.after
    assert seen is not None
    assert transmission is not None
    shown = (result.shown[0], result.shown[-1]) if result.shown else (seen.words, seen.words)
    return Difference(
        seen.window.low_ns - transmission.window.low_ns, transmission.words or (), seen.words, shown
    )


def _all_rivals() -> Iterator[tuple[str, Alteration]]:
    for number, rivals in RIVALS.items():
        for rival in rivals:
            yield number, rival


def _readings() -> list[str]:
    """Return the readings that rules name or that have rivals, by number."""
    named = {number for rule in RULES.values() for number in rule.reading} | set(RIVALS)
    return sorted(named, key=lambda number: (int(number[2:].rstrip("ab")), number))
