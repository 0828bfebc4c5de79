// Sends services of OPC UA as they are listed, and prints what comes back: a list of cases, each a list of steps.
const opcua = require('node-opcua-client');
const [url] = process.argv.slice(2);
const { AttributeIds, DataType, OPCUAClient, StatusCodes, Variant, VariantArrayType } = opcua;

const id = (name) => (/^(ns|i)=/.test(name) ? name : `ns=2;s=${name}`);
const times = (given) => (given ? new Date(Date.UTC(2020, 0, 1)) : null);
const named = (each) => ({
  nodeId: id(each.node),
  attributeId: each.attribute,
  indexRange: each.range || undefined,
  dataEncoding: each.encoding ? { namespaceIndex: 0, name: each.encoding } : undefined,
});

function variant(given) {
  if (given === null) return new Variant({ dataType: DataType.Null });
  const dataType = DataType[given.type];
  if (given.type === 'ByteString') return new Variant({ dataType, value: Buffer.from(given.value) });
  const isArray = Array.isArray(given.value);
  const arrays = { Int16: Int16Array, Int32: Int32Array };
  const value = isArray && given.type in arrays ? arrays[given.type].from(given.value) : given.value;
  if (given.dims) return new Variant({ dataType, arrayType: VariantArrayType.Matrix, dimensions: given.dims, value });
  return new Variant({ dataType, arrayType: isArray ? VariantArrayType.Array : undefined, value });
}

const written = (each) => ({
  ...named(each),
  value: {
    value: variant(each.value),
    statusCode: each.status ? StatusCodes[each.status] : undefined,
    sourceTimestamp: times(each.source),
    serverTimestamp: times(each.server),
  },
});

const plain = (value) => {
  if (ArrayBuffer.isView(value)) return Array.from(value);
  return Array.isArray(value) ? value.map(plain) : value ?? null;
};
const shown = (found) => ({
  status: found.statusCode.name,
  value: found.value ? plain(found.value.value) : null,
  dims: found.value?.dimensions ? plain(found.value.dimensions) : null,
  source: Boolean(found.sourceTimestamp),
  server: Boolean(found.serverTimestamp),
});
const browsed = (found) => ({
  status: found.statusCode.name,
  names: (found.references ?? []).map((each) => each.browseName.name ?? null),
  types: (found.references ?? []).map((each) => each.typeDefinition?.value ?? 0),
  more: Boolean(found.continuationPoint?.length),
});

const SERVICES = {
  read: (step) => [new opcua.ReadRequest({
    maxAge: step.age, timestampsToReturn: step.timestamps, nodesToRead: step.nodes.map(named),
  }), (response) => (response.results ?? []).map(shown)],
  write: (step) => [new opcua.WriteRequest({ nodesToWrite: step.nodes.map(written) }),
    (response) => (response.results ?? []).map((each) => each.name)],
  browse: (step) => [new opcua.BrowseRequest({
    view: { viewId: step.view ? id(step.view) : undefined },
    requestedMaxReferencesPerNode: step.most,
    nodesToBrowse: step.nodes.map((each) => ({
      nodeId: id(each.node), browseDirection: each.direction, referenceTypeId: id(each.type), includeSubtypes: each.subtypes,
      nodeClassMask: each.classes, resultMask: each.fields,
    })),
  }), (response) => (response.results ?? []).map(browsed)],
  next: (step, points) => [new opcua.BrowseNextRequest({
    releaseContinuationPoints: step.release,
    continuationPoints: step.points.map((each) => points[each] ?? Buffer.from('none')),
  }), (response) => (response.results ?? []).map(browsed)],
  translate: (step) => [new opcua.TranslateBrowsePathsToNodeIdsRequest({
    browsePaths: step.paths.map((each) => ({
      startingNode: id(each.node),
      relativePath: { elements: each.names.map((name) => ({
        referenceTypeId: 'i=33', isInverse: step.inverse, includeSubtypes: true,
        targetName: name ? { namespaceIndex: 2, name } : undefined,
      })) },
    })),
  }), (response) => (response.results ?? []).map(
    (each) => [each.statusCode.name, ...(each.targets ?? []).map((target) => target.targetId.value)])],
  subscribe: (step) => [new opcua.CreateSubscriptionRequest({
    requestedPublishingInterval: 50, publishingEnabled: true,
    requestedLifetimeCount: step.lifetime, requestedMaxKeepAliveCount: step.alive,
  }), (response, points) => {
    points.subscription = response.subscriptionId;
    return [response.revisedLifetimeCount, response.revisedMaxKeepAliveCount];
  }],
  items: (step, points) => [new opcua.CreateMonitoredItemsRequest({
    subscriptionId: step.other ? 4711 : points.subscription,
    timestampsToReturn: step.timestamps,
    itemsToCreate: step.nodes.map((each) => ({
      itemToMonitor: named(each), monitoringMode: 2, requestedParameters: { clientHandle: 7, queueSize: 1, filter: filter(step) },
    })),
  }), (response, points) => {
    points.items = (response.results ?? []).map((each) => each.monitoredItemId);
    return (response.results ?? []).map((each) => each.statusCode.name);
  }],
  modify: (step, points) => [new opcua.ModifyMonitoredItemsRequest({
    subscriptionId: step.other ? 4711 : points.subscription,
    timestampsToReturn: step.timestamps,
    itemsToModify: step.items.map((each) => ({
      monitoredItemId: each < 0 ? 4711 : points.items[each], requestedParameters: { clientHandle: 7, queueSize: 1 },
    })),
  }), (response) => (response.results ?? []).map((each) => each.statusCode.name)],
  publish: (step, points) => [new opcua.PublishRequest({
    subscriptionAcknowledgements: step.acknowledge.map((each) => ({
      subscriptionId: step.other ? 4711 : points.subscription, sequenceNumber: each,
    })),
  }), (response) => [(response.results ?? []).map((each) => each.name), ...changed(response.notificationMessage)]],
  republish: (step, points) => [new opcua.RepublishRequest({
    subscriptionId: step.other ? 4711 : points.subscription, retransmitSequenceNumber: step.number,
  }), (response) => changed(response.notificationMessage)],
};
const filter = (step) => (step.deadband
  ? new opcua.DataChangeFilter({ trigger: 1, deadbandType: step.deadband[0], deadbandValue: step.deadband[1] })
  : null);
const changed = (message) => (message.notificationData ?? [])
  .flatMap((each) => each?.monitoredItems ?? []).map((each) => shown(each.value));

async function run(session, steps) {
  const points = {}, found = [];
  for (const step of steps) {
    const [request, results] = SERVICES[step.service](step, points);
    found.push(await new Promise((resolve) => session.performMessageTransaction(request, (error, response) => {
      if (error) return resolve(/Bad\w+/.exec(error.message)?.[0] ?? error.message);
      (response.results ?? []).forEach((each, at) => {
        if (each?.continuationPoint?.length) points[`${found.length}.${at}`] = each.continuationPoint;
      });
      return resolve(results(response, points));
    })));
  }
  return found;
}

async function main() {
  let text = '';
  for await (const piece of process.stdin) text += piece;
  const told = [];
  for (const steps of JSON.parse(text)) {
    const client = OPCUAClient.create({ clientName: 'peer', endpointMustExist: false, connectionStrategy: { maxRetry: 0 } });
    await client.connect(url);
    const session = await client.createSession();
    told.push(await run(session, steps));
    await session.close();
    await client.disconnect();
  }
  console.log(JSON.stringify(told));
}

main().then(() => process.exit(0), (error) => { console.error(error); process.exit(1); });
