#!/usr/bin/env bash
# what: the end of a time range is excluded by the MCAP readers of Python and included by @mcap/core
# date: 2026-11-29
# meets: anyone who cuts a recording by time in Python and in a browser
# expected: excluded everywhere: the readers come from one project
# behavior:
#   Of messages at 10, 20, 30 and 40 the range 10 to 30 has two in mcap (end_time, deprecated) and small-mcap, and three
#   in @mcap/core.
# product: `--range A:B` includes B, in scans and in time; see [the language](query-language.md#the-language)
# output:
#   mcap [10, 20]
#   small-mcap [10, 20]
#   @mcap/core [10, 20, 30]
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install mcap==1.6.0 small-mcap==0.16.0 @mcap/core@2.2.2
observe python - <<'PY'
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from small_mcap import read_message

with open("four.mcap", "wb") as file:
    writer = Writer(file, compression=CompressionType.NONE)
    writer.start()
    schema = writer.register_schema("level", "jsonschema", b'{"type": "object"}')
    channel = writer.register_channel("/level", "json", schema)
    for when in (10, 20, 30, 40):
        writer.add_message(channel, when, b"{}", when)
    writer.finish()
with open("four.mcap", "rb") as file:
    print("mcap", [each.log_time for *_, each in make_reader(file).iter_messages(start_time=10, end_time=30)])
with open("four.mcap", "rb") as file:
    print("small-mcap", [each.log_time for *_, each in read_message(file, start_time_ns=10, end_time_ns=30)])
PY
cat >range.mjs <<'JS'
import { readFileSync } from "node:fs";
import { McapIndexedReader } from "@mcap/core";

const bytes = readFileSync("four.mcap");
const readable = {
  size: async () => BigInt(bytes.length),
  read: async (offset, length) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + length))),
};
const reader = await McapIndexedReader.Initialize({ readable });
const times = [];
for await (const message of reader.readMessages({ startTime: 10n, endTime: 30n })) times.push(Number(message.logTime));
console.log(`@mcap/core [${times.join(", ")}]`);
JS
observe node range.mjs
