"""Operands of instructions: numbers, words, digits, labels and text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


class OperandError(ValueError):
    """The operand is invalid; the message lists the allowed values."""


@dataclass(frozen=True, slots=True)
class Number:
    """A decimal integer."""

    low: int
    high: int
    width: int  # bytes in program memory
    name: str = "a number"  # its name in messages
    terminal = "NUMBER"

    def value(self, written: str) -> int:
        """Return the value; raise an `OperandError` if it is invalid."""
        value = int(written)
        if not self.low <= value <= self.high:
            raise OperandError(f"{value} is out of range: {self.name} is {self.low} to {self.high}")
        return value

    def written(self, value: int | str) -> str:
        """Return the value as it appears in a program's text."""
        return str(value)


@dataclass(frozen=True, slots=True)
class Choice:
    """One of two words, stored in the second byte of the instruction."""

    words: tuple[str, str]  # for 1 and for 0
    width = 0

    @property
    def terminal(self) -> str:
        """The terminal in the grammar."""
        return "_".join(self.words)

    def value(self, written: str) -> int:
        """Return 1 or 0."""
        return 1 - self.words.index(written.upper())

    def written(self, value: int | str) -> str:
        """Return the word."""
        return self.words[1 - int(value)]


@dataclass(frozen=True, slots=True)
class Digits:
    """Binary digits; the first digit is for input or output 1, which is bit 0 of the value."""

    count: int
    width = 1

    @property
    def terminal(self) -> str:
        """The terminal in the grammar."""
        return f"DIGITS{self.count}"

    def value(self, written: str) -> int:
        """Return the number whose bit 0 is the first digit."""
        return int(written[::-1], 2)

    def written(self, value: int | str) -> str:
        """Return the digits, bit 0 first."""
        return f"{int(value):0{self.count}b}"[::-1]


@dataclass(frozen=True, slots=True)
class Label:
    """A label in upper or lower case."""

    width: int  # bytes of its address in program memory; 0 where the label is defined
    terminal = "NAME"

    def value(self, written: str) -> str:
        """Return the name in upper case."""
        return written.upper()

    def written(self, value: int | str) -> str:
        """Return the name."""
        return str(value)


TEXT_MAX = 20
"""Maximum characters of a Send Text instruction [section 3]."""

ESCAPES: Mapping[str, str] = {"n": "\n", "r": "\r", '"': '"', "\\": "\\"}


@dataclass(frozen=True, slots=True)
class Text:
    r"""A quoted text to send; each of the escapes \n, \r, \" and \\ is one character."""

    width = 0
    terminal = "TEXT_"

    def value(self, written: str) -> str:
        """Return the characters; raise an `OperandError` if the text is invalid."""
        text = unquoted(written)
        if len(text) > TEXT_MAX:
            raise OperandError(f"{len(text)} characters are too many: text is at most {TEXT_MAX}")
        return text

    def written(self, value: int | str) -> str:
        """Return the text in quotes."""
        return quoted(str(value))


def unquoted(written: str) -> str:
    r"""Return the characters of a quoted text.

    >>> unquoted(r'"@1G\n"')
    '@1G\n'

    Raises:
        OperandError: the text has a character that can't be sent, or an unknown escape.
    """
    text = ""
    characters = iter(written[1:-1])
    for character in characters:
        text += _escaped(next(characters)) if character == "\\" else _plain(character)
    return text


def _escaped(letter: str) -> str:
    if letter not in ESCAPES:
        raise OperandError(rf"\{letter} is unknown: write n, r, \ or a quote after \ ")
    return ESCAPES[letter]


def _plain(character: str) -> str:
    if not " " <= character <= "~":
        raise OperandError(f"{character!r} can't be sent: text must be printable ASCII")
    return character


def quoted(text: str) -> str:
    r"""Return text in quotes.

    >>> print(quoted('@1G\n'))
    "@1G\n"
    """
    escapes = str.maketrans({character: f"\\{letter}" for letter, character in ESCAPES.items()})
    return f'"{text.translate(escapes)}"'


Operand = Number | Choice | Digits | Label | Text
