"""What the page says is so: keys that are pressed quickly, error bits, blocks of a scan that is worked out.

Broken on purpose: `moveBy` from the scan shown, the kind of error bits left out, `idle` of unknown: red.
"""

QUICKLY = """
for (let press = 0; press < 3; press++) {
  document.body.dispatchEvent(new KeyboardEvent("keydown", { key: arguments[0], bubbles: true }));
}
"""


def test_keys_that_are_pressed_quickly_add_up(page, paused):
    page.open_at(paused, 3000)
    page.run(QUICKLY, "[")
    page.until_scan(2999 - 3 * 500, "past")
    page.run(QUICKLY, ",")
    page.until_scan(2999 - 3 * 500 - 3, "past")
    page.run(QUICKLY, "]")
    page.until_scan(2999 - 3, "past")
