// Reads a trace with other people's software and prints what it found as JSON:
//
//     node read_trace.cjs TRACE FIRST_NS LAST_NS
//
// @mcap/core follows the indexes from the footer to every message, checks the CRCs of chunks and
// summary, and reads the slice from FIRST_NS to LAST_NS once more, backwards; its other reader goes
// through the whole file record by record. Each scan is decoded by name by the decoders that Foxglove
// and Lichtblick use.

const fs = require("node:fs/promises");
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const fzstd = require("fzstd");

const DECOMPRESS = { zstd: (data, size) => fzstd.decompress(data, new Uint8Array(Number(size))) };
const DECODERS = ["@foxglove", "@lichtblick"];

class FileReadable {
  constructor(file) {
    this.file = file;
  }
  async size() {
    return BigInt((await this.file.stat()).size);
  }
  async read(offset, size) {
    const buffer = new Uint8Array(Number(size));
    const { bytesRead } = await this.file.read(buffer, 0, Number(size), Number(offset));
    if (bytesRead !== Number(size)) {
      throw new Error(`only ${bytesRead} of ${size} bytes at ${offset}`);
    }
    return buffer;
  }
}

function decoder(vendor, schema) {
  const { parse } = require(`${vendor}/rosmsg`);
  const { MessageReader } = require(`${vendor}/rosmsg2-serialization`);
  const text = new TextDecoder().decode(schema.data);
  const reader = new MessageReader(parse(text, { ros2: true }));
  return (data) => reader.readMessage(data);
}

// Reads the file from its beginning to its end, without the indexes; returns how many records there are.
async function records(path) {
  const stream = new McapStreamReader({ decompressHandlers: DECOMPRESS, validateCrcs: true });
  stream.append(await fs.readFile(path));
  const counts = {};
  for (let record; (record = stream.nextRecord()); ) {
    counts[record.type] = (counts[record.type] ?? 0) + 1;
  }
  if (!stream.done()) {
    throw new Error("the file ends in the midst of something");
  }
  return counts;
}

async function main(path, firstNs, lastNs) {
  const reader = await McapIndexedReader.Initialize({
    readable: new FileReadable(await fs.open(path)),
    decompressHandlers: DECOMPRESS,
  });
  const channel = [...reader.channelsById.values()].find((known) => known.topic === "/scan");
  const schema = reader.schemasById.get(channel.schemaId);
  const decoders = DECODERS.map((vendor) => decoder(vendor, schema));

  const counts = {};
  const scans = [];
  for await (const message of reader.readMessages()) {
    const { topic } = reader.channelsById.get(message.channelId);
    counts[topic] = (counts[topic] ?? 0) + 1;
    if (topic === "/scan") {
      const [logTime, sequence] = [Number(message.logTime), message.sequence];
      scans.push({ sequence, logTime, decoded: decoders.map((decode) => decode(message.data)) });
    }
  }
  const slice = [];
  const wanted = { topics: ["/scan"], startTime: BigInt(firstNs), endTime: BigInt(lastNs), reverse: true };
  for await (const message of reader.readMessages(wanted)) {
    slice.push(message.sequence);
  }
  const attachments = [];
  for await (const attachment of reader.readAttachments()) {
    attachments.push(attachment.name);
  }
  const metadata = {};
  for await (const record of reader.readMetadata()) {
    metadata[record.name] = Object.fromEntries(record.metadata);
  }
  const statistics = Number(reader.statistics.messageCount);
  const chunks = reader.chunkIndexes.length;
  const all = await records(path);
  process.stdout.write(JSON.stringify({ all, counts, statistics, chunks, scans, slice, attachments, metadata }));
}

main(...process.argv.slice(2));
