// Puts the parts of the page together.

import { button } from "./dom.js";
import { clocked } from "./format.js";
import { hush, tell } from "./notice.js";
import { allowed, reload } from "./orders.js";
import { connect } from "./source.js";
import { exchange, greet, handles, run, take } from "./state.js";
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

function hear(message) {
  if (message.hello) {
    hush();
    greet(message.hello);
    follow();
  } else if (message.program) {
    exchange(message.program);
  } else if (message.frame) {
    if (run.state === "lost") hush("lost");
    take(message.frame);
  } else if (message.panel) {
    panel.take(message.panel);
  } else if (message.error) {
    erred(message.error);
  } else if (message.online) {
    heard(message.online);
  } else if ("preview" in message) {
    waits(message.preview);
  } else if (message.edited) {
    taken();
    tell(edited(message.edited), "news");
  } else if ("mistake" in message) {
    message.mistake ? tell(mistaken(message.mistake), "mistake", ...restarting(message.mistake)) : hush("mistake");
  } else if (message.note) {
    tell(message.note, "news");
  } else if (message.lost) {
    run.state = "lost";
    handles();
    paintMode();
    tell(message.lost, "lost");
  }
}

// What an edit has done to the tags, one line each.
function edited({ text, ...tags }) {
  const groups = ["new", "changed", "dropped"].filter(name => tags[name]?.length);
  return [
    clocked(text) || "The edited program has been taken over.",
    ...groups.map(name => `${name}: ${tags[name].join(", ")}`),
  ].join("\n");
}

function mistaken({ text, file, line }) {
  const place = [file, line].filter(Boolean).join(":");
  return `The old program continues. ${place && !text.includes(place) ? `${place}: ` : ""}${text}`;
}

// The button that takes the program over all the same, with the sequences that can't continue restarted.
function restarting({ restart }) {
  if (!restart?.length || !allowed()) return [];
  return [button(`Take over, restart ${restart.join(", ")}`, () => reload(restart.join(",")))];
}

// Opens what the link asks for.
function follow() {
  const { scan, rung } = requested();
  if (rung) showRung(rung);
  if (scan !== null) lookAt(scan);
  const { failure } = run.hello;
  if (failure?.tag && !rung && (scan ?? failure.scan) === failure.scan) explain(failure.tag, caused);
}

// Another key is the link of another session, which may have been started at the same port.
const key = keyOf();
addEventListener("hashchange", () => { keyOf() === key ? follow() : location.reload(); });
connect(key, hear);
