#!/usr/bin/env bash
# what: pyvcd writes a real with sixteen digits, so 0.1 + 0.2 reads back as another number
# date: 2026-11-29
# meets: anyone who compares an exported VCD file with the recording
# expected: seventeen digits or the shortest text that reads back as the same number
# behavior:
#   The writer formats reals with .16g. A double needs up to seventeen digits, so numbers that differ in the last bit
#   become one, and its own tokenizer reads back another number than was written.
# product: The export gives pyvcd reals that format themselves with all digits; see [export](query.md)
# output:
#   0.30000000000000004 reads back as 0.3 other
#   0.3 reads back as 0.3 same
#   0.3333333333333333 reads back as 0.3333333333333333 same
#   3 changes written, 3 read
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyvcd==0.5.1
observe python - <<'PY'
import io

from vcd import VCDWriter
from vcd.reader import TokenKind, tokenize

file = io.StringIO()
written = [0.1 + 0.2, 0.3, 1 / 3]
with VCDWriter(file, timescale="1 ns", date="today") as writer:
    level = writer.register_var("rack", "level", "real", init=0.0)
    for when, value in enumerate(written, 1):
        writer.change(level, when, value)
tokens = tokenize(io.BytesIO(file.getvalue().encode()))
read = [token.real_change.value for token in tokens if token.kind is TokenKind.CHANGE_REAL][1:]
for before, after in zip(written, read):
    print(repr(before), "reads back as", repr(after), "same" if before == after else "other")
print(len(written), "changes written,", len(read), "read")
PY
