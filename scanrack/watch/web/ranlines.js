// The lines of a Python program that ran in the scan shown. The server runs the program again up to that scan, so
// the page asks for them once it stays at a scan.

import { ask } from "./source.js";
import { onProgram, run } from "./state.js";

const STAYS_MS = 250;

let known = []; // { from, to, ran: [[scan, lines]...], departs }
let asked = 0, timer = 0;
let refusal = null; // { scan, text }

onProgram(() => {
  known = [];
  refusal = null;
  asked++;
});

const answerOf = scan => known.find(({ from, to }) => from <= scan && scan <= to);

// The lines of the scan shown, and a sentence while they are not known.
export function ranLines() {
  if (run.ran?.length) return { lines: run.ran, says: "" }; // a breakpoint has traced them
  if (run.state === "live" || run.scan === undefined || run.hello.shared) return { lines: [], says: "" };
  const answer = answerOf(run.scan);
  if (answer) return answer.departs !== null && answer.departs <= run.scan ? departed(answer) : linesIn(answer);
  if (refusal?.scan === run.scan) return { lines: [], says: `The lines that ran are not known: ${refusal.text}.` };
  return { lines: [], says: "The lines that ran in this scan are being worked out." };
}

const linesIn = ({ ran }) => ({ lines: ran.findLast(([scan]) => scan <= run.scan)[1], says: "" });

const departed = ({ departs }) => ({
  lines: [],
  says:
    "The lines that ran are not known: run again on the recorded inputs, the program writes other words from scan " +
    `${departs.toLocaleString("en-US")} on.`,
});

// Asks for the lines of the scan shown, if the page stays at it; calls `done` when there is an answer.
export function askRanLines(done) {
  clearTimeout(timer);
  if (run.state === "live" || run.scan === undefined || run.hello.shared || run.ran?.length) return;
  if (answerOf(run.scan) || refusal?.scan === run.scan) return;
  timer = setTimeout(async () => {
    const mine = ++asked, { scan } = run;
    try {
      const answer = await ask("ran", {});
      if (mine === asked) known = [...known, answer].slice(-8);
    } catch (refused) {
      if (mine === asked) refusal = { scan, text: refused.message };
    }
    if (mine === asked) done();
  }, STAYS_MS);
}
