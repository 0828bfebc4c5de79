// Since when a tag has its value. The source looks back a stretch of scans at a time; the page asks until it has found
// the change.

import { ask } from "./source.js";

const AGAIN_MS = 300; // wait for scans that are being computed

export const wait = ms => new Promise(done => { setTimeout(done, ms); });

// Returns { scan, t, before } of the last change, null if there was none in any scan, undefined if the answer is no
// longer requested.
// Calls lacks(from) with the first scan that was searched, as long as no change was found.
/** @param {(from: number) => void} [lacks] */
export async function lastChange(tag, requested, lacks = () => {}) {
  let from;
  for (;;) {
    const answer = await ask("since", from === undefined ? { tag } : { tag, from });
    if (!requested()) return undefined;
    if (answer.since || typeof answer.from !== "number") return answer.since;
    lacks(answer.from);
    if (answer.from === from) await wait(AGAIN_MS);
    from = answer.from;
  }
}
