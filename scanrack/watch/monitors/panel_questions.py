"""Answers to questions about the operator panel. A ValueError describes a mistake in a question."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scanrack.runtime.live.actions import ACTIONS, action_of
from scanrack.runtime.loop.pace import wall_ns

from ..panels.kept_panel import drafted
from .fields import Question
from .monitor import Json, Monitor
from .page import Page

HOLD_MS, HOLDS_MOST = 2000, 20
"""Time after which a press ends unless the page confirms it, ms, and maximum number of presses."""

RELEASE_ACTIONS = {name: ACTIONS[name] for name in ("press", "write")}
READ_ONLY = "this session is read-only"


def panel(monitor: Monitor, page: Page, question: Question) -> Json:
    """Return the operator panel; for `items` that a page edits, return the binding or mistake of each."""
    bindings = monitor.subject.bindings(page.program or monitor.subject.programs.latest)
    if "items" in question:
        return drafted(question["items"], bindings)
    if monitor.about.kind == "trace":
        return monitor.panel.described(bindings, "this is a recording")
    return monitor.panel.described(bindings, READ_ONLY if monitor.about.read_only else "")


def save_panel(monitor: Monitor, page: Page, question: Question) -> Json:
    """Write the file of the operator panel, and send it to all pages."""
    if monitor.about.read_only:
        raise ValueError(f"{READ_ONLY}: its panel can't be saved")
    monitor.panel.save(question)
    monitor.panel.changed()  # note the change here, since pages get it now
    show_panel(monitor, except_page=page)
    return panel(monitor, page, {})


def show_panel(monitor: Monitor, except_page: Page | None = None) -> None:
    """Send the operator panel to all pages except one."""
    for page in monitor.pages:
        if page is not except_page:
            page.send({"panel": panel(monitor, page, {})})


def hold(monitor: Monitor, page: Page, question: Question) -> Json:
    """Store the actions that release a page's presses if it closes, disconnects or stops responding."""
    releases = question.get("give")
    if not isinstance(releases, list) or len(releases) > HOLDS_MOST:
        raise ValueError(f"give must be a list of up to {HOLDS_MOST} actions")
    if monitor.about.read_only:
        raise ValueError(READ_ONLY)
    for action in releases:
        action_of(action, RELEASE_ACTIONS)
    page.releases, page.releases_due_ns = releases, wall_ns() + HOLD_MS * 1_000_000
    return {}


def left_pressed(monitor: Monitor) -> list[Json]:
    """Return the release actions of momentary buttons that a panel pressed and no page is holding."""
    panel = monitor.panel.described(monitor.subject.bindings(monitor.subject.programs.latest), "")
    pressed, releases = monitor.states.pressed_at(None), []
    held_by_pages = [release for page in monitor.pages for release in page.releases]
    for item, bound in zip(panel["items"], panel["bound"], strict=True):
        if item["kind"] != "momentary" or bound["broken"]:
            continue
        target, pressed_value, release = _release_of(bound)
        value, operator = pressed.get(target, (None, ""))
        is_pressed = value is pressed_value and operator.startswith("panel")
        if is_pressed and release not in held_by_pages and release not in releases:
            releases.append(release)
    return releases


def _release_of(bound: Json) -> tuple[str, bool, Json]:
    """Return the tag or input that a momentary button sets, its pressed value, and the release action."""
    if "press" not in bound:
        return bound["write"], True, {"do": "write", "tag": bound["write"], "value": False, "by": "panel"}
    slot, name, rest_level = bound["press"]
    release = {"do": "press", "slot": slot, "name": name, "on": rest_level, "by": "panel"}
    return f"{slot}.input.{name}", not rest_level, release


PANEL_QUESTIONS: Mapping[str, Callable[[Monitor, Page, Question], Json | None]] = {
    "panel": panel,
    "save_panel": save_panel,
    "hold": hold,
}
