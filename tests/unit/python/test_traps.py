"""The traps of sequences, a test for each: what a user does wrong, and what the CPU says to it."""

import gc
import textwrap
from typing import Any

import pytest
from scanrack import (
    Abort,
    Axis3601,
    AxisError,
    Input,
    Logic,
    Output,
    OutputWord,
    State,
    all_of,
    dwell,
    first_of,
    sequence,
    steady,
    until,
)
from scanrack.jobs import ProgramError, load_program
from scanrack.ladder.python.sequences import fresh
from scanrack.runtime import CpuFault
from sequence_bench import SETUP, SLOW, SequenceBench


def load(tmp_path, body, name="line.py"):
    """Load a program of which `body` is the class body."""
    text = HEAD + textwrap.indent(textwrap.dedent(body), "    ")
    (tmp_path / name).write_text(text, encoding="utf-8")
    return load_program(name, tmp_path).function


HEAD = """\
from scanrack import *
from scanrack import within

class Line(Logic):
    axis = Axis3601(1, Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500))
    start = Input("start")
    lamp: Output = Output("Local:2:O.Data.0")

"""
BODY_LINE = HEAD.count("\n") + 1


def fault_of(logic, scans=5):
    """Run until the CPU faults; return the fault."""
    bench = SequenceBench(logic)
    with pytest.raises(CpuFault) as caught:
        bench.scan(scans)
    return caught.value.fault


# -- refused when the class is made


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("@sequence\ndef cycle(self):\n    pass", r"line\.py:9: Line\.cycle is not an `async def` method"),
        ("@sequence\nasync def cycle(self):\n    yield 1", r"line\.py:9: Line\.cycle has a yield"),
        ("@sequence\nasync def cycle(self, n):\n    pass", r"line\.py:9: Line\.cycle has arguments"),
        ("stations = [0, 4000]", r"Line\.stations is a list, which all instances would share; write a tuple"),
        ("names = {}", r"Line\.names is a dict"),
        ("async def every_scan(self):\n    pass", r"line\.py:9: every_scan must be a plain method"),
        (
            "def every_scan(self, scan):\n    pass",
            r"every_scan must be a plain method every_scan\(self\)",
        ),
    ],
)
def test_a_class_that_can_not_be_meant_so(tmp_path, body, says):
    with pytest.raises(ProgramError, match=says):
        load(tmp_path, body)


@pytest.mark.parametrize(
    "call",
    [
        'dwell("2 s")',
        "self.start.rises",
        "self.part()",
        "helper()",
        "until(lambda: True)",
        'within("5 s", self.part())',
        "self.axis.captured()",
        "self.pause()",
        "long_pause()",
        'kept = dwell("2 s")',
        "kept: object = self.start.rises",
        "kept = self.part()",
        "kept = self.pause()",
    ],
)
def test_a_call_that_is_never_awaited_names_its_line(tmp_path, call):
    body = "async def part(self):\n    await dwell('1 s')\n"
    body += f"@sequence\nasync def cycle(self):\n    if True:\n        {call}\n"
    body += "def pause(self):\n    return self.start.falls\n"
    helper = "async def helper():\n    pass\ndef long_pause():\n    return dwell('1 h')\n"
    text = HEAD.replace("\nclass", f"{helper}\nclass") + textwrap.indent(body, "    ")
    (tmp_path / "line.py").write_text(text, encoding="utf-8")
    line = text[: text.index(f"{call}\n")].count("\n") + 1
    with pytest.raises(ProgramError, match=rf"line\.py:{line}: `.*` is never awaited"):
        load_program("line.py", tmp_path)


@pytest.mark.parametrize(
    ("statement", "kind"),
    [("self.start = True", "Input"), ("self.axis += 1", "Axis3601"), ("self.cycle = None", "SequenceMethod")],
)
def test_an_assignment_that_would_hide_a_part_names_its_line(tmp_path, statement, kind):
    body = (
        f"def every_scan(self):\n    {statement}\n@sequence\nasync def cycle(self):\n    self.lamp = True\n"
    )
    with pytest.raises(ProgramError, match=rf"line\.py:10: `.*` would hide .* declares as {kind}"):
        load(tmp_path, body)


@pytest.mark.parametrize(
    ("statement", "meant"),
    [
        ("self.lmp = True", "did you mean self.lamp, or declare it in the body of Line"),
        ("self.lamp, self.far = True, 1", "`self.far`: declare it in the body of Line"),
        ("for self.index in range(3): pass", "`self.index`: declare it in the body of Line"),
    ],
)
def test_a_field_that_the_class_does_not_declare_names_its_line(tmp_path, statement, meant):
    with pytest.raises(ProgramError, match=rf"line\.py:10: Line has no field .*{meant}"):
        load(tmp_path, f"def every_scan(self):\n    {statement}\n")


def test_a_field_of_a_base_class_in_another_file_is_declared_there(tmp_path):
    """That file has no `from __future__ import annotations`."""
    counting = "from scanrack import Logic\nclass Counting(Logic):\n    count: int\n"
    (tmp_path / "counting.py").write_text(counting, encoding="utf-8")
    head = HEAD.replace("import within\n", "import within\nfrom counting import Counting\n")
    body = "    def every_scan(self):\n        self.count = 1\n"
    (tmp_path / "line.py").write_text(head.replace("(Logic)", "(Counting)") + body, encoding="utf-8")
    assert load_program("line.py", tmp_path).name == "Line"


@pytest.mark.parametrize(
    "body",
    [
        "count = 0\ndef every_scan(self):\n    self.count += 1\n",
        "count: int\ndef every_scan(self):\n    self.count = 1\n",
        "def __init__(self):\n    self.count = 0\ndef every_scan(self):\n    self.count += 1\n",
        "def __setattr__(self, name, value):\n    vars(self)[name] = value\n"
        "def every_scan(self):\n    self.any = 1\n",
        "@property\ndef level(self): return 1\n@level.setter\ndef level(self, value): pass\n"
        "def every_scan(self):\n    self.level = 1\n",
    ],
)
def test_a_field_is_declared_in_the_body_or_in_init(tmp_path, body):
    load(tmp_path, body)


def test_fields_of_a_base_class_are_fields_of_the_class(tmp_path):
    (tmp_path / "line.py").write_text(
        "from scanrack import Logic\n\nclass Base(Logic):\n"
        "    def __init__(self):\n        self.count = 0\n\n"
        "class Line(Base):\n    def every_scan(self):\n        self.count = 1\n",
        encoding="utf-8",
    )
    load_program("line.py:Line", tmp_path)


def test_a_wait_in_a_field_that_nothing_reads_names_its_line(tmp_path):
    with pytest.raises(ProgramError, match=r"line\.py:11: `self\.pause = dwell\('2 s'\)` is never awaited"):
        load(tmp_path, "pause = None\ndef every_scan(self):\n    self.pause = dwell('2 s')\n")


def test_a_condition_that_is_async_is_refused_where_it_is_made():
    async def safe():
        return True

    class Line(Logic):
        @sequence
        async def cycle(self):
            await until(safe)

    fault = fault_of(Line)
    assert fault.text.startswith("TypeError: until(safe) is not allowed: safe is an `async def`")


@pytest.mark.parametrize("wait", [lambda ask: until(ask), lambda ask: steady(ask, "1 s")])
def test_a_condition_that_answers_with_a_coroutine_faults(wait):
    """A coroutine would count as true; pytest turns a warning about one that nobody awaits into an error."""

    async def safe():
        return False

    class Line(Logic):
        @sequence
        async def cycle(self):
            await wait(lambda: safe())

    assert fault_of(Line).text.startswith(
        "TypeError: safe is an `async def`, which returns a value only where it is awaited"
    )


@pytest.mark.parametrize(
    "lines",
    [
        ["kept = dwell('2 s')", "await dwell('1 s')", "await kept"],
        ["kept = dwell('2 s')", "if self.start:", "    await kept"],
        ["kept = [dwell('2 s'), self.start.rises]", "await first_of(*kept)"],
        ["kept = self.pause()", "await within('5 s', kept)"],
        ["self.kept = dwell('2 s')", "await self.kept"],
        ["_log = self.axis.halt()"],
    ],
)
def test_a_wait_that_is_kept_for_later_is_no_mistake(tmp_path, lines):
    body = "kept = None\ndef pause(self):\n    return self.start.falls\n@sequence\nasync def cycle(self):\n"
    load(tmp_path, body + "".join(f"    {line}\n" for line in lines))


def test_a_mistake_in_a_function_ahead_of_the_class_names_its_line(tmp_path):
    helper = "async def helper():\n    dwell('1 s')\n"
    text = (
        HEAD.replace("\nclass", f"{helper}\nclass")
        + "    @sequence\n    async def cycle(self):\n        pass\n"
    )
    (tmp_path / "line.py").write_text(text, encoding="utf-8")
    line = text[: text.index("    dwell(")].count("\n") + 1
    with pytest.raises(ProgramError, match=rf"line\.py:{line}: `dwell\('1 s'\)` is never awaited"):
        load_program("line.py", tmp_path)


def test_a_command_may_be_left_alone(tmp_path):
    """It is carried out, as a block whose outputs nobody reads."""
    logic = load(tmp_path, "@sequence\nasync def cycle(self):\n    self.axis.configure()\n")
    bench = SequenceBench(logic).scan()
    assert bench.words[0] != 0


# -- refused before the first scan


@pytest.mark.parametrize(
    ("declared", "says"),
    [
        ('bad = Input("strat")', r"line\.py:9: bad: no input 'strat'; did you mean start\?"),
        ('bad = Input("Local:7:I.Data.0")', r"line\.py:9: bad: 'Local:7:I\.Data\.0': slot 7 is empty"),
        ('bad = Input("slot1.status.IN_HOMES")', "did you mean IN_HOME"),
        ('bad = Input("Local:2:O.Data.0")', "is an output; declare it as Output"),
        ('bad = Output("Local:2:I.Data.0")', "is an input; declare it as Input"),
        ('bad = Input("Local:2:I.Data[0]")', "is a word; add a bit, or declare it as InputWord"),
        ('bad = InputWord("Local:2:I.Data.0")', "is a bit; declare it as Input"),
        ("bad = Axis3601(3, axis.configuration)", "bad: slot 3 is empty; modules sit in 1, 2"),
        ("bad = Axis3601(2, axis.configuration)", "which has neither a 3601's words nor a drive's"),
        (
            "bad = Axis3601(1, axis.configuration)",
            r"9: bad and axis \[.*line\.py:5\] write the same place in slot 1",
        ),
        ('bad = Output("Local:1:O.Data[0].3")', "write the same place in slot 1"),
        ('bad = Output("Local:2:O.Data[0].0")', "write the same place in slot 2"),
        ('bad = OutputWord("Local:2:O.Data[0]")', "write the same place in slot 2"),
    ],
)
def test_what_is_not_there_or_has_an_owner(tmp_path, declared, says):
    logic = load(tmp_path, declared)
    with pytest.raises(ValueError, match=says):
        SequenceBench(logic)


def test_all_mistakes_are_told_at_once(tmp_path):
    logic = load(tmp_path, 'one = Input("strat")\ntwo = Input("Local:9:I.Data.0")')
    with pytest.raises(ValueError, match=r"strat.*\n.*slot 9"):
        SequenceBench(logic)


# -- faults at the user's line


@pytest.mark.parametrize(
    ("body", "text", "line"),
    [
        ("await dwell('2 ms')\n1 / 0", "ZeroDivisionError", 2),
        ("await until(lambda: 1 / 0)", "ZeroDivisionError", 1),
        ("await dwell('2 ms')\nraise StopIteration", "StopIteration", 2),
        ("import asyncio\nawait asyncio.sleep(0)", "not a wait of scanrack; a sequence waits for a time", 2),
        ("import asyncio\nawait asyncio.sleep(1)", "no running event loop: cycle awaits an object", 2),
        ("await self.axis.set_position(0)", "AxisError", 1),
        ("await within('4 ms', self.start.rises)", "WaitTimeout", 1),
        ("self.lamp = 'on'", "an output must be True or False", 1),
    ],
)
def test_what_escapes_a_sequence_faults_the_cpu_there(tmp_path, body, text, line):
    method = "@sequence\nasync def cycle(self):\n" + textwrap.indent(body, "    ")
    fault = fault_of(load(tmp_path, method))
    assert text in fault.text
    assert fault.where.endswith(f"line.py:{BODY_LINE + 2 + line - 1}")


def test_what_every_scan_raises_faults_the_cpu_there(tmp_path):
    fault = fault_of(load(tmp_path, "def every_scan(self):\n    1 / 0"))
    assert fault.where.endswith(f"line.py:{BODY_LINE + 1}")


def test_a_sequence_that_never_waits_names_its_line(tmp_path):
    logic = load(tmp_path, "@sequence\nasync def cycle(self):\n    while True:\n        n = 1")
    bench = SequenceBench(logic)
    bench.cpu._watchdog.limit_ns = 50_000_000
    with pytest.raises(CpuFault) as caught:
        bench.scan(2)
    assert caught.value.fault.where.split(":")[-1] in (str(BODY_LINE + 2), str(BODY_LINE + 3))


def test_an_exception_in_finally_faults(tmp_path):
    body = """
        def every_scan(self):
            if self.start:
                self.cycle.abort()
        @sequence
        async def cycle(self):
            try:
                await dwell("1 s")
            finally:
                1 / 0
    """
    bench = SequenceBench(load(tmp_path, body)).scan(3).press(0)
    with pytest.raises(CpuFault) as caught:
        bench.scan()
    assert "ZeroDivisionError" in caught.value.fault.text
    assert caught.value.fault.where.endswith(f"line.py:{BODY_LINE + 9}")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # nothing can close it
def test_a_sequence_that_swallows_its_second_abort_faults(tmp_path):
    body = """
        def every_scan(self):
            self.cycle.abort()
        @sequence
        async def cycle(self):
            while True:
                try:
                    await dwell("1 s")
                except:
                    pass
    """
    bench = SequenceBench(load(tmp_path, body)).scan(2)  # begins; first Abort
    with pytest.raises(CpuFault) as caught:
        bench.scan()
    assert "cycle swallows Abort" in caught.value.fault.text
    assert caught.value.fault.where.endswith(f"line.py:{BODY_LINE + 7}")


# -- what is done about the others


class Remembering(Logic):
    start = Input("start")
    lamp: Output = Output("Local:2:O.Data.0")

    def __init__(self):
        self.pressed = False

    def every_scan(self):
        self.pressed = self.pressed or bool(self.start)

    @sequence
    async def cycle(self):
        while True:
            await dwell("20 ms")
            self.lamp = self.pressed


def test_a_pulse_while_the_sequence_is_elsewhere_is_latched_in_every_scan():
    bench = SequenceBench(Remembering).scan(3).press(0).scan().press(0, False).scan(20)
    assert bench.lamp(0)


class Twice(Logic):
    axis = Axis3601(1, SETUP)

    def __init__(self):
        self.said = []

    @sequence
    async def first(self):
        try:
            await self.axis.configure()
        except Exception as error:
            self.said.append(type(error).__name__)

    @sequence
    async def second(self):
        await self.axis.configure()
        self.said.append("done")


def test_of_two_commands_in_one_scan_the_later_has_the_axis():
    bench = SequenceBench(Twice).scan(30)
    assert bench.logic.said == ["CommandAborted", "done"]


class PowerCut(Logic):
    axis = Axis3601(1, SETUP)

    def __init__(self):
        self.said = None

    @sequence
    async def cycle(self):
        await self.axis.configure()
        await self.axis.set_position(0)
        try:
            await self.axis.move_to(90_000, **SLOW)
        except AxisError as error:
            self.said = error.id
        await self.axis.configure()
        self.said = "configured again"


def test_a_power_cycle_in_mid_wait_is_error_16():
    bench = SequenceBench(PowerCut).scan(300)
    bench.module.power_cycle()
    bench.until(lambda: bench.logic.said is not None, 10)
    assert bench.logic.said == 16
    bench.until(lambda: bench.logic.said == "configured again", 100)


class Program(Logic):
    axis = Axis3601(1, SETUP)
    lamp: Output = Output("Local:2:O.Data.0")

    def __init__(self):
        self.runs = 0
        self.ended = []

    @sequence
    async def cycle(self):
        self.runs += 1
        try:
            await self.axis.configure()
            await self.axis.set_position(0)
            await self.axis.move_to(90_000, **SLOW)
        finally:
            self.ended.append("finally")
            await dwell("1 s")
            self.ended.append("never")


def test_program_mode_closes_the_sequences_and_begins_anew():
    bench = SequenceBench(Program).scan(300)
    assert bench.logic.axis.moving
    bench.restart().scan()
    assert (bench.logic.runs, bench.logic.ended) == (2, ["finally"])
    assert bench.words[0] in (0, SETUP.to_image()[0])
    bench.scan(500)
    assert bench.logic.axis.moving


@pytest.mark.slow
def test_an_instance_dropped_in_mid_wait_is_closed_quietly():
    bench = SequenceBench(Program).scan(300)
    ended = bench.logic.ended
    words = bench.words
    bench.logic = None
    outputs = bench.rack.slots[1].outputs
    del bench
    gc.collect()
    assert ended == ["finally"]
    assert list(outputs) == words


def test_the_cpu_closes_its_logic():
    bench = SequenceBench(Program).scan(300)
    bench.cpu.close()
    assert bench.logic.ended == ["finally"]
    assert bench.sequences[0].over


def test_a_finally_that_awaits_in_a_helper_is_closed_inside_out():
    ended = []

    class Nested(Logic):
        @sequence
        async def outer(self):
            try:
                await self.inner()
            finally:
                ended.append("outer")

        async def inner(self):
            try:
                await dwell("1 s")
            finally:
                ended.append("inner")
                await dwell("1 s")
                ended.append("dropped with the wait before it")

    SequenceBench(Nested).scan(3).cpu.close()
    assert ended == ["inner", "outer"]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # Python's, when it is freed
def test_a_loop_that_swallows_everything_can_be_closed():
    class Deaf(Logic):
        @sequence
        async def deaf(self):
            while True:
                try:
                    await dwell("1 s")
                except BaseException:
                    continue

    bench = SequenceBench(Deaf).scan(3)
    bench.cpu.close()
    assert bench.sequences[0].over
    gc.collect()


def test_an_exception_while_closing_is_raised_and_the_others_are_closed():
    ended = []

    class Two(Logic):
        @sequence
        async def one(self):
            try:
                await dwell("1 s")
            finally:
                raise OSError("one")

        @sequence
        async def two(self):
            try:
                await dwell("1 s")
            finally:
                ended.append("two")

    bench = SequenceBench(Two).scan(3)
    with pytest.raises(OSError, match="one"):
        bench.cpu.close()
    assert ended == ["two"]


def test_names_of_the_user_hide_nothing():
    """The base class has no public name but every_scan."""
    public = [name for name in dir(Logic) if not name.startswith("_")]
    assert public == ["every_scan"]

    class Own(Logic):
        scan = 5
        close = Output("Local:2:O.Data.3")
        name = Input("start")

        @sequence
        async def reset(self):
            await until(lambda: True)
            self.close = True

    assert SequenceBench(Own).scan(3).lamp(3)


class Base(Logic):
    def __init__(self):
        self.order = []

    @sequence
    async def first(self):
        self.order.append("first")

    @sequence
    async def second(self):
        self.order.append("second")


class Derived(Base):
    @sequence
    async def third(self):
        self.order.append("third")

    @sequence
    async def first(self):
        self.order.append("first of Derived")


def test_order_is_that_of_definition_base_classes_first():
    assert SequenceBench(Derived).scan().logic.order == ["first of Derived", "second", "third"]


def test_a_new_instance_has_parts_of_its_own_and_the_same_arguments():
    class Made(Logic):
        axis = Axis3601(1, SETUP)

        def __init__(self, speed, *, name):
            self.speed, self.name = speed, name

    one = Made(5, name="a")
    other = fresh(one)
    assert (other.speed, other.name) == (5, "a")
    assert one.axis is not other.axis


def test_an_init_that_forgets_its_base_is_no_trap():
    class Careless(Logic):
        lamp: Output = Output("Local:2:O.Data.0")

        def __init__(self):
            pass

        @sequence
        async def cycle(self):
            self.lamp = True

    assert SequenceBench(Careless).scan().lamp(0)


def test_while_the_link_is_lost_only_a_wait_with_a_limit_ends():
    from scanrack import WaitTimeout, within
    from scanrack.runtime import ModuleFault

    class Limited(Logic):
        axis = Axis3601(1, SETUP)
        said = ""

        @sequence
        async def cycle(self):
            await self.axis.configure()
            await self.axis.set_position(0)
            try:
                await within("3 s", self.axis.move_to(4_000, **SLOW))
            except WaitTimeout as error:
                self.said = str(error)

    bench = SequenceBench(Limited).scan(300)
    bench.module.inject(ModuleFault.LINK_LOST)
    bench.scan(1_000)
    assert bench.logic.said == ""
    bench.until(lambda: bench.logic.said)
    told = "axis.move_to(4000) (the link to slot 1 was lost at 0.6 s) took longer than 3 s"
    assert bench.logic.said == told


def test_abort_passes_except_exception():
    class Catching(Logic):
        start = Input("start")
        caught: Any = ()

        def every_scan(self):
            if self.start:
                self.cycle.abort()

        @sequence
        async def cycle(self):
            try:
                await all_of(dwell("1 s"), first_of(dwell("1 s")))
            except Exception as error:
                self.caught = (error,)
            except Abort:
                self.caught = ("aborted",)
                raise

    bench = SequenceBench(Catching).scan(3).press(0).scan()
    assert bench.logic.caught == ("aborted",)
    assert bench.sequences[0].over


def test_words_out_of_range_are_refused():
    class Wide(Logic):
        level: OutputWord = OutputWord("Local:2:O.Data[1]")

        @sequence
        async def cycle(self):
            self.level = -32_768
            await dwell("2 ms")
            self.level = 32_768

    bench = SequenceBench(Wide).scan()
    assert bench.rack.slots[2].outputs[1] == -32_768
    assert "level = 32768 is out of range" in fault_of(Wide).text


def test_another_writer_of_the_modules_words_is_named():
    """A function of the scan beside an instance: both work in one rack, on modules of their own."""

    class Owner(Logic):
        axis = Axis3601(1, SETUP)

        @sequence
        async def cycle(self):
            await self.axis.configure()

    owner = Owner()

    def both(scan):
        owner(scan)
        scan.slot[2].outputs.set_bit(0, 5, True)
        if scan.number == 20:
            scan.slot[1].outputs[0] = 1

    bench = SequenceBench(both).scan(21)
    assert bench.lamp(5)
    with pytest.raises(CpuFault) as caught:
        bench.scan()
    says = str(caught.value)
    assert "axis of slot 1 [" in says
    assert "test_traps.py:" in says
    assert "changed [0, 0, 0, 0, 0, 0, 0, 0] to [1, 0, 0, 0, 0, 0, 0, 0]" in says


def test_forces_are_no_other_writer():
    class Owner(Logic):
        axis = Axis3601(1, SETUP)

        @sequence
        async def cycle(self):
            if self.axis.state == State.DISABLED:
                await self.axis.configure()

    bench = SequenceBench(Owner).scan()
    bench.until(lambda: bench.sequences[0].over, 100)
    bench.cpu.forces.set("Local:1:O.Data[7].0", True)
    bench.scan(5)
    assert bench.words[7] == 1
    bench.restart().scan(50)
    bench.cpu.forces.clear()
    bench.scan(50)
