"""Questions to a rack that runs: why, uses, find; and what may go wrong, by button."""

from watched_page import until, watching


def text(page, selector):
    return page.run("return document.querySelector(arguments[0])?.textContent ?? ''", selector)


def test_why_and_uses_of_a_contact(page, paused):
    page.open(paused.link, paused=True)
    page.step(1500)
    page.until_scan(1499, "paused")
    page.click("[data-element='Main.7.0']")  # Configure.Done
    page.press("Why")
    until(lambda: text(page, "#tag .answer p").startswith("Configure.Done is on since"))
    page.press("Uses")
    until(lambda: "Main.5" in text(page, "#tag .answer"))  # XIC(Configure.Done) of rung 5
    page.click("//section[@id='tag']//li/button[text()='Main.5']", "xpath")
    page.until_there("[data-at='Main.5'][aria-current]")


def test_find_opens_the_rung(page, paused):
    page.open(paused.link, paused=True)
    page.press("Step")
    page.control("Find").send_keys("Strokes")
    until(lambda: "Main.12" in text(page, ".hits"))  # XIC(Back.Done)CTU(Strokes,0,0)
    page.click("//ul[contains(@class, 'hits')]//b[text()='Main.12']", "xpath")
    page.until_there("[data-at='Main.12'][aria-current]")
    assert "rung=Main.12" in page.browser.current_url


def test_an_incident_is_raised_and_told(page, feeder):
    page.open(feeder.link)
    page.press("Incidents")
    page.press("Raise Module link lost")
    until(lambda: not page.run("return document.querySelector('dialog[open]')"))
    until(lambda: "link" in text(page, ".events").lower())


def test_why_of_a_python_program_names_the_line_and_shows_it(page):
    with watching("examples/three_stations/line.toml", "--paused", "--time-scale", "max") as session:
        page.open(session.link, paused=True)
        page.step(1200)
        page.until_scan(1199, "paused")  # the recording has not got the latest scans yet
        page.until_there("[data-name='line.step'][data-value='move']")
        chip = "//button[contains(@class, 'chip')]/span[text()='line.step']"
        page.click(chip, "xpath")
        page.press("Why")
        until(lambda: "line.step is 'move' since" in text(page, "#tag .answer"))
        assert 'line.step = "move"' in text(page, "#tag .answer")
        line = text(page, "#tag .answer .line button").removeprefix("Line ")
        page.click("#tag .answer .line button")
        page.until_there(f"[data-at='line.py.{line}'][aria-current]")


def test_a_tag_that_there_is_not_is_said_to_be_none(page, paused):
    page.open(paused.link, paused=True)
    page.step(10)
    page.watch("Nonsense")
    page.until_there("#watch tr[data-unknown]")


def test_forces_are_in_sight_and_an_order_in_a_pause_says_when_it_acts(page, paused):
    page.open(paused.link, paused=True)
    page.step(10)
    page.until_scan(9, "paused")
    page.click("[data-element='Main.2.1']")  # OTE(Trouble)
    page.press("Force")
    until(lambda: "before the next scan, 10" in text(page, "#notice"))
    page.press("Step")
    page.until_there("#bar [data-warning][title='Forced: Trouble']")
    page.until_there(".value[data-name='Trouble'][data-forced]")
    page.browser.find_element("css selector", "body").send_keys("\ue00c")  # Escape
    page.until_there("#tag:not([data-selected])")


def test_a_chain_leads_to_its_scans_and_rungs_and_is_marked_on_the_strip(page, paused):
    page.open(paused.link, paused=True)
    page.step(1500)
    page.until_scan(1499, "paused")
    page.click("[data-element='Main.7.0']")  # Configure.Done
    page.press("Why")
    page.until_there("#tag .chain li")
    links = page.run("return [...document.querySelectorAll('#tag .chain li')].map(each => each.dataset.kind)")
    assert links[-1] in ("power-up", "input", "rung", "module")
    page.run("document.querySelector(\"#tag .chain li button[title^='Show Main.']\").click()")
    page.until_there("[data-at][aria-current]")
    assert page.run("return document.querySelectorAll('#tag .chain li').length") == len(links)
    page.click(".alert button")
    numbers = page.run(
        "return [...document.querySelectorAll('.cause')].map(each => Number(each.textContent))"
    )
    assert sorted(numbers) == list(range(1, len(links) + 2))  # the claim is one, too
    rows = "return document.querySelectorAll('.rungs .row' + arguments[0]).length"
    shown = (
        "return [...document.querySelectorAll('.rungs .row')].filter(each => each.checkVisibility()).length"
    )
    assert 0 < page.run(rows, "[data-cause]") < page.run(rows, "")
    page.press("Causes only")
    assert page.run(shown) == page.run(rows, "[data-cause]")
    page.press("All rungs")
    assert page.run(shown) == page.run(rows, "")
    until(lambda: page.run("return document.querySelector('.ago').textContent") != "")
