"""Nothing on the page jumps while a rack runs: parts keep their places and sizes, whatever they show."""

STEPS = [1, 20, 780, 900, 800, 1505, 200, 794, 1000]
"""Scans: before home, first stroke, the way back, the emergency stop at 8 s with its rules, and after it."""

PLACES = """
const parts = "section, h2, .over, canvas.axis, svg.rung, button, .reading, output, summary";
const still = document.querySelectorAll(parts);
return [...still].filter(each => !each.closest(".events, .band, .over")).map(each => {
  const { x, y, width, height } = each.getBoundingClientRect();
  const size = each.id === "words" ? [] : [width, height];  // rules come and go at its foot
  return [each.getAttribute("aria-label") ?? each.className, [x, y, ...size].map(Math.round)];
});
"""


def test_nothing_jumps(page, paused):
    page.open(paused.link, paused=True)
    first, scans = None, 0
    for step in STEPS:
        page.step(step)
        scans += step
        page.until_scan(scans - 1, "paused")
        page.until_there(".events button")
        page.until_drawn()
        places = page.run(PLACES)
        first = first or places
        moved = [(was, now) for was, now in zip(first, places, strict=True) if was != now]
        assert moved == [], f"in scan {scans - 1}"
