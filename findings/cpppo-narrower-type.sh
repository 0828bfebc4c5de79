#!/usr/bin/env bash
# what: cpppo's simulated controller accepts a write whose type is not the tag's, if the written type is narrower
# date: 2026-11-30
# meets: drivers of HMIs that are tested against cpppo before they meet a Logix controller
# expected: status FFh, extended 2107h (type mismatch), as it answers a wider type and as a Logix controller does
# behavior:
#   SINT to INT, INT to DINT, DINT to REAL and DINT to LINT are converted and confirmed. The other direction is refused.
# product: A write whose type is not the tag's gets FFh, 2107h: [HMI](hmi.md#what-clients-may-write)
# output:
#   W[0-0] as SINT: success, reads -3
#   W[0-0] as DINT: 255, 2107h, reads -3
#   A[0-1] as INT: success, reads 5
#   A[0-0] as REAL: 255, 2107h, reads 5
#   R as DINT: success, reads 5.0
#   L as DINT: success, reads -1
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install cpppo==5.2.5
port=$(python -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
python -m cpppo.server.enip --address "127.0.0.1:$port" "A=DINT[4]" "W=INT[4]" R=REAL L=LINT >server 2>&1 &
observe python - "$port" <<'PY'
import socket
import sys
import time

from cpppo.server.enip import client

port = int(sys.argv[1])
for _ in range(100):
    try:
        socket.create_connection(("127.0.0.1", port), 1).close()
        break
    except OSError:
        time.sleep(0.1)


def answers(*operations):
    with client.connector(host="127.0.0.1", port=port, timeout=5) as connection:
        parsed = client.parse_operations(operations)
        return [(status, values) for *_, status, values in connection.pipeline(operations=parsed, depth=1, timeout=5)]


for tag, written in (
    ("W[0-0]", "SINT)-3"),
    ("W[0-0]", "DINT)7"),
    ("A[0-1]", "INT)5,6"),
    ("A[0-0]", "REAL)3.5"),
    ("R", "DINT)5"),
    ("L", "DINT)-1"),
):
    (status, _), (_, values) = answers(f"{tag}=({written}", tag)
    text = "success" if status == 0 else f"{status[0]}, {status[1][0]:04X}h"
    print(f"{tag} as {written.partition(')')[0]}: {text}, reads {values[0]}")
PY
