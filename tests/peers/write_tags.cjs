// Reads and writes tags of a controller at a port of this machine, or with `list` lists tags and templates. The package
// knows port 44818 only.
const { Controller } = require('st-ethernet-ip');
process.env.ENIP_PORT = process.argv[2];
require('./enip_port.cjs');

async function main() {
  const plc = new Controller();
  await plc.connect('127.0.0.1', Buffer.from([]));
  if (process.argv[3] === 'list') list(plc.state.tagList);
  const told = { tags: plc.state.tagList.tags.filter((tag) => !/^Program:/.test(tag.name)).length };
  for (const [name, value] of [['aDint', 777], ['aReal', 1.25], ['Text', 'from node']]) {
    const tag = plc.newTag(name);
    await plc.readTag(tag);
    tag.value = value;
    await plc.writeTag(tag);
    const again = plc.newTag(name);
    await plc.readTag(again);
    told[name] = again.value;
  }
  const hosts = plc.newTag('Hosts');
  await plc.readTag(hosts);
  told.Go = hosts.value.Go;
  console.log(JSON.stringify(told));
  process.exit(0);
}

// Prints [name, code, dimensions] of tags, and templates by number with [name, info, code, offset] of members.
function list({ tags, templates }) {
  const code = (type) => type.code | (type.structure ? 0x8000 : 0) | (type.arrayDims << 13);
  const told = { tags: [], templates: {} };
  for (const { name, program, type } of tags)
    if (!/^Program:/.test(name)) told.tags.push([program ? `Program:${program}.${name}` : name, code(type), type.arrayDims]);
  for (const [number, each] of Object.entries(templates)) {
    const members = each._members.map(({ name, info, type, offset }) => [name, info, code(type), offset]);
    told.templates[number] = { name: each._name, size: each._attributes.StructureSize, members };
  }
  console.log(JSON.stringify(told));
  process.exit(0);
}

main().catch((error) => { console.error(error); process.exit(1); });
