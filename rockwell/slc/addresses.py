"""Addresses of data files in both notations [1747-RM001, "Addressing"].

| export | meaning |
|---|---|
| `N7:3`, `N7:3/5` | word 3 of the file N7; bit 5 of that word |
| `B3/17` | bit 17 of the file: bit 1 of word 1 |
| `I:1.2/3`, `I:1/19` | slot 1, word 2, bit 3; bit 19 of the slot, which is word 1, bit 3 |
| `T4:0.ACC`, `T4:0/DN` | a member of timer 0 |
| `N7:[N7:1]`, `B3:0/[N7:2]` | word or bit number in another word |
| `#N7:0` | in a file instruction, the file from N7:0; elsewhere, the word S:24 words after N7:0 |
"""

from __future__ import annotations

import re

from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.tree import (
    Address,
    BitStep,
    MemberStep,
    Number,
    Operand,
    Operation,
    SlashStep,
    Step,
    SubscriptStep,
    WordStep,
    number,
)

BITS = 16
"""Bits per word."""

_INDIRECT = r"\[[^\[\]]+\]"
_ADDRESS = re.compile(
    rf"(?P<indexed>#)?(?P<letters>[A-Z]{{1,3}})(?P<file>\d{{0,3}})"
    rf"(?::(?P<element>\d{{1,3}}|{_INDIRECT}))?"
    rf"(?:\.(?P<part>\d{{1,3}}|[A-Z]\w*))?(?:/(?P<bit>\d{{1,4}}|[A-Z]\w*|{_INDIRECT}))?",
    re.IGNORECASE,
)

STRUCTURED = {
    "T": {15: "EN", 14: "TT", 13: "DN"},
    "C": {15: "CU", 14: "CD", 13: "DN", 12: "OV", 11: "UN", 10: "UA"},
    "R": {15: "EN", 14: "EU", 13: "DN", 12: "EM", 11: "ER", 10: "UL", 9: "IN", 8: "FD"},
}
"""Letters of files with three-word elements, and the names of bits in the first word."""

WORDS = {"T": ("PRE", "ACC"), "C": ("PRE", "ACC"), "R": ("LEN", "POS")}
"""Names of words 1 and 2 of these elements."""

IMAGES = ("I", "O")
INDEX = Address("S", (WordStep(24, ":"),))
"""S:24, the offset of indexed addresses."""


class AddressTextError(LadderError):
    """The text is not an address of a data file."""


def is_address(text: str) -> bool:
    """Return whether text has the form of an address.

    >>> is_address("B3/17"), is_address("#N7:0"), is_address("100"), is_address("ADD")
    (True, True, False, False)
    """
    match = _ADDRESS.fullmatch(text)
    return match is not None and any(match[group] for group in ("element", "part", "bit"))


def parse(text: str, *, file: bool = False) -> Address:
    """Read an address.

    >>> print(parse("B3/17"), parse("T4:0/DN"), parse("I:1/19"), parse("N7:[N7:1]"))
    B3:1/1 T4:0.DN I:1.1/3 N7[N7:1]

    Args:
        file: whether `#` marks a file; otherwise it adds the offset S:24.

    Raises:
        AddressTextError: the text is not an address.
    """
    match = _ADDRESS.fullmatch(text)
    if match is None or not is_address(text):
        raise AddressTextError(f"{text!r} is not an address of a data file")
    letters = match["letters"].upper()
    if letters in IMAGES:
        return _image(letters, match, text)
    name = letters if letters == "S" else f"{letters}{match['file']}"
    indexed = bool(match["indexed"]) and not file
    if match["element"] is None:
        return Address(name, (*_bit_of_file(match["bit"], text),))
    steps: list[Step] = [_element(match["element"], indexed=indexed)]
    return Address(name, (*steps, *_steps_inside(letters, match["part"], match["bit"], text)))


def _element(text: str, *, indexed: bool) -> Step:
    """Return the step to an element by its number or indirect address; an indexed one adds S:24."""
    index = _index(text)
    if indexed:
        return SubscriptStep((Operation("+", (index, INDEX)),))
    return WordStep(int(text), ":") if text.isdigit() else SubscriptStep((index,))


def _index(text: str) -> Operand:
    """Read a number, or an indirect address in brackets."""
    return number(int(text)) if text.isdigit() else parse(text[1:-1].strip())


def _bit_of_file(bit: str | None, text: str) -> tuple[Step, ...]:
    """Return the steps to a bit that is numbered from the file's beginning."""
    if bit is None or bit[0].isalpha():
        raise AddressTextError(f"{text!r} has no element: write {text}:0")
    if bit.isdigit():
        return WordStep(int(bit) // BITS, ":"), SlashStep(int(bit) % BITS)
    bit_number = _index(bit)
    word = Operation("/", (bit_number, number(BITS)))
    return SubscriptStep((word,)), BitStep(Operation("AND", (bit_number, number(BITS - 1))))


def _steps_inside(letters: str, part: str | None, bit: str | None, text: str) -> tuple[Step, ...]:
    """Return the steps from an element to its part or bit; () for the whole element."""
    if letters in STRUCTURED:
        return _steps_in_structure(letters, part, bit, text)
    steps: list[Step] = []
    if part is not None:
        steps.append(WordStep(int(part), ".") if part.isdigit() else MemberStep(part.upper()))
    if bit is not None:
        if bit.isdigit():
            if int(bit) >= 2 * BITS:
                raise AddressTextError(f"{text!r}: a word has bits 0 to 15")
            steps.append(SlashStep(int(bit)))
        else:
            steps.append(MemberStep(bit.upper()) if bit[0].isalpha() else BitStep(_index(bit)))
    return tuple(steps)


def _steps_in_structure(letters: str, part: str | None, bit: str | None, text: str) -> tuple[Step, ...]:
    """Return the steps in a timer, counter or control; bits of its first word are members."""
    if part is not None and part.isdigit() and part != "0":
        if int(part) > len(WORDS[letters]):
            raise AddressTextError(f"{text!r}: an element has words 0 to 2")
        part = WORDS[letters][int(part) - 1]
    if bit is not None and part in (None, "0"):
        name = STRUCTURED[letters].get(int(bit), "") if bit.isdigit() else bit
        if not name[:1].isalpha():
            raise AddressTextError(f"{text!r}: choose from bits {', '.join(STRUCTURED[letters].values())}")
        return (MemberStep(name.upper()),)
    if part == "0":
        raise AddressTextError(f"{text!r}: the first word has no address, only its bits have")
    steps: list[Step] = [] if part is None else [MemberStep(part.upper())]
    if bit is not None:
        steps.append(SlashStep(int(bit)) if bit.isdigit() else BitStep(_index(bit)))
    return tuple(steps)


def _image(letters: str, match: re.Match[str], text: str) -> Address:
    """Return an address in an image; a bit number above 15 means a later word."""
    slot, part, bit = match["element"], match["part"] or "0", match["bit"]
    if slot is None or not slot.isdigit() or not part.isdigit():
        raise AddressTextError(f"{text!r}: write slot and word, as in {letters}:1.0")
    word = int(part)
    steps: list[Step] = []
    if bit is not None:
        if bit.isdigit():
            word += int(bit) // BITS
            steps.append(SlashStep(int(bit) % BITS))
        else:
            steps.append(BitStep(_index(bit)))
    return Address(f"{letters}:{int(slot)}", (WordStep(word, "."), *steps))


# --- back to text


def text_of(operand: Operand, *, file: bool = False) -> str:
    """Return an operand in the notation of exports, with `#` before a file.

    >>> text_of(parse("N7:[N7:1]/3")), text_of(parse("T4:0/DN")), text_of(parse("B3/17"), file=True)
    ('N7:[N7:1]/3', 'T4:0/DN', '#B3:1/1')
    """
    if not isinstance(operand, Address):
        return str(operand)
    address_text = _address_text(operand)
    return f"#{address_text}" if file and not address_text.startswith("#") else address_text


def _index_text(index: Operand) -> str:
    """Return a number as text, or an indirect address in brackets."""
    return str(index) if isinstance(index, Number) else f"[{text_of(index)}]"


def _address_text(address: Address) -> str:
    """Return an address in the notation of exports, with `#` only if it is indexed by S:24."""
    bit_number = _number_of_bit(address)
    if bit_number is not None:
        return f"{address.name}/[{text_of(bit_number)}]"
    text = address.name
    for step in address.steps:
        if isinstance(step, SubscriptStep):
            inner = step.indices[0]
            if isinstance(inner, Operation) and inner.name == "+" and inner.operands[1] == INDEX:
                return f"#{text}:{text_of(inner.operands[0])}{''.join(map(str, address.steps[1:]))}"
            text += f":{_index_text(inner)}"
        elif isinstance(step, BitStep):
            text += f"/{_index_text(step.index)}"
        elif isinstance(step, MemberStep):
            text += f"{'/' if _is_status_bit(address.name, step.name) else '.'}{step.name}"
        else:
            text += str(step)
    return text


def _number_of_bit(address: Address) -> Operand | None:
    """Return the bit number that `_bit_of_file` reads in brackets; None for other addresses."""
    if len(address.steps) != 2:
        return None
    first, second = address.steps
    if not isinstance(first, SubscriptStep) or not isinstance(second, BitStep):
        return None
    word = first.indices[0]
    if not isinstance(word, Operation) or word.name != "/" or not isinstance(second.index, Operation):
        return None
    return word.operands[0]


def _is_status_bit(file: str, member: str) -> bool:
    """Return whether a member is a bit of the first word of a timer, counter or control."""
    return member in STRUCTURED.get(file[:1], {}).values()
