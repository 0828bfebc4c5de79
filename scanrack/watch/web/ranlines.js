// The lines of a Python program that ran in the scan shown. The server runs the program again up to that scan, so
// the page asks for them once it stays at a scan.

import { count } from "./format.js";
import { ask } from "./source.js";
import { onProgram, run } from "./state.js";

const STAYS_MS = 250;

let known = []; // { from, to, ran: [[scan, lines]...], departs }
let requests = 0, timer = 0;
let refusal = null; // { scan, text }

onProgram(() => {
  known = [];
  refusal = null;
  requests++;
});

const answerOf = scan => known.find(({ from, to }) => from <= scan && scan <= to);

// The lines of the scan shown, and a sentence about them: it is there always, so that the text below does not jump.
export function ranLines() {
  if (run.ran?.length) return marked(run.ran); // a breakpoint has traced them
  if (run.hello.shared) return none("");
  if (run.state === "live" || run.scan === undefined)
    return none("Pause, or go back, to see the lines that ran in a scan.");
  const answer = answerOf(run.scan);
  if (answer) return answer.departs !== null && answer.departs <= run.scan ? departed(answer) : marked(linesIn(answer));
  if (refusal?.scan === run.scan) return none(`The lines that ran are not known: ${refusal.text}.`);
  return none("The lines that ran in this scan are being worked out.");
}

const none = says => ({ lines: [], says });
const marked = lines => ({ lines, says: "A bar stands before each line that ran in this scan." });

const linesIn = ({ ran }) => ran.findLast(([scan]) => scan <= run.scan)[1];

const departed = ({ departs }) =>
  none(
    "The lines that ran are not known: run again on the recorded inputs, the program writes other words from scan " +
      `${count(departs)} on.`
  );

// Asks for the lines of the scan shown, if the page stays at it; calls `done` when there is an answer.
export function askRanLines(done) {
  clearTimeout(timer);
  if (run.state === "live" || run.scan === undefined || run.hello.shared || run.ran?.length) return;
  if (answerOf(run.scan) || refusal?.scan === run.scan) return;
  timer = setTimeout(async () => {
    const mine = ++requests, { scan } = run;
    try {
      const answer = await ask("ran", {});
      if (mine === requests) known = [...known, answer].slice(-8);
    } catch (refused) {
      if (mine === requests) refusal = { scan, text: refused.message };
    }
    if (mine === requests) done();
  }, STAYS_MS);
}
