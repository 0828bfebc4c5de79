"""A name of an input or output is its address: forced and released as its address, and never written."""

from pathlib import Path
from typing import Any, cast

import pytest
from live_sessions import LiveSession
from recordings import opened
from scanrack import open_bench
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.ladder import LadderLogic
from scanrack.watch.history.catalog import Catalog, tag_hits
from scanrack.watch.monitors.questions import handle_message as ask
from typer.testing import CliRunner

PANEL = Path(__file__).parents[3] / "examples" / "three_stations_panel" / "line.toml"

NAMES = [
    ("Start", 1, "Local:2:I.Data[0].0"),
    ("lamp", 1, "Local:3:O.Data[0].0"),
    ("card.I.Data[3]", -7, "Local:1:I.Data[3]"),
    ("card.status.MOVE_COMPLETE", 1, "Local:1:I.Data[0].7"),  # 3601 manual, Status Bits
    ("slot2.input.start", 1, "Local:2:I.Data[0].0"),
    ("Local:2:I.Data.0", 1, "Local:2:I.Data[0].0"),
]
"""Names, a value, and the address of the same word or bit."""

IDS = [name for name, _value, _address in NAMES]


@pytest.mark.parametrize(("name", "value", "address"), NAMES, ids=IDS)
def test_a_session_forces_a_name_as_its_address_and_releases_it(name, value, address):
    orders = [(10, {"do": "force", "tag": name, "value": value}), (20, {"do": "unforce", "tag": name})]
    session = LiveSession(orders, rack=PANEL)
    forced: list[object] = []
    session.run.cpu.add_listener(_Noted(session.run.cpu, forced))
    assert session.play(30).refusals == []
    assert forced[15] == {address: value}
    assert forced[25] == {}


class _Noted:
    """Notes the forces of a CPU after each scan."""

    def __init__(self, cpu, forced):
        self._cpu, self._forced = cpu, forced

    def scan(self, _scan, _now_ns, _flags):
        self._forced.append(dict(self._cpu.forces.active))

    def event(self, *_told):
        pass

    def close(self):
        pass


ALIASED = """\
PROGRAM Line
TAG N : DINT
TAG Row : DINT[4]
TAG Fill : TIMER
ALIAS Copy : N
ALIAS Again : Copy
ALIAS Bit : Again.3
ALIAS Third : Row[2]
ALIAS Full : Fill.DN
ROUTINE Main
ADD(N,1,N)MOV(Third,Row[0])TON(Fill,1000,0);
END
"""
TWINS = [
    ("Copy", "N", 7),
    ("again", "N", 7),
    ("Bit", "N.3", True),
    ("Third", "Row[2]", 5),
    ("Full", "Fill.DN", True),
]
"""Aliases, their tags, and a value."""


@pytest.fixture
def aliased(tmp_path):
    (tmp_path / "line.rung").write_text(ALIASED, encoding="utf-8")
    slot = '[[slot]]\nnumber = 1\nmodule = "1769-IQ16"\n'
    text = f'name = "line"\nprogram = "line.rung"\nscan_ms = 2\nwatchdog_ms = 0\n{slot}'
    (tmp_path / "line.toml").write_text(text, encoding="utf-8")
    return tmp_path / "line.toml"


@pytest.mark.parametrize(("alias", "tag", "value"), TWINS)
def test_an_alias_of_a_tag_is_forced_and_released_as_the_tag(aliased, alias, tag, value):
    def force(name, value):
        return {"do": "force", "tag": name, "value": value}

    orders = [(5, force(alias, value)), (10, force(tag, value)), (15, {"do": "unforce", "tag": alias})]
    orders += [(20, force(tag, value)), (25, {"do": "unforce", "tag": alias})]
    session = LiveSession(orders, rack=aliased)
    program: Any = session.program
    forces: list[object] = []
    values: list[object] = []

    class Noted(_Noted):
        def scan(self, *_told):
            forces.append(program.forces)
            values.append(program.tags[alias])

    session.run.cpu.add_listener(Noted(session.run.cpu, []))
    assert session.play(30).refusals == []
    assert [forces[at] for at in (3, 7, 12, 17, 22, 27)] == [{}, *[{tag: value}] * 2, {}, {tag: value}, {}]
    assert values[7] == values[12] == values[22] == value
    assert program.tags[tag] == program.tags[alias]


def test_a_page_shows_a_forced_tag_at_its_alias(aliased):
    catalog = Catalog(cast(LadderLogic, load_job(str(aliased)).logic))
    names = [name for alias, tag, _value in TWINS for name in (alias, tag)]
    assert catalog.addresses([*names, "Nowhere"]) == {alias: tag for alias, tag, _value in TWINS}


@pytest.mark.parametrize("name", [*IDS, "card.I.Data"])
def test_a_name_of_an_image_is_not_written(name):
    session = LiveSession([(10, {"do": "write", "tag": name, "value": 1})], rack=PANEL).play(30)
    (refusal,) = session.refusals
    assert f"{name}" in refusal
    assert "force it instead" in refusal or "not allowed" in refusal
    assert session.run.cpu.fault is None


@pytest.mark.slow
def test_a_bench_forces_a_name_as_its_address():
    bench = open_bench(str(PANEL))
    bench.force("Start", 1)
    bench.scan(3)
    assert [bench[name] for name in ("Start", "Run", "Lamp")] == [True] * 3
    assert bench["slot2.input.start"] == 1
    assert dict(bench.cpu.forces.active) == {"Local:2:I.Data[0].0": 1}
    assert bench.why("Start") == "Start is on since 0 s: forced to 1 since 0 s"
    assert bench.chain("Start").text == "forced to 1 since 0 s"
    bench.unforce("Start")
    bench.force("Lamp", 0)
    bench.scan(2)
    assert bench["Run"]
    assert bench.slot[3].outputs[0] & 1 == 0
    for name in ("Start", "card.I.Data[0]", "card.I.Data"):
        with pytest.raises(ValueError, match="is an input image, which every scan overwrites; force it"):
            bench[name] = [1] * 8 if name.endswith("Data") else 1


@pytest.mark.slow
def test_a_session_with_a_forced_name_runs_again(tmp_path):
    trace = tmp_path / "forced.mcap"
    orders = [(10, {"do": "force", "tag": "Start", "value": 1}), (50, {"do": "unforce", "tag": "Start"})]
    LiveSession(orders, trace, PANEL).play(100)
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(trace)])
    assert done.exit_code == 0, done.output


FAULTS = [("card.I.Fault", "Local:1:I.Fault", -1, -1), ("Local:1:I.Fault.3", "card.I.Fault.3", True, 8)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "other", "value", "word"), FAULTS)
def test_the_fault_of_a_connection_is_forced_and_released_by_any_of_its_names(name, other, value, word):
    """A module that answers has fault 0: the program copies it to Module.Fault in the same scan."""
    bench = open_bench(str(PANEL))
    bench.scan(2)
    bench.force(name, value)
    bench.scan(3)
    assert (bench["card.I.Fault"], bench["Module.Fault"]) == (word, word)
    assert f": forced to {int(value)} since 0.004 s" in bench.why(other)
    assert bench.chain("Module.Fault").causes[0][0].text == f"forced to {word}"
    bench.unforce(other)
    bench.scan(1)
    assert (bench["card.I.Fault"], bench["Module.Fault"]) == (0, 0)
    with pytest.raises(ValueError, match=r"is an input image, .*force it instead"):
        bench[name] = value


@pytest.mark.slow
def test_a_session_with_a_forced_fault_runs_again(tmp_path):
    trace = tmp_path / "forced.mcap"
    orders = [
        (10, {"do": "force", "tag": "card.I.Fault", "value": -1}),
        (50, {"do": "unforce", "tag": "all"}),
    ]
    session = LiveSession(orders, trace, PANEL).play(100)
    assert session.refusals == []
    done = CliRunner().invoke(build(), ["replay", "--into", "session", str(trace)])
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("Start", "Start is itself an input, slot 2 input 0: switch it there"),
        (
            "card.status.MOVE_COMPLETE",
            "card.status.MOVE_COMPLETE is a value that a module reports: let the module report it",
        ),
        ("card.I.Fault.0", "card.I.Fault.0 is a value that a module reports"),
    ],
)
def test_of_an_input_it_is_said_what_gives_it_a_value(name, says):
    bench = open_bench(str(PANEL))
    bench.scan(1)
    said = str(bench.suggest_inputs(name, "on"))
    assert said.startswith(says)
    assert said.endswith("or force it")


PYTHON = """\
from scanrack import Input, Logic, Output


class Small(Logic):
    go = Input("slot2.input.start")
    lamp = Output("slot3.output.lamp")

    def every_scan(self):
        self.lamp = self.go.read()
"""


@pytest.fixture
def small(tmp_path):
    """The panel's rack with a program in Python."""
    (tmp_path / "small.py").write_text(PYTHON, encoding="utf-8")
    text = PANEL.read_text(encoding="utf-8").replace('tags = ["Run", "Step", "Dwell.*"]', "")
    text = text.replace("line.rung", "small.py")
    (tmp_path / "small.toml").write_text(text[: text.index("[[prove")], encoding="utf-8")
    return tmp_path / "small.toml"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["go", "small.go"])
def test_an_input_of_a_python_program_is_its_address(small, tmp_path, name):
    bench = open_bench(str(small))
    bench.force(name, 1)
    bench.scan(2)
    assert dict(bench.cpu.forces.active) == {"Local:2:I.Data[0].0": 1}
    assert bench.slot[3].outputs[0] & 1
    bench.unforce(name)
    trace = tmp_path / "small.mcap"
    orders = [(10, {"do": "force", "tag": name, "value": 1}), (20, {"do": "write", "tag": name, "value": 1})]
    session = LiveSession(orders, trace, small).play(40)
    assert [each for each in session.refusals if "force it instead" not in each] == []
    assert dict(session.run.cpu.forces.active) == {"Local:2:I.Data[0].0": 1}


@pytest.mark.slow
def test_inputs_of_a_python_program_are_found_watched_and_in_the_strip(small, tmp_path):
    trace = tmp_path / "small.mcap"
    done = CliRunner().invoke(build(), ["run", str(small), "--scans", "300", "--record", str(trace), "-q"])
    assert done.exit_code == 0, done.output
    with opened(trace, tmp_path, 250, trust=True) as found:
        found.settle()
        assert "small.go" in [each["tag"] for each in asked(found, "find", text="Data[0].0")["hits"]]
        watched = asked(found, "watch", tags=["small.go"])
        assert watched == watched | {"unknown": [], "addresses": {"small.go": "Local:2:I.Data[0].0"}}
        assert asked(found, "since", tag="small.go")["since"]["scan"] == 250  # 0.5 s of 2 ms scans
        steps = asked(found, "steps", **{"from": 240, "to": 260}, tags=["small.go", "small.lamp"])
        assert steps["lanes"]["tags"] == {
            "small.go": [[480_000_000, 0], [500_000_000, 1]],
            "small.lamp": [[480_000_000, 0], [500_000_000, 1]],
        }


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """A recording of the panel's first 600 scans, whose Start is pressed at 0.5 s, with one page."""
    folder = tmp_path_factory.mktemp("panel")
    done = CliRunner().invoke(
        build(), ["run", str(PANEL), "--scans", "600", "--record", str(folder / "panel.mcap"), "-q"]
    )
    assert done.exit_code == 0, done.output
    with opened(folder / "panel.mcap", folder, 300) as found:
        found.settle()
        yield found


def asked(seen, do, **fields):
    seen.page.outbox.clear()
    ask(seen.monitor, seen.page, {"id": 1, "do": do, **fields})
    return seen.page.outbox[-1]["answer"]


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("step", "Step"),  # before Axis.Step
        ("lamp", "Lamp"),
        ("card.I", None),  # a rung
        ("slot3.output.middle_lamp", "Local:3:O.Data[0].1"),
        ("local:1:i.data[3]", "Local:1:I.Data[3]"),
        ("Local:2:I.Data[0].1", "Local:2:I.Data[0].1"),
    ],
)
def test_find_lists_aliases_and_addresses_and_the_name_itself_first(seen, text, first):
    hits = asked(seen, "find", text=text)["hits"]
    assert hits[0]["tag"] == first


def test_find_lists_the_alias_of_an_address_and_names_that_begin_before_names_inside(seen):
    assert {"Stop", "Local:2:I.Data[0].1"} <= {
        each["tag"] for each in asked(seen, "find", text="Local:2:I.Data[0].1")["hits"]
    }
    tags = [each["tag"] for each in asked(seen, "find", text="dwell.")["hits"] if each["tag"]]
    assert tags[0].startswith("Dwell.")
    ranks = [hit["tag"] for hit in tag_hits([_tag("Axis.Step"), _tag("Steps"), _tag(r"\Main.Step")], "step")]
    assert ranks == [r"\Main.Step", "Steps", "Axis.Step"]
    assert tag_hits([_tag("Run", "starts a step")], "STEP")[0]["says"] == "DINT  starts a step"


def _tag(name, description=""):
    return {"name": name, "type": "DINT", "description": description}


@pytest.mark.parametrize(("name", "_value", "address"), NAMES, ids=IDS)
def test_a_name_of_an_image_can_be_watched(seen, name, _value, address):
    answer = asked(seen, "watch", tags=[name, "Nothing"])
    assert answer["addresses"] == {name: address}
    assert answer["unknown"] == ["Nothing"]


@pytest.mark.parametrize("name", ["slot2.input.start", "Start", "Local:2:I.Data[0].0", "I:2/0"])
def test_any_name_of_an_input_is_in_the_strip(seen, name):
    assert asked(seen, "lanes", tags=[name, "Nothing"])["unknown"] == ["Nothing"]
    steps = asked(seen, "steps", **{"from": 240, "to": 400}, tags=[name, "Run"])
    assert steps["lanes"]["tags"][name] == [[480_000_000, 0], [500_000_000, 1], [700_000_000, 0]]
    assert steps["lanes"]["tags"]["Run"] == [[480_000_000, 0], [500_000_000, 1]]
    assert steps["lanes"]["to"] == 802_000_000
    alone = asked(seen, "steps", **{"from": 240, "to": 400}, tags=[name])
    assert alone["lanes"]["tags"] == {name: steps["lanes"]["tags"][name]}


def test_why_uses_and_since_take_the_name_that_a_module_gives(seen):
    assert "The start input is energized" in asked(seen, "why", tag="slot2.input.start")["text"]
    assert {each["rung"] for each in asked(seen, "xref", tag="slot2.input.start")["hits"]} == {"Main.0"}
    assert asked(seen, "since", tag="Start")["since"]["scan"] == 250  # 0.5 s of 2 ms scans


def test_a_page_knows_the_addresses_of_names(seen):
    routine = asked(seen, "show", routine="Main", columns=88)
    assert routine["addresses"] == {
        "Start": "Local:2:I.Data[0].0",
        "Stop": "Local:2:I.Data[0].1",
        "AtMiddle": "Local:2:I.Data[0].2",
        "Lamp": "Local:3:O.Data[0].0",
        "MiddleLamp": "Local:3:O.Data[0].1",
        "card.status.POSITION_INVALID": "Local:1:I.Data[0].10",  # 3601 manual, Status Bits
        "card.I.Data[0]": "Local:1:I.Data[0]",
        "card.I.Fault": "Local:1:I.Fault",
        "card.O.Data[0]": "Local:1:O.Data[0]",
    }
    tags = {each["name"]: each for each in seen.page.program.described({})["tags"]}
    assert tags["Lamp"] == {
        "name": "Lamp",
        "type": "BOOL",
        "description": "Local:3:O.Data.0",
        "writable": False,
        "address": "Local:3:O.Data[0].0",
    }
