#!/usr/bin/env bash
# what: vcdvcd lists a string variable of a VCD file but returns no values for it
# date: 2026-11-29
# meets: anyone who reads states or step names of a VCD recording with Python
# expected: values of string variables are strings, as GTKWave shows them
# behavior:
#   pyvcd writes a variable of type string and its changes as s values. vcdvcd names the signal among its signals and
#   has no change for it, without an error. Bits and reals of the same file are there.
# product: Codes are string variables, which GTKWave shows; other readers differ: [export](query.md#vcd-readers)
# output:
#   rack.lamp [(0, '0'), (1, '1')]
#   rack.step []
#   rack.level [(0, '0.5'), (2, '1.5')]
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyvcd==0.5.1 vcdvcd==2.6.0
observe python - <<'PY'
from vcd import VCDWriter
from vcdvcd import VCDVCD

with open("a.vcd", "w") as file, VCDWriter(file, timescale="1 ns", date="today") as writer:
    lamp = writer.register_var("rack", "lamp", "wire", size=1, init=0)
    step = writer.register_var("rack", "step", "string", init="idle")
    level = writer.register_var("rack", "level", "real", init=0.5)
    writer.change(lamp, 1, 1)
    writer.change(step, 1, "home")
    writer.change(step, 2, "move")
    writer.change(level, 2, 1.5)
read = VCDVCD("a.vcd")
for name in read.signals:
    print(name, read[name].tv)
PY
