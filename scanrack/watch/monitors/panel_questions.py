"""Answers pages' questions about the operator panel; a ValueError describes a mistake in a question."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scanrack.runtime.live.actions import ACTIONS, action_of
from scanrack.runtime.loop.pace import wall_ns

from ..panels.kept_panel import drafted
from .fields import Question
from .monitor import Json, Monitor
from .page import Page

HOLD_MS, HOLDS_MOST = 2000, 20
"""Time after which a press ends unless a page confirms it, ms; and the most presses at once."""

LETTING_GO = {name: ACTIONS[name] for name in ("press", "write")}
READ_ONLY = "this session is read-only"


def panel(monitor: Monitor, page: Page, question: Question) -> Json:
    """Return the operator panel, or the binding or mistake of each of the `items` that a page edits."""
    bindings = monitor.subject.bindings(page.program or monitor.subject.programs.latest)
    if "items" in question:
        return drafted(question["items"], bindings)
    is_recording = monitor.about.kind == "trace"
    lacks = "this is a recording" if is_recording else READ_ONLY if monitor.about.read_only else ""
    return monitor.panel.described(bindings, lacks)


def save_panel(monitor: Monitor, page: Page, question: Question) -> Json:
    """Write the file of the operator panel, and send it to all pages."""
    if monitor.about.read_only:
        raise ValueError(f"{READ_ONLY}: its panel can't be saved")
    monitor.panel.save(question)
    monitor.panel.changed()  # it is sent to pages right here
    show_panel(monitor, besides=page)
    return panel(monitor, page, {})


def show_panel(monitor: Monitor, besides: Page | None = None) -> None:
    """Send the operator panel to pages."""
    for page in monitor.pages:
        if page is not besides:
            page.send({"panel": panel(monitor, page, {})})


def hold(monitor: Monitor, page: Page, question: Question) -> Json:
    """Keep the orders that end a page's presses, to be given when it closes, is lost, or falls silent."""
    orders = question.get("give")
    if not isinstance(orders, list) or len(orders) > HOLDS_MOST:
        raise ValueError(f"give must be a list of up to {HOLDS_MOST} orders")
    if monitor.about.read_only:
        raise ValueError(READ_ONLY)
    for order in orders:
        action_of(order, LETTING_GO)
    page.holds, page.holds_until_ns = orders, wall_ns() + HOLD_MS * 1_000_000
    return {}


def left_pressed(monitor: Monitor) -> list[Json]:
    """Return the orders that release momentary buttons pressed by a panel but held by no page."""
    panel = monitor.panel.described(monitor.subject.bindings(monitor.subject.programs.latest), "")
    pressed, orders = monitor.states.pressed_at(None), []
    held_orders = [order for page in monitor.pages for order in page.holds]
    for item, bound in zip(panel["items"], panel["bound"], strict=True):
        if item["kind"] != "momentary" or bound["broken"]:
            continue
        key, on, order = _release_of(bound)
        level, by = pressed.get(key, (None, ""))
        if level is on and by.startswith("panel") and order not in held_orders and order not in orders:
            orders.append(order)
    return orders


def _release_of(bound: Json) -> tuple[str, bool, Json]:
    """Return the tag or input that a momentary button sets, its pressed value, and the release order."""
    if "press" not in bound:
        return bound["write"], True, {"do": "write", "tag": bound["write"], "value": False, "by": "panel"}
    slot, name, rest_level = bound["press"]
    order = {"do": "press", "slot": slot, "name": name, "on": rest_level, "by": "panel"}
    return f"{slot}.input.{name}", not rest_level, order


PANEL_QUESTIONS: Mapping[str, Callable[[Monitor, Page, Question], Json | None]] = {
    "panel": panel,
    "save_panel": save_panel,
    "hold": hold,
}
