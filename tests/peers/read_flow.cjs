// Reads the tags of the endpoint in a flow of Node-RED, as its node does, and prints them as JSON by program and name.
//
//     node read_flow.cjs FLOW PORT
const fs = require('fs');
const { Controller } = require('st-ethernet-ip');
process.env.ENIP_PORT = process.argv[3];
require('./enip_port.cjs');

async function main() {
  const endpoint = JSON.parse(fs.readFileSync(process.argv[2])).find((each) => each.type === 'eth-ip endpoint');
  const plc = new Controller();
  await plc.connect('127.0.0.1', Buffer.from([]));
  const found = {};
  for (const [program, tags] of Object.entries(endpoint.vartable)) {
    found[program] = {};
    for (const name of Object.keys(tags)) {
      const tag = plc.newTag(name, program || null);
      await plc.readTag(tag);
      found[program][name] = tag.value;
    }
  }
  console.log(JSON.stringify(found));
  process.exit(0);
}

main().catch((error) => { console.error(error); process.exit(1); });
