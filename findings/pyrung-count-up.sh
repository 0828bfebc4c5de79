#!/usr/bin/env bash
# what: pyrung's count_up, called CTU in its documentation, counts scans and not edges, and beyond its preset
# date: 2026-11-29
# meets: anyone who counts parts with a CTU that came from Logix or IEC 61131-3
# expected: one count for each rising edge of the rung
# behavior:
#   A sensor that is on for four scans and on again for two counts six with count_up alone and two with rise before it.
# product: CTU counts edges, as in Logix: [Coming from](coming.md#pyrung)
# output:
#   {'alone_Acc': 6, 'alone_Done': True, 'edges_Acc': 2, 'edges_Done': False}
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyrung==0.15.2 pyclickplc==0.4.1
observe python - <<'PY'
from pyrung import PLC, Bool, Counter, Program, Rung, count_up, rise

sensor, reset = Bool("sensor"), Bool("reset")
alone, edges = Counter.clone("alone"), Counter.clone("edges")
with Program() as program:
    with Rung(sensor):
        count_up(alone, preset=3).reset(reset)
    with Rung(rise(sensor)):
        count_up(edges, preset=3).reset(reset)
plc = PLC(program, dt=0.01)
for on in (False, True, True, True, True, False, True, True, False):
    plc.patch({"sensor": on})
    plc.step()
tags = dict(plc.current_state.tags)
print({name: tags[name] for name in ("alone_Acc", "alone_Done", "edges_Acc", "edges_Done")})
PY
