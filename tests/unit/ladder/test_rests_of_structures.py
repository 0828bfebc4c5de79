"""A large structure takes variables for the members that the program uses; all others are in bytes."""

import gc
from weakref import ref

import pytest
from ladder_lockstep import differences, outcome
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program
from scanrack.ladder.model.collector import COLLECTED, LARGE, collector_paused
from scanrack.ladder.state.snapshots import restore, snapshot

TEXT = """PROGRAM p
TYPE Name (LEN : DINT, DATA : SINT[7])
TYPE Inner (Delay : TIMER, Level : REAL, Codes : INT[3], Title : Name)
TYPE Unit (On : BOOL, Off : BOOL, Count : DINT, Inner : Inner, Inners : Inner[2], Wide : LINT, \
Flags : BOOL[40])
TAG One : Unit := {"Off": true, "Count": 7, "Wide": -5, "Inner": {"Level": 1.5, "Codes": [1, -2, 3], \
"Title": "abc", "Delay": {"PRE": 25}}, "Inners": [{"Level": 2.5}, {"Title": "de"}]}
TAG Row : Unit[3] := [{"Count": 1}, {"Count": 2, "Wide": 4}, {"Flags": [false, true]}]
TAG Number : DINT
TAG I : DINT := 1
ROUTINE Main
XIC(One.Off)TON(One.Inner.Delay,?,?);
ADD(One.Count,1,One.Count)ADD(Row[I].Count,One.Inner.Codes[1],Number);
END
"""


def test_what_is_used_is_a_variable_and_the_rest_is_bytes():
    program = parse_program(TEXT)
    source = program.source()
    assert "One_Count" in source
    assert "One_Inner_Delay_ACC" in source
    layout = program.build().layout
    assert {each.ident for each in layout.single} >= {
        "One_Off",
        "One_Count",
        "One_Inner_Delay_ACC",
        "Row_Count",
    }
    assert not {each.ident for each in layout.single} & {"One_On", "One_Wide", "Row_Wide", "One_Inner_Level"}
    assert set(layout.rests) == {"ONE", "ROW"}


def test_all_values_are_there_from_the_beginning():
    program = parse_program(TEXT)
    for engine in (program.compile(), program.interpret()):
        assert engine.tags["One"] == {
            "On": False,
            "Off": True,
            "Count": 7,
            "Inner": {
                "Delay": {"EN": False, "TT": False, "DN": False, "PRE": 25, "ACC": 0},
                "Level": 1.5,
                "Codes": [1, -2, 3],
                "Title": "abc",
            },
            "Inners": [
                {
                    "Delay": {"EN": False, "TT": False, "DN": False, "PRE": 0, "ACC": 0},
                    "Level": level,
                    "Codes": [0, 0, 0],
                    "Title": title,
                }
                for level, title in ((2.5, ""), (0.0, "de"))
            ],
            "Wide": -5,
            "Flags": [False] * 40,
        }
        assert [engine.tags[f"Row[{at}].Count"] for at in range(3)] == [1, 2, 0]
        assert engine.tags["Row[1].Wide"] == 4
        assert engine.tags["Row[2].Flags[1]"] is True


def test_both_back_ends_and_a_client_see_the_same():
    program = parse_program(TEXT)
    compiled, interpreted = program.compile(), program.interpret()
    changes = {"One.Wide": 12, "One.Inner.Title": "xyz", "Row[2].Inners[1].Codes[2]": -9, "Row[1].Count": 40}
    for changed in ({}, changes, {}):
        ours, theirs = (outcome(each, 10, changed) for each in (compiled, interpreted))
        assert differences(ours[1], theirs[1]) == {}
    for engine in (compiled, interpreted):
        assert {name: engine.tags[name] for name in changes} == changes
        assert engine.tags["One.Count"] == 10
        assert engine.tags["Number"] == 38  # 40 - 2
        assert engine.tags["One.Inner.Delay"]["ACC"] == 20  # from the first of three scans on


def test_a_snapshot_has_the_rest():
    engine = parse_program(TEXT).compile()
    engine.tags["One.Wide"], engine.tags["Row[0].On"] = 3, True
    before = snapshot(engine.memory)
    engine.tags["One.Wide"], engine.tags["Row[0].On"] = 4, False
    engine.step(10)
    restore(engine.memory, before)
    assert (engine.tags["One.Wide"], engine.tags["Row[0].On"], engine.tags["One.Count"]) == (3, True, 7)


def test_a_value_of_the_rest_can_be_forced():
    debugger = Debugger(parse_program(TEXT))
    debugger.force("One.Inner.Level", 9.0)
    debugger.tags["One.Inner.Level"] = 1.0
    debugger.scan(1, 1)
    assert debugger.tags["One.Inner.Level"] == 9.0


def made_in_a_pause():
    with collector_paused():
        made = [[each] for each in range(LARGE + 2_000)]
    assert gc.isenabled()
    young = {id(each) for generation in (0, 1) for each in gc.get_objects(generation)}
    return sum(id(each) in young for each in made)


@pytest.mark.slow
def test_what_was_made_in_a_pause_counts_as_old():
    gc.collect()
    frozen = gc.get_freeze_count()
    gc.unfreeze()
    try:
        assert made_in_a_pause() == 0
        assert gc.get_freeze_count() == 0
    finally:
        if frozen:
            gc.freeze()


@pytest.mark.slow
def test_garbage_of_large_trees_does_not_stay():
    class Tree(list[object]):
        pass

    tree = Tree()
    tree.append(tree)
    seen = ref(tree)
    del tree
    gc.disable()  # outside of pauses nothing collects it
    try:
        for _ in range(COLLECTED):
            gc.enable()
            made_in_a_pause()
            gc.disable()
    finally:
        gc.enable()
    assert seen() is None


def test_a_pause_thaws_nothing():
    before = gc.get_freeze_count()
    gc.freeze()
    try:
        frozen = gc.get_freeze_count()
        made_in_a_pause()
        assert gc.get_freeze_count() >= frozen - 100  # some of it may have been freed
    finally:
        gc.unfreeze()
        if before:
            gc.freeze()
