"""The mutation tester's own operators: which mutants a source has, and what they look like."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import house
import pytest
from scanrack.io_images.amci3601 import RULES

ROOT = Path(__file__).parents[3]


@pytest.fixture(autouse=True, scope="module")
def _benchmarks_can_be_imported():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "benchmarks")
        before = set(sys.modules)
        yield
        for name in set(sys.modules) - before:
            if name.partition(".")[0] in ("mutation", "mutants"):
                del sys.modules[name]


@pytest.mark.slow
def test_the_copy_has_a_file_of_each_room_where_it_is_looked_for(tmp_path):
    """A mutant of a room in `scanrack` was never reached: it was put where nothing is imported from."""
    from mutation.rooms import ROOMS
    from mutation.trials import ProjectCopy

    copy = ProjectCopy(ROOT, tmp_path)
    missing = [
        path for room in ROOMS.values() for path in room.files(ROOT).values() if not copy.file(path).is_file()
    ]
    assert missing == []
    assert copy.file("scanrack/watch/play.py").read_bytes() == (ROOT / "scanrack/watch/play.py").read_bytes()


def mutations(source):
    """Return (operator, mutated source) of every mutant."""
    from mutation.operators import mutants_of

    return [(mutant.kind, mutant.apply(source)) for mutant in mutants_of("x.py", source)]


@pytest.mark.parametrize(
    ("source", "wanted"),
    [
        ("if f(a): b = c", {("condition", "if not (f(a)): b = c")}),
        ("x = b if a else c", {("condition", "x = b if not (a) else c")}),
        ("while a: b = c", {("condition", "while not (a): b = c")}),
        ("x = [a for a in b if a.c]", {("condition", "x = [a for a in b if not (a.c)]")}),
        ("if not a: b = c", {("not", "if a: b = c")}),
        (
            "x = not (a or b)",
            {("not", "x = (a or b)"), ("operand", "x = not (a)"), ("operand", "x = not (b)")},
        ),
        ("x = a and b", {("connective", "x = (a or b)"), ("operand", "x = a"), ("operand", "x = b")}),
        (
            "x = (a or b) and c",
            {
                ("connective", "x = ((a or b) or c)"),
                ("operand", "x = (a or b)"),
                ("operand", "x = c"),
                ("connective", "x = ((a and b)) and c"),
            },
        ),
        ("x = a < b", {("comparison", "x = a <= b")}),
        ("x = a >= b", {("comparison", "x = a > b")}),
        ("x = a <= b < c", {("comparison", "x = a < b < c"), ("comparison", "x = a <= b <= c")}),
        ("if a == b: c = d", {("comparison", "if a != b: c = d")}),  # the negation is the same
        ("if a < b: c = d", {("comparison", "if a <= b: c = d"), ("condition", "if not (a < b): c = d")}),
        ("x = a is not None", {("comparison", "x = a is None")}),
        ("x = a not in b", {("comparison", "x = a in b")}),
        ("f(x)", {("statement", "pass")}),
        ("a |= b", {("statement", "pass")}),
        ("x = f(alone=True)", {("truth", "x = f(alone=False)")}),
        ("x = f(STOPPED | a)", {("status bit", "x = f(0 | a)")}),
        ("x = a[2]", {("number", "x = a[3]")}),
        ("x = a + b", {("sign", "x = a - b")}),
        ("x = -a", {("sign", "x = a")}),
        ("x = -1", {("sign", "x = 1")}),
    ],
)
def test_operators(source, wanted):
    found = mutations(source)
    assert wanted <= set(found)
    assert len(found) == len(set(found))
    for _, mutated in found:
        ast.parse(mutated)


def test_a_negation_that_another_operator_makes_is_not_made_twice():
    assert mutations("if a is None: b = c") == [("comparison", "if a is not None: b = c")]
    assert mutations("if not a: b = c") == [("not", "if a: b = c")]


@pytest.mark.parametrize(
    "source",
    [
        '"""Docstring."""',
        "import a",
        "from a import b",
        "assert a is not None",
        "if TYPE_CHECKING:\n    from a import b",
        "raise ValueError(a + 1)",
        "def f(a: int = 1) -> int | None: ...",
        "x = f'{a + 1}'",
        "x: Literal[1]",
        "x = 'a'",
    ],
)
def test_what_has_no_mutants(source):
    assert mutations(source) == []


def test_a_predicate_is_negated_where_it_returns():
    source = "def f(a) -> bool:\n    return bool(a & b)"
    assert ("condition", "def f(a) -> bool:\n    return not (bool(a & b))") in mutations(source)
    assert mutations("def f(a) -> int:\n    return g(a)") == []


def test_attributes_keep_their_values_except_in_a_constructor():
    method = "class A:\n    def {}(self):\n        self.a = b"
    assert mutations(method.format("f")) == [("statement", method.format("f").replace("self.a = b", "pass"))]
    assert mutations(method.format("__init__")) == []


TABLE = """\
HELD = Refusal("HLD-11", held)
START: Refusals = (
    Refusal("CMD-03", busy),
    HELD,
    Refusal("CMD-04", wrong),
)
MOVE: Refusals = (*START, Refusal("CMD-06", invalid))
ONE: Refusals = (Refusal("RST-02", not_zero),)
"""


def test_rows_of_refusals_are_taken_out_and_change_places():
    from mutation.operators import mutants_of

    def rows(name, mutant):
        tree = ast.parse(mutant.apply(TABLE))
        [table] = [s for s in tree.body if isinstance(s, ast.AnnAssign) and ast.unparse(s.target) == name]
        assert isinstance(table.value, ast.Tuple | ast.List)
        return [ast.unparse(row).replace("'", "") for row in table.value.elts]

    found = mutants_of("x.py", TABLE)
    first, second, third = "Refusal(CMD-03, busy)", "HELD", "Refusal(CMD-04, wrong)"
    assert [(m.kind, rows(m.scope, m), m.rules) for m in found if m.scope == "START"] == [
        ("row", [second, third], ("CMD-03",)),
        ("order", [second, first, third], ("CMD-03", "HLD-11")),
        ("row", [first, third], ("HLD-11",)),
        ("order", [first, third, second], ("HLD-11", "CMD-04")),
        ("row", [first, second], ("CMD-04",)),
    ]
    assert sorted((m.kind, rows(m.scope, m), m.rules) for m in found if m.scope == "MOVE") == [
        ("order", ["Refusal(CMD-06, invalid)", "*START"], ("CMD-03", "HLD-11", "CMD-04", "CMD-06")),
        ("row", ["*START"], ("CMD-06",)),
        ("row", ["Refusal(CMD-06, invalid)"], ("CMD-03", "HLD-11", "CMD-04")),
    ]
    assert [(m.kind, rows(m.scope, m)) for m in found if m.scope == "ONE"] == [("row", [])]


def test_a_mutant_knows_where_it_is():
    from mutation.operators import mutants_of

    source = "class A:\n    def f(self):\n        g(\n            'µs',\n            a[1],\n        )\n"
    number = next(m for m in mutants_of("x.py", source) if m.kind == "number")
    assert (number.scope, number.first_line, number.line, number.last_line) == ("A.f", 3, 5, 5)
    assert number.diff(source) == "-            a[1],\n+            a[2],"


def test_effects_of_rules_follow_from_how_they_are_fired():
    from mutation.effects import effects_of, fired

    used = fired(
        [
            'self.fire(now, "CMD-04")\nself.fire(now, "HOM-01", alone=True)\n'
            'self.fire(now, "CMD-12", bits=COMMAND_ERROR)\n'
            'fault = ("CMD-13", None)\nother = ("CMD-15", BITS)\n'
            'return "CMD-30"\nx = "no rule"'
        ],
        RULES,
    )
    assert used.partners == {"CMD-04", "CMD-13", "CMD-30"}
    assert used.own_bits == {"CMD-04", "PRF-02", "HOM-01", "CMD-13", "PRF-09", "CMD-30"}

    source = (
        'ROWS = (\n    Rule("CMD-04", "s", "t", COMMAND_ERROR, together_with=("PRF-02",)),\n'
        '    Rule("HOM-01", "s", "t", HOME_INVALID, together_with=("CMD-05", "PRF-01")),\n'
        '    Rule("CMD-12", "s", "t", COMMAND_ERROR),\n)'
    )
    found = effects_of("x.py", source, RULES, used)
    assert [(m.scope, m.kind, m.new) for m in found] == [
        ("CMD-04", "effect COMMAND_ERROR", "(COMMAND_ERROR) & ~0x1000"),
        ("CMD-04", "partner PRF-02", "()"),
        ("HOM-01", "effect HOME_INVALID", "(HOME_INVALID) & ~0x0100"),
    ]


def test_every_package_with_code_belongs_to_a_room():
    import mutants

    tried = {ROOT / path for room in mutants.ROOMS.values() for path in room.files(ROOT).values()}
    tried |= {
        ROOT / mutant.path for mutant in mutants.all_mutants(mutants.ROOMS["amci3601"], [mutants.TABLE])
    }
    code = {path for room in house.ROOMS for path in (ROOT / room).rglob("*.py")}
    folders = {path.parent for path in code if path.name != "__init__.py" and "templates" not in path.parts}
    left = folders - {path.parent for path in tried}
    assert left == set(), "give them a room in tests/tools/mutation/rooms.py"


def test_the_copy_in_which_mutants_are_made_has_every_folder_of_packages():
    from mutation.trials import BESIDE, FRONT, ROOMS

    assert {"scanrack", *house.BESIDE} <= {FRONT, *ROOMS, *BESIDE}


def test_every_room_has_files_and_each_of_its_patterns_finds_tests():
    import mutants

    for name, room in mutants.ROOMS.items():
        assert room.files(ROOT), name
        for pattern in room.tests:
            assert mutants.test_files([pattern]), f"{name}: {pattern}"


@pytest.mark.slow
def test_every_mutant_of_the_layer_is_python():
    import mutants

    found = mutants.all_mutants(mutants.ROOMS["amci3601"], ["refusals", "latches"])
    assert len(found) > 200
    for mutant in found:
        source = (ROOT / mutant.path).read_text(encoding="utf-8")
        mutated = mutant.apply(source)
        assert mutated != source
        compile(mutated, mutant.path, "exec")


def test_smoke_mutants_and_known_equivalents_still_exist():
    import mutants
    from mutation.known import EQUIVALENT, SMOKE
    from mutation.operators import mutants_of

    for row in SMOKE:
        assert mutants._smoke_mutant(*row)
    there = {
        (path, mutant.scope, mutant.old, mutant.new)
        for path in {known.path for known in EQUIVALENT}
        for mutant in mutants_of(path, (ROOT / path).read_text(encoding="utf-8"))
    }
    gone = [known for known in EQUIVALENT if known[:4] not in there]
    assert gone == []
    assert all(known.reason for known in EQUIVALENT)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("room", "some"),
    [
        ("amci3601", ["refusals", "rules"]),
        ("pcl601", ["pcl601_motor", "program/machine"]),
        ("pmc006", ["pmc006_motor"]),
        ("adapters", ["driver", "pcl601/driver"]),
        ("ladder", ["model/arithmetic", "compiler/value_writer"]),
        ("line", ["rtu", "pcl601_pdus"]),
        ("traces", ["repair", "plot/chart"]),
        ("io_images", ["thousands", "pcl601/program/text"]),
    ],
)
def test_every_room_has_files_and_tests(room, some):
    import mutants

    names = mutants.names_in(mutants.ROOMS[room])
    assert {*some} <= {*names}
    assert ("rules" in names) == (room == "amci3601")
    for pattern in mutants.ROOMS[room].tests:
        assert mutants.test_files([pattern]), pattern
    assert len(mutants.all_mutants(mutants.ROOMS[room], some)) > 50


def test_a_file_of_another_room_is_refused(capsys):
    import mutants

    with pytest.raises(SystemExit):
        mutants.parse(["--room", "pmc006", "--files", "refusals"])
    assert "--files refusals: the room pmc006 has controller" in " ".join(
        capsys.readouterr().err.split()
    ).replace("__init__ ", "")


def test_the_rule_table_has_mutants():
    """Which rows count is read off the layer's sources, so this fails where they are looked for elsewhere."""
    import mutants

    assert len(mutants.all_mutants(mutants.ROOMS["amci3601"], ["rules"])) > 50


@pytest.mark.slow
def test_a_private_copy_is_a_package_like_the_installed_one(tmp_path):
    """Without the front door the copy would be a namespace, and the installed project would win over it."""
    from mutation.trials import ProjectCopy

    copy = ProjectCopy(ROOT, tmp_path)
    assert (copy.package / "__init__.py").read_text(encoding="utf-8") == (
        ROOT / "scanrack" / "__init__.py"
    ).read_text(encoding="utf-8")
    assert (copy.package / "runtime" / "modules" / "amci3601" / "refusals.py").exists()
