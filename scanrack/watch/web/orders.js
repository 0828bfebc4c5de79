// Operator actions, which change the run and are recorded with it. A refused action changes nothing.

import { count } from "./format.js";
import { tell } from "./notice.js";
import { ask } from "./source.js";
import { run } from "./state.js";

export async function order(name, fields = {}) {
  try {
    return await ask(name, fields);
  } catch (refused) {
    tell(refused.message);
    return null;
  }
}

// Sends an action that takes effect before the next scan, and says so during a pause.
async function act(name, fields) {
  const answer = await order(name, fields);
  if (answer && run.state === "paused")
    tell(`It takes effect before the next scan, ${count(answer.scan)}.`, "news");
  return answer;
}

// Sends an action in the form of a trace.
export const operate = ({ do: name, ...fields }) => act(name, fields);
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

// Whether the page shows a trace, in which it moves freely.
export const recorded = () => run.hello?.kind === "trace";

// Whether the page controls time, which a real controller does not allow.
export const timed = () => allowed() && !run.hello.live_ports;
