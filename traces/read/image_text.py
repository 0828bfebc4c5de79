"""Describes changed images as text, with bits that rose and fell, command names and decoded values."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from enum import IntFlag

from scanrack.io_images.amci3601.bits import CommandLsw, CommandMsw, ConfigMsw, InputBit, StatusMsw
from scanrack.io_images.amci3601.words import WORDS_3601, Profile, is_stepper
from scanrack.io_images.module_words import ModuleWords, Quantity
from scanrack.io_images.number_formats import NumberFormat
from scanrack.io_images.thousands import is_legal_pair, join_reported, join_thousands

from ..format.layout import SlotInfo

Words = Sequence[int]
"""The signed words of an image."""

ValueReader = Callable[[Quantity, Words], int]
"""Reads a quantity in the signed words of its image."""

_MODE_CONFIG = StatusMsw.MODE_CONFIG.value
_OTHER_USE = (CommandLsw.BLEND_PROGRAM | CommandLsw.ENC_FOLLOWER).value


def output_wording(before: Words, after: Words) -> str:
    """Return a changed output image of a 3601 as text: its command, and changed parameters.

    A new command is followed by all its parameters that are not 0.

    >>> output_wording((0,) * 8, (2, 0, 12, 345, 5, 0, 20, 10))
    'RELATIVE_MOVE, target 12,345, speed 5,000, acceleration 20, deceleration 10'
    >>> output_wording((2, 0, 12, 345, 5, 0, 20, 10), (0, 0, 12, 345, 6, 0, 20, 10))
    'no command, speed 6,000'
    """
    if after[0] & _MODE_CONFIG:
        return _configuration(after)
    names = bit_names(CommandMsw, after[0]) + bit_names(CommandLsw, after[1])
    phrases = [" ".join(names) or "no command"]
    if after[1] & _OTHER_USE:
        phrases.append("words 2 to 7: " + " ".join(map(str, after[2:])))
        return ", ".join(phrases)
    if before[0] & _MODE_CONFIG:
        before = (0,) * len(after)  # a configuration can't be compared with parameters
    is_new_command = bool(after[0] & ~before[0])
    for name, words in _PARAMETERS.items():
        values = [after[word] for word in words]
        is_changed = values != [before[word] for word in words]
        if is_changed or (is_new_command and any(values)):
            phrases.append(f"{name} {_value(values)}")
    return ", ".join(phrases)


_PARAMETERS: Mapping[str, tuple[int, ...]] = {
    "target": (2, 3),
    "speed": (4, 5),
    "acceleration": (6,),
    "deceleration": (7,),
}


def input_wording(before: Words, after: Words, profile: Profile = WORDS_3601) -> str:
    """Return a changed input image of a 3601 as text: bits that rose and fell, and a captured value.

    The position and counts are omitted, because they have their own columns.

    >>> input_wording((0x4008, 0, 0, 0, 0, 0, 0, 0), (0x4021, 0, 0, 3, 0, 0, 0, 0))
    '+MOVING_CW +ACCELERATING -STOPPED'
    """
    changed_names = risen_and_fallen(
        profile.status_names(before[0], before[1]), profile.status_names(after[0], after[1])
    )
    other_changes = _other_inputs(before, after, has_bits=bool(changed_names))
    text = " ".join(filter(None, (changed_names, other_changes)))
    if text or list(before[:2]) == list(after[:2]):
        return text
    return f"reserved bits: status words {after[0] & 0xFFFF:04X}h {after[1] & 0xFFFF:04X}h"


def _other_inputs(before: Words, after: Words, *, has_bits: bool) -> str:
    """Return the changes in the remaining words as text, depending on the mode.

    Args:
        has_bits: whether named bits changed; if so, a changed echo of the configuration is not mentioned.
    """
    was_configuring, is_configuring = in_configuration_mode(before), in_configuration_mode(after)
    if is_configuring and not was_configuring:
        return f"firmware {after[6]}.{after[7]}"
    if is_configuring:
        return "" if has_bits or list(before[:6]) == list(after[:6]) else "another configuration echoed"
    is_captured = not was_configuring and tuple(before[6:]) != tuple(after[6:])
    return f"captured {join_reported(after[6], after[7]):,}" if is_captured else ""


def in_thousands(quantity: Quantity, words: Words) -> int:
    """Return a quantity from the words of its image; if its format is not fixed, read it as thousands."""
    first_word, *units = words[quantity.word : quantity.word + quantity.words]
    if not units:
        return first_word
    number_format = quantity.format or NumberFormat.THOUSANDS
    return number_format.reported(first_word, units[0])


def moded_wording(
    module: ModuleWords, direction: str, before: Words, after: Words, value: ValueReader = in_thousands
) -> str:
    """Return a changed image of a module with a configuration mode as text, with the module's names.

    For outputs, this lists the bits that are on, and the quantities that changed or belong to a new command.
    For inputs, it lists bits that rose and fell, and changed quantities that do not have their own columns.

    >>> from scanrack.io_images.drives.models import SMD23E2
    >>> moded_wording(SMD23E2.words, "out", (0,) * 10, (2, -0x8000, 12, 345, 5, 0, 20, 10, 0, 0))
    'RELATIVE_MOVE ENABLE_DRIVER, target 12,345, programmed_speed 5,000, acceleration 20, deceleration 10'
    >>> moded_wording(SMD23E2.words, "in", (0x4008, *9 * (0,)), (0x4021, *9 * (0,)))
    '+MOVING_CW +ACCELERATING -STOPPED'
    """
    if module.configures(direction, after):
        shown_words = [f"{word & 0xFFFF:04X}h" for word in after[:2]] + [str(word) for word in after[2:]]
        return f"configuration {' '.join(shown_words)}"
    if module.configures(direction, before):
        before = (0,) * len(after)  # a configuration can't be compared with commands
    names_before, names_after = (_bits_on(module, direction, words) for words in (before, after))
    if direction == "out":
        bits_text = " ".join(names_after) or "no command"
        is_new_command = bool(set(names_after) - set(names_before))
    else:
        bits_text = risen_and_fallen(names_before, names_after)
        is_new_command = False
    phrases = [bits_text]
    quantities = list(module.quantities_in(direction))
    for quantity in quantities:
        span = slice(quantity.word, quantity.word + quantity.words)
        is_changed = list(after[span]) != list(before[span])
        if not quantity.counts and (is_changed or (is_new_command and any(after[span]))):
            phrases.append(f"{quantity.name} {value(quantity, after):,}")
    described = module.covered(direction) | {quantity.word for quantity in quantities}
    phrases.append(_plain_words(module, direction, described, before, after))
    return ", ".join(filter(None, phrases))


def _bits_on(module: ModuleWords, direction: str, words: Words) -> list[str]:
    """Return the names of the bits that are on, in words with named bits; see `_names_on`."""
    word_names = module.named(direction)
    names: list[str] = []
    for word, bits in _named_bits(module, direction).items():
        names += _names_on(word_names[word], bits, words[word])
    return names


def _named_bits(module: ModuleWords, direction: str) -> dict[int, dict[str, int]]:
    """Return the named bits of each word that has any, by word number."""
    image = "O" if direction == "out" else "I"
    bits_of_words = {word: dict(module.bits(image, word)) for word in range(len(module.named(direction)))}
    return {word: bits for word, bits in bits_of_words.items() if bits}


def _plain_words(
    module: ModuleWords, direction: str, described: Collection[int], before: Words, after: Words
) -> str:
    """Return the changes in all words except the `described` ones as text."""
    names = module.named(direction)
    plain = [word for word in range(len(names)) if word not in described]
    return plain_wording(
        [names[word] for word in plain], [before[word] for word in plain], [after[word] for word in plain]
    )


def in_configuration_mode(inputs: Words) -> bool:
    """Return whether a 3601's input image is in configuration mode, which is an echo without positions."""
    return bool(inputs[0] & _MODE_CONFIG)


def plain_wording(names: Sequence[str], before: Words, after: Words) -> str:
    """Return the changed words of a module of any other kind as text.

    >>> plain_wording(["a", "b"], (1, 2), (1, -3))
    'b 2 -> -3'
    """
    return ", ".join(
        f"{name} {old_word} -> {new_word}"
        for name, old_word, new_word in zip(names, before, after, strict=True)
        if old_word != new_word
    )


def risen_and_fallen(before: Sequence[str], after: Sequence[str]) -> str:
    """Return the difference between two lists of names as text.

    >>> risen_and_fallen(["A", "B"], ["B", "C"])
    '+C -A'
    """
    risen = [f"+{name}" for name in after if name not in before]
    fallen = [f"-{name}" for name in before if name not in after]
    return " ".join(risen + fallen)


def bit_names(bits: type[IntFlag], word: int) -> list[str]:
    """Return the names of the bits that are set in a word; an unnamed bit is listed as, e.g., `bit6`.

    >>> bit_names(CommandLsw, 0x0041)
    ['S_CURVE', 'bit6']
    """
    return [_bit_name(bits, bit) for bit in range(16) if word >> bit & 1]


def module_text(
    slot: SlotInfo, direction: str, before: Words, after: Words, value: ValueReader = in_thousands
) -> str:
    """Return the changes in a slot's image as text.

    Args:
        direction: "out" or "in".
        value: reads a quantity in the words of the image after the change.
    """
    if is_stepper(slot.words):
        if direction == "out":
            return output_wording(before, after)
        return input_wording(before, after, slot.words)
    if slot.words.modes is not None:
        return moded_wording(slot.words, direction, before, after, value)
    names, named_bits = slot.words.named(direction), _named_bits(slot.words, direction)
    texts: list[str] = []
    for word, bits in named_bits.items():
        if before[word] != after[word]:
            names_before = _names_on(names[word], bits, before[word])
            texts.append(risen_and_fallen(names_before, _names_on(names[word], bits, after[word])))
    texts.append(_plain_words(slot.words, direction, named_bits.keys(), before, after))
    return ", ".join(filter(None, texts))


def _names_on(word: str, bits: Mapping[str, int], value: int) -> list[str]:
    """Return the names of the bits that are on; an unnamed bit is listed as, e.g., `data.5`.

    Args:
        word: name of the word.
        bits: numbers of the word's named bits.
    """
    by_number = {number: name for name, number in bits.items()}
    return [by_number.get(number, f"{word}.{number}") for number in range(16) if value >> number & 1]


def _configuration(words: Words) -> str:
    """Describe an output image in configuration mode [chapter 3]."""
    active_names = " ".join(bit_names(InputBit, words[1])) or "none"
    phrases = [
        " ".join(bit_names(ConfigMsw, words[0])),
        f"active high {active_names}",
        f"starting speed {_value(words[2:4])}",
    ]
    if any(words[4:]):
        phrases.append("words 4 to 7: " + " ".join(map(str, words[4:])))
    return ", ".join(phrases)


def _value(words: Words) -> str:
    """Return a parameter of one or two words as text; an illegal pair is shown as two words."""
    if len(words) == 1:
        return f"{words[0]:,}"
    return f"{join_thousands(*words):,}" if is_legal_pair(*words) else f"({words[0]}, {words[1]})"


def _bit_name(bits: type[IntFlag], bit: int) -> str:
    return str(bits(1 << bit).name) if 1 << bit in bits.__members__.values() else f"bit{bit}"
