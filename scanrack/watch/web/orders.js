// Orders change the run and are recorded with it. A refusal is shown; it changes nothing.

import { count } from "./format.js";
import { tell } from "./notice.js";
import { ask } from "./source.js";
import { run } from "./state.js";

export async function order(what, fields = {}) {
  try {
    return await ask(what, fields);
  } catch (refused) {
    tell(refused.message);
    return null;
  }
}

// What acts in the next scan; in a pause that one may be far away, so the page says so.
async function act(what, fields) {
  const answer = await order(what, fields);
  if (answer && run.state === "paused")
    tell(`Ordered: it acts before scan ${count(answer.scan)}, the next one.`, "news");
  return answer;
}

// An order that is given as the rack records it.
export const operate = ({ do: what, ...fields }) => act(what, fields);
export const mode = name => act("mode", { mode: name });
export const pause = () => order("pause");
export const go = () => order("go");
export const step = (scans = 1) => order("step", { scans });
export const speed = factor => order("speed", { factor });
export const press = (slot, name, on) => act("press", { slot, name, on });
export const write = (tag, value) => act("write", { tag, value });
export const force = (tag, value) => act("force", { tag, value });
export const unforce = tag => act("unforce", { tag });
export const incident = (kind, fields) => act("incident", { kind, ...fields });
export const branch = scan => order("branch", { scan });
export const reload = restart => order("reload", { restart });
export const share = () => order("share");
export const look = scan => order("look", { scan });

export const breakpoint = place =>
  order(run.breakpoints.includes(place) ? "unbreak" : "breakpoint", { at: place });

// Whether the page may change the run.
export const allowed = () => Boolean(run.hello) && !run.hello.read_only && run.hello.kind === "rack";

// Whether a recording is shown: time is the page's own.
export const recorded = () => run.hello?.kind === "trace";

// Whether time obeys: a real controller does not wait.
export const timed = () => allowed() && !run.hello.live_ports;
