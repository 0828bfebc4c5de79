#!/usr/bin/env bash
# what: pywellen reads -1 of a VCD integer as 4294967295
# date: 2026-11-29
# meets: anyone who reads a position from a VCD file with Python
# expected: the type integer of IEEE 1364 is signed, so -1
# behavior:
#   A variable of type integer with 32 bits, as a VCD writer makes it of -1. pywellen knows the type and gives the bits as
#   an unsigned number.
# product: A position is a 32-bit integer in the export: in pywellen, subtract 2**32 from numbers of 2**31 and above; see [export](query.md#vcd-readers)
# output:
#   position Integer [0, 4294967295, 1]
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyvcd==0.5.1 pywellen==0.25.7
observe python - <<'PY'
import pywellen
from vcd import VCDWriter

with open("a.vcd", "w") as file, VCDWriter(file, timescale="1 ns", date="today") as writer:
    position = writer.register_var("rack", "position", "integer", size=32, init=0)
    writer.change(position, 1, -1)
    writer.change(position, 2, 1)
for variable in pywellen.Waveform("a.vcd").all_vars():
    print(variable.name, variable.var_type, [variable.signal.value_at(when) for when in (0, 1, 2)])
PY
