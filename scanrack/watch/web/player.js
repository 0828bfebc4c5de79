// Plays a recording: looks at one scan after the other, as fast as they were, or faster.

import { lookAt } from "./scrub.js";
import { run } from "./state.js";

const TICK_MS = 40;

export const player = { speed: 1, playing: false };
let scan = 0, before = 0, over = () => {};

// Plays from the scan that is shown, or from the start after the end; calls ended() when nothing is left.
export function play(ended) {
  if (player.playing || !run.range) return;
  over = ended;
  player.playing = true;
  scan = run.scan >= run.range[1] ? run.range[0] : run.scan;
  before = performance.now();
  setTimeout(tick, TICK_MS);
}

export function rest() {
  player.playing = false;
}

function tick() {
  if (!player.playing || run.hello.kind !== "trace") return rest();
  const now = performance.now(), last = run.range[1];
  scan = Math.min(scan + (now - before) * 1e6 / run.hello.period_ns * player.speed, last);
  before = now;
  lookAt(scan);
  if (scan < last) return setTimeout(tick, TICK_MS);
  rest();
  over();
}
