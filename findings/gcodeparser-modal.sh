#!/usr/bin/env bash
# what: gcodeparser omits lines without a G or M word, so moves that continue a G1 are missing from the path
# date: 2026-11-30
# meets: anyone who runs a CAM program on separate axes, or computes its length
# expected: moves to (10, 20), (5, 20) and (5, 30), since G0 to G3 are modal and CAM programs state them once
# behavior:
#   The parser wants a letter G, M or T at the beginning of each command and gives no error for text that has none. A
#   comment in parentheses ends the command: the words that follow it are left out. In `G1 G91 X10` the X belongs to G91.
#   A number that ends with its point, as programs for Fanuc controls write it, raises ValueError.
# product: Reads no G-code; moves are lines of a sequence: [sequences](sequences.md#commands-and-errors)
# output:
#   G1 X10 Y20: G1 X=10 Y=20
#   X5: nothing
#   Y30 (top): nothing
#   G1 Z5 (up) X0: G1 Z=5
#   G1 G91 X10: G1 | G91 X=10
#   G1 X10.: ValueError invalid literal for int() with base 10: '10.'
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install gcodeparser==0.3.0
observe python - <<'PY'
from gcodeparser import parse_gcode_lines

PROGRAM = ("G1 X10 Y20", "X5", "Y30 (top)", "G1 Z5 (up) X0", "G1 G91 X10")


def shown(command):
    return " ".join((command.command_str, *(f"{name}={value}" for name, value in command.params.items())))


commands = list(parse_gcode_lines("\n".join(PROGRAM)))
for number, line in enumerate(PROGRAM):
    print(f"{line}:", " | ".join(shown(command) for command in commands if command.line_index == number) or "nothing")
try:
    list(parse_gcode_lines("G1 X10."))
except ValueError as error:
    print("G1 X10.:", type(error).__name__, error)
PY
