// Writes data files of a controller at a port of this machine one by one, and prints whether each was refused and what
// it then reads.
const Pccc = require('nodepccc');
const writes = Object.entries({
  'N7:4': 444, 'F8:2': 3.5, 'B3:2/5': true, 'L10:1': 70000, 'ST9:1': 'from node', 'T4:0.PRE': 321, 'C5:0.PRE': 7, 'R6:0.LEN': 5,
  'O:1': 6, 'I:1': 6, 'S:7': 3,
});
const told = {};

function next() {
  if (!writes.length) {
    console.log(JSON.stringify(told));
    process.exit(0);
  }
  const [name, value] = writes.shift();
  const client = new Pccc({ silent: true });
  client.initiateConnection({ port: +process.argv[2], host: '127.0.0.1' }, (error) => {
    if (error) throw error;
    client.setTranslationCB((each) => each);
    client.addItems([name]);
    client.writeItems([name], [value], (refused) => {
      client.readAllItems((bad, values) => {
        if (bad) throw new Error(JSON.stringify(values));
        told[name] = [refused, values[name]];
        client.dropConnection(next);
      });
    });
  });
}

next();
