"""Partners in `[stubs]`: what consumed tags and messages get, and racks that run beside one another."""

import json
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import l5x_files as files
import pytest
from scanrack import BOOL, DINT, EQU, OTE, load_rack
from scanrack.commands import build
from scanrack.jobs import JobRun, load_job
from scanrack.ladder import Controller, LadderLogic
from scanrack.runtime import RackFileError
from typer.testing import CliRunner

ROOT = Path(__file__).parents[3]
SLOT = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
LINE = """PROGRAM line
TYPE FromTwo (Status : CONNECTION_STATUS, Count : DINT, Ready : BOOL)
TAG In : FromTwo
TAG Level : DINT
TAG Copy : DINT[4]
TAG Order : MESSAGE
TAG Go : BOOL
TAG Sum : DINT
ROUTINE Main
XIC(Go)MSG(Order);
ADD(In.Count,Level,Sum);
END
"""
TWO = """PROGRAM two
TYPE ToOne (Status : CONNECTION_STATUS, Count : DINT, Ready : BOOL)
TAG Out : ToOne
TAG Numbers : DINT[4] := [1, 2, 3, 4]
ROUTINE Main
ADD(Out.Count,1,Out.Count);
OTE(Out.Ready);
END
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.rung").write_text(LINE, encoding="utf-8")
    (tmp_path / "two.rung").write_text(TWO, encoding="utf-8")
    two = f'program = "two.rung"\nscan_ms = 5\n{SLOT}'
    (tmp_path / "two.toml").write_text(two, encoding="utf-8")
    return tmp_path


def logic_of(job):
    assert isinstance(job.logic, LadderLogic)
    return job.logic


def write(folder, *stubs):
    text = "\n".join(['program = "line.rung"', "scan_ms = 10", "[stubs]", *stubs, SLOT])
    (folder / "line.toml").write_text(text, encoding="utf-8")


DONE = 'MSG = "done after 20 ms"'


def both(folder, *stubs):
    """Yield a CPU and its engine, for both back ends."""
    write(folder, *stubs)
    for interpreted in (False, True):
        job = load_job("line.toml")
        engine = logic_of(job).interpret() if interpreted else logic_of(job).engine
        with ExitStack() as stack:
            run = JobRun(replace(job, logic=engine), stack)
            yield stack.enter_context(run.cpu), engine.tags


def test_a_constant_and_a_table_fill_consumed_tags(folder):
    """Scans every 10 ms, samples every 20 ms: the change at 30 ms is seen at 40 ms."""
    level = "Level = { table = [{ value = 5 }, { at_ms = 30, value = 7 }] }"
    for cpu, tags in both(folder, DONE, "In = { value = { Count = 3 } }", level):
        seen = []
        for _ in range(6):
            cpu.run(1)
            seen.append(tags.Sum)
        assert seen == [8, 8, 8, 8, 10, 10]
        assert tags["In.Status"] == {"RunMode": True, "ConnectionFaulted": False}


def test_a_scan_between_two_samples_gets_the_one_before(folder):
    """Scans at 0, 30, 60 ms; samples of 0, 20, 60 ms: what changes at 25 ms is seen at 60 ms."""
    write(folder, DONE, "Level = { table = [{ value = 5 }, { at_ms = 25, value = 7 }] }")
    text = (folder / "line.toml").read_text(encoding="utf-8").replace("scan_ms = 10", "scan_ms = 30")
    (folder / "line.toml").write_text(text, encoding="utf-8")
    job, seen = load_job("line.toml"), []
    with ExitStack() as stack:
        cpu = stack.enter_context(JobRun(job, stack).cpu)
        for _ in range(3):
            cpu.run(1)
            seen.append(logic_of(job).tags.Level)
    assert seen == [5, 5, 7]


def test_a_broken_connection_keeps_the_data(folder):
    broken = "{ at_ms = 40, faulted = true, value = { Count = 9 } }"
    broken += ", { at_ms = 80, value = { Count = 4 }, running = false }"
    for cpu, tags in both(folder, DONE, f"In = {{ table = [{{ value = {{ Count = 3 }} }}, {broken}] }}"):
        cpu.run(5)
        assert (tags.Sum, tags["In.Status"]) == (3, {"RunMode": False, "ConnectionFaulted": True})
        cpu.run(4)
        assert (tags.Sum, tags["In.Status"]) == (4, {"RunMode": False, "ConnectionFaulted": False})


def test_another_rack_runs_beside(folder):
    """It scans every 5 ms; at 20 ms four scans have begun before, at 40 ms eight."""
    for cpu, tags in both(folder, DONE, 'In = { rack = "two.toml", tag = "Out" }'):
        seen = []
        for _ in range(5):
            cpu.run(1)
            seen.append((tags.Sum, tags["In.Ready"], tags["In.Status.RunMode"]))
        assert seen == [(0, False, True)] * 2 + [(4, True, True)] * 2 + [(8, True, True)]


def test_racks_may_name_each_other(folder):
    """Two consumes Sum of line at 20 ms, and line Count of two: each sees what the other was."""
    back = 'program = "two.rung"\nscan_ms = 5\n[stubs]\n"Numbers[0]" = { rack = "line.toml", tag = "Sum" }\n'
    (folder / "two.toml").write_text(back + SLOT, encoding="utf-8")
    stubs = ('In = { rack = "two.toml", tag = "Out" }', 'Level = { rack = "two.toml", tag = "Numbers[0]" }')
    for cpu, tags in both(folder, DONE, *stubs):
        seen = []
        for _ in range(7):
            cpu.run(1)
            seen.append((tags.Level, tags.Sum))
        # two's number is 1, from its first scan on line's Sum: 0 at 0 ms, 1 at 20 ms, 4 at 40 ms
        assert seen == [(1, 1), (1, 1), (0, 4), (0, 4), (1, 9), (1, 9), (4, 16)]


def test_messages_end_as_they_are_told_and_bring_data(folder):
    for cpu, tags in both(folder, 'Order = { after_ms = 20, value = [7, 8], to = "Copy[1]" }'):
        tags.Go = True
        cpu.run(2)
        assert (tags["Order.DN"], tags.Copy) == (False, [0, 0, 0, 0])
        cpu.run(1)
        assert (tags["Order.DN"], tags.Copy) == (True, [0, 7, 8, 0])
    for cpu, tags in both(
        folder, 'Order = { after_ms = 20, rack = "two.toml", tag = "Numbers", to = "Copy" }'
    ):
        tags.Go = True
        cpu.run(3)
        assert (tags["Order.DN"], tags.Copy) == (True, [1, 2, 3, 4])
    for cpu, tags in both(folder, "Order = { after_ms = 10, error = 0xCB }"):
        tags.Go = True
        cpu.run(3)
        assert (tags["Order.ER"], tags["Order.ERR"]) == (True, 0xCB)
    for cpu, tags in both(folder, 'Order = "waits"'):
        tags.Go = True
        cpu.run(500)
        assert (tags["Order.EN"], tags["Order.DN"], tags["Order.ER"]) == (True, False, False)
        tags["Order.TO"] = True
        cpu.run(1)
        assert (tags["Order.ER"], tags["Order.ERR"]) == (True, 1)


def test_a_run_names_its_partners_and_a_rerun_brings_the_other_rack(folder, monkeypatch):
    write(folder, DONE, 'In = { rack = "two.toml", tag = "Out" }')
    status = CliRunner().invoke(build(), ["run", "line.toml", "--scans", "9", "--record", "a.mcap", "--json"])
    assert "IN = Out of two.toml" in json.loads(status.stdout)["stubs"]
    (folder / "elsewhere").mkdir()
    monkeypatch.chdir(folder / "elsewhere")
    again = CliRunner().invoke(build(), ["replay", "--into", "session", "../a.mcap"])
    assert (again.exit_code, "identical byte for byte" in again.output) == (0, True), again.output


CONSUMED = """<Tag Name="Level" TagType="Consumed" DataType="DINT">
<ConsumeInfo Producer="Two" RemoteTag="Numbers[2]" RPI="30.0"/></Tag>"""
MESSAGE = """<Tag Name="Order" TagType="Base" DataType="MESSAGE"><Data Format="Message"><MessageParameters
MessageType="CIP Data Table Read" RequestedLength="2" DestinationTag="Copy[0]"/></Data></Tag>"""


def test_an_export_says_the_tag_the_interval_and_the_destination(folder):
    tags = (CONSUMED, MESSAGE, files.tag("Go", "BOOL"), files.tag("Copy", "DINT", "4"))
    (folder / "line.L5X").write_text(files.machine("XIC(Go)MSG(Order);", tags=tags), encoding="utf-8")
    stubs = 'Level = { rack = "two.toml" }\nOrder = { after_ms = 0, value = [5, 6] }'
    text = f'program = "line.L5X"\n[stubs]\n{stubs}\n{SLOT}'
    (folder / "line.toml").write_text(text, encoding="utf-8")
    job = load_job("line.toml")
    (connection,) = logic_of(job).build().connections
    assert connection.rpi_ns == 30_000_000
    with ExitStack() as stack:
        cpu = stack.enter_context(JobRun(job, stack).cpu)
        logic_of(job).tags.Go = True
        cpu.run(3)
    assert (logic_of(job).tags.Level, logic_of(job).tags.Copy) == (3, [5, 6, 0, 0])


@pytest.mark.parametrize(
    ("stubs", "says"),
    [
        (("In = { value = 5 }",), "In: 5 is not a dict of members of FromTwo"),
        (("Inn = { value = 5 }",), "no tag INN"),
        (('In = { rack = "two.toml" }',), "give the tag of two.toml"),
        (('In = { rack = "two.toml", tag = "Nothing" }',), "two.toml has no tag Nothing"),
        (('In = { rack = "none.toml", tag = "Out" }',), "no such rack file"),
        (("Order = { after_ms = 5, value = 3 }",), "no tag for the data; name one"),
        (("In = { rpi_ms = 5 }",), "line.toml:5: stubs.In: a consumed tag needs value, table or rack"),
        (("Order = { after_ms = 5, rpi_ms = 5 }",), "only a consumed tag has this key"),
        (("In = { vallue = 5 }",), "line.toml:5: stubs.In.vallue: unknown key; did you mean value"),
        (("In = { table = [{ at = 5 }] }",), "did you mean at_s"),
        (("In = { table = [{ at_ms = 5 }, { at_ms = 5 }] }",), "each entry must be later than the entry"),
        (('In = { value = 1, rack = "two.toml" }',), "this table has value already"),
    ],
)
def test_what_is_refused(folder, stubs, says):
    write(folder, DONE, *stubs)
    with pytest.raises(RackFileError) as refused:
        load_job("line.toml")
    assert says in str(refused.value)


RACK_IN_PYTHON = """from scanrack import BOOL, DINT, EQU, OTE, Program, RackSpec, SlotSpec

plant = Program("plant")
level, lamp = plant.declare("Level", DINT), plant.declare("Lamp", BOOL)


@plant.routine
def lamps(rung):
    rung(EQU(level, 8), OTE(lamp))


def rack():
    stubs = {"Level": {"value": 8}}
    return RackSpec(program=plant, stubs=stubs, slot=[SlotSpec(number=1, module="amci3601")])
"""


def plant():
    controller = Controller("plant")
    level, lamp = controller.declare("Level", DINT), controller.declare("Lamp", BOOL)
    main = controller.program("Main")

    @main.routine
    def lamps(rung):
        rung(EQU(level, 8), OTE(lamp))

    return controller


def test_a_program_object_takes_the_stubs_of_its_rack(folder):
    """`load_rack` with an object, and a rack in Python with one."""
    write(folder, "Level = { value = 8 }")
    job = load_rack("line.toml", plant())
    with ExitStack() as stack:
        stack.enter_context(JobRun(job, stack).cpu).run(2)
    assert (logic_of(job).tags.Lamp, job.stubs) == (True, ("LEVEL = a constant",))
    (folder / "rack.py").write_text(RACK_IN_PYTHON, encoding="utf-8")
    assert load_job("rack.py").stubs == ("LEVEL = a constant",)


@pytest.mark.slow
def test_the_palletizer_of_the_examples_places_a_labeled_box():
    """A pitch takes 1.5 s from power-up, sampled every 20 ms; the grip 0.4 s more."""
    job = load_job(str(ROOT / "examples/l5x/palletizer.toml"))
    with ExitStack() as stack:
        cpu = stack.enter_context(JobRun(job, stack).cpu)
        cpu.run(1_900 // 5)
        assert logic_of(job).tags.Placed == 0
        cpu.run(100 // 5)
    box = logic_of(job).tags["Layer"][0]
    assert (logic_of(job).tags.Placed, box["Label"], box["At"]) == (1, "PEACH-1", 250.0)
