"""Draw the pictures of docs/watch.md: the page of `scanrack watch` in a headless Chromium.

    python tests/tools/watch_pictures.py [NAME ...]

A picture is made of a session that is stepped to one scan, so that it shows the same every time; only fonts
may differ from machine to machine. The film is taken of a session that runs, and keeps its time. It takes
Chromium with its driver, selenium, and Pillow, which matplotlib brings.
"""

from __future__ import annotations

import io
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from watched_page import Look, open_browser, until, watching, why_not

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "docs" / "images"
EXAMPLES = ROOT / "examples"
COLORS, FILM_COLORS = 128, 128
"""Of a picture and of the film: few enough for a small file, enough for smooth letters."""

LAST_MS = 1500
"""How long the last picture of the film stays."""

INTO_STRIP = "import('/taglanes.js').then(tags => arguments[0].forEach(tags.toggleTag))"
"""Puts tags into the timing strip."""

STRIP_HAS = "return import('/taglanes.js').then(its => arguments[0].every(tag => its.pointsOf(tag).length))"
"""Whether it has their values."""

FILM_SIZE, FILM_WIDTH = (1480, 880), 1000
"""Of the window, and how wide the film is, CSS pixels."""

FILM_FROM_S, FILM_TO_S, FILM_STEP_S, FILM_SPEED = 0.3, 5.6, 0.08, 0.1
"""Machine time of its start, of its end, between two pictures at least; how fast the rack runs meanwhile."""


def stepped(look: Look, rack: Path, scan: int, then: Callable[[], None]) -> None:
    """Run a rack to a scan, and do something with the page that shows it."""
    with watching(rack, "--paused", "--time-scale", "max") as session:
        look.open(session.link, paused=True)
        look.step(scan + 1)
        look.until_scan(scan, "paused")
        look.run("document.getElementById('notice').hidden = true")
        time.sleep(0.5)
        then()


def picture(look: Look) -> Any:
    """Return what the window shows."""
    from PIL import Image

    return Image.open(io.BytesIO(look.browser.get_screenshot_as_png())).convert("RGB")


def saved(look: Look, name: str) -> None:
    """Save what the window shows."""
    from PIL import Image

    small = picture(look).quantize(COLORS, Image.Quantize.MEDIANCUT)
    small.save(IMAGES / name, optimize=True)


def whole(look: Look) -> None:
    """The feeder in the middle of a stroke, a contact selected."""
    look.look(1600, 1180)

    def then() -> None:
        contact = look.browser.find_element("css selector", "[data-element='Main.8.2']")
        look.run("arguments[0].dispatchEvent(new MouseEvent('click', { bubbles: true }))", contact)
        look.press("Why")
        look.until_there(".band:not([hidden])")
        look.run("import('/program.js').then(program => program.showRung('Main.8', false))")
        look.run(INTO_STRIP, ["OutGo", "Strokes.ACC"])
        until(lambda: look.run(STRIP_HAS, ["OutGo", "Strokes.ACC"]))
        look.watch("Strokes.ACC")
        look.watch("Quiet.ACC")
        time.sleep(0.5)
        saved(look, "watch.png")

    stepped(look, EXAMPLES / "feeder" / "feeder.toml", 3_100, then)


def dark(look: Look) -> None:
    """The line with a panel: cards with buttons and lamps, in dark."""
    look.look(1600, 1000, scheme="dark")
    stepped(
        look, EXAMPLES / "three_stations_panel" / "line.toml", 3_600, lambda: saved(look, "watch-dark.png")
    )


def panel(look: Look) -> None:
    """The line of the tutorial on its way to the middle station."""
    look.look(1600, 1000)
    rack = EXAMPLES / "three_stations_panel" / "line.toml"
    stepped(look, rack, 1_500, lambda: saved(look, "watch-panel.png"))


def operator_panel(look: Look) -> None:
    """The operator panel of the feeder on a tablet."""
    look.look(1024, 480)

    def then() -> None:
        look.run("location.hash += '&panel'")
        look.until_there(".grid .item")
        time.sleep(0.7)
        saved(look, "watch-operator-panel.png")

    stepped(look, EXAMPLES / "feeder" / "feeder.toml", 3_100, then)


def past(look: Look) -> None:
    """The feeder's emergency stop, looked at 1.5 s later."""
    look.look(1600, 820)

    def then() -> None:
        look.run("import('/scrub.js').then(scrub => scrub.lookAt(4010))")
        look.until_scan(4_010, "past")
        time.sleep(0.7)
        saved(look, "watch-past.png")

    stepped(look, EXAMPLES / "feeder" / "feeder.toml", 4_760, then)


def film(look: Look) -> None:
    """A button, a lamp, home, and the first stations, for the README."""
    from PIL import Image

    look.look(*FILM_SIZE)
    rack = EXAMPLES / "three_stations_panel" / "line.toml"
    taken: list[tuple[float, Image.Image]] = []
    with watching(rack, "--paused", "--time-scale", FILM_SPEED) as session:
        look.open(session.link, paused=True)
        look.step(1)
        look.until_there("svg.rung")
        look.until_scan(0, "paused")
        look.press("Continue")
        now_s = 0.0
        while now_s < FILM_TO_S:
            now_s = int(look.handle("time-ns") or 0) / 1e9
            if now_s > (taken[-1][0] + FILM_STEP_S if taken else FILM_FROM_S):
                taken.append((now_s, picture(look)))
    size = FILM_WIDTH, FILM_WIDTH * FILM_SIZE[1] // FILM_SIZE[0]
    small = [image.resize(size, Image.Resampling.LANCZOS) for _, image in taken]
    palette = small[len(small) // 2].quantize(FILM_COLORS, Image.Quantize.MAXCOVERAGE)
    drawn = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in small]
    times = [time_s for time_s, _ in taken]
    lasts = [round(100 * (after - each)) * 10 for each, after in pairwise(times)] + [LAST_MS]
    drawn[0].save(IMAGES / "watch.gif", save_all=True, append_images=drawn[1:], duration=lasts, loop=0)


PICTURES: dict[str, Callable[[Look], None]] = {
    "watch": whole,
    "dark": dark,
    "panel": panel,
    "operator-panel": operator_panel,
    "past": past,
    "film": film,
}


def main(names: list[str]) -> None:
    missing = why_not()
    if missing is not None:
        sys.exit(missing)
    with tempfile.TemporaryDirectory() as profile:
        browser = open_browser(Path(profile))
        try:
            for name in names or PICTURES:
                PICTURES[name](Look(browser))
                browser.execute_script("localStorage.clear()")
        finally:
            browser.quit()
    for file in sorted(IMAGES.glob("watch*")):
        sys.stdout.write(f"{file.relative_to(ROOT)}: {file.stat().st_size // 1000} kB\n")


if __name__ == "__main__":
    main(sys.argv[1:])
