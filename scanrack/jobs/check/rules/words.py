"""Rules about the output words of 3601s, in any language: images that the module refuses."""

from __future__ import annotations

from collections.abc import Iterator

from scanrack.io_images.amci3601 import CommandMsw, Configuration, Firmware

from ..facts import FileLine, Violation
from ..module_kinds import MODE_CONFIG
from ..module_refusals import RANGES, WAYS_ON, Breach, broken, wrong_configuration
from ..subject import Subject
from ..words import SentImage


def refused_images(subject: Subject) -> Iterator[Violation]:
    """Find images that the module refuses with every configuration of the program, except for ranges."""
    yield from (Violation(place, text) for rule, place, text in _refusals(subject) if rule not in RANGES)


def images_out_of_range(subject: Subject) -> Iterator[Violation]:
    """Find images with numbers out of range, and invalid configurations."""
    for image in subject.images:
        if image.command & MODE_CONFIG:
            for words, name in image.variants():
                profile = subject.profile(image.slot)
                for rule in wrong_configuration(words, Firmware.parse(subject.firmware(image.slot)), profile):
                    row, suffix = profile.rules[rule], f" with {name}" if name else ""
                    text = f"slot {image.slot}: the configuration{suffix} is invalid: {row.text.rstrip('.')}"
                    yield Violation(image.place, f"{text} [{row.section}]")
    yield from (Violation(place, text) for rule, place, text in _refusals(subject) if rule in RANGES)


def _refusals(subject: Subject) -> Iterator[tuple[str, FileLine, str]]:
    """Yield the rule, place and text of each refusal, once per place and rule."""
    seen: set[tuple[str, FileLine]] = set()
    several: dict[tuple[int, int], tuple[FileLine, str]] = {}  # the last line of each pair of bits
    for image, words, name, refusal in _breaches(subject):
        place = (image.cells[refusal.word].place if refusal.word else None) or image.place
        text = _text(image, words, name, refusal)
        if refusal.rule == TWO_BITS:
            key = image.slot, image.command
            if key not in several or several[key][0] < place:
                several[key] = place, text
        elif (refusal.rule, place) not in seen:
            seen.add((refusal.rule, place))
            yield refusal.rule, place, text
    yield from ((TWO_BITS, place, text) for place, text in several.values())


TWO_BITS = "CMD-02"


def _breaches(subject: Subject) -> Iterator[tuple[SentImage, tuple[int | None, ...], str, Breach]]:
    """Yield the rules that commands break, each with image, words, the source of the words, and rule."""
    for image in subject.images:
        for words, name in image.variants() if not image.command & MODE_CONFIG else ():
            for refusal in _broken(subject, image, words):
                yield image, words, name, refusal


def _broken(subject: Subject, image: SentImage, words: tuple[int | None, ...]) -> list[Breach]:
    """Return the rules that words break with every configuration that the program sends."""
    firmware = Firmware.parse(subject.firmware(image.slot))
    configurations: list[Configuration | None] = [*subject.configurations(image.slot)] or [None]
    first, *others = [
        broken(words, configuration, firmware, subject.profile(image.slot))
        for configuration in configurations
    ]
    return [refusal for refusal in first if all(refusal in other for other in others)]


def _text(image: SentImage, words: tuple[int | None, ...], name: str, found: Breach) -> str:
    bits = " and ".join(str(bit.name) for bit in CommandMsw if bit.value & image.command)
    with_words = f" with {name}" if name else ""
    pair = {3: (2, 3), 5: (4, 5)}.get(found.word, (found.word,))
    hint = _hint(words, pair) or WAYS_ON.get(found.rule, "")
    numbers = _numbers(words, pair)
    return f"slot {image.slot}, {bits}{with_words}{numbers}. {found}" + (f": {hint}" if hint else "")


def _numbers(words: tuple[int | None, ...], at: tuple[int, ...]) -> str:
    """Return the words at given places for a message; "" for command words."""
    values = " and ".join("?" if words[index] is None else str(words[index]) for index in at)
    if len(at) > 1:
        return f": words {at[0]} and {at[1]} are {values}"
    return f": word {at[0]} is {values}" if at[0] > 1 else ""


def _hint(words: tuple[int | None, ...], pairs: tuple[int, ...]) -> str:
    """Return what to do about words with opposite signs."""
    values = [words[index] or 0 for index in pairs]
    is_mixed = len(values) > 1 and values[0] * values[1] < 0
    return "split the absolute value, and give both words its sign" if is_mixed else ""
