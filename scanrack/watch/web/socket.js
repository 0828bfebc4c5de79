// The connection: the key first, then questions and orders with their answers, and what the rack sends.

import { read, written } from "./exact.js";

const RETRY_MS = [250, 500, 1000, 2000]; // waits between attempts, the last one over and over
const SILENT_MS = 2000, GONE_MS = 10000; // without a message: ask whether it is there; take it for lost

const waiting = new Map(); // id -> [resolve, reject]
let socket = null, next = 1, attempts = 0, listener = null, heard = 0, asks = false;

// What the server refuses comes as this error; its message is the server's sentence. `lost`: there was no connection
// or no answer.
export class Refused extends Error {}
const lost = text => Object.assign(new Refused(text), { lost: true });

export function connect(key, listening) {
  listener = listening;
  const opened = new WebSocket(`ws://${location.host}/socket`);
  socket = opened;
  heard = performance.now();
  opened.onopen = () => { opened.send(JSON.stringify({ key })); };
  opened.onmessage = message => hear(read(message.data));
  opened.onclose = event => closed(key, event);
  opened.gone = () => {
    opened.gone = opened.onclose = opened.onmessage = null;
    opened.close();
    closed(key, {});
  };
}

// A network that is cut closes no socket: nothing more comes, and the picture would look live. It is sent as well while
// an answer takes long: in a pause nothing else comes.
setInterval(() => {
  const silent = performance.now() - heard;
  if (socket?.readyState === WebSocket.OPEN && silent > SILENT_MS && !asks) {
    asks = true;
    ask("here").catch(() => {}).finally(() => { asks = false; });
  }
  if (silent > GONE_MS) socket?.gone?.();
}, 1000);

function hear(message) {
  heard = performance.now();
  if (message.answer) return answered(message.answer);
  if (message.hello) attempts = 0;
  listener(message);
}

function answered(answer) {
  const [resolve, reject] = waiting.get(answer.id) ?? [];
  waiting.delete(answer.id);
  if (answer.refused !== undefined) reject?.(new Refused(answer.refused));
  else resolve?.(answer);
}

function closed(key, event) {
  socket = null;
  for (const [, reject] of waiting.values()) reject(lost("The connection is lost."));
  waiting.clear();
  listener({ lost: event.reason || "The connection to the rack is lost; trying again." });
  const wait = RETRY_MS[Math.min(attempts++, RETRY_MS.length - 1)];
  if (event.code !== 1008 && event.code !== 4401) setTimeout(connect, wait, key, listener); // not for a wrong key
}

export const unanswered = () => waiting.size;

// Asks or orders something; the answer, or a Refused.
export function ask(what, fields = {}) {
  return new Promise((resolve, reject) => {
    if (socket?.readyState !== WebSocket.OPEN) return reject(lost("No connection to the rack."));
    const id = next++;
    waiting.set(id, [resolve, reject]);
    socket.send(written({ id, do: what, ...fields }));
  });
}
