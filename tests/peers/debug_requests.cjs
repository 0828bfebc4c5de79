// Makes requests of a debug adapter with the test client of the protocol's makers, and prints the answers as JSON.
// Arguments: python, a file that runs the adapter, a file with rows and values (see debug_requests.toml).
"use strict";

let DebugClient;
try {
  ({ DebugClient } = require("@vscode/debugadapter-testsupport"));
} catch {
  process.exit(3);
}

const [python, adapter, table] = process.argv.slice(2);
const { rows, values } = JSON.parse(require("node:fs").readFileSync(table, "utf-8"));

/** Returns arguments with values in place of their names. */
function filled(given) {
  if (typeof given === "string") {
    return given.startsWith("$") ? values[given.slice(1)] : given;
  }
  if (given === null || typeof given !== "object") {
    return given;
  }
  return Array.isArray(given) ? given.map(filled) : Object.fromEntries(Object.entries(given).map(([key, each]) => [key, filled(each)]));
}

/** Returns what a path leads to. */
function at(body, path) {
  return path.reduce((value, step) => typeof step !== "object" ? value[step]
    : value.find((each) => Object.entries(step).every(([key, member]) => each[key] === member)), body);
}

async function main() {
  const client = new DebugClient(python, adapter, "scanrack");
  client.defaultTimeout = 60000;
  const answers = [];
  let printed = "";
  client.on("output", (event) => { printed += event.body.output; });
  await client.start();
  for (const { request, arguments: given, awaits, keep = {} } of rows) {
    printed = "";
    const answer = {};
    const sent = client.send(request, filled(given)).then(
      ({ body }) => { answer.body = body ?? {}; }, (error) => { answer.refused = error.message; });
    if (awaits) {
      answer.event = (await client.waitForEvent(awaits)).body ?? {};
    }
    await sent;
    answers.push(Object.assign(answer, { printed }));
    for (const [name, path] of Object.entries(keep)) {
      values[name] = at(answer.body, filled(path));
    }
  }
  console.log(JSON.stringify(answers));
  process.exit(0);
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
