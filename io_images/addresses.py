"""Addresses of words and bits in a rack, in Rockwell's notations or by name.

    Local:1:I.Data[0].14            CompactLogix, slot 1, input word 0, bit 14
    Local:1:I.Data0.14              the same, as add-on profiles name the words
    Local:2:I.Data.3                CompactLogix, bit 3 of a digital card
    Local:3:I.Ch0Data               CompactLogix, channel 0 of an analog card
    Local:3:I.Ch1Overrange          a member of a card's tag, see `cards`
    I:1.0/14, I:1/14                MicroLogix, bit 14 of word 0
    Local:1:I.ModuleOK              a bit of input word 0, as named in the module's V20 profile
    Local:1:O.Data[2], O:1.2        output word 2 as a whole
    slot1.status.MOVE_COMPLETE      a bit of the module's status, by name
    slot1.command.HOLD_MOVE         a bit of the module's command, by name
    slot2.input.start               a bit of a card, as the rack file names it
    slot2.in.start                  the same, as a trace names it

Case does not matter.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache

from .cards import member_of, members_of
from .dataclass import dataclass
from .module_words import BitPlace, Groups, ModuleWords
from .site import SiteError

BITS = 16
_DIRECTIONS = {"in": "I", "out": "O"}
FORMS = "Local:1:I.Data[0].14, I:1.0/14 or slot1.status.MOVE_COMPLETE"
"""Examples of each form of an address, for messages."""


@dataclass(frozen=True, slots=True, order=True)
class Address:
    """A word of an image, or one of its bits.

    >>> str(Address(1, "I", 0, 14)), str(Address(2, "O", 3, None))
    ('Local:1:I.Data[0].14', 'Local:2:O.Data[3]')
    """

    slot: int
    image: str  # "I" for the input image, "O" for the output image
    word: int  # from 0
    bit: int | None  # 0 to 15, or None for the whole word

    def __str__(self) -> str:
        word = f"Local:{self.slot}:{self.image}.Data[{self.word}]"
        return word if self.bit is None else f"{word}.{self.bit}"


_RAW_FORMS = (
    r"Local:(?P<slot>\d+):(?P<image>[IO])\.Data\[(?P<word>\d+)\](?:\.(?P<bit>\d+))?",
    r"Local:(?P<slot>\d+):(?P<image>[IO])\.Data(?P<word>\d+)(?:\.(?P<bit>\d+))?",
    r"(?P<image>[IO]):(?P<slot>\d+)(?:\.(?P<word>\d+))?(?:/(?P<bit>\d+))?",
)
_PROFILE_FORM = r"Local:(?P<slot>\d+):(?P<image>[IO])\.(?P<name>\w+)(?:\.(?P<bit>\d+))?"
_CARD_FORM = r"Local:(?P<slot>\d+):(?P<image>[IO])\.Data(?:\.(?P<bit>\d+))?"
_NAMED_FORM = r"slot(?P<slot>\d+)\.(?P<group>\w+)\.(?P<name>\w+)"


@cache
def _form(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern, re.IGNORECASE)


def parse_address(text: str, slots: Mapping[int, ModuleWords]) -> Address:
    """Parse an address in a rack.

    >>> from scanrack.io_images.amci3601.words import WORDS_3601
    >>> parse_address("I:1.0/14", {1: WORDS_3601})
    Address(slot=1, image='I', word=0, bit=14)
    >>> parse_address("slot1.status.IN_HOME", {1: WORDS_3601})
    Address(slot=1, image='I', word=1, bit=2)

    Args:
        slots: the words of the module in every occupied slot.

    Raises:
        ValueError: the form, slot, word, bit or name is unknown; the message lists the valid ones.
    """
    stripped = text.strip()
    for form in _RAW_FORMS:
        if match := _form(form).fullmatch(stripped):
            return _numbered_word(text, match, slots)
    # before profile names, whose form matches `Data` too
    match = _form(_CARD_FORM).fullmatch(stripped)
    if match:
        data_bits = _data_bits(int(match["slot"]), slots)
        if data_bits:
            return _data_of_card(text, match, data_bits)
    if match := _form(_PROFILE_FORM).fullmatch(stripped):
        return _profile_word_or_bit(text, match, slots)
    if match := _form(_NAMED_FORM).fullmatch(stripped):
        return _named_bit(text, match, slots)
    raise ValueError(f"{text!r} is not an address: write it like {FORMS}")


def _refusal(text: str, reason: str) -> SiteError:
    """Return an error whose text begins with the address; its `reason` is the text without the address."""
    error = SiteError(f"{text!r}: {reason}")
    error.reason = reason
    return error


def _data_bits(slot: int, slots: Mapping[int, ModuleWords]) -> int:
    """Return the bits in a card's `Data`; 0 for an empty slot, or a module with an array of words."""
    return slots[slot].data_bits if slot in slots else 0


def _data_of_card(text: str, match: re.Match[str], bits: int) -> Address:
    """Return the address of `Data` as one word, or of one of its bits; refuse 32-bit data as a word."""
    slot, image = int(match["slot"]), match["image"].upper()
    if match["bit"] is None:
        if bits > BITS:
            raise _refusal(text, f"Data of slot {slot} has {bits} bits: write Data[0] or Data[1]")
        return Address(slot, image, 0, None)
    bit = int(match["bit"])
    if bit >= bits:
        raise _refusal(text, f"bit {bit} does not exist: bits are 0 to {bits - 1}")
    return Address(slot, image, *divmod(bit, BITS))


def _numbered_word(text: str, match: re.Match[str], slots: Mapping[int, ModuleWords]) -> Address:
    """Return the address of a word given by its number, or of one of its bits."""
    slot = int(match["slot"])
    word = int(match["word"] or 0)
    bit = None if match["bit"] is None else int(match["bit"])
    _check_slot(text, slot, slots)
    last_word = len(slots[slot].named(match["image"].upper())) - 1
    if word > last_word:
        raise _refusal(text, f"word {word} does not exist: words are 0 to {last_word}")
    if bit is not None and bit >= BITS:
        raise _refusal(text, f"bit {bit} does not exist: bits are 0 to {BITS - 1}")
    return Address(slot, match["image"].upper(), word, bit)


def _profile_word_or_bit(text: str, match: re.Match[str], slots: Mapping[int, ModuleWords]) -> Address:
    """Return the address of a card's member, a profile's word, or a bit of input word 0, by its name."""
    slot, name = int(match["slot"]), match["name"].upper()
    _check_slot(text, slot, slots)
    if name == "FAULT":
        raise _refusal(text, "the fault of a connection is not a word of an image; a ladder program reads it")
    image, words = match["image"].upper(), slots[slot]
    place = member_of(words.card, image, name) if words.card else None
    if place is not None:
        return _card_member(text, Address(slot, *place), match["bit"], words.data_bits)
    profile_words = {
        own_name: word for own_name, (of_image, word) in words.profile_words.items() if of_image == image
    }
    word_by_name = {own_name.upper(): word for own_name, word in profile_words.items()}
    if name in word_by_name:
        return _word_of_profile(text, Address(slot, image, word_by_name[name], None), match["bit"])
    profile = words.profile if image == "I" and match["bit"] is None else {}
    bit_by_name = {own_name.upper(): bit for own_name, bit in profile.items()}
    if name not in bit_by_name:
        names = allowed(match["name"], (*profile, *members_of(words.card, image), *profile_words, "Data0"))
        image_name = "input" if image == "I" else "output"
        raise _refusal(text, f"slot {slot} has no {image_name} {match['name']!r}; {names}")
    return Address(slot, "I", 0, bit_by_name[name])


def _card_member(text: str, member: Address, bit: str | None, data_bits: int) -> Address:
    """Return the address of a card's member, or its bit; bits 16 to 31 of `ReadBack` are in the next word."""
    if bit is None:
        return member
    if member.bit is not None:
        raise _refusal(text, "nothing can follow a bit")
    bits = max(BITS, data_bits)
    if int(bit) >= bits:
        raise _refusal(text, f"bit {bit} does not exist: bits are 0 to {bits - 1}")
    word, number = divmod(int(bit), BITS)
    return replace(member, word=member.word + word, bit=number)


def _word_of_profile(text: str, word: Address, bit: str | None) -> Address:
    """Return the address of a word, or of its bit if a number follows its name."""
    if bit is None:
        return word
    if int(bit) >= BITS:
        raise _refusal(text, f"bit {bit} does not exist: bits are 0 to {BITS - 1}")
    return replace(word, bit=int(bit))


def _named_bit(text: str, match: re.Match[str], slots: Mapping[int, ModuleWords]) -> Address:
    """Return the address of a bit by group and name, as in `slot1.status.IN_HOME`.

    The groups `in` and `out` contain all bits of an image, unless the module has a group with that name.
    """
    slot = int(match["slot"])
    _check_slot(text, slot, slots)
    groups = slots[slot].groups
    group, name = match["group"].lower(), match["name"].upper()
    if group in _DIRECTIONS and group not in groups:
        groups = {**groups, group: _of_image(groups, _DIRECTIONS[group])}
    if group not in groups:
        raise _refusal(text, f"no {match['group']!r} in slot {slot}; {allowed(group, groups)}")
    places = {own_name.upper(): place for own_name, place in groups[group].items()}
    if name not in places:
        raise _refusal(
            text, f"slot {slot} has no {group} bit {match['name']!r}; {_allowed_bit(name, groups[group])}"
        )
    return Address(slot, *places[name])


def _of_image(groups: Groups, image: str) -> Mapping[str, BitPlace]:
    """Return all named bits of an image by their names in a trace."""
    return {name: place for names in groups.values() for name, place in names.items() if place.image == image}


def _allowed_bit(name: str, names: Iterable[str]) -> str:
    """Return the allowed names as text, beginning with the closest match, ignoring case."""
    names = list(names)
    return allowed(name if any(map(str.isupper, names)) else name.lower(), names)


def _check_slot(text: str, slot: int, slots: Mapping[int, ModuleWords]) -> None:
    if slot not in slots:
        raise _refusal(text, f"slot {slot} is empty; {allowed(slot, slots)}")


def allowed(value: object, choices: Iterable[object]) -> str:
    """Return the allowed values as text, beginning with the one closest to `value`.

    >>> allowed("HOLD_MOVES", ["HOLD_MOVE", "RESUME_MOVE"])
    'did you mean HOLD_MOVE? Choose from HOLD_MOVE, RESUME_MOVE'
    """
    names = [str(choice) for choice in choices]
    import difflib  # imported late, because most names are right

    close_names = difflib.get_close_matches(str(value), names, n=1)
    name_list = ", ".join(names) or "none"
    if close_names:
        return f"did you mean {close_names[0]}? Choose from {name_list}"
    return f"choose from {name_list}"
