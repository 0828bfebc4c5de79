"""Draw the pictures of docs/watch.md: the page of `scanrack watch` in a headless Chromium.

    python tests/tools/watch_pictures.py [NAME ...]

Each picture is made of a session that is stepped to one scan, so that it shows the same every time; only fonts
may differ from machine to machine. Takes Chromium with its driver, selenium, and Pillow (which matplotlib brings).
"""

from __future__ import annotations

import io
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))

from watched_page import Look, open_browser, watching, why_not

IMAGES = ROOT / "docs" / "images"
EXAMPLES = ROOT / "examples"
COLOURS = 128
"""Of a picture: few enough for a small file, enough for smooth letters."""

FILM_SCANS, FILM_STEP = 1_760, 40
"""Scans of the film, a stroke to and fro, and from one of its pictures to the next."""

FILM_SIZE = 1080, 640
PICTURE_MS = 90


def stepped(look: Look, rack: Path, scan: int, then: Callable[[], None]) -> None:
    """Run a rack to a scan, and do something with the page that shows it."""
    with watching(rack, "--paused", "--speed", "max") as session:
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
    picture(look).quantize(COLOURS).save(IMAGES / name, optimize=True)


def whole(look: Look) -> None:
    """The feeder in the middle of a stroke, a contact selected."""
    look.look(1600, 1180)

    def then() -> None:
        look.browser.find_element("css selector", "[data-element='Main.8.2']").click()
        look.press("Why")
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


def past(look: Look) -> None:
    """The feeder's emergency stop, looked at 1.5 s later."""
    look.look(1600, 820)

    def then() -> None:
        look.run("import('/scrub.js').then(scrub => scrub.lookAt(4010))")
        look.until_scan(4_010, "past")
        time.sleep(0.7)
        saved(look, "watch-past.png")

    stepped(look, EXAMPLES / "feeder" / "feeder.toml", 4_760, then)


def narrow(look: Look) -> None:
    """The feeder on a telephone."""
    look.look(400, 860)
    stepped(look, EXAMPLES / "feeder" / "feeder.toml", 3_100, lambda: saved(look, "watch-narrow.png"))


def film(look: Look) -> None:
    """A stroke to and fro, for the README."""
    look.look(*FILM_SIZE)

    def then() -> None:
        frames = []
        look.run("document.querySelector('#strip details').parentElement.hidden = true")
        for scan in range(2_360, 2_360 + FILM_SCANS, FILM_STEP):
            look.step(FILM_STEP)
            look.until_scan(scan + FILM_STEP, "paused")
            frames.append(picture(look).resize((900, 900 * FILM_SIZE[1] // FILM_SIZE[0]), reducing_gap=3))
        palette = frames[0].quantize(64)
        small = [frame.quantize(palette=palette, dither=0) for frame in frames]
        small[0].save(
            IMAGES / "watch.gif",
            save_all=True,
            append_images=small[1:],
            duration=PICTURE_MS,
            loop=0,
            optimize=True,
        )

    stepped(look, EXAMPLES / "feeder" / "feeder.toml", 2_360, then)


PICTURES: dict[str, Callable[[Look], None]] = {
    "watch": whole,
    "dark": dark,
    "past": past,
    "narrow": narrow,
    "film": film,
}


def main(wanted: list[str]) -> int:
    missing = why_not()
    if missing is not None:
        print(missing, file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as profile:
        browser = open_browser(Path(profile))
        try:
            for name in wanted or PICTURES:
                PICTURES[name](Look(browser))
                browser.execute_script("localStorage.clear()")
        finally:
            browser.quit()
    for file in sorted(IMAGES.glob("watch*")):
        print(f"{file.relative_to(ROOT)}: {file.stat().st_size // 1000} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
