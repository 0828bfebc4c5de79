// Reads and writes tags of a controller at a port of this machine. The package knows port 44818 only.
const net = require('net');
const { Controller } = require('st-ethernet-ip');
const port = +process.argv[2];
const connect = net.Socket.prototype.connect;
net.Socket.prototype.connect = function (...words) {
  const first = Array.isArray(words[0]) ? words[0][0] : words[0];
  if (first === 44818) words[0] = port;
  else if (first && first.port === 44818) first.port = port;
  return connect.apply(this, words);
};

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
