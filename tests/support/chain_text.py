"""Chains of causes as short text, and programs after what is done to them."""

from __future__ import annotations

from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import CauseLink, Debugger

PLAIN = ("rung", "line", "wait")
"""Kinds of links that the text leaves out."""


def text_of(link: CauseLink | None) -> str:
    """Return a chain: links as `name value @scan kind`, `<` before causes, `&` needed, `|` or."""
    assert link is not None
    names = {None: "", False: " off", True: " on"}
    value = names[link.value] if link.value is None or isinstance(link.value, bool) else f" = {link.value}"
    kind = "" if link.kind in PLAIN or link.name == link.kind else f" {link.kind}"
    causes = " & ".join(" | ".join(map(text_of, group)) for group in link.causes)
    return f"{link.name}{value} @{link.scan}{kind}{' < ' if causes else ''}{causes}"


def after(program: LadderLogic, done: str) -> Debugger:
    """Return a program after scans of 10 ms.

    Args:
        done: `Start` sets that tag, `-Start` clears it, `N=5` gives it a value, a number does so many scans.
    """
    debugger = Debugger(program)
    for word in done.split():
        name, given, value = word.partition("=")
        if word.isdecimal():
            debugger.scan(int(word))
        elif given:
            debugger.tags[name] = int(value)
        else:
            debugger.tags[name.removeprefix("-")] = not name.startswith("-")
    return debugger
