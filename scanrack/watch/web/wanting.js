// The answers to What would it take: each has a button that runs it as a branch, compared with the past.
// The branch pauses when the tag has the value.

import { compareWith } from "./compare.js";
import { button, el } from "./dom.js";
import { capital, count, plain, sentence, timeText } from "./format.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { wait } from "./since.js";
import { ask } from "./source.js";
import { run } from "./state.js";
import { nameOf } from "./words.js";

const LOOK_MS = 50, PATIENCE_MS = 60000; // interval and limit of the wait until the branch has repeated the past

// The nodes of the answers, or of the reason why there are none.
export async function answersTo(tag, value) {
  try {
    const { scan, answers } = await ask("want", { tag, value });
    return [
      el("p", {}, `For ${nameOf(tag)} ${plain(value)} after scan ${count(scan)}:`),
      el("ul", { class: "answers" }, ...answers.map(each => el("li", {}, ...rowOf(each, scan)))),
    ];
  } catch (refused) {
    return [el("p", { class: "refused" }, sentence(refused.message))];
  }
}

// An answer without an action, or with one that the page cannot send, has no button.
function rowOf(answer, scan) {
  if (!answer.orders || !run.hello.branches) return [answer.text];
  const text = answer.acts.join(", then ") || "wait";
  return [
    button(`Try: ${text}`, () => attempt(answer, scan), {
      text: capital(text),
      title: "Run this as a branch, compared with the past",
    }),
    ` ${timeText(answer.after_ns)} later`,
  ];
}

async function attempt({ orders: steps, after_ns: after, text }, scan) {
  const parent = run.hello.record?.split("/").pop(), scansOf = ns => Math.ceil(ns / run.hello.period_ns);
  if (!await orders.order("branch", { scan: scan + 1, paused: true }) || !await arrived(scan)) return;
  let left = scansOf(after);
  for (const { wait_ns: wait, do: what, ...fields } of steps) {
    if (!wait && !await orders.order(what, fields)) return;
    const scans = Math.min(wait ? scansOf(wait) : 0, left);
    if (scans && !await orders.step(scans)) return;
    left -= scans;
  }
  if (left > 0 && !await orders.step(left)) return;
  if (parent) await compareWith(parent);
  tell(`${text}. This is a branch: ▶ continues it.`, "news");
}

// Waits until the branch is paused at its scan.
async function arrived(scan) {
  for (const end = performance.now() + PATIENCE_MS; performance.now() < end;) {
    if (run.hello?.kind === "rack" && run.state === "paused" && run.scan === scan) return ask("look", { scan: "live" });
    await wait(LOOK_MS);
  }
  tell("The branch did not reach its scan in time.");
  return null;
}
