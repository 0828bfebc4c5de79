// Connects the parts of the page.

import { button } from "./dom.js";
import { clocked } from "./format.js";
import { hush, tell } from "./notice.js";
import { allowed, reload } from "./orders.js";
import { connect } from "./source.js";
import { exchange, greet, setHandles, run, take } from "./state.js";
import "./layout.js";
import "./statebar.js";
import "./machine.js";
import "./strip.js";
import "./program.js";
import "./words.js";
import "./tag.js";
import "./watchtable.js";
import "./compare.js";
import "./events.js";
import * as panel from "./panel.js";
import "./keys.js";
import "./drag.js";
import { erred } from "./causeband.js";
import { caused } from "./failed.js";
import { explain } from "./tag.js";
import { taken, waits } from "./editing.js";
import { heard } from "./draft.js";
import { keyOf, requested } from "./link.js";
import { lookAt } from "./scrub.js";
import { showRung } from "./program.js";
import { paintMode } from "./statebar.js";

// Handlers of messages by kind.
const HANDLERS = {
  hello: hello => { hush(); greet(hello); follow(); },
  program: exchange,
  frame: frame => { if (run.state === "lost") hush("lost"); take(frame); },
  panel: panel.take,
  error: erred,
  online: heard,
  preview: waits,
  edited: edit => { taken(); tell(edited(edit), "news"); },
  mistake: mistake => mistake ? tell(mistaken(mistake), "mistake", ...restarting(mistake)) : hush("mistake"),
  note: note => tell(note, "news"),
  lost: text => { run.state = "lost"; setHandles(); paintMode(); tell(text, "lost"); },
};

function hear(message) {
  for (const [kind, content] of Object.entries(message)) HANDLERS[kind]?.(content);
}

// Returns the changes of tags by an edit, a line for each kind.
function edited({ text, ...tags }) {
  const groups = ["new", "changed", "dropped"].filter(name => tags[name]?.length);
  return [
    clocked(text) || "The edited program runs.",
    ...groups.map(name => `${name}: ${tags[name].join(", ")}`),
  ].join("\n");
}

function mistaken({ text, file, line }) {
  const place = [file, line].filter(Boolean).join(":");
  return `The old program continues. ${place && !text.includes(place) ? `${place}: ` : ""}${text}`;
}

// The button that accepts the program, and restarts the sequences that can't continue.
function restarting({ restart }) {
  if (!restart?.length || !allowed()) return [];
  return [button(`Take over, restart ${restart.join(", ")}`, () => reload(restart.join(",")))];
}

// Shows the scan and the rung of the link.
function follow() {
  const { scan, rung } = requested();
  if (rung) showRung(rung);
  if (scan !== null) lookAt(scan);
  const { failure } = run.hello;
  if (failure?.tag && !rung && (scan ?? failure.scan) === failure.scan) explain(failure.tag, caused);
}

// Another key belongs to another session at the same port.
const key = keyOf();
addEventListener("hashchange", () => { keyOf() === key ? follow() : location.reload(); });
connect(key, hear);
