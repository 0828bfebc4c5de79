#!/usr/bin/env bash
# what: pylogix sends 21 requests for its first list of 20 tags and one for the next
# date: 2026-11-29
# meets: anyone who connects for each poll, or compares the load of clients
# expected: one or two requests, each time: a list is packed into Multiple Service Packets
# behavior:
#   Before a tag's first read pylogix reads it alone to learn its type, one request for a tag, and then packs the list into
#   one Multiple Service Packet. The types are kept as long as the object lives, so a program that makes a new PLC object
#   for each poll pays 21 round trips each time. Counted are SendUnitData frames at a relay before cpppo's server.
# product: Its EtherNet/IP server answers both; keep the PLC object between polls: [what surprises](hmi-clients.md#surprising-client-behavior)
# output:
#   first list: 21 requests, Success
#   second list: 1 requests, Success
#   third list: 1 requests, Success
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pylogix==1.1.6 cpppo==5.2.5
cat >serve.sh <<'SH'
exec python -m cpppo.server.enip --no-udp -a "127.0.0.1:$1" $(printf 'tag%d=DINT ' $(seq 0 19)) >server.log 2>&1
SH
observe python - <<'PY'
import socket
import subprocess
import threading
import time

from pylogix import PLC

with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
server = subprocess.Popen(["bash", "serve.sh", str(port)])
sent = 0


def upstream():
    for _ in range(100):
        try:
            return socket.create_connection(("127.0.0.1", port))
        except OSError:
            time.sleep(0.2)
    raise SystemExit("the server does not listen")


def pump(source, sink, count):
    global sent
    kept = b""
    while data := source.recv(65536):
        kept += data if count else b""
        while len(kept) >= 24 + int.from_bytes(kept[2:4] or b"\xff\xff", "little"):
            sent += int.from_bytes(kept[:2], "little") == 0x70
            kept = kept[24 + int.from_bytes(kept[2:4], "little") :]
        try:
            sink.sendall(data)
        except OSError:  # its client has gone
            return


relay = socket.create_server(("127.0.0.1", 0))


def accept():
    while True:
        client, _ = relay.accept()
        far = upstream()
        threading.Thread(target=pump, args=(client, far, True), daemon=True).start()
        threading.Thread(target=pump, args=(far, client, False), daemon=True).start()


threading.Thread(target=accept, daemon=True).start()
upstream().close()
try:
    with PLC("127.0.0.1", port=relay.getsockname()[1], timeout=10) as plc:
        for time_ in ("first", "second", "third"):
            before = sent
            statuses = {each.Status for each in plc.Read([f"tag{number}" for number in range(20)])}
            print(time_, "list:", sent - before, "requests,", *statuses)
finally:
    server.terminate()
    server.wait()
PY
