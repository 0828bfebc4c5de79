"""The grammar of a program line, generated from the instruction table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .instructions import INSTRUCTIONS, Instruction

DIRECTIVES: Mapping[str, str] = {"title": "TEXT_", "axis": "NUMBER", "autostart": "ON_OFF"}
"""The terminal after each directive."""

TERMINALS: Mapping[str, tuple[str, str]] = {
    "NUMBER": (r"/[+-]?\d{1,20}(?![\w.])/", "a number"),
    "ON_OFF": (r"/(ON|OFF)\b/i", "ON or OFF"),
    "CW_CCW": (r"/(CW|CCW)\b/i", "CW or CCW"),
    "DIGITS6": (r"/[01]{6}\b/", "six digits 0 or 1, input 1 first"),
    "DIGITS8": (r"/[01]{8}\b/", "eight digits 0 or 1, output 1 first"),
    "NAME": (r"/[A-Za-z][A-Za-z0-9_]{0,15}\b/", "a label (a letter, then up to 15 letters, digits or _)"),
    "TEXT_": (r'/"(?:[^"\\]++|\\.)*+"/', "text in quotes"),
    "EQUALS": ('"="', "="),
}
"""The pattern of each terminal, and its name in messages."""


def row_rule(index: int) -> str:
    """Return the grammar's rule for an instruction row."""
    return f"row{index}"


def grammar() -> str:
    """Return the grammar of a line: an instruction, a directive or nothing, then an optional comment."""
    rules = [f"{_terminals_of(row)} -> {row_rule(index)}" for index, row in enumerate(INSTRUCTIONS)]
    rules += [f"/\\.{name}\\b/i {terminal} -> directive" for name, terminal in DIRECTIVES.items()]
    rules.append("-> nothing")
    terminals = [f"{name}: {pattern}" for name, (pattern, _) in TERMINALS.items()]
    terminals += [f"{keyword_terminal(word)}.2: /{word}\\b/i" for word in keywords()]
    return "\n".join(["start: " + "\n     | ".join(rules), *terminals, r"%ignore /[ \t]+/", "%ignore /;.*/"])


def _terminals_of(row: Instruction) -> str:
    """Return the terminals of an instruction's line as text: its name and operands, in order."""
    words = [keyword_terminal(word) for word in row.name.split()]
    operands = [operand.terminal for operand in row.operands]
    if row.name == "IF INPUT":
        operands.insert(1, "EQUALS")
    return " ".join(words + operands)


def keywords() -> Iterator[str]:
    """Yield each word in instruction names once, in the table's order."""
    yield from dict.fromkeys(word for row in INSTRUCTIONS for word in row.name.split())


def keyword_terminal(word: str) -> str:
    """Return the terminal for a keyword; lark omits terminals that begin with an underscore from the tree."""
    return f"_W_{word}"


def names_of(terminals: set[str]) -> str:
    """Return the names of terminals for a message, in the grammar's order."""
    names = {name: meaning for name, (_, meaning) in TERMINALS.items()}
    names |= {keyword_terminal(word): word for word in keywords()}
    names["$END"] = "the end of the line"
    return ", ".join(meaning for name, meaning in names.items() if name in terminals)
