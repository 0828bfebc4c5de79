// Reads and writes tags over OPC UA as a user, encrypted; then tries it with less.
const { AttributeIds, DataType, MessageSecurityMode, OPCUAClient, SecurityPolicy, UserTokenType } = require('node-opcua-client');
const [url, userName, password] = process.argv.slice(2);

async function session(secure, identity, work) {
  const client = OPCUAClient.create({
    clientName: 'peer',
    endpointMustExist: false,
    connectionStrategy: { maxRetry: 0 },
    ...(secure && { securityMode: MessageSecurityMode.SignAndEncrypt, securityPolicy: SecurityPolicy.Basic256Sha256 }),
  });
  try {
    await client.connect(url);
    const open = await client.createSession(identity);
    const told = await work(open);
    await open.close();
    return told;
  } catch (error) {
    return /Bad\w+/.exec(error.message)?.[0] ?? error.message;
  } finally {
    await client.disconnect();
  }
}

async function main() {
  const ann = { type: UserTokenType.UserName, userName, password };
  const read = async (open, name) => (await open.read({ nodeId: `ns=2;s=${name}`, attributeId: AttributeIds.Value })).value.value;
  const told = { encrypted: await session(true, ann, async (open) => {
    const value = { dataType: DataType.Int32, value: 777 };
    const write = async (name) => (await open.write({ nodeId: `ns=2;s=${name}`, attributeId: AttributeIds.Value, value: { value } })).name;
    return { wrote: await write('aDint'), aDint: await read(open, 'aDint'), locked: await write('Locked') };
  }) };
  told.wrong = await session(true, { ...ann, password: 'wrong' }, (open) => read(open, 'aDint'));
  told.nobody = await session(true, undefined, (open) => read(open, 'aDint'));
  told.open = await session(false, ann, (open) => read(open, 'aDint'));
  console.log(JSON.stringify(told));
}

main().then(() => process.exit(0), (error) => { console.error(error); process.exit(1); });
