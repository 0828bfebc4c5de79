"""What a reader asks, and where the site answers: by its own search, and by links from its first page.

    python tests/tools/site_search.py SITE

runs the search of a built site as a browser does, in node. A question is answered if its page is the first
hit, or one link away from the first hit.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple


class Answer(NamedTuple):
    """Where a question is answered."""

    row: str  # a part of its row in docs/tasks.md
    place: str  # page and section, as a path in docs/
    names: str  # what the section has to name


ANSWERS = {
    "how do I set acceleration": Answer(
        "set acceleration", "units.md#set-acceleration-and-speed", "acceleration"
    ),
    "my move does not start": Answer(
        "my move does not start", "debugging.md#my-move-does-not-start", "scanrack why"
    ),
    "see the registers": Answer("see the registers", "units.md#see-the-words", "scanrack show"),
    "what is MSW": Answer("what MSW and LSW are", "units.md#msw-and-lsw", "most significant word"),
    "jog from a button": Answer("jog from a button", "sequences.md#five-programs", "jog"),
    "a normally closed stop": Answer("normally closed stop", "cards.md#wiring", "normally_closed"),
    "talk to it from Node-RED": Answer("Node-RED", "hmi.md#node-red", "eth-ip endpoint"),
    "faster than real time": Answer("faster than real time", "run.md", "faster than real time"),
    "RS-485": Answer("RS-485", "clients.md", "RS-485"),
    "units of speed": Answer("units of speed", "units.md#units", "steps/s"),
    "Windows": Answer("Windows", "windows.md", "COM"),
    "use it in CI": Answer("use it in CI", "ci.md", "action"),
    "put my Studio program in": Answer(
        "put my Studio 5000 program in", "l5x.md#from-an-export-to-a-rack", "--print-rack"
    ),
    "get the data into pandas": Answer("get the data into pandas", "notebook.md#numbers", "to_pandas"),
    "what happens when the link is lost": Answer(
        "what happens when the link is lost", "axis.md#a-lost-link", "link"
    ),
}
"""Fifteen questions, as they are typed into the search."""

LINK = re.compile(r'href="([^"#]*\.html(?:#[^"]*)?)"')


def answered(site: Path, first: str, answer: str) -> bool:
    """Whether an answer is the first hit of a search, or linked from it."""
    page, _, anchor = answer.partition("#")
    wanted = page.removesuffix(".md")
    if first.partition("#")[0] == wanted:
        return True
    text = (site / f"{first.partition('#')[0]}.html").read_text(encoding="utf-8")
    article = text[text.index("<article") : text.index("</article>")]
    return f"{wanted}.html{f'#{anchor}' if anchor else ''}" in LINK.findall(article)


def main(site: Path) -> int:
    """Print what the search finds first for each question; return 1 if one is not answered."""
    search = ["node", str(Path(__file__).with_suffix(".mjs")), str(site)]
    done = subprocess.run(search, input=json.dumps(list(ANSWERS)), capture_output=True, text=True, check=True)
    status = 0
    for (question, answer), hits in zip(ANSWERS.items(), json.loads(done.stdout), strict=True):
        if not hits or not answered(site, hits[0], answer.place):
            sys.stdout.write(
                f"{question}: {answer.place} is neither the first hit nor linked from it: {hits[:3]}\n"
            )
            status = 1
    sys.stdout.write(f"{len(ANSWERS)} questions, {'all answered' if not status else 'not all answered'}\n")
    return status


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
