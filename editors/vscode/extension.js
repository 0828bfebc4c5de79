// Starts `scanrack editor lsp` for rungs, structured text, steps, rack files and programs in Python.
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

async function activate(context) {
  context.subscriptions.push(
    vscode.workspace.onDidGrantWorkspaceTrust(begin),
    vscode.workspace.onDidChangeConfiguration((change) => change.affectsConfiguration("scanrack") && begin()));
  await begin();
}

module.exports = { activate, deactivate: () => client?.stop() };
