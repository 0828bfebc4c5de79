// The lines of a Python program that ran in the scan shown. The server must run the program again up to that scan, so
// the page asks only after it has shown one scan for a while.

import { count } from "./format.js";
import { ask } from "./source.js";
import { onProgram, run } from "./state.js";

const STAY_MS = 250;

let answers = []; // { from, to, ran: [[scan, lines]...], departs }
let requests = 0, timer = 0;
let refusal = null; // { scan, text }

onProgram(() => {
  answers = [];
  refusal = null;
  requests++;
});

const answerOf = scan => answers.find(({ from, to }) => from <= scan && scan <= to);

// The lines that ran in the scan shown, and a sentence about them. There always is one, so that the text below does
// not jump.
export function ranLines() {
  if (run.ran?.length) return marks(run.ran); // traced for a breakpoint
  if (run.hello.shared) return noLines("");
  if (run.state === "live" || run.scan === undefined)
    return noLines("Pause, or go back, to see the lines that ran in a scan.");
  const answer = answerOf(run.scan);
  const departs = answer && answer.departs !== null && answer.departs <= run.scan;
  if (answer) return departs ? departedFrom(answer) : marks(linesIn(answer));
  if (refusal?.scan === run.scan) return noLines(`The lines that ran are not known: ${refusal.text}.`);
  return noLines("The lines that ran in this scan are being computed.");
}

const noLines = says => ({ lines: [], says });
const marks = lines => ({ lines, says: "A bar stands before each line that ran in this scan." });

const linesIn = ({ ran }) => ran.findLast(([scan]) => scan <= run.scan)[1];

const departedFrom = ({ departs }) =>
  noLines(
    "The lines that ran are not known: repeated with the recorded inputs, the program writes other words from scan " +
      `${count(departs)} on.`
  );

// Asks for the lines of the scan shown, once the page has shown it for a while; calls done() after the answer.
export function askRanLines(done) {
  clearTimeout(timer);
  if (run.state === "live" || run.scan === undefined || run.hello.shared || run.ran?.length) return;
  if (answerOf(run.scan) || refusal?.scan === run.scan) return;
  timer = setTimeout(async () => {
    const request = ++requests, { scan } = run;
    try {
      const answer = await ask("ran", {});
      if (request === requests) answers = [...answers, answer].slice(-8);
    } catch (refused) {
      if (request === requests) refusal = { scan, text: refused.message };
    }
    if (request === requests) done();
  }, STAY_MS);
}
