// Reads the tags of a trace with @mcap/core and Foxglove's decoder and prints them as JSON, a scan after the other;
// with `whole` all of each scan:
//
//     node read_tags.cjs TRACE [whole]
//
// 64-bit integers are printed as text.

const fs = require("node:fs/promises");
const { McapIndexedReader } = require("@mcap/core");
const fzstd = require("fzstd");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

async function main(path, whole) {
  const data = await fs.readFile(path);
  const reader = await McapIndexedReader.Initialize({
    readable: {
      size: async () => BigInt(data.length),
      read: async (offset, size) => data.subarray(Number(offset), Number(offset + size)),
    },
    decompressHandlers: { zstd: (bytes, size) => fzstd.decompress(bytes, new Uint8Array(Number(size))) },
  });
  const channel = [...reader.channelsById.values()].find((each) => each.topic === "/scan");
  const text = new TextDecoder().decode(reader.schemasById.get(channel.schemaId).data);
  const decoder = new MessageReader(parse(text, { ros2: true }));
  const found = [];
  for await (const message of reader.readMessages({ topics: ["/scan"] })) {
    const scan = decoder.readMessage(message.data);
    found.push(whole ? scan : scan.tags);
  }
  const plain = (_, value) =>
    typeof value === "bigint" ? String(value) : ArrayBuffer.isView(value) ? [...value] : value;
  console.log(JSON.stringify(found, plain));
}

main(process.argv[2], process.argv[3] === "whole").catch((error) => {
  console.error(error.stack);
  process.exit(1);
});
