// The controls for pause, continue, single scan and speed, of the rack or of a recording that the page plays.

import { button, el } from "./dom.js";
import { times } from "./format.js";
import * as orders from "./orders.js";
import { play, player, stop } from "./player.js";
import { goOn, moveBy } from "./scrub.js";
import { onHello, onPaint, run } from "./state.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, 60, "max"];
const FASTEST = 60; // times real time, for a recording

const pauseButton = button("Pause", pause, { text: "❚❚", title: "Pause (space)", class: "sign" });
const goButton = button("Continue", go, { text: "▶", title: "Continue (space)", class: "sign" });
const stepButton = button("Step", step, { text: "▶❘", title: "One scan (.)", class: "sign" });
const speedChoice = el("select", { "aria-label": "Speed", title: "Speed requested", change: chosen },
  ...SPEEDS.map(speed => el("option", { value: speed }, speed === "max" ? "max" : `${speed}×`)));
const node = el("div", { class: "transport", role: "group", "aria-label": "Time" },
  pauseButton, goButton, stepButton, speedChoice);

export const transport = () => node;

export const toggle = () => (run.state === "live" || player.playing ? pause() : go());

export function step() {
  if (orders.recorded() || run.state === "past") moveBy(1);
  else orders.step(1);
}

function pause() {
  if (!orders.recorded()) return orders.pause();
  stop();
  paint();
}

function go() {
  if (!orders.recorded()) return goOn();
  play(paint);
  paint();
}

function chosen() {
  const value = speedChoice.value, factor = value === "max" ? value : Number(value);
  if (orders.recorded()) player.speed = factor === "max" ? FASTEST : factor;
  else orders.speed(factor);
}

function paint() {
  const isControllable = orders.timed() || orders.recorded(), lost = run.state === "lost";
  // the rack may run while the page shows the past
  pauseButton.disabled = !isControllable || lost || (orders.recorded() ? !player.playing : run.paused);
  goButton.disabled = !isControllable || lost || (orders.recorded() ? player.playing : run.state === "live");
  stepButton.disabled = speedChoice.disabled = !isControllable || lost;
}

function paintSpeed(requested) {
  const choice = String(requested);
  if (![...speedChoice.options].some(option => option.value === choice)) {
    speedChoice.append(el("option", { value: choice }, times(requested)));
  }
  if (document.activeElement !== speedChoice) speedChoice.value = choice;
}

onHello(() => {
  stop();
  if (orders.recorded()) paintSpeed(player.speed);
  paint();
});

onPaint(({ speed }) => {
  if (speed && !orders.recorded()) paintSpeed(speed.requested);
  paint();
});
