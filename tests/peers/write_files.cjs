// Writes data files of a controller at a port of this machine, and prints what it then reads.
const Pccc = require('nodepccc');
const client = new Pccc({ silent: true });
const written = { 'N7:4': 444, 'F8:2': 3.5, 'B3:2/5': true, 'L10:1': 70000, 'T4:0.PRE': 321 };
client.initiateConnection({ port: +process.argv[2], host: '127.0.0.1' }, (error) => {
  if (error) throw error;
  client.setTranslationCB((name) => name);
  client.addItems([...Object.keys(written), 'ST9:1']);
  client.writeItems(Object.keys(written), Object.values(written), (refused) => {
    if (refused) throw new Error('a write was refused');
    client.readAllItems((bad, values) => {
      if (bad) throw new Error(JSON.stringify(values));
      console.log(JSON.stringify(values));
      process.exit(0);
    });
  });
});
