// Opens a page in Firefox, by WebDriver BiDi, and does there what people do; prints what it saw as JSON.
//     node firefox_page.cjs FIREFOX LINK look|work
const puppeteer = require("puppeteer-core");

const state = () => ({ ...document.documentElement.dataset });
const wide = () => [document.documentElement.scrollWidth, innerWidth];

async function look(page, seen) {
  await page.setViewport({ width: 1280, height: 720 });
  await page.waitForFunction(() => document.documentElement.dataset.state === "live");
  await page.waitForSelector("[data-power='1'] > .wire");
  await page.locator("button[aria-label=Pause]").click();
  await page.waitForFunction(() => document.documentElement.dataset.state === "paused");
  await page.waitForFunction(() => !document.querySelector("button[aria-label=Step]").disabled);
  const before = Number((await page.evaluate(state)).scan);
  await page.locator("button[aria-label=Step]").click();
  await page.waitForFunction(scan => document.documentElement.dataset.scan === String(scan), {}, before + 1);
  await page.locator("[data-element='Main.7.2'] > .hit").click();
  await page.waitForFunction(() => document.querySelector("#tag .name")?.textContent);
  seen.tag = await page.$eval("#tag .name", each => each.textContent);
  await page.$eval("[aria-label='Scan shown']", each => { each.value = each.min; each.dispatchEvent(new Event("input", { bubbles: true })); });
  await page.waitForFunction(() => document.documentElement.dataset.state === "past");
  seen.least = await page.$eval("[aria-label='Scan shown']", each => each.min);
  await page.waitForFunction(scan => document.documentElement.dataset.scan === scan, {}, seen.least);
  await page.setViewport({ width: 400, height: 800 });
  await new Promise(rest => setTimeout(rest, 300));
  seen.wide = await page.evaluate(wide);
}

// With keys alone, of a session that pauses: an edit that is cancelled, a force that is removed, an answer that is run.
async function work(page, seen) {
  const press = async (...keys) => { for (const key of keys) await page.keyboard.press(key); };
  const step = scans => page.evaluate(count => import("/orders.js").then(orders => orders.step(count)), scans);
  const says = (selector, part) => page.waitForFunction(
    (where, text) => document.querySelector(where)?.textContent.includes(text), {}, selector, part);
  const tabTo = async name => {
    const focus = () => page.evaluate(() => document.activeElement.getAttribute("aria-label") ?? "");
    for (let tabs = 0; tabs < 30 && !(await focus()).startsWith(name); tabs++) await press("Tab");
    if (!(await focus()).startsWith(name)) throw new Error(`Tab does not reach ${name}`);
  };
  await step(1500);
  await page.waitForSelector("[data-element='Main.7.4'][data-power='1']");
  await press("F6", "F6");
  await tabTo("Edit");
  await press("Enter");
  await page.waitForSelector(".caret input:focus");
  await page.keyboard.type("XIO Trouble");
  await press("Enter");
  await page.waitForSelector("[aria-label='Accept edits']:enabled");
  await page.keyboard.down("Shift");
  await press("F6");
  await page.keyboard.up("Shift");
  await press("Enter");
  await page.waitForSelector("[aria-label='Test edits']:enabled:focus");
  await tabTo("Cancel edits");
  await press("Enter");
  await says(".verdict", "Nothing is edited");
  seen.drafts = await page.$$eval(".row.draft", rows => rows.length);
  await tabTo("Close edit");
  await press("Enter", "/");
  await page.keyboard.type("Awake");
  await press("Enter");
  await says("#tag .name", "Awake");
  await press("1", ".");
  await says(".readings", "Remove 1 force");
  await press("r", ".");
  await page.waitForFunction(() => !document.querySelector("[data-forced]"));
  await press("F6", "F6", "F6");
  await tabTo("Press E-stop");
  await press("Enter");
  await step(100);
  await press("/");
  await page.keyboard.type("Feeding");
  await press("Enter");
  await says("#tag .name", "Feeding");
  await press("g");
  await page.waitForSelector("#tag .answers button");
  seen.answer = await page.$eval("#tag .answer", each => each.textContent);
  await press("F6", "F6", "F6", "F6");
  await tabTo("Try:");
  await press("Enter");
  await says("#notice", "This is a branch");
  await page.waitForSelector("[data-name='Feeding'][data-value='1']"); // with the next frame
  seen.feeding = "1";
}

async function main(firefox, link, task) {
  const browser = await puppeteer.launch({ browser: "firefox", executablePath: firefox, headless: true });
  try {
    const page = await browser.newPage(), errors = [];
    page.on("console", each => { if (each.type() === "error") errors.push(each.text()); });
    page.on("pageerror", each => errors.push(String(each)));
    const seen = { errors };
    await page.goto(link);
    await page.waitForSelector("[data-element='Main.7.2']");
    await { look, work }[task](page, seen);
    console.log(JSON.stringify(seen));
  } finally {
    await browser.close();
  }
}

main(...process.argv.slice(2)).catch(error => { console.error(error); process.exitCode = 1; });
