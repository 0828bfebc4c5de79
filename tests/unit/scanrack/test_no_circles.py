"""No module imports, in whatever way, one that imports it: at run time, when asked, or for types only."""

from __future__ import annotations

from graphlib import CycleError, TopologicalSorter

import pytest


@pytest.mark.slow
def test_no_import_goes_in_a_circle() -> None:
    grimp = pytest.importorskip("grimp", reason="import-linter brings it")
    graph = grimp.build_graph("scanrack", cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert imports["scanrack.ladder"] >= {
        "scanrack.ladder.draw",
        "scanrack.ladder.prove.answers",
    }  # lazy ones
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))
