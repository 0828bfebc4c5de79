#!/usr/bin/env bash
# what: pyvcd sorts scopes by their text, so slot10 comes before slot2 in every viewer
# date: 2026-11-29
# meets: anyone who exports more than ten modules
# expected: scopes in the order of registration
# behavior:
#   Scopes are written in the order of their names as text, whatever the order of registration. Variables inside
#   a scope keep their order of registration.
# product: Exported scopes also come in this order: `slot10` is before `slot2`; see [export](query.md)
# output:
#   module rack
#   module slot1
#   wire 1 ! run
#   wire 1 " home
#   module slot10
#   wire 1 % run
#   wire 1 & home
#   module slot2
#   wire 1 # run
#   wire 1 $ home
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyvcd==0.5.1
observe python - <<'PY'
import io

from vcd import VCDWriter

file = io.StringIO()
with VCDWriter(file, timescale="1 ns", date="today") as writer:
    for slot in (1, 2, 10):
        for name in ("run", "home"):
            writer.register_var(f"rack.slot{slot}", name, "wire", size=1)
for line in file.getvalue().splitlines():
    if line.startswith(("$scope", "$var")):
        print(" ".join(line.split()[1:-1]))
PY
