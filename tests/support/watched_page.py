"""`scanrack watch` in a process of its own, and Chromium with the distribution's driver looking at it."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import scanrack.watch.command
import scanrack.watch.server  # noqa: F401  # each process would import it
from forked import start

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")
PATIENCE_S = 120
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1600,1000",
)


def why_not() -> str | None:
    """Return why no browser can be driven here; None if one can."""
    if BROWSER is None:
        return "no Chromium is installed"
    if DRIVER is None:
        return "chromedriver is not installed (Debian: chromium-driver)"
    try:
        import selenium  # noqa: F401
    except ImportError:
        return "selenium is not installed"
    return None


def open_browser(profile: Path) -> Any:
    """Return a Chromium that has loaded nothing yet.

    Args:
        profile: an empty folder for its files.
    """
    from selenium.webdriver import Chrome
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service

    options = Options()
    options.binary_location = BROWSER or ""
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return Chrome(options, Service(DRIVER))


class Session:
    """A `scanrack watch` that runs.

    Attributes:
        link: what it has printed first.
    """

    def __init__(self, process: subprocess.Popen[str], link: str) -> None:
        self.process = process
        self.link = link

    @property
    def base(self) -> str:
        """The address without the key."""
        return f"http://{urlsplit(self.link).netloc}"

    def end(self) -> int:
        """End it as Ctrl-C does; return its exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(PATIENCE_S)


@contextmanager
def watching(*words: object) -> Iterator[Session]:
    """Run `scanrack watch` with these words as long as the context lasts."""
    command = [
        sys.executable,
        "-c",
        "import sys; from scanrack.commands import main; sys.exit(main())",
        "watch",
    ]
    process = start([*command, *words], stdout=subprocess.PIPE, text=True, encoding="utf-8")
    assert process.stdout is not None
    try:
        link = process.stdout.readline().split(" ")[0]
        assert link.startswith("http://"), link
        yield Session(process, link)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()


def until(holds: Callable[[], Any], patience_s: float = PATIENCE_S) -> Any:
    """Wait until something holds, and return it."""
    give_up = time.monotonic() + patience_s
    while not (found := holds()):
        assert time.monotonic() < give_up, "it has not become true in time"
        time.sleep(0.02)
    return found


def steadily(action: Callable[[], Any]) -> Any:
    """Return what an action returns; do it again if the page has exchanged an element meanwhile."""
    from selenium.common.exceptions import StaleElementReferenceException

    give_up = time.monotonic() + PATIENCE_S
    while True:
        try:
            return action()
        except StaleElementReferenceException:
            assert time.monotonic() < give_up, "the page does not come to rest"


class Look:
    """The page as a script sees it: the handles of docs/watch-socket.md and nothing else.

    Args:
        browser: a driver.
    """

    def __init__(self, browser: Any) -> None:
        self.browser = browser

    def open(self, link: str, *, paused: bool = False) -> None:
        """Open a link and wait for the first picture of the rack.

        Args:
            paused: before its first scan, of which there is no picture.
        """
        self.browser.get("about:blank")
        self.browser.get(link)
        until(lambda: self.handle("state") == "paused" if paused else self.handle("scan") is not None)

    def open_at(self, session: Session, scans: int) -> None:
        """Open the page of a session that pauses before its first scan, and run so many scans."""
        self.open(session.link, paused=True)
        self.step(scans)
        self.until_scan(scans - 1, "paused")
        self.until_drawn()

    def step(self, scans: int) -> None:
        """Run so many scans: by the button if it is one, else as the button does it."""
        if scans == 1:
            self.press("Step")
        else:
            self.run("import('/orders.js').then(orders => orders.step(arguments[0]))", scans)

    def panel(self, name: str) -> None:
        """Bring a list to the front: events, watch or words."""
        self.run("return import('/layout.js').then(layout => layout.showPanel(arguments[0]))", name)

    def watch(self, tag: str) -> None:
        """Put a tag into the watch table."""
        self.panel("watch")
        field = self.control("Tag to watch")
        field.send_keys(tag)
        self.press("Add to watch table")

    def run(self, script: str, *given: object) -> Any:
        """Run a script in the page."""
        return self.browser.execute_script(script, *given)

    def handle(self, name: str) -> str | None:
        """Return a handle of the whole page: scan, mode, time-ns, late, speed or state."""
        found: str | None = self.run(f"return document.documentElement.getAttribute('data-{name}')")
        return found

    def value(self, name: str) -> str | None:
        """Return the value that is shown of a name."""
        found: str | None = self.run(
            "const found = document.querySelector(`[data-name='${CSS.escape(arguments[0])}']`);"
            "return found?.dataset.value ?? null",
            name,
        )
        return found

    def power(self) -> dict[str, str]:
        """Return the power of all elements that are shown."""
        found: dict[str, str] = self.run(
            "return Object.fromEntries([...document.querySelectorAll('[data-element]')]"
            ".map(each => [each.dataset.element, each.dataset.power]))"
        )
        return found

    def control(self, name: str) -> Any:
        """Return the control with an accessible name."""
        return steadily(lambda: self._control(name))

    def _control(self, name: str) -> Any:
        found: list[Any] = self.run(CALLED, name)
        for each in found:
            if each.accessible_name == name:
                return each
        raise AssertionError(f"no control is called {name}")

    def until_handle(self, name: str, wanted: str) -> None:
        """Wait until a handle of the whole page is as wanted."""
        until(lambda: self.handle(name) == wanted)

    def until_value(self, name: str, wanted: str) -> None:
        """Wait until the page shows this value of a name."""
        until(lambda: self.value(name) == wanted)

    def until_power(self, wanted: dict[str, str]) -> None:
        """Wait until the page shows this power."""
        until(lambda: self.power() == wanted)

    def until_scan(self, scan: int, state: str) -> None:
        """Wait until the page shows a scan, in a state."""
        until(lambda: (self.handle("scan"), self.handle("state")) == (str(scan), state))

    def until_there(self, selector: str) -> None:
        """Wait until an element is there."""
        until(lambda: self.run("return document.querySelector(arguments[0]) !== null", selector))

    def until_drawn(self) -> None:
        """Wait until the rungs are drawn for their width, and all that was asked has come and is painted."""
        until(lambda: self.run(DRAWN))

    def press(self, name: str) -> None:
        """Click the control with an accessible name."""

        def click() -> None:
            control = self._control(name)
            self.run("arguments[0].scrollIntoView({block: 'center'})", control)
            control.click()

        steadily(click)

    def click(self, selector: str, by: str = "css selector") -> None:
        """Click the first element of a selector, once it is there."""
        until(lambda: self.browser.find_elements(by, selector))
        steadily(lambda: self.browser.find_element(by, selector).click())

    def choose(self, name: str, value: str) -> None:
        """Choose a value of the list with an accessible name."""
        from selenium.webdriver.support.select import Select

        Select(self.control(name)).select_by_value(value)

    def look(self, width: int, height: int, *, scheme: str = "light", motion: str = "no-preference") -> None:
        """Make the window so big, with a scheme of colors."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        features = [
            {"name": "prefers-color-scheme", "value": scheme},
            {"name": "prefers-reduced-motion", "value": motion},
        ]
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})

    def messages(self) -> list[str]:
        """Return what the browser's console has said since it was last asked."""
        return [str(each["message"]) for each in self.browser.get_log("browser")]


NAMED = """
const named = async name => {
  const page = await import("scanrack/page.js");
  return page[Object.keys(page).find(each => each.startsWith(`${name}$`))];
};
"""
"""Finds a name of a module in a shared page."""

DRAWN = """
const parts = ["program", "socket", "state"].map(name => import(`/${name}.js`));
const [program, socket, state] = await Promise.all(parts);
return program.isDrawn() && !socket.unanswered() && state.isPainted();
"""

CALLED = """
return [...document.querySelectorAll("button, input, select, [role=button]")].filter(each =>
  [each.getAttribute("aria-label"), each.textContent.trim()].includes(arguments[0]));
"""
"""Gives the controls that may have an accessible name."""

FRAMES = """
const [ms, done] = arguments, times = [];
const watcher = new MutationObserver(() => times.push(performance.now()));
watcher.observe(document.documentElement, { attributes: true, attributeFilter: ["data-scan"] });
setTimeout(() => { watcher.disconnect(); done(times); }, ms);
"""
"""Gives the times, ms, at which another scan was shown."""


def frames(look: Look, seconds: float) -> Sequence[float]:
    """Return the times, s, at which the page has shown another scan."""
    look.browser.set_script_timeout(seconds + PATIENCE_S)
    times: list[float] = look.browser.execute_async_script(FRAMES, seconds * 1000)
    return [each / 1000 for each in times]
