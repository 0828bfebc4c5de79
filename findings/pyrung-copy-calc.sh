#!/usr/bin/env bash
# what: pyrung's copy clamps 70000 to 32767 where its calc wraps it to 4464
# date: 2026-11-29
# meets: anyone who moves a program from Logix, where MOV and CPT treat one value alike
# expected: one way for both, and a fault flag for a value that does not fit
# behavior:
#   One DINT into an INT: copy stores the nearest number of the destination, calc stores the low sixteen bits. The flag
#   out_of_range is set after calc and not after copy. In calc `/` truncates -7/2 to -3 while `//` rounds down to -4.
# product: MOV and CPT both keep the low bits and record a minor fault: [where instructions end](instructions.md#instructions), [Coming from](coming.md#pyrung)
# output:
#   {'copied': 32767} out_of_range False
#   {'calculated': 4464} out_of_range True
#   {'slash': -3, 'double': -4} out_of_range False
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyrung==0.15.2 pyclickplc==0.4.1
observe python - <<'PY'
from pyrung import PLC, Dint, Int, Program, Rung, calc, copy

wide, copied, calculated, dividend, slash, double = Dint("wide"), *map(Int, ("copied", "calculated", "dividend", "slash", "double"))
with Program() as copying:
    with Rung():
        copy(wide, copied)
with Program() as calculating:
    with Rung():
        calc(wide, calculated)
with Program() as dividing:
    with Rung():
        calc(dividend / 2, slash)
        calc(dividend // 2, double)
for program, values, shown in (
    (copying, {"wide": 70000}, ["copied"]),
    (calculating, {"wide": 70000}, ["calculated"]),
    (dividing, {"dividend": -7}, ["slash", "double"]),
):
    plc = PLC(program, dt=0.01)
    plc.patch(values)
    plc.step()
    tags = dict(plc.current_state.tags)
    print({name: tags[name] for name in shown}, "out_of_range", tags.get("fault.out_of_range", False))
PY
