"""The modules of the page import downward: none is in a circle.

Broken on purpose: `tag.js` imports from `actions.js`, `paneledit.js` from `panel.js`: red.
"""

import re
from graphlib import TopologicalSorter
from pathlib import Path

WEB = Path(__file__).parents[3] / "scanrack" / "watch" / "web"
IMPORT = re.compile(r'(?:from|import\()\s*"\./([a-z]+)\.js"')


def test_no_module_of_the_page_imports_itself_through_others():
    imports = {path.stem: IMPORT.findall(path.read_text("utf-8")) for path in WEB.glob("*.js")}
    assert imports["main"]
    order = list(TopologicalSorter(imports).static_order())  # a circle is a CycleError, which names it
    assert set(order) == set(imports)
