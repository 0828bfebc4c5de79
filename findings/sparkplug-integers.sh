#!/usr/bin/env bash
# what: Sparkplug integers lose their sign or their value between pysparkplug and sparkplug-payload
# date: 2026-11-29
# meets: anyone who sends tags of a PLC over MQTT from Python to Node-RED, or back
# expected: integers of every type survive both ways: both use the protobuf of the Sparkplug specification
# behavior:
#   Python to Node: Int8 -1 arrives as 255 and Int16 -2 as 65534; UInt32 4294967295 arrives as null, since pysparkplug puts
#   it into the field for 64 bits that the reader does not look at for that type. Node to Python: Int8 -1 is sent with
#   32 bits, and pysparkplug raises OverflowError for the whole message.
# product: Publishes no Sparkplug; see what a bridge keeps: [what surprises](hmi-clients.md#surprising-client-behavior)
# output:
#   Python to Python: INT8 -1
#   Python to Python: INT16 -2
#   Python to Python: INT32 -3
#   Python to Python: INT64 -4
#   Python to Python: UINT8 255
#   Python to Python: UINT32 4294967295
#   Python to Python: UINT64 18446744073709551615
#   Python to Node: Int8 255
#   Python to Node: Int16 65534
#   Python to Node: Int32 -3
#   Python to Node: Int64 -4
#   Python to Node: UInt8 255
#   Python to Node: UInt32 null
#   Python to Node: UInt64 18446744073709551615
#   Node to Python: Int8 OverflowError: Int8 overflow with value 4294967295
#   Node to Python: Int16 OverflowError: Int16 overflow with value 4294967294
#   Node to Python: Int32 -3
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pysparkplug==0.6.1 sparkplug-payload@1.0.3
cat >send.py <<'PY'
import pysparkplug
from pysparkplug import DataType

values = [(DataType.INT8, -1), (DataType.INT16, -2), (DataType.INT32, -3), (DataType.INT64, -4)]
values += [(DataType.UINT8, 255), (DataType.UINT32, 4294967295), (DataType.UINT64, 2**64 - 1)]
metrics = tuple(pysparkplug.Metric(timestamp=1, name="level", datatype=each, value=value) for each, value in values)
raw = pysparkplug.NBirth(timestamp=1, seq=0, metrics=metrics).encode()
open("python.bin", "wb").write(raw)
for metric in pysparkplug.NBirth.decode(raw).metrics:
    print("Python to Python:", metric.datatype.name, metric.value)
PY
cat >both.cjs <<'JS'
const fs = require("fs");
const sparkplug = require("sparkplug-payload").get("spBv1.0");
for (const metric of sparkplug.decodePayload(fs.readFileSync("python.bin")).metrics)
  console.log("Python to Node:", metric.type, String(metric.value));
for (const [type, value] of [["Int8", -1], ["Int16", -2], ["Int32", -3]]) {
  const metric = { name: "level", type, value, timestamp: 1 };
  fs.writeFileSync(`${type}.bin`, sparkplug.encodePayload({ timestamp: 1, seq: 0, metrics: [metric] }));
}
JS
cat >read.py <<'PY'
import pysparkplug

for name in ("Int8", "Int16", "Int32"):
    try:
        message = pysparkplug.NBirth.decode(open(f"{name}.bin", "rb").read())
        print("Node to Python:", name, message.metrics[0].value)
    except OverflowError as error:
        print("Node to Python:", name, "OverflowError:", error)
PY
observe python send.py
observe node both.cjs
observe python read.py
