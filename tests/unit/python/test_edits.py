"""Edits of logic in Python while it runs: all of it continues, or the edit is refused by name.

Broken on purpose: a `finally` of the replaced frame that runs, a constant that keeps its value, a field that
begins anew, a condition of the program before: a test turns red.
"""

import gc
import shutil
from pathlib import Path

import pytest
from bench3601 import CONFIGURATION
from scanrack import open_bench
from scanrack.jobs import load_job, load_program
from scanrack.jobs.trust.attachments import forget_imported
from scanrack.ladder.python.online.editing import edit_logic
from scanrack.ladder.python.online.field_plan import EditRefusal
from scanrack.ladder.python.online.fields import Fields
from sequence_bench import SequenceBench

EXAMPLES = Path(__file__).parents[3] / "examples/sequences"

TEXT = f"""\
from scanrack import *
from scanrack.io_images.image import Image

SETUP = Configuration.from_image(Image({list(CONFIGURATION)}))
STEP = 1


class Plant(Logic):
    axis = Axis3601(1, SETUP)
    one = Input("Local:2:I.Data.0")
    two = Input("Local:2:I.Data.1")
    late = OnDelay("10 ms")
    a: Output = Output("Local:2:O.Data.0")
    rounds = 0
    name = "plant"
    stops = (4, 6, 8)

    def every_scan(self) -> None:
        self.late(self.one)

    @sequence
    async def cycle(self) -> None:
        while True:
            await self.one.rises
            try:
                n = self.rounds
                for stop in self.stops:
                    await dwell(f"{{stop}} ms")
                    self.rounds += STEP
                await until(lambda: self.two, "two")
            finally:
                self.a = True
            self.rounds = n + 10
"""


class Plant:
    """A running program that a test edits."""

    def __init__(self, folder):
        self.path, self.text = folder / "plant.py", TEXT
        self.bench = SequenceBench(self.load())
        self.logic = self.bench.logic
        self.scan = self.bench.scan

    def load(self):
        self.path.write_text(self.text, encoding="utf-8")
        return load_program(str(self.path)).function

    def edit(self, *changes, restart=()):
        for old, new in changes:
            assert old in self.text
            self.text = self.text.replace(old, new)
        return edit_logic(self.logic, self.load(), restart)


@pytest.fixture
def plant(tmp_path):
    return Plant(tmp_path)


@pytest.fixture
def dwelling(plant):
    """The program in its first dwell, of 4 ms, since scan 2."""
    plant.scan()
    plant.bench.press(0)
    plant.scan()
    assert plant.logic.cycle.waits_for == "dwell 4 ms"
    return plant


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stations", "labeller", "blend_path", "jog_panel", "shared_zone"])
def test_edits_in_mid_move_of_each_example_change_no_image(name, tmp_path):
    """Every line moves, every 257 scans; images, waits and fields are those of a run without edits."""
    for path in (*EXAMPLES.glob("*.py"), *EXAMPLES.glob("*.toml")):
        shutil.copy(path, tmp_path)
    rack, program = tmp_path / f"{name}.toml", tmp_path / f"{name}.py"
    with open_bench(rack) as plain, open_bench(rack) as edited:
        for number in range(7):
            plain.scan(257)
            edited.scan(257)
            program.write_text("# moved\n" + program.read_text(encoding="utf-8"), encoding="utf-8")
            forget_imported(tmp_path.resolve())
            edit = edited.edit(load_job(str(rack)).logic)
            assert (edit.new, edit.changed, edit.dropped, edit.restarted) == ((), (), (), ())
            for one, other in zip(plain.sequences.values(), edited.sequences.values(), strict=True):
                assert (one.waits_for, one.resumed, one.since_ns) == (
                    other.waits_for,
                    other.resumed,
                    other.since_ns,
                )
                assert other.line == (one.line or 0) + number + 1
            for slot in plain.slot:
                assert tuple(plain.slot[slot].inputs) == tuple(edited.slot[slot].inputs)
                assert tuple(plain.slot[slot].outputs) == tuple(edited.slot[slot].outputs)


def test_a_wait_goes_on_and_the_lines_after_it_are_the_edited_ones(dwelling):
    """4 ms from scan 2 on, whenever it is edited; then the edited step of 5."""
    dwelling.scan()
    edit = dwelling.edit(("STEP = 1", "STEP = 5"))
    assert (edit.continued, edit.changed) == (("cycle at line 28",), ())
    dwelling.scan()
    assert dwelling.logic.rounds == 5
    assert dwelling.logic.cycle.waits_for == "dwell 6 ms"


@pytest.mark.slow
def test_the_finally_of_a_replaced_frame_never_runs(dwelling):
    dwelling.edit(("    @sequence", "\n    @sequence"))
    gc.collect()
    dwelling.scan()
    assert not dwelling.bench.lamp(0)
    dwelling.logic.cycle.abort()
    dwelling.scan()
    assert dwelling.bench.lamp(0)


def test_fields_keep_values_and_constants_take_theirs(dwelling):
    dwelling.scan(2)
    edit = dwelling.edit(
        ('name = "plant"', 'name = "line"\n    extra = 3\n    other = 4'),
        ("self.late(self.one)", "self.late(self.one)\n        self.other += 1"),
        ("rounds = 0", "rounds = 100"),
    )
    assert (edit.new, edit.changed, edit.dropped) == (("other", "extra"), ("name",), ())
    dwelling.scan()
    assert (dwelling.logic.rounds, dwelling.logic.name, dwelling.logic.other) == (1, "line", 5)


def test_a_field_of_another_type_begins_anew(dwelling):
    dwelling.scan(2)
    assert dwelling.edit(("rounds = 0", "rounds = 0.5")).changed == ("rounds",)
    assert dwelling.logic.rounds == 0.5


def test_a_timer_keeps_its_time_and_takes_another_preset(dwelling):
    elapsed = dwelling.logic.late.elapsed_ns
    dwelling.edit(('OnDelay("10 ms")', 'OnDelay("4 ms")'))
    dwelling.scan(2)
    assert dwelling.logic.late
    assert dwelling.logic.late.elapsed_ns == elapsed + 4_000_000


def test_a_loop_continues_over_a_tuple_with_the_same_turns_so_far(dwelling):
    dwelling.scan(2)  # in its second turn
    dwelling.edit(("stops = (4, 6, 8)", "stops = (4, 6, 20, 30)"))
    waits = {dwelling.scan().logic.cycle.waits_for for _ in range(40)}
    assert waits == {"dwell 6 ms", "dwell 20 ms", "dwell 30 ms", "two"}


REFUSED = {
    "another wait": (('dwell(f"{stop} ms")', 'dwell("4 ms")'), "is no longer at its place"),
    "another way to it": (("for stop in self.stops", "for stop in (4, 6)"), "statement around it, .* is now"),
    "another local": (("n = self.rounds", "n = 7"), "its local n comes from a line that has changed"),
    "turns so far": (("stops = (4, 6, 8)", "stops = (5, 6, 8)"), "and stops has changed"),
    "the same in a block before it": (
        (
            "self.stops:\n",
            f'self.stops:\n{" " * 20}if self.rounds < 0:\n{" " * 24}await dwell(f"{{stop}} ms")\n',
        ),
        "occurs 2 times, before once",
    ),
    "twice": (
        ("                    self.rounds += STEP", '                    await dwell(f"{stop} ms")'),
        "occurs 2 times, before once",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_an_edit_that_is_not_certain_is_refused_and_nothing_changes(case, dwelling):
    change, why = REFUSED[case]
    with pytest.raises(EditRefusal, match=why) as refused:
        dwelling.edit(change)
    assert refused.value.sequences == ("cycle",)
    assert refused.value.sites[0].line == 28
    dwelling.scan(2)
    assert (dwelling.logic.rounds, dwelling.logic.cycle.waits_for) == (1, "dwell 6 ms")


def test_a_local_that_is_read_later_has_to_be_there(dwelling):
    with pytest.raises(EditRefusal, match="its local m has no value"):
        dwelling.edit(("n = self.rounds", "m = self.rounds"), ("= n + 10", "= m + 10"))


def test_one_sequence_begins_anew_when_it_is_told_to(dwelling):
    dwelling.scan(2)
    edit = dwelling.edit(('dwell(f"{stop} ms")', 'dwell("4 ms")'), restart=["cycle"])
    assert (edit.restarted, edit.continued) == (("cycle",), ())
    dwelling.scan()
    assert dwelling.bench.lamp(0)  # its `finally` has run
    assert (dwelling.logic.rounds, dwelling.logic.cycle.waits_for) == (1, "one rises")


def test_a_condition_that_waits_is_taken_over_only_unchanged(dwelling):
    dwelling.scan(20)
    assert dwelling.logic.cycle.waits_for == "two"
    with pytest.raises(EditRefusal, match="its condition has changed"):
        dwelling.edit(("lambda: self.two", "lambda: not self.two"))
    dwelling.text = TEXT
    dwelling.edit(("STEP = 1", "STEP = 1\n"))
    dwelling.edit(("STEP = 1", "STEP = 1\n"))  # the lambda is of the program before the last
    dwelling.bench.press(1)
    dwelling.scan()
    assert dwelling.logic.rounds == 10


def test_sequences_come_and_go(dwelling):
    lines = (
        "@sequence",
        "async def two_more(self) -> None:",
        "    await self.two.rises",
        "    self.rounds = 50",
    )
    two = "\n" + "".join(f"    {each}\n" for each in lines)
    edit = dwelling.edit(("self.rounds = n + 10\n", "self.rounds = n + 10\n" + two))
    assert edit.new == ("two_more",)
    dwelling.scan()
    dwelling.bench.press(1)
    dwelling.scan()
    assert dwelling.logic.rounds == 50
    assert dwelling.edit((two, "")).dropped == ("two_more",)


def test_fields_are_set_and_forced_over_edits_too(dwelling):
    fields = Fields(lambda: dwelling.logic)
    fields.force("plant.rounds", 7)
    dwelling.scan(5)
    assert dwelling.logic.rounds == 7
    dwelling.edit(("STEP = 1", "STEP = 2\n"))
    dwelling.scan(3)
    assert fields["plant.rounds"] == 7
    fields.unforce("plant.rounds")
    fields["plant.rounds"] = 1
    assert dwelling.logic.rounds == 1
    with pytest.raises(ValueError, match="rounds = 'x' is not allowed; must be int"):
        fields.force("plant.rounds", "x")
    with pytest.raises(ValueError, match=r"no field plant\.round; choose from plant\.rounds"):
        fields.force("plant.round", 1)
    with pytest.raises(ValueError, match=r"plant\.rounds is not forced"):
        fields.unforce("plant.rounds")


def test_the_finally_of_a_lost_edit_says_its_place(dwelling):
    """Within `finally` no function can begin."""
    late = ("self.a = True\n", 'self.a = True\n                await dwell("9 ms")\n')
    dwelling.edit(late)
    dwelling.logic.cycle.abort()
    dwelling.scan()
    assert dwelling.logic.cycle.waits_for == "dwell 9 ms"
    with pytest.raises(EditRefusal, match=r"plant\.py:33: cycle waits in cycle: the await is in a `finally`"):
        dwelling.edit(("STEP = 1", "STEP = 1\n"))
    dwelling.text = dwelling.text.replace("STEP = 1\n\n", "STEP = 1\n", 1)
    dwelling.edit(('name = "plant"', 'name = "plants"'))  # its lines stay, so its frame can


def test_a_plan_names_fields_that_stay_though_the_class_gives_others(plant):
    plant.scan(8)
    rounds = plant.logic.rounds
    edit = plant.edit(("rounds = 0", "rounds = 100"), ("STEP = 1\n", "STEP = 2\n"))
    assert edit.restated == (f"rounds {rounds}, not 100",)
    assert "rounds" in edit.kept
    assert plant.logic.rounds == rounds
