"""The menu of contacts, blocks and rungs: by right-click, key and long press; dragging one to the strip.

Broken on purpose: `Toggle` that writes the value it has, `Main.9 changes` set as `Main.9`, a drop that is not
looked for: each turns a test red.
"""

from selenium.webdriver.common.action_chains import ActionChains
from watched_page import until, watching

ESCAPE, DOWN, END, ENTER = "\ue00c", "\ue015", "\ue010", "\ue007"
ITEMS = """
return [...document.querySelectorAll(".menu:not([hidden]) [role^=menuitem]")].map(each => [
  each.firstChild.textContent, each.getAttribute("aria-disabled") ? each.querySelector("small").textContent
    : each.getAttribute("aria-checked")]);
"""
FOCUS = "return document.activeElement.dataset.element ?? document.activeElement.firstChild?.textContent"
FORCED = "return [...document.querySelectorAll('.rung [data-forced]')].map(each => each.dataset.name)"
STOP_AT = "return document.querySelector('[data-at=\"Main.9\"] .stop')"
STOP = f"{STOP_AT}.textContent"
MIDDLE = """
const { x, y, width, height } = arguments[0].getBoundingClientRect();
return [x + width / 2, y + height / 2];
"""
LANES = "return import('/taglanes.js').then(lanes => lanes.tagNames())"


def menu(page):
    return dict(page.run(ITEMS))


def element(page, selector):
    page.until_there(selector)
    found = page.browser.find_element("css selector", selector)
    page.run("arguments[0].scrollIntoView({ block: 'center' })", found)
    return found


def right_click(page, selector):
    ActionChains(page.browser).context_click(element(page, selector)).perform()
    return until(lambda: menu(page))


def choose(page, item):
    page.click(f"//*[@role='menu']//button[span[text()='{item}']]", "xpath")


def test_a_right_click_toggles_forces_and_breaks_and_says_what_cannot_be_done(page, paused):
    page.open_at(paused, 1500)
    trouble = "[data-element='Main.2.1']"  # OTE(Trouble)
    items = right_click(page, trouble)
    assert items["Remove force"] == "it is not forced"
    assert [name for name, lack in items.items() if lack is None] == [
        "Toggle",
        "Force on",
        "Force off",
        "Why",
        "What would it take",
        "Uses",
        "Into the watch table",
    ]
    choose(page, "Force on")
    page.step(1)
    until(lambda: set(page.run(FORCED)) == {"Trouble"} and page.value("Trouble") == "1")
    assert right_click(page, trouble)["Remove force"] is None
    choose(page, "Remove force")
    page.step(1)
    until(lambda: page.run(FORCED) == [])
    assert right_click(page, "[data-element='Main.5.0']")["Toggle"] is None  # Configure.Done
    choose(page, "Why")
    until(
        lambda: (
            "Configure.Done is on" in page.run("return document.querySelector('#tag .answer').textContent")
        )
    )
    estop = right_click(page, "[data-element='Main.3.1']")  # XIO(card.status.IN_ESTOP)
    assert estop["Toggle"] == "an input of a module: press it at the machine, or force it"
    assert estop["Force on"] is None
    choose(page, "Lane in the strip")
    until(lambda: page.run(LANES) == ["card.status.IN_ESTOP"])
    block = right_click(page, "[data-element='Main.3.2'] .heading")  # TON(Quiet,1000,0)
    assert (block["Quiet"], block["Quiet.ACC"], block["Toggle"]) == ("true", "false", "not a BOOL")
    page.click("//*[@role='menuitemradio'][text()='Quiet.DN']", "xpath")
    until(lambda: menu(page)["Toggle"] is None)
    ActionChains(page.browser).send_keys(ESCAPE).perform()
    page.press("Parameters")
    block = right_click(page, "[data-element='Main.3.2'] [data-name='Quiet.ACC']")  # the operand pointed at
    assert (block["Quiet"], block["Quiet.ACC"]) == ("false", "true")


def test_the_keyboard_reaches_the_menu_and_the_rung_says_what_it_waits_for(page, paused):
    page.open_at(paused, 1500)
    out_go = "[data-element='Main.9.1']"  # XIC(Feeding)XIO(OutGo)OTE(BackGo)
    page.run("arguments[0].focus()", element(page, out_go))
    keys = ActionChains(page.browser)
    keys.send_keys("m").perform()
    until(lambda: page.run(FOCUS) == "Toggle")
    keys.send_keys(DOWN * 2).perform()
    assert page.run(FOCUS) == "Force off"
    keys.send_keys(END).perform()
    assert page.run(FOCUS) == "Break when rung 9 executes"
    keys.send_keys(ESCAPE).perform()
    assert page.run(FOCUS) == "Main.9.1"
    assert menu(page) == {}
    before = page.value("OutGo")
    keys.send_keys("t").perform()
    until(
        lambda: (
            "before the next scan, 1,500" in page.run("return document.getElementById('notice').textContent")
        )
    )
    keys.send_keys("m").perform()
    until(lambda: menu(page))
    keys.send_keys("B").perform()
    until(lambda: page.run(STOP) == "9changes")
    assert page.run(f"{STOP_AT}.ariaDescription") == "Waits for: changes"
    page.press("Continue")  # the toggle itself stops it at once, or the stroke's end does
    until(lambda: "rung 9 is" in page.run("return document.getElementById('notice').textContent"))
    until(lambda: "OutGo is set to 0" in page.run("return document.getElementById('events').textContent"))
    assert (before, page.handle("state")) == ("1", "paused")
    page.run("document.querySelector('[data-at=\"Main.9\"] .stop').click()")
    until(lambda: page.run(STOP) == "9")


def test_a_contact_is_dragged_to_the_strip_and_pressed_long_by_a_finger(page, paused):
    page.open_at(paused, 100)
    feeding = element(page, "[data-element='Main.9.0']")
    strip = page.browser.find_element("id", "strip")
    ActionChains(page.browser).click_and_hold(feeding).move_by_offset(3, 2).release().perform()
    assert page.run(LANES) == []
    ActionChains(page.browser).drag_and_drop(feeding, strip).perform()
    until(lambda: page.run(LANES) == ["Feeding"])
    assert page.run("return document.querySelectorAll('[data-drop], .ghost:not([hidden])').length") == 0
    ActionChains(page.browser).send_keys(ESCAPE).perform()  # the short click has selected it
    page.until_there("#tag:not([data-selected])")
    x, y = page.run(MIDDLE, feeding)
    touch = {"touchPoints": [{"x": x, "y": y}]}
    page.browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": "touchStart", **touch})
    until(lambda: menu(page))
    page.browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    assert menu(page)["Lane in the strip"] == "true"
    page.until_drawn()
    assert not page.run(
        "return document.querySelector('#tag[data-selected]')"
    )  # the finger that is lifted selects nothing


def test_a_page_that_may_not_change_the_run_says_so_in_the_menu(page, running_rack):
    with watching(running_rack, "--read-only") as session:
        page.open(session.link)
        page.until_drawn()
        items = right_click(page, "[data-element='Main.2.1']")
        assert {items[name] for name in ("Toggle", "Force on", "Break when rung 2 is true")} == {
            "this page is read-only"
        }
        assert items["Why"] is None
