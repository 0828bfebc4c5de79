// Runs the extension with a stand-in of VS Code, and prints what it does as JSON.
// Arguments: the extension, a file, the line of a stop (from 0).
"use strict";
const fs = require("node:fs");
const Module = require("node:module");

const [extension, file, line] = process.argv.slice(2);
const lines = fs.readFileSync(file, "utf-8").split("\n");
const requests = [], commands = {}, contexts = [];
let provider, saved, choice;

class Range {
  constructor(startLine, startCharacter, endLine, endCharacter) {
    this.start = { line: startLine, character: startCharacter };
    this.end = { line: endLine, character: endCharacter };
  }
}

const nothing = () => ({ dispose() {} });
const vscode = {
  Range,
  DebugAdapterExecutable: class {},
  InlineValueEvaluatableExpression: class {
    constructor(range, expression) { Object.assign(this, { range, expression }); }
  },
  workspace: {
    isTrusted: true, getConfiguration: () => ({ get: () => ["scanrack", "editor", "lsp"] }),
    onDidGrantWorkspaceTrust: nothing, onDidChangeConfiguration: nothing,
    onDidSaveTextDocument: (act) => { saved = act; return nothing(); },
  },
  window: { showWarningMessage: nothing, showErrorMessage: nothing, showInformationMessage: async () => choice },
  commands: {
    registerCommand: (name, act) => { commands[name] = act; return nothing(); },
    executeCommand: async (name, key, value) => contexts.push([name, key, value]),
  },
  languages: { registerInlineValuesProvider: (_languages, given) => { provider = given; return nothing(); } },
  debug: {
    registerDebugAdapterDescriptorFactory: nothing, onDidTerminateDebugSession: nothing,
    activeDebugSession: { type: "scanrack", customRequest: async (...words) => requests.push(words) },
  },
};
const load = Module._load;
Module._load = (name, ...more) => name === "vscode" ? vscode
  : name === "vscode-languageclient/node" ? { LanguageClient: class { async start() {} async stop() {} } } : load(name, ...more);

async function main() {
  require(extension).activate({ subscriptions: [] });
  const document = { lineAt: (number) => ({ text: lines[number] }), languageId: "rung" };
  const stop = { stoppedLocation: new Range(Number(line), 0, Number(line), 0) };
  const values = provider.provideInlineValues(document, new Range(0, 0, lines.length - 1, 0), stop);
  choice = "Test";
  await saved(document);
  choice = undefined;
  await saved(document);
  await saved({ languageId: "markdown" });
  await commands["scanrack.accept"]();
  const shown = values.map((each) => [each.range.start.line, each.range.start.character, each.expression]);
  console.log(JSON.stringify({ shown, requests, contexts, commands: Object.keys(commands) }));
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
