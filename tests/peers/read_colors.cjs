// Colors files as VS Code does: prints [line, text, innermost scope] of each token as JSON.
// Status 3: a package of npm is missing.
// node read_colors.cjs GRAMMAR_FOLDER SCOPE FILE...
"use strict";
const fs = require("node:fs");
const path = require("node:path");

const MISSING = 3;
let textmate, oniguruma;
try {
  textmate = require("vscode-textmate");
  oniguruma = require("vscode-oniguruma");
} catch (error) {
  process.exit(MISSING);
}

const [folder, scope, ...files] = process.argv.slice(2);
const grammars = {};
for (const name of fs.readdirSync(folder)) {
  const file = path.join(folder, name);
  const grammar = textmate.parseRawGrammar(fs.readFileSync(file, "utf8"), file);
  grammars[grammar.scopeName] = grammar;
}

async function main() {
  await oniguruma.loadWASM(fs.readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm")).buffer);
  const library = {
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  };
  const registry = new textmate.Registry({
    onigLib: Promise.resolve(library), loadGrammar: async (name) => grammars[name] });
  const grammar = await registry.loadGrammar(scope);
  const tokens = [];
  for (const file of files) {
    let stack = textmate.INITIAL;
    fs.readFileSync(file, "utf8").split("\n").forEach((line, number) => {
      const found = grammar.tokenizeLine(line, stack);
      stack = found.ruleStack;
      for (const each of found.tokens) {
        const text = line.slice(each.startIndex, each.endIndex);
        if (text.trim()) tokens.push([number + 1, text, each.scopes.at(-1)]);
      }
    });
  }
  console.log(JSON.stringify(tokens));
}

main();
