// Every function of modbus-serial at a drive: node drive_port.cjs PORT
const Modbus = require("modbus-serial"), client = new Modbus();
(async () => {
  await client.connectTCP("127.0.0.1", {port: +process.argv[2]});
  client.setID(1);
  await client.writeRegisters(1026, [1, 2]);
  await client.writeRegister(1026, 7);
  await client.maskWriteRegister(1028, 0, 9);
  const words = (await client.readHoldingRegisters(1024, 10)).data;
  await client.writeCoil(16384 + 64, true);
  await client.writeCoils(16384 + 64, [true, true]);
  const coils = (await client.readCoils(16384 + 64, 3)).data.slice(0, 3);
  const bits = (await client.readDiscreteInputs(0, 16)).data;
  const status = (await client.readInputRegisters(0, 1)).data[0];
  if (status !== bits.reduce((sum, bit, at) => sum + (bit ? 1 << at : 0), 0)) throw new Error("bits");
  console.log(JSON.stringify({words, coils, status}));
  process.exit(0);
})();
