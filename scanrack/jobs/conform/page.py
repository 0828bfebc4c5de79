"""The result as an HTML page to send to others: a single file without scripts or external content."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from itertools import count
from pathlib import Path

from scanrack.io_images.amci3601 import RULES
from scanrack.traces.files.guard import PAGE, Used
from scanrack.traces.files.newfile import new_file

from .findings import ConformResult, ConformVerdict, SceneVerdict
from .report import PlayedPlan, counted, difference_lines, factor_sentences, next_steps
from .rules_apart.scales import either

MOST_DIFFERENCES = 6
"""Number of differing scenes that the page shows in full; the result file has all of them."""

STYLE = """\
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #57606a; --line: #d0d7de; --paper: #fff;
  --bad: #cf222e; --good: #1a7f37 }
body { font: 14px/1.45 system-ui, sans-serif; margin: 1.5em auto; max-width: 54em; padding: 0 1em;
  color: var(--ink); background: var(--paper) }
h1 { font-size: 1.5em; margin: 0 0 .5em } h2 { font-size: 1.1em; margin: 1.2em 0 .3em }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; padding: .2em .8em .2em 0; vertical-align: top;
  border-bottom: 1px solid var(--line); overflow-wrap: break-word }
td:first-child { white-space: nowrap } th { font-weight: 600 } .n { text-align: right; width: 16% }
pre { font: 12px/1.5 "DejaVu Sans Mono", Menlo, Consolas, monospace; white-space: pre-wrap; margin: .2em 0;
  overflow-wrap: anywhere }
p, ul { margin: .3em 0 } .soft { color: var(--soft) } .bad { color: var(--bad) } .good { color: var(--good) }
section { break-inside: avoid }
@media (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --soft: #9198a1; --line: #3d444d;
  --paper: #0d1117; --bad: #f85149; --good: #3fb950 } }
@media print { :root { --ink: #000; --soft: #444; --line: #bbb; --paper: #fff; --bad: #a00; --good: #060 }
  @page { margin: 14mm } body { font-size: 10.5px; margin: 0; max-width: none; padding: 0 }
  pre { font-size: 8.5px } }"""


def save_report(path: Path, recorded: PlayedPlan, result: ConformResult, used: Used, name: str = "") -> None:
    """Write the page to a file.

    Args:
        name: name of the result file; "" if none is written.

    Raises:
        OwnedError: the page would replace a file of a different kind, or a file that is in use.
        OSError: the file can't be written.
    """
    title = "AMCI 3601 against its manual"
    head = f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
    view = '<meta name="viewport" content="width=device-width">'
    with new_file(path, PAGE, used=used) as file:
        file.write(f"{head}{view}\n<style>\n{STYLE}\n</style></head><body>\n<h1>{title}</h1>\n")
        file.writelines(f"{part}\n" for part in _body_parts(recorded, result, name))
        file.write("</body></html>\n")


def _body_parts(recorded: PlayedPlan, result: ConformResult, name: str) -> Iterator[str]:
    """Yield the parts of the page in order, as HTML. Sections without content are omitted."""
    differing = _scenes_with(ConformVerdict.DIFFERS, result)
    if differing:
        yield f'<p class="bad"><b>{len(differing)} of {len(result.scenes)} scenes differ.</b></p>'
    else:
        yield '<p class="good"><b>No difference was seen.</b></p>'
    yield _table((), _facts(recorded))
    yield _verdicts(result)
    factors = factor_sentences(result)
    if factors:
        yield _section("Factors", _list(factors))
    if differing:
        yield from _differing(differing, result, name)
    rules = list(_differing_rules(result))
    if rules:
        yield _section("Rules that differ", _table(("rule", "manual", "it says", "the module"), rules))
    undecided = _scenes_with(ConformVerdict.OPEN, result)
    if undecided:
        rows = ((escape(scene.name), escape(scene.why)) for scene in undecided)
        yield _section("Open scenes", _table(("scene", "why"), rows))
    steps = list(next_steps(recorded, result, name))
    if steps:
        yield _section("What to try next", _list(steps))
    yield (
        '<p class="soft">This page has words and images of the module, product and revision of the '
        "controller, and the date. It has no address, tag or program.</p>"
    )


def _scenes_with(verdict: ConformVerdict, result: ConformResult) -> list[SceneVerdict]:
    return [scene for scene in result.scenes if scene.verdict is verdict]


def _differing(differing: Sequence[SceneVerdict], result: ConformResult, name: str) -> Iterator[str]:
    """Yield the first scenes that differ, and the number of remaining scenes."""
    shown = (_difference(scene, result) for scene in differing[:MOST_DIFFERENCES])
    yield _section("What differs", "".join(shown))
    if len(differing) > MOST_DIFFERENCES:
        where = f"{escape(name)} has them" if name else "--out FILE writes them"
        yield f"<p>{len(differing) - MOST_DIFFERENCES} more scenes differ; {where}.</p>"


def _differing_rules(result: ConformResult) -> Iterator[tuple[str, ...]]:
    """Yield the rules that differ: rule, section, text, and the module's behavior."""
    for rule, finding in result.rules.items():
        if finding.verdict is ConformVerdict.DIFFERS:
            yield tuple(map(escape, (rule, RULES[rule].section, RULES[rule].text, finding.why)))


def _facts(recorded: PlayedPlan) -> Iterator[tuple[str, str]]:
    """Return the rows of the table about the module and its path, each as an escaped name and text."""
    timing = recorded.timing
    scans = f"scans of up to {timing.scan_ns / 1e6:g} ms" if timing.scan_ns else "with a counter of scans"
    facts = {
        "module": f"AMCI 3601, slot {recorded.slot}, taken as firmware {recorded.firmware}",
        "controller": recorded.controller or "not recorded",
        "path to the module": f"RPI {timing.rpi_ns / 1e6:g} ms, {scans}",
        "date": recorded.date or "not recorded",
        "scenes": f"plan {recorded.plan}" if recorded.plan else "a recording",
        "images read": f"{recorded.reads:,}",
    }
    return ((escape(name), escape(fact)) for name, fact in facts.items())


def _verdicts(result: ConformResult) -> str:
    """Return the table with the number of scenes, rules and interpretations for each verdict."""
    rows = {
        "scenes": [scene.verdict for scene in result.scenes],
        "rules of the manual": [rule.verdict for rule in result.rules.values()],
        "interpretations": [reading.verdict for reading in result.readings.values()],
    }
    counts = ((name, *map(str, counted(row).values())) for name, row in rows.items())
    return _table(("", *map(str, ConformVerdict)), counts, numbers=True)


def _difference(scene: SceneVerdict, result: ConformResult) -> str:
    """Return the HTML section about a scene that differs: its explanations and the first different read."""
    difference = scene.difference
    shown = "" if difference is None else f"<pre>{escape(chr(10).join(difference_lines(difference)))}</pre>"
    explanations = [
        *(f"{number}: {result.readings[number].why}" for number in scene.readings),
        *(f"without {rule}" for rule in scene.rules),
        *([either(scene.scales)] if scene.scales else []),
    ]
    why = f"Explained by: {'; '.join(explanations)}" if explanations else "No known alternative explains it."
    head = f"<b>{escape(scene.name)}</b>, after {scene.reads:,} reads."
    return f"<section>{head} {escape(why)}{shown}</section>"


def _section(title: str, body: str) -> str:
    return f"<section><h2>{title}</h2>{body}</section>"


def _list(texts: Iterable[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in texts)}</ul>"


def _table(heads: Iterable[str], rows: Iterable[Iterable[str]], *, numbers: bool = False) -> str:
    """Return a table of HTML cells; with `numbers`, all columns except the first are right-aligned."""

    def line(cells: Iterable[str], kind: str) -> str:
        classes = (" class=n" if numbers and column else "" for column in count())
        marked = (f"<{kind}{name}>{cell}</{kind}>" for cell, name in zip(cells, classes, strict=False))
        return f"<tr>{''.join(marked)}</tr>"

    head = line(heads, "th") if heads else ""
    return f"<table>{head}{''.join(line(row, 'td') for row in rows)}</table>"
