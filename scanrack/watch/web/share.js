// The Share button: a page from a server saves the recording as one file; a shared page copies the link to its scan.

import { button } from "./dom.js";
import { count } from "./format.js";
import { link } from "./link.js";
import { tell } from "./notice.js";
import { share } from "./orders.js";
import { run } from "./state.js";

const write = button("Write a page to share", save, {
  text: "Share",
  title: "Write the recording, with this page, to one file that any browser opens",
});
const copy = button("Copy link", copied, { title: "Copy the link to this scan of this page" });

export const shareButton = () => run.hello.shared ? copy : write;

async function save() {
  write.disabled = true;
  tell("The page is being written.", "news");
  const shownScan = run.scan ?? 0, answer = await share();
  write.disabled = false;
  if (!answer) return;
  const content = Uint8Array.from(atob(answer.page), letter => letter.charCodeAt(0));
  const address = URL.createObjectURL(new Blob([content], { type: "text/html" }));
  Object.assign(document.createElement("a"), { href: address, download: answer.name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
  const last = answer.scan < shownScan ? ` It ends at scan ${count(answer.scan)}: the rest is not written yet.` : "";
  tell(
    `${answer.name} is in the browser's downloads. Everyone who gets it can read the program, its tags ` +
      `and words, and the events.${last}`,
    "news"
  );
}

async function copied() {
  link({ scan: run.scan });
  try {
    await navigator.clipboard.writeText(location.href);
    tell("The link is copied.", "news");
  } catch {
    tell(`The browser does not let this page copy; the link is ${location.href}`, "news");
  }
}
