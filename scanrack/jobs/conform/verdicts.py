"""Verdicts on scenes, rules and readings.

| on | verdict | reason |
|---|---|---|
| a rule | as the manual | it fires in all hypotheses left, and a read contradicts a module without it |
| | differs | a module without it, or a rival of its reading, explains a scene that the model does not |
| | open | it fired, or a read shows its bit, but nothing decides |
| | not in this plan | no played scene involves it |
| a reading | as read | for every rival, a scene that the model explains contradicts it |
| | otherwise | a rival explains a scene that the model does not |
| | open | a rival acts in some scene, but nothing decides |
| | not in this plan | no rival acts in any scene |
"""

from __future__ import annotations

from collections.abc import Sequence
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

_UNDECISIVE = {
    ConformVerdict.AS_MANUAL: "also explained without it",
    ConformVerdict.DIFFERS: "not explained",
    ConformVerdict.OPEN: "open",
}
"""By verdict, the description of a scene that decides nothing about a rule."""


class Judge:
    """Judges scenes one by one.

    Args:
        firmware: firmware of the module.
        timing: the times of the path.
        most: number of simultaneous hypotheses above which a scene stays open.

    Attributes:
        result: the verdicts so far.
    """

    def __init__(self, firmware: str, timing: Timing, most: int = MOST) -> None:
        self._firmware, self._timing, self._most = firmware, timing, most
        self._contradicted: dict[str, set[int]] = {number: set() for number in RIVALS}  # rivals by index
        self.result = ConformResult(rules=_unplayed_rules(firmware), readings=_unplayed_readings())

    def judge(self, played: PlayedScene) -> SceneVerdict:
        """Judge a scene, and note its evidence about rules and readings."""
        result = self._search(played, None)
        verdict = SceneVerdict(played.name, ConformVerdict.OPEN, result.reads, result.most, played.note)
        self.result.scenes.append(verdict)
        if result.many:
            verdict.why = _too_many(result, played, self._timing)
        elif result.overlapping:
            verdict.why = f"{_sent(result.last_sent)} can't have acted after the words before: wrong times"
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
        """Note the rules that fired and that no scene has settled yet."""
        for rule in result.fired_anywhere:
            finding = self.result.rules.get(rule)
            if finding is not None and finding.verdict is ConformVerdict.NOT_IN_PLAN:
                finding.verdict, finding.scene = ConformVerdict.OPEN, verdict.name
                finding.why = f"it may have fired in {verdict.name}, which is {_UNDECISIVE[verdict.verdict]}"

    def _search(
        self, played: PlayedScene, alteration: Alteration | None, instants: Sequence[int] | None = None
    ) -> Search:
        """Search for the instants of a scene, with the model or an altered model."""

        def model() -> Amci3601:
            return Amci3601(self._firmware) if alteration is None else Altered3601(alteration, self._firmware)

        return search(played.moments, model, self._timing, self._most, instants)

    # -- scenes that are explained ------------------------------------------------------------

    def _confirm(self, played: PlayedScene, result: Search) -> None:
        """Note the rules and readings that an explained scene settles."""
        scene = _SceneEvidence(played, result, _shown_in(played))
        for rule, finding in self.result.rules.items():
            if finding.verdict in UNDECIDED:
                self._confirm_rule(rule, finding, scene)
        for number, rivals in RIVALS.items():
            finding = self.result.readings[number]
            if finding.verdict in UNDECIDED:
                self._confirm_reading(number, rivals, finding, scene)

    def _confirm_rule(self, rule: str, finding: RuleFinding, scene: _SceneEvidence) -> None:
        """Note whether an explained scene contradicts a module without a rule, or leaves the rule open."""
        alteration = without(rule, scene.fired)
        if alteration is None:
            if rule in scene.fired:
                finding.verdict, finding.why = ConformVerdict.OPEN, "it fired, but sets no bit"
        elif self._contradicts(scene, alteration):
            finding.verdict, finding.scene = ConformVerdict.AS_MANUAL, scene.played.name
            finding.why = f"contradicted: {alteration.sentence}"
        elif rule in scene.fired:
            finding.verdict = ConformVerdict.OPEN
            finding.why = "it fired, but a module without it shows the same"

    def _confirm_reading(
        self, number: str, rivals: Sequence[Alteration], finding: RuleFinding, scene: _SceneEvidence
    ) -> None:
        """Note which rivals of a reading a scene contradicts.

        The reading is confirmed if all are contradicted.
        """
        contradicted = self._contradicted[number]
        for index, rival in enumerate(rivals):
            if index not in contradicted and self._contradicts(scene, rival):
                contradicted.add(index)
                finding.scene = scene.played.name
            if finding.verdict is ConformVerdict.NOT_IN_PLAN and scene.may_show(rival):
                finding.verdict = ConformVerdict.OPEN
                finding.why = "a module of the other interpretation shows the same"
        if len(contradicted) == len(rivals):
            finding.verdict = ConformVerdict.AS_MANUAL
            finding.why = "contradicted: " + " ".join(rival.sentence for rival in rivals)
        elif contradicted:
            finding.why = f"{len(contradicted)} of its {len(rivals)} rivals are contradicted"

    def _contradicts(self, scene: _SceneEvidence, alteration: Alteration) -> bool:
        """Whether an altered model can't explain a scene with any instants; the model's are tried first."""
        if not scene.may_show(alteration):
            return False
        if self._search(scene.played, alteration, scene.instants).explains_all:
            return False
        return self._search(scene.played, alteration).unexplained is not None

    # -- scenes that differ -------------------------------------------------------------------

    def _explain(self, played: PlayedScene, verdict: SceneVerdict, result: Search) -> None:
        """Note the rival readings that explain a scene.

        If there are none, note the rules, or else the scales.
        """
        evidence = _SceneEvidence(played, result, _differing(result))
        for number, rivals in RIVALS.items():
            for rival in rivals:
                if self._explains(played, rival, evidence, result):
                    verdict.readings.append(number)
                    self._note_rival(number, rival, played, result)
        if verdict.readings:
            return
        fired = result.fired_anywhere
        for rule in [*sorted(fired), *(rule for rule in STATEMENTS if rule not in fired)]:
            without_rule = without(rule, fired) if rule in self.result.rules else None
            if without_rule is not None and self._explains(played, without_rule, evidence, result):
                verdict.rules.append(rule)
                self._differs(self.result.rules[rule], played.name, without_rule.sentence)
        if not verdict.rules and _moves(result):
            verdict.scales += fitted(lambda alteration: self._search(played, alteration))

    def _note_rival(self, number: str, alteration: Alteration, played: PlayedScene, result: Search) -> None:
        """Note, for a reading and its rules that fired, that an altered module explains a scene."""
        self._differs(self.result.readings[number], played.name, alteration.sentence)
        for name in result.fired_anywhere & self.result.rules.keys():
            if number in RULES[name].reading:
                self._differs(self.result.rules[name], played.name, f"{number}: {alteration.sentence}")

    def conclude(self) -> ConformResult:
        """Return the result of all scenes, without the factors that other scenes rule out. Call it last."""
        scenes = [scene for scene in self.result.scenes if scene.scales]
        remaining = without_lesser([scene.scales for scene in scenes])
        for scene, scales in zip(scenes, remaining, strict=True):
            scene.scales = scales
            for scale in scales:
                self._differs(self.result.rules[scale.rule], scene.name, either(scales))
        return self.result

    def _explains(
        self, played: PlayedScene, alteration: Alteration, evidence: _SceneEvidence, result: Search
    ) -> bool:
        """Whether an alteration explains a scene; skip the search if it has no effect at the difference."""
        if not evidence.may_show(alteration):
            return False
        trial = self._search(played, alteration, result.instants)
        if trial.unexplained is result.unexplained and trial.shown == result.shown:
            return False
        return self._search(played, alteration).explains_all

    @staticmethod
    def _differs(finding: RuleFinding, scene: str, why: str) -> None:
        finding.verdict, finding.scene, finding.why = ConformVerdict.DIFFERS, scene, why


class _SceneEvidence:
    """The evidence of a scene, for a quick test of whether an alteration may have a visible effect.

    Args:
        bits: status bits that an alteration must hide to have a visible effect.
    """

    def __init__(self, played: PlayedScene, result: Search, bits: int) -> None:
        self.played, self.fired, self.instants = played, result.fired, result.instants
        self._sent = {  # all output words of the scene
            moment.words
            for moment in played.moments
            if isinstance(moment, Transmission) and moment.words is not None
        }
        self._bits, self._fired_anywhere = bits, result.fired_anywhere

    def may_show(self, alteration: Alteration) -> bool:
        """Whether an alteration may have a visible effect in the scene."""
        if alteration.hidden:
            return bool(alteration.hidden & self._bits)
        rules = alteration.silent | alteration.overlooked | alteration.adds.keys()
        if rules:
            return not self._fired_anywhere.isdisjoint(rules)
        if alteration.hears is not None:
            return any(alteration.hears(words) != words for words in self._sent)
        return True


def _moves(result: Search) -> bool:
    """Whether the module or the model moves around the first read that differs."""
    assert result.unexplained is not None
    return any(words[0] & MOVING for words in (result.unexplained.words, *result.shown))


def _too_many(result: Search, played: PlayedScene, timing: Timing) -> str:
    """Return why a scene has too many hypotheses: the time, the words sent, and a remedy."""
    sent = result.last_sent
    assert sent is not None
    at_ns = sent.window.low_ns - played.moments[0].window.low_ns
    width_ns = sent.window.high_ns - sent.window.low_ns + timing.lag_ns
    remedy = "use a counter of scans, see --print-counter" if timing.scan_ns else "wait longer at rest before"
    return (
        f"too many hypotheses: {result.many:,} after {at_ns / 1e9:.3f} s, with {_sent(sent)}, "
        f"which may act within {width_ns / 1e6:.1f} ms; it is change {result.moving} since the axis "
        f"was at rest; {remedy}"
    )


def _sent(sent: Transmission | None) -> str:
    """Return the words of a transmission for a message."""
    if sent is None or sent.words is None:
        return "the inputs"
    return f"the words {words_text(sent.words)}"


def _shown_in(played: PlayedScene) -> int:
    """Return the status bits that any read of a scene shows."""
    reads = (moment for moment in played.moments if isinstance(moment, SeenImage))
    return reduce(or_, (_status(read.words) for read in reads), 0)


def _differing(result: Search) -> int:
    """Return the status bits that differ in the first differing read."""
    assert result.unexplained is not None
    read = _status(result.unexplained.words)
    return reduce(or_, (_status(words) ^ read for words in result.shown), 0)


def _status(words: ImageWords) -> int:
    """Return the status bits of an image, with word 1 in the upper 16 bits."""
    return words[0] & 0xFFFF | (words[1] & 0xFFFF) << 16


def _difference(result: Search) -> Difference:
    """Return the first read that differs, its time after the last words, and the model's images."""
    read, sent = result.unexplained, result.last_sent
    assert read is not None
    assert sent is not None
    shown = (result.shown[0], result.shown[-1]) if result.shown else (read.words, read.words)
    return Difference(read.window.low_ns - sent.window.low_ns, sent.words or (), read.words, shown)


def _unplayed_rules(firmware: str) -> dict[str, RuleFinding]:
    """Return the findings on the rules for a firmware before any scene is played."""
    findings = {}
    version = Firmware.parse(firmware)
    for rule in RULES.values():
        if rule.applies_to(version):
            why = "no scene shows it" if rule.id in STATEMENTS else "it did not fire in any scene"
            if rule.untestable_because:
                why = f"in no image: {rule.untestable_because}"
            findings[rule.id] = RuleFinding(ConformVerdict.NOT_IN_PLAN, why=why)
    return findings


def _unplayed_readings() -> dict[str, RuleFinding]:
    """Return the findings on all readings, in numerical order, before any scene is played."""
    readings = RIVALS.keys() | {number for rule in RULES.values() for number in rule.reading}
    findings = {}
    for number in sorted(readings, key=lambda number: (int(number[2:].rstrip("ab")), number)):
        why = "no scene settles it" if number in RIVALS else "no rival is known"
        findings[number] = RuleFinding(ConformVerdict.NOT_IN_PLAN, why=why)
    return findings
