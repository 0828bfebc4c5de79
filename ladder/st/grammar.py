"""The grammar of structured text: its terminals, its operators, and the names of terminals in messages.

    block      = { statement }
    statement  = target (":=" | "[:=]") expression ";"
               | name "(" [ expression { "," [ expression | word ] } ] ")" ";"
               | IF expression THEN block { ELSIF expression THEN block } [ ELSE block ] END_IF ";"
               | CASE expression OF { choice } [ ELSE block ] END_CASE ";"
               | FOR target ":=" expression TO expression [ BY expression ] DO block END_FOR ";"
               | WHILE expression DO block END_WHILE ";"
               | REPEAT block UNTIL expression END_REPEAT ";"
               | EXIT ";" | RETURN ";" | ";" | #region block #endregion
    choice     = range { "," range } ":" block
    range      = label [ ".." label ]
    label      = [ "-" ] number
    target     = name { step }
    step       = "." name | "." bit | ".[" expression "]" | "[" expression { "," expression } "]"
    primary    = number | string | target | name "(" expression ")" | "(" expression ")"

Precedence of operators [1756-PM007]: (), functions, **, unary -, NOT, * / MOD, + -, < <= > >=, = <>, & AND,
XOR, OR. Operators of the same level are evaluated from left to right.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..model.expressions import TAG_BASE

KEYWORDS = (
    *("IF", "THEN", "ELSIF", "ELSE", "END_IF", "CASE", "OF", "END_CASE", "FOR", "TO", "BY", "DO", "END_FOR"),
    *("WHILE", "END_WHILE", "REPEAT", "UNTIL", "END_REPEAT", "EXIT", "RETURN"),
    *("OR", "XOR", "AND", "MOD", "NOT"),
)

_SIGNS = {
    "ASSIGN": ":=",
    "UNEQUAL": "<>",
    "EQUAL": "=",
    "PLUS": "+",
    "MINUS": "-",
    "POWER": "**",
    "DOTS": "..",
    "COLON": ":",
    "SEMI": ";",
    "LPAR": "(",
    "RPAR": ")",
    "LSQB": "[",
    "RSQB": "]",
    "COMMA": ",",
}
_TERMINALS = {
    "SPACE": r"\s+",
    "AND": r"&(?![0-9A-F]{8}:)",
    "NON_RETENTIVE": r"\[\s*:=\s*\]",
    "NUMBER": r"(?:16|8|2)\#[0-9A-Fa-f_]+|1\.(?:\$|\#[A-Za-z]+)0*|T(?:IME)?\#\w+(?:\.\w+)*+"
    r"|(?:\d[\d_]*\.(?!\.)\d*|(?<![\w\]])\.\d+)(?:E[+-]?\d+)?|\d[\d_]*(?:E[+-]?\d+)?",
    "BIT": r"(?<=[\w\]])\.\d+",
    "UNEQUAL": r"<>",
    "RELATION": r"<=|>=|<|>",
    "POWER": r"\*\*",
    "TIMES": r"\*|/",
    "DOTS": r"\.\.",
    "MEMBER": r"\.\s*[A-Za-z_]\w*",
    "COMPUTED": r"\.\s*\[",
    "ASSIGN": r":=",
    "STRING": r"'(?:[^'$\n]++|\$[^\n])*+'",
    "REGION": r"\#region\b[^\n]*",
    "END_REGION": r"\#endregion\b[^\n]*",
    "PERCENT": r"%\s?of\s?\w+",
    "KEYWORD": rf"(?:{'|'.join(KEYWORDS)})\b",
    "BASE": TAG_BASE,
    **{name: re.escape(sign) for name, sign in _SIGNS.items() if len(sign) == 1},
}
TERMINAL = re.compile(
    "|".join(f"(?P<{name}>{pattern})" for name, pattern in _TERMINALS.items()), re.IGNORECASE
)
"""A terminal: the first alternative that matches."""

BINDING: Mapping[str, int] = {
    "OR": 1,
    "XOR": 2,
    "AND": 3,
    **dict.fromkeys(("EQUAL", "UNEQUAL"), 4),
    "RELATION": 5,
    **dict.fromkeys(("PLUS", "MINUS"), 6),
    **dict.fromkeys(("TIMES", "MOD"), 7),
    "POWER": 9,
}
"""Precedence of operators; the highest number binds first. Unary minus and NOT have `UNARY`."""

UNARY = 8

END = "$END"
"""The end of the text, as a terminal."""

TERMS: Mapping[str, str] = {
    **_SIGNS,
    "NON_RETENTIVE": "[:=]",
    "RELATION": "a comparison",
    "TIMES": "* or /",
    "NUMBER": "a number",
    "STRING": "a string",
    "MEMBER": "a member",
    "BIT": "a bit",
    "COMPUTED": "a bit",
    "BASE": "a name",
    "REGION": "#region",
    "END_REGION": "#endregion",
    END: "the end",
}
"""Names of terminals in messages, except keywords."""

OPERATORS = frozenset(BINDING)
"""Terminals named "an operator" in messages."""

OPERANDS = frozenset(("NUMBER", "STRING", "BASE", "LPAR", "NOT", "MINUS"))
"""Terminals named "an expression" in messages."""

PARTS = frozenset(("MEMBER", "BIT", "COMPUTED", "LSQB", "LPAR"))
"""Terminals that continue a name; messages with other terminals omit them."""

STATEMENTS = frozenset(("IF", "CASE", "FOR", "WHILE", "REPEAT", "EXIT", "RETURN", "REGION", "SEMI", "BASE"))
"""Terminals named "a statement" in messages."""
