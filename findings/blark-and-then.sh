#!/usr/bin/env bash
# what: blark binds AND_THEN more loosely than OR, so that `a AND_THEN b OR c` becomes `a AND_THEN (b OR c)`
# date: 2026-11-30
# meets: anyone who translates or checks TwinCAT structured text with its syntax tree
# expected: AND_THEN groups as AND does, which is what Beckhoff's table of binding strengths says (ST Expressions)
# behavior:
#   AND, XOR and OR group as in the table. AND_THEN has one level with OR_ELSE, below OR: with a FALSE and c TRUE the
#   tree's value is FALSE, the controller's TRUE. The text written back has no parentheses, so it does not show.
# product: Its structured text is Logix's: AND and `&` share one level above XOR and OR, and AND_THEN does not exist: [L5X](l5x.md)
# output:
#   a AND b OR c = ((a AND b) OR c)
#   a AND_THEN b OR c = (a AND_THEN (b OR c))
#   a OR b AND c = (a OR (b AND c))
#   a OR_ELSE b AND c = (a OR_ELSE (b AND c))
#   written back: q := a AND_THEN b OR c;
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install blark==0.8.3 lark==1.3.1
observe python - <<'PY'
from blark.parse import parse_source_code


def grouped(expression):
    if hasattr(expression, "left"):
        return f"({grouped(expression.left)} {expression.op} {grouped(expression.right)})"
    return str(expression)


def assignment(text):
    block = f"FUNCTION_BLOCK Sample\nVAR\n a, b, c, q : BOOL;\nEND_VAR\nq := {text};\nEND_FUNCTION_BLOCK\n"
    return parse_source_code(block).transform().items[0].body.statements[0]


for text in ("a AND b OR c", "a AND_THEN b OR c", "a OR b AND c", "a OR_ELSE b AND c"):
    print(text, "=", grouped(assignment(text).expression))
print("written back:", assignment("a AND_THEN b OR c"))
PY
