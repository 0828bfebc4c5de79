// A line for refusals and news, which does not move other parts of the page.

import { at } from "./dom.js";

const LASTS_MS = 8000;
const LASTING = ["lost", "mistake", "met", "branch"]; // kinds that stay until they are dismissed

let timer = 0;

at("notice").addEventListener("click", () => hush());

export function tell(text, kind = "refused", ...buttons) {
  const notice = at("notice");
  notice.replaceChildren(text, ...buttons);
  notice.dataset.kind = kind;
  clearTimeout(timer);
  if (!LASTING.includes(kind)) timer = setTimeout(hush, LASTS_MS);
}

export function hush(kind) {
  const notice = at("notice");
  if (kind && notice.dataset.kind !== kind) return;
  notice.replaceChildren();
  delete notice.dataset.kind;
}
