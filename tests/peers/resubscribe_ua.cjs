// Subscribes to a tag and prints each value; at the end of its input, how often it asked for lost messages.
const { AttributeIds, OPCUAClient, TimestampsToReturn } = require('node-opcua-client');
const [url, name] = process.argv.slice(2);

async function main() {
  const asked = {};
  const client = OPCUAClient.create({
    clientName: 'peer',
    endpointMustExist: false,
    keepSessionAlive: true,
    connectionStrategy: { initialDelay: 100, maxDelay: 300, maxRetry: -1 },
  });
  client.on('send_request', (request) => {
    const kind = request.constructor.name;
    asked[kind] = (asked[kind] ?? 0) + 1;
  });
  await client.connect(url);
  const session = await client.createSession();
  const subscription = await session.createSubscription2({
    requestedPublishingInterval: 50,
    requestedLifetimeCount: 1000,
    requestedMaxKeepAliveCount: 20,
    publishingEnabled: true,
  });
  const item = await subscription.monitor(
    { nodeId: `ns=2;s=${name}`, attributeId: AttributeIds.Value },
    { samplingInterval: 0, discardOldest: true, queueSize: 10 },
    TimestampsToReturn.Both,
  );
  item.on('changed', (value) => console.log(JSON.stringify({ value: value.value.value })));
  process.stdin.resume();
  await new Promise((resolve) => process.stdin.on('end', resolve));
  console.log(JSON.stringify({ asked }));
}

main().then(() => process.exit(0), (error) => { console.error(error); process.exit(1); });
