// Starts `scanrack editor lsp` for rungs, structured text, steps, rack files and programs in Python, and `scanrack debug`.
"use strict";

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const SUFFIXES = ["rung", "st", "steps", "toml", "py"];

let client;

/** Starts the server anew: with the command of the settings, and with what the folder's trust allows. */
async function begin() {
  await client?.stop();
  const [command, ...args] = vscode.workspace.getConfiguration("scanrack").get("command");
  client = new LanguageClient("scanrack", "scanrack", { command, args }, {
    documentSelector: SUFFIXES.map((suffix) => ({ scheme: "file", pattern: `**/*.${suffix}` })),
    initializationOptions: { trusted: vscode.workspace.isTrusted },
  });
  try {
    await client.start();
  } catch (error) {
    client = undefined;
    vscode.window.showWarningMessage(
      `scanrack: ${command} does not start (${error.message}). Install it with pip install ".[editor]" in a checkout of scanrack, ` +
        "or set scanrack.command to where it is.");
  }
}

/** Returns how the debug adapter is started: by the command of the language server, which names the installation. */
function adapter(session) {
  const [command] = vscode.workspace.getConfiguration("scanrack").get("command");
  const cwd = session.configuration.cwd ?? session.workspaceFolder?.uri.fsPath;
  return new vscode.DebugAdapterExecutable(command, ["debug"], { cwd });
}

const NAME = /[A-Za-z_][\w:\\]*(?:\.\w+|\[\d+\])*(?!\w*\()/g;

/** Names the tags in the lines of a routine up to the stop, whose values the editor then shows in them. */
function inlineValues(document, range, { stoppedLocation }) {
  const found = [];
  for (let line = range.start.line; line <= Math.min(range.end.line, stoppedLocation.end.line); line += 1) {
    for (const match of document.lineAt(line).text.replace(/(#|\/\/).*/, "").matchAll(NAME)) {
      const place = new vscode.Range(line, match.index, line, match.index + match[0].length);
      found.push(new vscode.InlineValueEvaluatableExpression(place, match[0]));
    }
  }
  return found;
}

const EDITS = { test: "Test", accept: "Accept", cancel: "Cancel" };

/** Shows or hides the buttons of an edit in the debug toolbar. */
const waits = (isEdited) => vscode.commands.executeCommand("setContext", "scanrack.edited", isEdited);

/** Tries, accepts or cancels the saved program of the rack that is debugged; the console says what came of it. */
async function edit(step) {
  try {
    await vscode.debug.activeDebugSession?.customRequest("evaluate", { expression: step, context: "repl" });
    await waits(step === "test");
  } catch (error) {
    vscode.window.showErrorMessage(`scanrack: ${error.message}`);
  }
}

/** Offers to try or accept a program that is saved while it is debugged. */
async function offer(document) {
  if (vscode.debug.activeDebugSession?.type !== "scanrack" || !["rung", "scanrack-st"].includes(document.languageId)) {
    return;
  }
  await waits(true);
  const choice = await vscode.window.showInformationMessage("The rack runs the program as it was before.", EDITS.test, EDITS.accept);
  const step = Object.keys(EDITS).find((each) => EDITS[each] === choice);
  if (step !== undefined) {
    await edit(step);
  }
}

function activate(context) {
  context.subscriptions.push(
    ...Object.keys(EDITS).map((step) => vscode.commands.registerCommand(`scanrack.${step}`, () => edit(step))),
    vscode.workspace.onDidSaveTextDocument(offer),
    vscode.debug.onDidTerminateDebugSession(() => waits(false)),
    vscode.debug.registerDebugAdapterDescriptorFactory("scanrack", { createDebugAdapterDescriptor: adapter }),
    vscode.languages.registerInlineValuesProvider(
      ["rung", "scanrack-st"], { provideInlineValues: (document, range, at) => inlineValues(document, range, at) }),
    vscode.workspace.onDidGrantWorkspaceTrust(begin),
    vscode.workspace.onDidChangeConfiguration((change) => change.affectsConfiguration("scanrack") && begin()));
  void begin(); // debugging does not wait for the language server
}

module.exports = { activate, deactivate: () => client?.stop() };
