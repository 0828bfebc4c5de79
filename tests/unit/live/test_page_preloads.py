"""The page names its modules, so that a browser loads them at once and not import by import.

Broken on purpose: one module left out, the source of shared pages not left out: the test turns red.
"""

import re
from importlib.resources import files

from scanrack.watch.gate import Gate

HOST = "127.0.0.1"


def test_the_page_names_each_module_that_it_imports_from_this_server() -> None:
    gate = Gate(HOST, 80, "00")
    page = gate.answer("/", HOST, None)
    assert page is not None
    named = re.findall(r'<link rel="modulepreload" href="/([a-z]+\.js)">', page.body.decode())
    assert page.headers["Content-Length"] == str(len(page.body))
    found, waiting = set(), ["main.js"]
    while waiting:
        name = waiting.pop()
        if name in found or name == "embedded.js":  # of shared pages
            continue
        found.add(name)
        text = files("scanrack.watch").joinpath("web", name).read_text(encoding="utf-8")
        waiting += re.findall(r'(?:from|import)\s*\(?\s*"\./([a-z]+\.js)"', text)
    assert sorted(named) == sorted(found)
