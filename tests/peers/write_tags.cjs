// Reads and writes tags of a controller at a port of this machine. The package knows port 44818 only.
const { Controller } = require('st-ethernet-ip');
process.env.ENIP_PORT = process.argv[2];
require('./enip_port.cjs');

async function main() {
  const plc = new Controller();
  await plc.connect('127.0.0.1', Buffer.from([]));
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

main().catch((error) => { console.error(error); process.exit(1); });
