"""Commands and options of the release before: they work until the next one, and name what replaces them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

COMMANDS: Mapping[tuple[str, ...], tuple[str, ...]] = {
    ("ports",): ("device", "list"),
    ("probe",): ("device", "identify"),
    ("pcl601",): ("device", "pcl601"),
    ("pmc006",): ("device", "pmc006"),
    ("pclt", "check"): ("check",),
    ("pclt", "list"): ("device", "pcl601", "program", "list"),
    ("pclt",): ("device", "pcl601", "program"),
    ("rerun",): ("replay", "--into", "session"),
    ("schema",): ("editor", "schema"),
    ("lsp",): ("editor", "lsp"),
}
"""The words of a command, longer ones first, and what they are now."""

KEPT = {("lsp",)}
"""Names that stay and say nothing: editors store them."""


class OldOption(NamedTuple):
    """An option under its old name."""

    command: str
    old: str
    new: str
    value: Callable[[str], str] = str
    """Returns what the new option takes instead of an old value."""


def _last_of(scans: str) -> str:
    """Return the number of the last scan of so many; another text as it is, so that it is refused."""
    return str(int(scans) - 1) if scans.isdecimal() and int(scans) else scans


OPTIONS = (
    OldOption("watch", "--control", "--allow-writes"),
    OldOption("watch", "--speed", "--time-scale"),
    OldOption("show", "--scans", "--range"),
    OldOption("show", "--time", "--range"),
    OldOption("plot", "--scans", "--range"),
    OldOption("plot", "--time", "--range"),
    OldOption("export", "--scans", "--range"),
    OldOption("export", "--time", "--range"),
    OldOption("share", "--scan", "--at"),
    OldOption("share", "--whole", "--all"),
    OldOption("import", "--unit", "--address"),
    OldOption("repair", "--output", "--out"),
    OldOption("why", "--scans", "--at", _last_of),
    OldOption("l5x", "--rack", "--print-rack"),
    OldOption("fuzz", "--time", "--budget"),
    OldOption("fuzz", "--from", "--corpus"),
    OldOption("prove", "--only", "--may-differ"),
    OldOption("device pcl601", "--port", "--serial"),
    OldOption("device pcl601", "--unit", "--address"),
    OldOption("device pmc006", "--port", "--serial"),
    OldOption("serve", "--control", "--test-port"),
    OldOption("serve", "--speed", "--time-scale"),
    OldOption("serve", "--whole", "--whole-writes"),
    OldOption("conform", "--control", "--allow-writes"),
    OldOption("conform", "--from", "--judge"),
    OldOption("conform", "--scan", "--max-scan-time"),
    OldOption("conform", "--rung", "--print-counter"),
)


def renewed(words: Sequence[str], known: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the words of a call under their present names, and a sentence for each that was old.

    Args:
        words: as they were typed.
        known: names of the present commands.
    """
    firsts = {*known, *(old[0] for old in COMMANDS)}
    at = next((place for place, word in enumerate(words) if word in firsts), len(words))
    head, call, notes = list(words[:at]), list(words[at:]), list[str]()
    for old, new in COMMANDS.items():
        if tuple(call[: len(old)]) == old:
            call[: len(old)] = new
            if old not in KEPT:
                notes.append(_note(f"scanrack {' '.join(old)}", f"scanrack {' '.join(new)}"))
            break
    return [*head, *_with_options(call, notes)], notes


def _with_options(call: Sequence[str], notes: list[str]) -> Iterator[str]:
    """Yield the words of a command with the present names of its options."""
    path = " ".join(call)
    rows = {row.old: row for row in OPTIONS if path == row.command or path.startswith(f"{row.command} ")}
    end = call.index("--") if "--" in call else len(call)
    row = None
    for word in call[:end]:
        name, given, value = word.partition("=")
        if row is not None and row.value is not str:
            yield row.value(word)
            row = None
            continue
        row = rows.get(name)
        if row is None:
            yield word
            continue
        notes.append(_note(row.old, row.new))
        if given:
            yield f"{row.new}={row.value(value)}"
            row = None
        else:
            yield row.new
    yield from call[end:]


def _note(old: str, new: str) -> str:
    return f"'{old}' is now '{new}'; the next release drops the old name"
