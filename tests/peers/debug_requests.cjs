// Makes every request of a debug adapter with the test client of the protocol's makers, and prints what came of it.
// Arguments: python, a file that runs the adapter, the requests as JSON, launch arguments, a file, its line, a tag.
"use strict";

let DebugClient;
try {
  ({ DebugClient } = require("@vscode/debugadapter-testsupport"));
} catch {
  process.exit(3);
}

const [python, adapter, wanted, launch, file, line, tag] = process.argv.slice(2);
const source = { path: file };
const told = {};

async function main() {
  const client = new DebugClient(python, adapter, "scanrack");
  client.defaultTimeout = 60000;
  await client.start();

  async function ask(command, args) {
    const answer = await client.send(command, args);
    told[command] = answer.body ?? {};
    return told[command];
  }

  /** Makes a request that moves, and returns the stop that follows it. */
  async function move(command) {
    const [stop] = await Promise.all([client.waitForEvent("stopped"), ask(command, { threadId: 1 })]);
    told[`${command}:stop`] = stop.body;
  }

  await ask("initialize", { adapterID: "scanrack", linesStartAt1: true, columnsStartAt1: true, pathFormat: "path" });
  await Promise.all([client.waitForEvent("initialized"), ask("launch", JSON.parse(launch))]);
  await ask("setBreakpoints", { source, breakpoints: [{ line: Number(line) }] });
  await ask("setExceptionBreakpoints", { filters: ["fault"] });
  await ask("breakpointLocations", { source, line: 1, endLine: 1000 });
  await Promise.all([client.waitForEvent("stopped"), ask("configurationDone")]);
  await ask("threads");
  await move("continue");
  await move("continue");
  const { stackFrames } = await ask("stackTrace", { threadId: 1 });
  const { scopes } = await ask("scopes", { frameId: stackFrames[0].id });
  for (const each of scopes) {
    await ask("variables", { variablesReference: each.variablesReference });
  }
  await ask("evaluate", { expression: tag, context: "hover", frameId: stackFrames[0].id });
  await ask("completions", { text: tag.slice(0, 2), column: 3 });
  await ask("dataBreakpointInfo", { name: tag });
  await ask("exceptionInfo", { threadId: 1 });
  await ask("loadedSources");
  for (const command of ["next", "stepIn", "stepOut", "stepBack", "reverseContinue"]) {
    await move(command);
  }
  await ask("setDataBreakpoints", { breakpoints: [{ dataId: tag }] });
  await ask("setFunctionBreakpoints", { breakpoints: [{ name: `${tag} changes` }] });
  await ask("setBreakpoints", { source, breakpoints: [] });
  if (!JSON.parse(launch).program.endsWith(".mcap")) {
    await client.send("continue", { threadId: 1 }).catch(() => {}); // the past asks once
    await move("continue");
    await ask("setDataBreakpoints", { breakpoints: [] });
    await ask("setFunctionBreakpoints", { breakpoints: [] });
    const refused = (command) => (error) => { told[command] = { refused: error.message }; }; // a function's values
    await ask("setVariable", { variablesReference: await scopeOf(ask, tag), name: tag, value: "1" }).catch(refused("setVariable"));
    await ask("setExpression", { expression: tag, value: "0" }).catch(refused("setExpression"));
    await ask("continue", { threadId: 1 });
    await move("pause");
  }
  await ask("terminate");
  console.log(JSON.stringify(told));
  process.exit(0);
}

/** Returns the number of the scope that has a tag. */
async function scopeOf(ask, tag) {
  const { stackFrames } = await ask("stackTrace", { threadId: 1 });
  const { scopes } = await ask("scopes", { frameId: stackFrames[0].id });
  for (const { name, variablesReference } of scopes) {
    const { variables } = await ask("variables", { variablesReference });
    if (name.startsWith("Tags") && variables.some((each) => each.name === tag)) {
      return variablesReference;
    }
  }
  throw new Error(`no scope has ${tag}`);
}

main().catch((error) => {
  console.error(error, JSON.stringify(told));
  process.exit(1);
});
