"""Function block diagrams of tests: imported, and followed scan by scan on both back ends."""

from typing import Any

import pytest
from l5x_files import block, document, ladder, program, reference, sheets, tag, task, wire
from scanrack.rockwell.l5x import import_l5x


def around(kind: str, operand: str, inputs: dict[str, str], outputs: dict[str, str], **arrays: str) -> str:
    """Return a sheet with one block: the references or numbers of its inputs, the tags of its outputs."""
    parts = [block(kind, 0, operand, x=200, **arrays)]
    for number, (pin, source) in enumerate(inputs.items(), start=1):
        parts.append(reference("IRef", number, source) + wire(number, f"0.{pin}"))
    for number, (pin, target) in enumerate(outputs.items(), start=100):
        parts.append(reference("ORef", number, target, x=400) + wire(f"0.{pin}", number))
    return sheets("Blocks", "".join(parts))


def open_diagram(
    path: Any, diagram: str, tags: dict[str, str], *, add_ons: Any = (), routines: Any = (), rate: float = 0
) -> tuple[Any, Any]:
    """Import a diagram with its tags by type, in a task of `rate` ms; return an engine of either kind."""
    main = program("P", ladder("Main", "JSR(Blocks,0);"), diagram, *routines)
    made = [tag(name, *kind.strip("]").split("[")) for kind, names in tags.items() for name in names.split()]
    run = task("T", "P", kind="PERIODIC" if rate else "CONTINUOUS", rate=rate)
    path.write_text(document(add_ons=add_ons, tags=made, programs=[main], tasks=[run]), encoding="utf-8")
    found = import_l5x(path)
    problems = [*found.report.refused, *found.report.objects]
    assert not problems, problems
    assert found.controller is not None
    return found.controller.compile(), found.controller.interpret()


def follow(engines: Any, *scans: tuple[dict[str, Any], dict[str, Any]], ms: float = 10) -> None:
    """Run scans, each the tags that change before it and all that is expected after it."""
    for engine in engines:
        for number, (changes, expected) in enumerate(scans):
            for name, value in changes.items():
                engine.tags[name] = value
            engine.step(ms)
            found = {name: engine.tags[name] for name in expected}
            assert found == pytest.approx(expected, rel=1e-5, abs=1e-6), (number, found, engine)
