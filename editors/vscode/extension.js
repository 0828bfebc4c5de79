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

function activate(context) {
  context.subscriptions.push(
    vscode.debug.registerDebugAdapterDescriptorFactory("scanrack", { createDebugAdapterDescriptor: adapter }),
    vscode.workspace.onDidGrantWorkspaceTrust(begin),
    vscode.workspace.onDidChangeConfiguration((change) => change.affectsConfiguration("scanrack") && begin()));
  void begin(); // debugging does not wait for the language server
}

module.exports = { activate, deactivate: () => client?.stop() };
