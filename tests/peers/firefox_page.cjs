// Opens a page in Firefox, by WebDriver BiDi, and does there what people do; prints what it saw as JSON.
//     node firefox_page.cjs FIREFOX LINK
const puppeteer = require("puppeteer-core");

const state = () => ({ ...document.documentElement.dataset });
const wide = () => [document.documentElement.scrollWidth, innerWidth];

async function main(firefox, link) {
  const browser = await puppeteer.launch({ browser: "firefox", executablePath: firefox, headless: true });
  try {
    const page = await browser.newPage(), errors = [];
    page.on("console", each => { if (each.type() === "error") errors.push(each.text()); });
    page.on("pageerror", each => errors.push(String(each)));
    const seen = { errors };
    await page.setViewport({ width: 1280, height: 720 });
    await page.goto(link);
    await page.waitForSelector("[data-element='Main.7.2']");
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
    console.log(JSON.stringify(seen));
  } finally {
    await browser.close();
  }
}

main(...process.argv.slice(2)).catch(error => { console.error(error); process.exitCode = 1; });
