// What the site's own search finds, best first: node site_search.mjs SITE, with questions as a JSON list on standard input.
import { readFileSync } from "node:fs";
import { createContext, runInContext } from "node:vm";

const site = process.argv[2];
const document = { addEventListener() {}, getElementById: () => null, documentElement: { dataset: {} }, readyState: "loading" };
const localStorage = { getItem: () => null, setItem() {}, removeItem() {} };
const browser = createContext({ document, localStorage, URLSearchParams, console });
browser.window = browser;
const scripts = ["_static/doctools", "_static/sphinx_highlight", "_static/language_data", "_static/searchtools", "searchindex"];
for (const name of scripts) runInContext(readFileSync(`${site}/${name}.js`, "utf8"), browser);
const ask = runInContext("text => Search._performSearch(...Search._parseQuery(text))", browser);
const questions = JSON.parse(readFileSync(0, "utf8"));
console.log(JSON.stringify(questions.map(text => ask(text).reverse().map(([page, , anchor]) => page + (anchor ?? "")))));
