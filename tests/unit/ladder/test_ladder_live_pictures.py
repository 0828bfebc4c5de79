"""Rungs that are drawn once and lit from outside: numbered elements, and the power of each."""

import json
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ladder_programs import rungs
from scanrack.ladder import parse_rung
from scanrack.ladder.draw import live_rung, power, rung_text
from scanrack.ladder.model.tree import Address, Branch, Instruction, Number, Rung, instructions_of

SEAL_IN = "[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);"
SVG = "{http://www.w3.org/2000/svg}"


def drawn(text, width=60, **more):
    return live_rung(parse_rung(text), "Main.3", width, **more)


def tree_of(live):
    return ElementTree.fromstring(live.svg)


def elements_of(live):
    return {each.get("data-element"): each for each in tree_of(live).iter() if each.get("data-element")}


@pytest.mark.parametrize(
    ("truth", "expected"),
    [
        # Start, Run, Stop, the coil; the branch; the rail
        ([False, True, True, True], "011111"),
        ([False, False, False, False], "000001"),
        ([False, True, False, False], "010011"),
        ([True, False], "100011"),  # a fault has kept the rest from running
        (None, "000000"),
    ],
)
def test_power_of_a_seal_in(truth, expected):
    assert power(parse_rung(SEAL_IN), truth) == expected


def test_an_empty_leg_carries_the_power_in_front_of_its_branch():
    # A, B, D; the outer branch, the inner one; the rail
    rung = parse_rung("XIC(A)[[XIC(B),],XIC(C)]OTE(D);")
    assert power(rung, [True, False, False, True]) == "1001" + "11" + "1"
    assert power(rung, [False, False, False, False]) == "0000" + "00" + "1"


def test_more_truth_than_instructions_is_refused():
    with pytest.raises(ValueError, match="5 truths; must be at most 4"):
        power(parse_rung(SEAL_IN), [True] * 5)


def test_every_element_has_a_group_that_names_its_tag():
    live = drawn(SEAL_IN)
    groups = elements_of(live)
    assert list(groups) == [f"Main.3.{number}" for number in range(6)]
    assert live.elements == 6 == len(power(parse_rung(SEAL_IN), None))
    tags = [groups[f"Main.3.{number}"].get("data-tag") for number in range(4)]
    assert tags == ["Start", "Run", "Stop", "Run"]
    assert live.names == ("Start", "Run", "Stop")


def places_of(live):
    return sorted(filter(None, (each.get("data-name") for each in tree_of(live).iter(f"{SVG}text"))))


def letters_of(live):
    return [each.text for each in tree_of(live).iter(f"{SVG}text") if each.text and each.text.strip()]


def test_a_call_without_parameters_shows_none():
    assert letters_of(drawn("JSR(Fill,0);")) == ["JSR", "Routine", "Fill"]
    assert letters_of(drawn("JSR(Fill,0);", operands=True)) == ["JSR", "Routine", "Fill", "Inputs", "0"]
    assert "Inputs" in letters_of(drawn("JSR(Fill,1,N);"))


def test_there_is_a_place_for_each_value():
    text = "XIC(Go)TON(Fill,5000,0)EQU(Step,7)OTE(Done);"
    assert places_of(drawn(text, operands=True)) == ["Done", "Fill", "Fill.ACC", "Fill.PRE", "Go", "Step"]
    assert places_of(drawn(text)) == ["Done", "Go", "Step"]  # the timer's title says its time
    without = drawn("XIC(Go)TON(Fill,5000,0);", name_of=lambda address: None)
    assert without.names == ()
    assert "5000" in [each.text for each in tree_of(without).iter(f"{SVG}text")]


def test_names_are_those_that_the_caller_knows():
    live = drawn("XIC(Go)OTE(Done);", name_of=lambda address: f"\\Main.{address}")
    assert live.names == ("\\Main.Go", "\\Main.Done")
    assert elements_of(live)["Main.3.0"].get("data-tag") == "\\Main.Go"


def test_no_style_stands_in_the_picture():
    root = tree_of(drawn(SEAL_IN))
    assert not list(root.iter(f"{SVG}style"))
    assert not [each for each in root.iter() if each.get("style") or each.get("onclick")]


def test_what_looks_like_markup_is_text():
    live = live_rung(parse_rung("CMP(A<B AND C>0)OTE(D);"), '<i>"&.0', 60)
    root = tree_of(live)
    assert root.get("data-rung") == '<i>"&.0'
    assert {each.tag for each in root.iter()} <= {
        f"{SVG}{name}" for name in ("svg", "g", "path", "rect", "text", "title")
    }


def branches_of(series, before, truth):
    """The power behind a series, and that behind its branches, each in front of those within it."""
    found = []
    for each in series:
        if isinstance(each, Branch):
            legs = [branches_of(leg, before, truth) for leg in each.legs]
            before = any(behind for behind, _ in legs)
            found += [before, *(inner for _, within in legs for inner in within)]
        else:
            before = next(truth)
    return before, found


@given(rungs(), st.data())
def test_a_branch_has_power_if_one_of_its_legs_has(text, data):
    rung = parse_rung(text)
    count = sum(1 for _ in instructions_of(rung.series))
    truth = data.draw(st.lists(st.booleans(), min_size=count, max_size=count))
    _, branches = branches_of(rung.series, True, iter(truth))
    assert power(rung, truth) == "".join("01"[each] for each in [*truth, *branches, True])
    assert live_rung(rung, "R.0", 60).elements == count + len(branches) + 1


@pytest.mark.slow
@given(rungs(), st.integers(10, 60))
def test_it_is_laid_out_in_the_width_as_characters_are(text, width):
    rung = parse_rung(text)
    root = ElementTree.fromstring(live_rung(rung, "R.0", width, name_of=lambda address: None).svg)
    assert root.get("width") == str(8 * len(rung_text(rung, width)[0]))


def states_of(live):
    return [json.loads(each.get("data-now")) for each in tree_of(live).iter() if each.get("data-now")]


def test_a_block_says_what_it_does_with_values_of_its_tags_and_constants():
    assert states_of(drawn("TON(Fill,3000,0);")) == [[["", "{Fill.ACC:s} of {Fill.PRE:s} s"]]]
    counts = [["Fill.PRE", "{Fill.ACC} of {Fill.PRE}"], ["", "{Fill.ACC}, preset 0"]]
    assert states_of(drawn("CTU(Fill,3,0);")) == [counts]
    captions = {"MC_MoveAbsolute": ("Instance", "Axis", "Execute", "Position", "Velocity")}
    operands = (Address("Out"), Address("Feed"), Address("Go"), Number(-6000, "-6000"), Address("Fast"))
    rung = Rung((Instruction("MC_MoveAbsolute", operands),))
    live = live_rung(rung, "R.0", 60, captions)
    first, second = states_of(live)
    assert first[1] == ["Out.Busy", "moving to -6,000"]
    assert second[1] == ["Out.Busy", "at {Feed.Position}, {Fast} steps/s"]
    assert {"Out.Done", "Feed.Position", "Fast"} <= set(live.names)
    assert "Velocity" not in live.svg
    assert "Velocity" in live_rung(rung, "R.0", 60, captions, operands=True).svg


@pytest.mark.parametrize(
    ("text", "states", "operand"),
    [
        ("MOV(5,N);", [["*", "moves 5"], ["", "idle"]], "N"),
        ("ADD(A,3,N);", [["*", "result {N}"], ["", "idle"]], "A"),
        ("CLR(N);", [["*", "clears"], ["", "idle"]], "N"),
        ("COP(A[2],B[0],N);", [["*", "copies, length {N}"], ["", "idle"]], "A[2]"),
        ("CPT(N,A*(B+2));", [["*", "result {N}"], ["", "idle"]], "A*(B+2)"),
        ("FFL(N,A[0],Queue,10,0);", [["", "{Queue.POS} of {Queue.LEN}"]], "A[0]"),
        ("SQO(A[0],16#FF,N,Turn,4,0);", [["", "{Turn.POS} of {Turn.LEN}"]], "16#FF"),
    ],
)
def test_an_instruction_says_beside_its_title_what_it_does_with_power(text, states, operand):
    live = drawn(text)
    assert states_of(live) == [states]
    assert "*" not in live.names  # power is no tag
    assert f">{operand}</text>" in live.svg  # operands stay in view


def test_a_state_that_the_program_cannot_tell_is_left_out():
    only, captions = {"Part", "Part.Busy", "Part.Done"}, {"Mine": ("Instance", "Size")}
    rung = Rung((Instruction("Mine", (Address("Part"), Number(7, "7"))),))
    live = live_rung(rung, "R.0", 60, captions, lambda each: str(each) if str(each) in only else None)
    assert states_of(live) == [[["Part.Busy", "busy"], ["Part.Done", "done"], ["", "idle"]]]
    silent = live_rung(rung, "R.0", 60, captions, lambda _address: None)
    assert states_of(silent) == []
    assert "Size" in silent.svg
