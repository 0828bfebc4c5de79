"""What the page of `scanrack watch` reaches in a headless Chromium that draws in software.

    python benchmarks/watch_page.py [--seconds N] [--clicks N] [--scrubs N] [--scans N] [--smoke]
    python benchmarks/watch_page.py --against COMMIT [--turns N]    ratios to another commit, both in turns

The feeder in real time, scans of 2 ms, one page of 1600 by 1000:

    opens      from the start of the command to its link; from there to rungs, bits and rail
    frames     pictures a second that show another scan: the median of three windows; the longest gap of 95 %
    bytes      what the socket brings for such a page
    click      from a click on an input to the picture that shows its level
    scrub      from the slider to the picture of a scan of the last minute, rungs with their power
    processor  share of a core: the monitor with the page and without, the scan process, Chromium; in turns,
               medians of three
    far        from the slider to the picture of any of 300,000 scans, in a session at full speed that pauses
    recording  as `opens`, of the recording of that session, with marks; 1 s in all is wanted of 60 minutes:
               --trace FILE
    slow       on a line of 400 ms and 50 kB/s (by the browser): the first picture, the files before it, and
               their bytes with heads; the socket is another request
    share      processor time of `scanrack share` for 20,000 scans, 2 s are wanted; its first picture, 0.5 s
    edit       from a changed rung of a program of 1,000 to its verdict and its picture; 50 ms are wanted

What is shown is checked: each click has its picture, each scrub shows its scan, each edit its
mistakes. Without a browser or a driver the benchmark says so and ends.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from urllib.parse import urlsplit

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from bars import children_s
from watched_page import Look, Session, frames, open_browser, until, watching, why_not
from websockets.asyncio.client import connect

FEEDER = Path(__file__).parents[1] / "examples" / "feeder" / "feeder.toml"
SLOW = {"offline": False, "latency": 400, "downloadThroughput": 50_000, "uploadThroughput": 50_000}
READY = ("svg.rung [data-element]", "[data-name='1.MOVE_COMPLETE'][data-value]", "svg.rail .cart")

CLICKS = """
const [clicks, done] = arguments, took = [];
const button = document.querySelector("[data-name='1.input.external']");
const painted = () => new Promise(shown => requestAnimationFrame(shown));
for (let click = 0; click < clicks; click++) {
  const before = button.dataset.value, start = performance.now();
  button.click();
  while (button.dataset.value === before) await painted();
  took.push(performance.now() - start);
  await new Promise(rest => setTimeout(rest, 100 + 7 * (click % 13)));
}
done(took);
"""

EDITS = """
const [count, done] = arguments;
async function edits() {
const took = [];
const { begin, change, draft, keyOf, verdict } = await import("/draft.js");
await begin();
const rested = () => new Promise(later => setTimeout(later, 30));
for (let edit = 0; edit < count; edit++) {
  const rung = 7 * edit, wrong = edit % 2, key = keyOf("Main", rung);
  const start = performance.now();
  const text = `XIC(A${rung})XIC(${wrong ? "N" : "New"})OTE(A${rung + 1});`;
  change(rungs => { rungs.clear(); rungs.set(key, [text]); });
  if (verdict.dataset.kind !== "busy") throw new Error("the old verdict stays");
  while (verdict.dataset.kind === "busy") await new Promise(soon => setTimeout(soon, 1));
  took.push(performance.now() - start);
  const { svg, mistakes } = draft.checked.get(`${key}\\n0`);
  const fits = svg && mistakes.length === wrong && draft.right === !wrong;
  if (!fits) throw new Error(`${JSON.stringify(mistakes)} of edit ${edit}`);
  await rested();
}
return took;
}
edits().then(done, failed => done(String(failed)));
"""
"""Changes rungs; gives the times, ms, from each change to its verdict."""

SCRUBS = """
const [count, done] = arguments, took = [], root = document.documentElement;
const slider = document.querySelector("[aria-label='Scan shown']");
const painted = () => new Promise(shown => requestAnimationFrame(shown));
for (let scrub = 0; scrub < count; scrub++) {
  const least = Number(slider.min), most = Number(slider.max);
  const scan = Math.round(least + (most - least) * ((scrub * 0.618) % 1)), start = performance.now();
  slider.value = scan;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
  while (root.dataset.scan !== String(scan) || root.dataset.state !== "past") await painted();
  took.push(performance.now() - start);
}
done(took);
"""


FILES = """
const files = ["navigation", "resource"].flatMap(kind => performance.getEntriesByType(kind));
const sent = files.filter(each => !each.name.endsWith("icon.svg"));
return [sent.length, sent.reduce((sum, each) => sum + each.transferSize, 0)];
"""
"""Gives how many files were loaded, and their bytes; a browser loads the icon when the page is there."""

MARKED = "return document.documentElement.dataset.marks ?? null"

TURNS = 3
SETTLE_S = 1.0
FAR_PATIENCE_S = 300
SLIDER = "[aria-label='Scan shown']"


def processor_s(pid: int) -> float:
    """Return the processor time that a process has used, s; FileNotFoundError if it has ended."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def children(pid: int) -> list[int]:
    """Return a process' children and theirs."""
    own: list[int] = []
    with suppress(FileNotFoundError, ProcessLookupError):  # it ends meanwhile
        for task in Path(f"/proc/{pid}/task").glob("*/children"):
            own += map(int, task.read_text(encoding="utf-8").split())
    return [every for each in own for every in (each, *children(each))]


def shares(pids: list[int], seconds: float) -> list[float]:
    """Return the share of a core that each process uses for a while, %; 0 of one that ends meanwhile."""
    before = used_s(pids)
    start = time.monotonic()
    time.sleep(seconds)
    took = time.monotonic() - start
    after = used_s(pids)
    return [100 * (after[pid] - before.get(pid, 0)) / took if pid in after else 0.0 for pid in pids]


def used_s(pids: list[int]) -> dict[int, float]:
    """Return the processor time of those processes that live: Chromium ends helpers at any time."""
    found = {}
    for pid in pids:
        with suppress(FileNotFoundError, ProcessLookupError):
            found[pid] = processor_s(pid)
    return found


async def bytes_per_s(session: Session, seconds: float) -> float:
    """Return what the socket brings for a page that shows the routine Main."""
    link = urlsplit(session.link)
    async with connect(f"ws://{link.netloc}/socket", max_size=None) as socket:
        await socket.send(json.dumps({"key": link.fragment.removeprefix("key=")}))
        await socket.send(json.dumps({"id": 1, "do": "show", "routine": "Main", "columns": 120}))
        settled = time.monotonic() + 1
        while time.monotonic() < settled:
            await socket.recv()
        count, end = 0, time.monotonic() + seconds
        while time.monotonic() < end:
            count += len(await socket.recv())
    return count / seconds


def said(name: str, values: list[float], unit: str) -> None:
    values = sorted(values) or [float("nan")]  # two pictures in no window
    print(f"{name:10} {statistics.median(values):8.1f} {values[int(0.95 * (len(values) - 1))]:8.1f}  {unit}")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="What the page of scanrack watch reaches.")
    parser.add_argument("--seconds", type=float, default=10.0, help="length of a window")
    parser.add_argument("--clicks", type=int, default=50)
    parser.add_argument("--scrubs", type=int, default=50)
    parser.add_argument("--scans", type=int, default=300_000, help="scans of the session at full speed")
    parser.add_argument("--trace", type=Path, help="recording to open instead of that of the session")
    parser.add_argument("--against", metavar="COMMIT", help="print ratios to another commit")
    parser.add_argument("--turns", type=int, default=3, help="of either side, for --against")
    parser.add_argument("--turn", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    missing = why_not()
    if missing is not None:
        print(f"not measured: {missing}")
        return 0
    if given.against:
        return in_turns_with(given.against, given.turns, given.scans)
    if given.turn:
        given.turn.write_text(json.dumps(turn(given.trace, given.clicks, given.scrubs)), encoding="utf-8")
        return 0
    seconds, clicks, scrubs = (0.2, 3, 3) if given.smoke else (given.seconds, given.clicks, given.scrubs)
    with tempfile.TemporaryDirectory() as profile:
        browser = open_browser(Path(profile))
        try:
            measure(Look(browser), seconds, clicks, scrubs)
            measure_edits(Look(browser), 1_000, 6 if given.smoke else 40)
            print(f"slow       {'  '.join(f'{each:,.2f}' for each in slow(Look(browser)))}  s, files, bytes")
            measure_far(Look(browser), 2_000 if given.smoke else given.scans, scrubs, given.trace)
            measure_share(Look(browser), 500 if given.smoke else 20_000)
        finally:
            browser.quit()
    return 0


def measure_edits(look: Look, rungs: int, count: int) -> None:
    """Edit rungs of a large program in the page, with a new tag or a mistake each."""
    said(f"edit of {rungs:,} rungs", edits(look, rungs, count), "ms")


def edits(look: Look, rungs: int, count: int) -> list[float]:
    """Return the times from an edit to its verdict, ms."""
    with tempfile.TemporaryDirectory() as folder:
        rack = Path(folder) / "rack.toml"
        rack.write_text(
            'name = "large"\nprogram = "large.rung"\nscan_ms = 50\nwatchdog_ms = 0\n'
            '[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n',
            encoding="utf-8",
        )
        tags = "".join(f"TAG A{number} : BOOL\nTAG T{number} : TIMER\n" for number in range(rungs + 8))
        lines = (
            f"[XIC(A{number}),XIC(T{number}.DN)]XIO(A{number + 7})TON(T{number},1000,0)OTE(A{number + 1});\n"
            for number in range(rungs)
        )
        text = f"PROGRAM Large\nTAG N : DINT\n{tags}ROUTINE Main\n{''.join(lines)}END\n"
        (Path(folder) / "large.rung").write_text(text, encoding="utf-8")
        with watching(rack) as session:
            look.open(session.link)
            look.until_drawn()
            look.browser.set_script_timeout(120)
            took = look.browser.execute_async_script(EDITS, count)
            assert isinstance(took, list), took
            return took


def measure(look: Look, seconds: float, clicks: int, scrubs: int) -> None:
    look.look(1600, 1000)
    start = time.monotonic()
    with watching(FEEDER) as session:
        first_picture("opens", look, session.link, start)
        print("             median     95 %")
        windows = [frames(look, seconds) for _ in range(3)]
        rate = statistics.median(len(each) / seconds for each in windows)
        print(f"frames     {rate:8.1f}           pictures/s")
        said("gap", [1000 * (after - each) for times in windows for each, after in pairwise(times)], "ms")
        look.browser.set_script_timeout(120)
        took: list[float] = look.browser.execute_async_script(CLICKS, clicks)
        assert len(took) == clicks
        said("click", took, "ms")
        took = look.browser.execute_async_script(SCRUBS, scrubs)
        assert len(took) == scrubs
        said("scrub", took, "ms")
        look.press("Live")
        until(lambda: look.handle("state") == "live")
        print(f"bytes      {asyncio.run(bytes_per_s(session, seconds)) / 1000:8.1f}           kB/s")
        used, idle = in_turns(look, session, seconds)
        print(f"monitor    {used[0]:8.1f} {idle[0]:8.1f}  % of a core, with the page and without")
        print(f"scans      {used[1]:8.1f} {idle[1]:8.1f}  %, {used[1] / max(idle[1], 1e-9):.2f} times")
        print(f"chromium   {used[2]:8.1f}           %")


def in_turns(look: Look, session: Session, seconds: float) -> tuple[list[float], list[float]]:
    """Return the shares of monitor, scan process and browser with the page and without, by turns."""
    monitor, scans = children(session.process.pid)[0], session.process.pid
    used, idle = [], []
    for _ in range(TURNS):
        look.open(session.link)
        time.sleep(SETTLE_S)
        monitor_pct, scans_pct, *browser = shares(
            [monitor, scans, *children(look.browser.service.process.pid)], seconds
        )
        used.append((monitor_pct, scans_pct, sum(browser)))
        look.browser.get("about:blank")
        time.sleep(SETTLE_S)
        idle.append(tuple(shares([monitor, scans], seconds)))
    return [statistics.median(each) for each in zip(*used, strict=True)], [
        statistics.median(each) for each in zip(*idle, strict=True)
    ]


def first_picture(row: str, look: Look, link: str, start: float) -> None:
    """Open a link; print the time from the start to the link, and from there to the first picture."""
    linked = time.monotonic()
    look.open(link)
    for selector in READY:
        look.until_there(selector)
    print(f"{row:10} {linked - start:8.2f} {time.monotonic() - linked:8.2f}  s: link, page")


def measure_share(look: Look, scans: int) -> None:
    """Share a recording, and open the page."""
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder) / "run.mcap"
        for words in ("run", FEEDER, "--scans", scans, "--record", trace, "-q"), ("share", trace):
            before = children_s()
            command = [sys.executable, "-m", "scanrack", *map(str, words)]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            used = children_s() - before
        page, start = trace.with_suffix(".html"), time.monotonic()
        look.browser.get(page.as_uri())
        look.until_there(READY[0])
        took = time.monotonic() - start
        assert look.handle("scan") == str(scans - 1)
        print(f"share      {used:8.2f} {took:8.2f}  s: processor, page of {page.stat().st_size:,} bytes")


def measure_far(look: Look, scans: int, scrubs: int, trace: Path | None) -> None:
    """Scrub through a whole session of many scans; open its recording, or another one."""
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "session.mcap"
        with watching(FEEDER, "--time-scale", "max", "--record", record) as session:
            look.open(session.link)
            until(lambda: int(look.handle("scan") or 0) >= scans, FAR_PATIENCE_S)
            look.press("Pause")
            look.until_handle("state", "paused")
            took: list[float] = look.browser.execute_async_script(SCRUBS, scrubs)
            assert len(took) == scrubs
            last = look.run("return document.querySelector(arguments[0]).max", SLIDER)
            said("far", took, f"ms, any of {int(last):,} scans")
        start = time.monotonic()
        with watching(trace or record) as session:
            first_picture("recording", look, session.link, start)
            until(lambda: look.run(MARKED))
            print(f"marks      {'':8} {time.monotonic() - start:8.2f}  s: link, page and marks")


# --- beside another commit


def slow(look: Look) -> tuple[float, int, int]:
    """Return when the first picture is there on a slow line, s, the files before it, and their bytes."""
    browser = look.browser
    with watching(FEEDER) as session:
        browser.get("about:blank")
        browser.execute_cdp_cmd("Network.enable", {})
        browser.execute_cdp_cmd("Network.setCacheDisabled", {"cacheDisabled": True})
        browser.execute_cdp_cmd("Network.emulateNetworkConditions", SLOW)
        start = time.monotonic()
        browser.get(session.link)
        for selector in READY:
            look.until_there(selector)
        took = time.monotonic() - start
        files, sent = look.run(FILES)
        fast = {"offline": False, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
        browser.execute_cdp_cmd("Network.emulateNetworkConditions", fast)
    return took, files, sent


def turn(trace: Path, clicks: int, scrubs: int) -> dict[str, float]:
    """Return the figures of one side."""
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as profile:
        look = Look(open_browser(Path(profile)))
        try:
            found["slow, s"], found["files"], found["bytes"] = slow(look)
            look.browser.set_script_timeout(240)
            with watching(FEEDER) as session:
                look.open(session.link)
                for selector in READY:
                    look.until_there(selector)
                found["click, ms"] = statistics.median(look.browser.execute_async_script(CLICKS, clicks))
                found["scrub, ms"] = statistics.median(look.browser.execute_async_script(SCRUBS, scrubs))
            found["edit, ms"] = statistics.median(edits(look, 1_000, 20))
            start = time.monotonic()
            with watching(trace) as session:
                look.open(session.link)
                for selector in READY:
                    look.until_there(selector)
                if look.run("return Boolean(document.querySelector('canvas.mark-axis'))"):
                    until(lambda: look.run(MARKED))
                found["recording, s"] = time.monotonic() - start
        finally:
            look.browser.quit()
    return found


def in_turns_with(commit: str, turns: int, scans: int) -> int:
    """Measure this commit and another one in turns; print medians and ratios."""
    import against  # of this folder: it lays out another commit

    own = Path(__file__)
    with tempfile.TemporaryDirectory() as kept:
        folder = Path(kept)
        against.laid_out(against.archived(commit, folder / "source"), folder / "site")
        sides: dict[str, list[dict[str, float]]] = {str(folder / "site"): [], "": []}
        for turn_of, site in [(number, site) for number in range(turns) for site in sides]:
            environment = os.environ | ({"PYTHONPATH": site} if site else {})
            trace, result = (
                folder / f"{bool(site)}.mcap",
                folder / "turn.json",
            )  # each reads its own recordings
            if not turn_of:
                words = ["run", FEEDER, "--scans", scans, "--record", trace, "-q"]
                command = [sys.executable, "-m", "scanrack", *map(str, words)]
                subprocess.run(command, env=environment, cwd=folder, check=True)
            told = [sys.executable, str(own), "--turn", str(result), "--trace", str(trace)]
            subprocess.run([*told, "--clicks", "20", "--scrubs", "20"], env=environment, check=True)
            sides[site].append(json.loads(result.read_text(encoding="utf-8")))
    other, this = sides.values()
    print(f"{'':14} {'before':>10} {'now':>10} {'ratio':>6}   ratios of the turns")
    for name in this[0]:
        pairs = [(one[name], two[name]) for one, two in zip(other, this, strict=True)]
        before, now = (statistics.median(each) for each in zip(*pairs, strict=True))
        ratios = " ".join(f"{new / old:.2f}" for old, new in pairs)
        print(f"{name:14} {before:10,.2f} {now:10,.2f} {now / before:6.2f}   {ratios}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
