"""Rules about output words that a 3601 refuses, in any language."""

from __future__ import annotations

from collections.abc import Iterator

from scanrack.io_images.amci3601 import CommandMsw, Configuration, Firmware

from ..facts import FileLine, Violation
from ..module_kinds import MODE_CONFIG
from ..module_refusals import RANGES, REMEDIES, Breach, broken, wrong_configuration
from ..subject import Subject
from ..words import SentImage


def refused_images(subject: Subject) -> Iterator[Violation]:
    """Find images that the module refuses with every configuration of the program, apart from ranges."""
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
    reported: set[tuple[str, FileLine]] = set()
    two_bits: dict[tuple[int, int], tuple[FileLine, str]] = {}  # the last line of each pair of bits
    for image in subject.images:
        for words, name in image.variants() if not image.command & MODE_CONFIG else ():
            for breach in _broken(subject, image, words):
                place = (image.cells[breach.word].place if breach.word else None) or image.place
                text = _text(image, words, name, breach)
                if breach.rule == TWO_BITS:
                    pair = image.slot, image.command
                    if pair not in two_bits or two_bits[pair][0] < place:
                        two_bits[pair] = place, text
                elif (breach.rule, place) not in reported:
                    reported.add((breach.rule, place))
                    yield breach.rule, place, text
    yield from ((TWO_BITS, place, text) for place, text in two_bits.values())


TWO_BITS = "CMD-02"


def _broken(subject: Subject, image: SentImage, words: tuple[int | None, ...]) -> list[Breach]:
    """Return the rules that words break with every configuration that the program sends."""
    firmware = Firmware.parse(subject.firmware(image.slot))
    configurations: list[Configuration | None] = [*subject.configurations(image.slot)] or [None]
    first, *others = [
        broken(words, configuration, firmware, subject.profile(image.slot))
        for configuration in configurations
    ]
    return [breach for breach in first if all(breach in breaches for breaches in others)]


def _text(image: SentImage, words: tuple[int | None, ...], name: str, breach: Breach) -> str:
    """Return the message about a breach.

    Args:
        name: the source of the words, such as an element of a table; "" if they have a single value.
    """
    bits = " and ".join(str(bit.name) for bit in CommandMsw if bit.value & image.command)
    source = f" with {name}" if name else ""
    numbers = {3: (2, 3), 5: (4, 5)}.get(breach.word, (breach.word,))  # the words of the same number
    remedy = _sign_remedy(words, numbers) or REMEDIES.get(breach.rule, "")
    text = f"slot {image.slot}, {bits}{source}{_values(words, numbers)}. {breach}"
    return f"{text}: {remedy}" if remedy else text


def _values(words: tuple[int | None, ...], numbers: tuple[int, ...]) -> str:
    """Return the numbers and values of words as the end of a message; "" for command words."""
    values = " and ".join("?" if words[number] is None else str(words[number]) for number in numbers)
    if len(numbers) > 1:
        return f": words {numbers[0]} and {numbers[1]} are {values}"
    return f": word {numbers[0]} is {values}" if numbers[0] > 1 else ""


def _sign_remedy(words: tuple[int | None, ...], numbers: tuple[int, ...]) -> str:
    """Return the remedy for two words with opposite signs; "" for other words."""
    values = [words[number] or 0 for number in numbers]
    is_mixed = len(values) > 1 and values[0] * values[1] < 0
    return "split the absolute value, and apply its sign to both words" if is_mixed else ""
