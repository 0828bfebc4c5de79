"""The grammar of a query, and the names that messages use for its terminals."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.times import TIME

GRAMMAR = r"""
?start: pattern
      | AGGREGATE "(" pattern ")"                       -> aggregate

?pattern: condition                                     -> runs
        | condition _THEN condition                    -> then
        | condition _THEN condition _WITHIN DURATION  -> then
        | condition _WITHOUT condition _WITHIN DURATION -> without

?condition: both
          | both (_OR both)+                            -> any_of
?both: negated
     | negated (_AND negated)+                          -> all_of
?negated: _NOT negated                                 -> negation
        | held
?held: comparison
     | comparison _FOR DURATION                        -> held
?comparison: sum
           | sum COMPARE sum                            -> compare
?sum: product
    | sum SIGN product                                  -> arithmetic
?product: factor
        | product TIMES factor                          -> arithmetic
?factor: SIGN factor                                    -> signed
       | _ABS "(" sum ")"                              -> absolute
       | EDGE "(" condition ")"                         -> edge
       | "(" condition ")"
       | DURATION                                       -> duration
       | NUMBER                                         -> number
       | NAME                                           -> name
       | TEXT                                           -> text

AGGREGATE.2: /(count|first|last|longest|shortest)\b/
EDGE.2: /(rose|fell|changed)\b/
COMPARE: "==" | "!=" | "<=" | ">=" | "<" | ">"
SIGN: "+" | "-"
TIMES: "*"
DURATION.3: /@TIME@\b/
NUMBER.1: /0[xX][0-9a-fA-F]+|\d[\d_]*(\.\d+)?/
NAME: /(Program:(?=\w+\.)|\\)?[^\W\d]\w*(:[IOCSiocs]\d*(?=\W|$)|:\d+|\/\w+|\.\w+|\[([\w\s.,]*|"[^"]*")\])*/
TEXT: /"[^"]*"|'[^']*'/

_AND.2: /and\b/
_OR.2: /or\b/
_NOT.2: /not\b/
_THEN.2: /then\b/
_WITHOUT.2: /without\b/
_WITHIN.2: /within\b/
_FOR.2: /for\b/
_ABS.2: /abs\b/

%ignore /\s+/
""".replace("@TIME@", TIME)

TERMS: Mapping[str, str] = {
    "AGGREGATE": "count, first, last, longest or shortest",
    "EDGE": "rose, fell or changed",
    "COMPARE": "a comparison (== != < <= > >=)",
    "SIGN": "+ or -",
    "TIMES": "*",
    "DURATION": "a time such as 20 ms",
    "NUMBER": "a number",
    "NAME": "a signal",
    "TEXT": "a text in quotes",
    "LPAR": "(",
    "RPAR": ")",
    "_AND": "and",
    "_OR": "or",
    "_NOT": "not",
    "_THEN": "then",
    "_WITHOUT": "without",
    "_WITHIN": "within",
    "_FOR": "for",
    "_ABS": "abs",
    "$END": "the end",
}
"""Names that messages use for the grammar's terminals."""
