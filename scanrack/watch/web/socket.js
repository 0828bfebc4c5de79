// The connection to the server: first the key, then requests with their answers, and the messages of the rack.

import { read, written } from "./exact.js";

const RETRY_MS = [250, 500, 1000, 2000]; // waits between attempts; the last one is repeated
const SILENT_MS = 2000, GONE_MS = 10000; // without a message: probe the connection; take it as lost

const waiting = new Map(); // id -> [resolve, reject]
let socket = null, next = 1, attempts = 0, listener = null, heardAt = 0, probing = false;

// The error of a refused request; its message is the server's sentence. With `lost`, there was no connection
// or no answer.
export class Refused extends Error {}
const lostError = text => Object.assign(new Refused(text), { lost: true });

export function connect(key, listening) {
  listener = listening;
  const opened = new WebSocket(`ws://${location.host}/socket`);
  socket = opened;
  heardAt = performance.now();
  opened.onopen = () => { opened.send(JSON.stringify({ key })); };
  opened.onmessage = message => receive(read(message.data));
  opened.onclose = event => onClosed(key, event);
  opened.drop = () => {
    opened.drop = opened.onclose = opened.onmessage = null;
    opened.close();
    onClosed(key, {});
  };
}

// An interrupted network closes no socket: no message comes, and the picture would still look live. The probe is also
// sent while an answer takes long: in a pause there are no other messages.
setInterval(() => {
  const silent = performance.now() - heardAt;
  if (socket?.readyState === WebSocket.OPEN && silent > SILENT_MS && !probing) {
    probing = true;
    ask("here").catch(() => {}).finally(() => { probing = false; });
  }
  if (silent > GONE_MS) socket?.drop?.();
}, 1000);

function receive(message) {
  heardAt = performance.now();
  if (message.answer) return settle(message.answer);
  if (message.hello) attempts = 0;
  listener(message);
}

function settle(answer) {
  const [resolve, reject] = waiting.get(answer.id) ?? [];
  waiting.delete(answer.id);
  if (answer.refused !== undefined) reject?.(new Refused(answer.refused));
  else resolve?.(answer);
}

function onClosed(key, event) {
  socket = null;
  for (const [, reject] of waiting.values()) reject(lostError("The connection is lost."));
  waiting.clear();
  listener({ lost: event.reason || "The connection to the rack is lost; trying again." });
  const wait = RETRY_MS[Math.min(attempts++, RETRY_MS.length - 1)];
  if (event.code !== 1008 && event.code !== 4401) setTimeout(connect, wait, key, listener); // not for a wrong key
}

export const unanswered = () => waiting.size;

// Sends a request; resolves to the answer, or rejects with Refused.
export function ask(what, fields = {}) {
  return new Promise((resolve, reject) => {
    if (socket?.readyState !== WebSocket.OPEN) return reject(lostError("No connection to the rack."));
    const id = next++;
    waiting.set(id, [resolve, reject]);
    socket.send(written({ id, do: what, ...fields }));
  });
}
