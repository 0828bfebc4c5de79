// Orders change the run and are recorded with it. A refusal is shown; it changes nothing.

import { tell } from "./notice.js";
import { ask } from "./socket.js";
import { run } from "./state.js";

export async function order(what, fields = {}) {
  try {
    return await ask(what, fields);
  } catch (refused) {
    tell(refused.message);
    return null;
  }
}

export const mode = name => order("mode", { mode: name });
export const pause = () => order("pause");
export const go = () => order("go");
export const step = (scans = 1) => order("step", { scans });
export const speed = factor => order("speed", { factor });
export const press = (slot, name, on) => order("press", { slot, name, on });
export const write = (tag, value) => order("write", { tag, value });
export const force = (tag, value) => order("force", { tag, value });
export const unforce = tag => order("unforce", { tag });
export const incident = (kind, fields) => order("incident", { kind, ...fields });
export const branch = scan => order("branch", { scan });
export const look = scan => order("look", { scan });

export const breakpoint = place =>
  order(run.breakpoints.includes(place) ? "unbreak" : "breakpoint", { at: place });

// Whether the page may change the run.
export const allowed = () => Boolean(run.hello) && !run.hello.read_only && run.hello.kind === "rack";

// Whether a recording is shown: time is the page's own.
export const recorded = () => run.hello?.kind === "trace";

// Whether time obeys: a real controller does not wait.
export const timed = () => allowed() && !run.hello.live_ports;
