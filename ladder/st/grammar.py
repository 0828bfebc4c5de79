"""The grammar of structured text, and the names of its terminals in messages.

Precedence of operators [1756-PM007]: (), functions, **, unary -, NOT, * / MOD, + -, < <= > >=, = <>, & AND,
XOR, OR; those of one level from left to right.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..model.expressions import TAG_BASE

GRAMMAR = rf"""
start: block

block: statement*

?statement: BASE step* ASSIGN expression SEMI                     -> assignment
          | BASE step* NON_RETENTIVE expression SEMI              -> assignment
          | BASE "(" [expression ("," argument)*] ")" SEMI        -> invocation
          | IF expression THEN block (ELSIF expression THEN block)* (ELSE block)? END_IF SEMI      -> if_
          | CASE expression OF choice* (ELSE block)? END_CASE SEMI                                 -> case
          | FOR BASE step* ASSIGN expression TO expression (BY expression)? DO block END_FOR SEMI  -> for_
          | WHILE expression DO block END_WHILE SEMI                                               -> while_
          | REPEAT block UNTIL expression END_REPEAT SEMI                                          -> repeat
          | EXIT SEMI                                             -> exit
          | RETURN SEMI                                           -> return_
          | SEMI                                                  -> empty
          | REGION block END_REGION                               -> region

?argument: expression
         | PERCENT                                                -> word
         |                                                        -> missing

choice: range ("," range)* COLON block
range: label [DOTS label]
label: NUMBER | MINUS NUMBER

?expression: exclusive | expression OR exclusive                  -> operation
?exclusive: both | exclusive XOR both                             -> operation
?both: equality | both AND equality                               -> operation
?equality: relation | equality (EQUAL | UNEQUAL) relation         -> operation
?relation: sum | relation RELATION sum                            -> operation
?sum: product | sum (PLUS | MINUS) product                        -> operation
?product: unary | product (TIMES | MOD) unary                     -> operation
?unary: power | MINUS unary -> negation | NOT unary -> inversion
?power: primary | power POWER exponent                            -> operation
?exponent: primary | MINUS exponent -> negation
?primary: NUMBER
        | BASE step*                                              -> address
        | BASE "(" expression ")"                                 -> function
        | "(" expression ")"                                      -> group
        | STRING                                                  -> string

step: MEMBER                                                      -> member
    | BIT                                                         -> bit
    | "[" expression ("," expression)* "]"                        -> subscript
    | COMPUTED expression "]"                                     -> computed_bit

IF.3: /IF\b/i
THEN.3: /THEN\b/i
ELSIF.3: /ELSIF\b/i
ELSE.3: /ELSE\b/i
END_IF.3: /END_IF\b/i
CASE.3: /CASE\b/i
OF.3: /OF\b/i
END_CASE.3: /END_CASE\b/i
FOR.3: /FOR\b/i
TO.3: /TO\b/i
BY.3: /BY\b/i
DO.3: /DO\b/i
END_FOR.3: /END_FOR\b/i
WHILE.3: /WHILE\b/i
END_WHILE.3: /END_WHILE\b/i
REPEAT.3: /REPEAT\b/i
UNTIL.3: /UNTIL\b/i
END_REPEAT.3: /END_REPEAT\b/i
EXIT.3: /EXIT\b/i
RETURN.3: /RETURN\b/i
REGION: /#region\b[^\n]*/i
END_REGION: /#endregion\b[^\n]*/i

ASSIGN: ":="
NON_RETENTIVE.2: /\[\s*:=\s*\]/
OR.3: /OR\b/i
XOR.3: /XOR\b/i
AND.3: /AND\b|&/i
MOD.3: /MOD\b/i
NOT.3: /NOT\b/i
EQUAL: "="
UNEQUAL.2: "<>"
RELATION: "<=" | ">=" | "<" | ">"
PLUS: "+"
MINUS: "-"
TIMES: "*" | "/"
POWER: "**"
DOTS: ".."
COLON: ":"
SEMI: ";"

NUMBER.2: /(16|8|2)#[0-9A-Fa-f_]+/ | /1\.(\$|#[A-Za-z]+)0*/ | /T(IME)?#\w+(\.\w+)*/i
        | /(\d[\d_]*\.(?!\.)\d*|(?<![\w\]])\.\d+)([eE][+-]?\d+)?/
        | /\d[\d_]*([eE][+-]?\d+)?/
STRING: /'([^'$\n]|\$[^\n])*'/
MEMBER: /\.\s*[A-Za-z_]\w*/
BIT.2: /(?<=[\w\]])\.\d+/
COMPUTED: /\.\s*\[/
PERCENT: /%\s?of\s?\w+/i
BASE: /{TAG_BASE}/

%ignore /\s+/
"""

TERMS: Mapping[str, str] = {
    "ASSIGN": ":=",
    "NON_RETENTIVE": "[:=]",
    "EQUAL": "=",
    "UNEQUAL": "<>",
    "RELATION": "a comparison",
    "PLUS": "+",
    "MINUS": "-",
    "TIMES": "* or /",
    "POWER": "**",
    "DOTS": "..",
    "COLON": ":",
    "SEMI": ";",
    "NUMBER": "a number",
    "STRING": "a string",
    "MEMBER": "a member",
    "BIT": "a bit",
    "COMPUTED": "a bit",
    "BASE": "a name",
    "REGION": "#region",
    "END_REGION": "#endregion",
    "LPAR": "(",
    "RPAR": ")",
    "LSQB": "[",
    "RSQB": "]",
    "COMMA": ",",
    "$END": "the end",
}
"""Names of terminals in messages, keywords apart."""

OPERATORS = frozenset(
    ("OR", "XOR", "AND", "MOD", "EQUAL", "UNEQUAL", "RELATION", "PLUS", "MINUS", "TIMES", "POWER")
)
"""Terminals named "an operator" in messages."""

OPERANDS = frozenset(("NUMBER", "STRING", "BASE", "LPAR", "NOT", "MINUS"))
"""Terminals named "an expression" in messages."""

PARTS = frozenset(("MEMBER", "BIT", "COMPUTED", "LSQB", "LPAR"))
"""Terminals that continue a name; messages with other terminals omit them."""

STATEMENTS = frozenset(("IF", "CASE", "FOR", "WHILE", "REPEAT", "EXIT", "RETURN", "REGION", "SEMI", "BASE"))
"""Terminals named "a statement" in messages."""
