// Since when a value is as it is. A source looks back a stretch at a time, and what is left is requested again.

import { ask } from "./source.js";

const AGAIN_MS = 300; // to wait for scans that are being worked out

export const wait = ms => new Promise(done => { setTimeout(done, ms); });

// Returns { scan, t, before } of the last change, null of none in any scan, undefined after another question.
// Calls lacks(from) with the first scan that was looked at as long as none was found.
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
