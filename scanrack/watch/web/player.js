// Plays a recording: shows its scans one after another, at the speed at which they ran, or at another.

import { lookAt } from "./scrub.js";
import { run } from "./state.js";

const TICK_MS = 40;

export const player = { speed: 1, playing: false };
let scan = 0, lastTick = 0, onEnd = () => {};

// Plays from the scan that is shown, or from the start if that is the last one; calls ended() at the end.
export function play(ended) {
  if (player.playing || !run.range) return;
  onEnd = ended;
  player.playing = true;
  scan = run.scan >= run.range[1] ? run.range[0] : run.scan;
  lastTick = performance.now();
  setTimeout(tick, TICK_MS);
}

export function stop() {
  player.playing = false;
}

function tick() {
  if (!player.playing || run.hello.kind !== "trace") return stop();
  const now = performance.now(), last = run.range[1];
  scan = Math.min(scan + (now - lastTick) * 1e6 / run.hello.period_ns * player.speed, last);
  lastTick = now;
  lookAt(scan);
  if (scan < last) return setTimeout(tick, TICK_MS);
  stop();
  onEnd();
}
