"""A shared page as one self-contained file with script, style, data, and optionally the trace.

<meta> content policy      hashed scripts, script and images from `data:`; no connections
<style>                    watch.css
#data                      JSON, deflated, in base64
#recording                 the trace in base64, if requested
<script> import map        the joined modules as a `data:` address, see `joining`
<script> start             imports them
"""

from __future__ import annotations

import base64
import json
import re
import zlib
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any

from scanrack.traces.files.guard import TRACE, FileKind
from scanrack.traces.files.newfile import new_file

from ..joining import joined
from ..page_files import SCRIPT, SOURCE_OF_SHARED_PAGES, STYLE_LINK

MOST_BYTES = 10_000_000
"""Maximum size of a page, bytes."""

GENERATOR = '<meta name="generator" content="scanrack share">'
SHARED_PAGE = FileKind("a shared page", lambda content: GENERATOR.encode() in content)
"""The kind of file that a new page may replace."""

_RECORDING = re.compile(rb'<script type="application/octet-stream" id="recording">([A-Za-z0-9+/=]+)</script>')
_NAME = "scanrack/page.js"
_START = f'import "{_NAME}";'


def page_of(data: Any, trace: bytes | None = None) -> bytes:
    """Return a page as HTML.

    Args:
        data: see `collecting.collect`.
        trace: the trace to include; None = no trace.

    Raises:
        ValueError: the page would be larger than `MOST_BYTES`.
    """
    web = files("scanrack.watch") / "web"
    text = (web / "index.html").read_text(encoding="utf-8")
    modules = {
        file.name: file.read_text(encoding="utf-8") for file in web.iterdir() if file.name.endswith(".js")
    }
    modules["socket.js"] = modules.pop(SOURCE_OF_SHARED_PAGES)  # a shared page has no server
    script = _base64(joined(modules).script.encode())
    mapped = json.dumps({"imports": {_NAME: f"data:text/javascript;base64,{script}"}})
    style = (web / "watch.css").read_text(encoding="utf-8")
    packed = zlib.compress(json.dumps(data, separators=(",", ":")).encode(), 9)
    inside = f'<script type="application/octet-stream" id="data">{_base64(packed)}</script>\n'
    if trace is not None:
        inside += f'<script type="application/octet-stream" id="recording">{_base64(trace)}</script>\n'
    inside += f'<script type="importmap">{mapped}</script>\n<script type="module">{_START}</script>'
    policy = f'{GENERATOR}\n<meta http-equiv="Content-Security-Policy" content="{_policy(mapped)}">'
    for old, new in {
        '<link rel="icon" href="icon.svg">': policy,
        STYLE_LINK: f"<style>{style}</style>",
        SCRIPT: inside,
    }.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    page = text.encode()
    if len(page) > MOST_BYTES:
        raise ValueError(
            f"the page would have {len(page):,} bytes; must be at most {MOST_BYTES:,}: share fewer scans, "
            "see --before and --after"
        )
    return page


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode()


def _policy(mapped: str) -> str:
    """Return the content policy of a page, which allows only its own two scripts."""
    hashes = " ".join(f"'sha256-{_base64(sha256(script.encode()).digest())}'" for script in (mapped, _START))
    return (
        f"default-src 'none'; script-src {hashes} data:; style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )


def is_page(path: Path) -> bool:
    """Return whether a file has the suffix of a page."""
    return path.suffix.lower() in (".html", ".htm")


def recording_in(path: Path) -> bytes:
    """Return the trace in a page. The page may come from anyone, so nothing else in it is read.

    Raises:
        ValueError: the file is larger than a page may be, or has no usable trace.
        OSError: the file can't be read.
    """
    with path.open("rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise ValueError(f"{path} is larger than a shared page, {MOST_BYTES:,} bytes")
    match = _RECORDING.search(content)
    if match is None:
        raise ValueError(f"{path} has no recording in it: scanrack share --with-recording puts it there")
    try:
        trace = base64.b64decode(match[1], validate=True)
    except ValueError as error:
        raise ValueError(f"{path}: its recording is damaged: {error}") from error
    if not TRACE.recognizes(trace):
        raise ValueError(f"{path}: its recording is damaged: it is not {TRACE.name}")
    return trace


def recording_beside(page: Path) -> Path:
    """Write the trace in a page to a file of the same name next to the page; return its path.

    Raises:
        ValueError: see `recording_in`; also if another file with that name exists.
        OSError: a file can't be read or written.
    """
    content, trace = recording_in(page), page.with_suffix(".mcap")
    if trace.is_symlink() or trace.exists():
        if not trace.is_file() or trace.read_bytes() != content:
            raise ValueError(f"{trace} is another file than the recording in {page}: move it away")
        return trace
    with new_file(trace, TRACE, "wb") as file:
        file.write(content)
    return trace
