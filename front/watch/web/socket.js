// The connection: the key first, then questions and orders with their answers, and what the rack sends.

import { read, written } from "./exact.js";

const RETRY_MS = [250, 500, 1000, 2000]; // waits between attempts, the last one over and over

const waiting = new Map(); // id -> [resolve, reject]
let socket = null, next = 1, attempts = 0, listener = null;

// What the server refuses comes as this error; its message is the server's sentence.
export class Refused extends Error {}

export function connect(key, heard) {
  listener = heard;
  const opened = new WebSocket(`ws://${location.host}/socket`);
  socket = opened;
  opened.onopen = () => { opened.send(JSON.stringify({ key })); };
  opened.onmessage = message => hear(read(message.data));
  opened.onclose = event => closed(key, event);
}

function hear(message) {
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
  for (const [, reject] of waiting.values()) reject(new Refused("The connection is lost."));
  waiting.clear();
  listener({ lost: event.reason || "The connection to the rack is lost; trying again." });
  const wait = RETRY_MS[Math.min(attempts++, RETRY_MS.length - 1)];
  if (event.code !== 1008 && event.code !== 4401) setTimeout(connect, wait, key, listener); // not for a wrong key
}

export const unanswered = () => waiting.size;

// Asks or orders something; the answer, or a Refused.
export function ask(what, fields = {}) {
  return new Promise((resolve, reject) => {
    if (socket?.readyState !== WebSocket.OPEN) return reject(new Refused("There is no connection to the rack."));
    const id = next++;
    waiting.set(id, [resolve, reject]);
    socket.send(written({ id, do: what, ...fields }));
  });
}
