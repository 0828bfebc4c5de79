"""The site: `python -m sphinx -W -b html docs site`, with the extra `docs`."""

import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
ROOT = DOCS.parent
REPOSITORY = "https://github.com/scanrack/scanrack/blob/main"

project = "scanrack"
author = "the scanrack authors"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["images/*.md"]
html_theme = "furo"
html_title = "scanrack"
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_search_scorer = str(DOCS / "search_scorer.js")
html_theme_options = {"navigation_with_keys": True}
myst_heading_anchors = 4
autodoc_typehints = "description"
autodoc_member_order = "bysource"

LEAVING = re.compile(r"\]\(((?:\.\./)+[^)\s#]*)(#[^)\s]*)?\)")
CONTENT = re.compile(r"^\* \[.*\]\((\S+)\.md\)$", re.MULTILINE)


def _to_the_repository(app: Any, page: str, source: list[str]) -> None:
    """Links that leave docs/ lead into the repository; one that leads nowhere stays, and Sphinx complains."""
    folder = (DOCS / page).parent

    def link(match: re.Match[str]) -> str:
        target = (folder / match[1]).resolve()
        if target.is_relative_to(DOCS) or not target.exists():
            return match[0]
        return f"]({REPOSITORY}/{target.relative_to(ROOT).as_posix()}{match[2] or ''})"

    source[0] = LEAVING.sub(link, source[0])


def _with_contents(app: Any, page: str, source: list[str]) -> None:
    """Make the first page's lists of links the contents of the site; other pages come under "How to"."""
    if page != "index":
        return
    parts = re.split(r"^## (.*)$", source[0], flags=re.MULTILINE)
    sections = {name: CONTENT.findall(text) for name, text in zip(parts[1::2], parts[2::2], strict=True)}
    named = {"index", *(each for pages in sections.values() for each in pages)}
    sections["How to"] += sorted(each.stem for each in DOCS.glob("*.md") if each.stem not in named)
    for name, pages in sections.items():
        source[0] += "\n".join(["", "```{toctree}", f":caption: {name}", ":hidden:", "", *pages, "```", ""])


def setup(app: Any) -> None:
    """Sphinx calls this."""
    app.connect("source-read", _to_the_repository)
    app.connect("source-read", _with_contents)
