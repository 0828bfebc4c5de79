#!/usr/bin/env bash
# what: nodes7 writes zeros for what is missing or no number: one value to an array of three clears it, NaN and a text become 0
# date: 2026-11-30
# meets: flows of Node-RED that send a form's text, a calculation or a part of an array to an S7 controller
# expected: an error or a bad quality, as for 70000 into an INT, which throws; and the elements that are not given unchanged
# behavior:
#   The callback gets false, which stands for no bad item, each time. A text that is no number and NaN become 0 in an INT and
#   NaN in a REAL. An array that is shorter than the item is filled up with 0, and a number in place of an array writes 0
#   everywhere, so even the number is lost. A fraction is cut off.
# product: Does not serve S7; see the protocols that it serves: [HMI](hmi.md)
# output:
#   INT: 70000 throws RangeError
#   INT: "fast" reads 0, bad false
#   INT: NaN reads 0, bad false
#   INT: 1.9 reads 1, bad false
#   REAL: "fast" reads NaN, bad false
#   three INT: [7,8,9] reads [7,8,9], bad false
#   three INT: [5] reads [5,0,0], bad false
#   three INT: 5 reads [0,0,0], bad false
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install nodes7@0.3.18 python-snap7==3.3.0
cat >write.js <<'JS'
const NodeS7 = require("nodes7");

const ADDRESSES = { INT: "DB1,INT0", REAL: "DB1,REAL4", "three INT": "DB1,INT8.3" };
const WRITES = [
  ["INT", 70000],
  ["INT", "fast"],
  ["INT", NaN],
  ["INT", 1.9],
  ["REAL", "fast"],
  ["three INT", [7, 8, 9]],
  ["three INT", [5]],
  ["three INT", 5],
];
const shown = (value) => (Number.isNaN(value) ? "NaN" : JSON.stringify(value));
const client = new NodeS7({ silent: true });

const write = (item, value) =>
  new Promise((resolve) => {
    client.writeItems(item, value, (bad) => client.readAllItems((_, read) => resolve([bad, read[item]])));
  });

async function main() {
  for (const [item, value] of WRITES) {
    try {
      const [bad, read] = await write(item, value);
      console.log(`${item}: ${shown(value)} reads ${shown(read)}, bad ${bad}`);
    } catch (error) {
      console.log(`${item}: ${shown(value)} throws ${error.name}`);
    }
  }
  client.dropConnection(() => process.exit(0));
}

client.initiateConnection({ port: Number(process.argv[2]), host: "127.0.0.1", rack: 0, slot: 1 }, (failed) => {
  if (failed) process.exit(1);
  client.setTranslationCB((item) => ADDRESSES[item]);
  client.addItems(Object.keys(ADDRESSES));
  main();
});
JS
observe python - <<'PY'
import socket
import subprocess
import time

from snap7 import Server
from snap7.type import SrvArea

with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
server = Server(log=False)
server.register_area(SrvArea.DB, 1, bytearray(32))
server.start(tcp_port=port)
time.sleep(0.5)
subprocess.run(["node", "write.js", str(port)], timeout=60, check=True)
server.stop()
PY
