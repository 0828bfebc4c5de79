"""Function block diagrams of an L5X, scan by scan on both back ends, with values by hand.

Order, feedback and latching: 1756-RM003, Function Block Attributes. Blocks: the page of each instruction.
"""

import pytest
from diagram_runs import follow, open_diagram
from l5x_files import add_on, block, connector, ladder, parameter, reference, sheets, structured, wire
from scanrack.rockwell.l5x.diagrams.blocks import BLOCKS

IN, OUT = "IRef", "ORef"


@pytest.fixture
def opened(tmp_path):
    """Imports a diagram; returns an engine of either kind."""
    return lambda diagram, tags, **more: open_diagram(tmp_path / "machine.L5X", diagram, tags, **more)


def test_a_motor_that_holds_itself_by_a_feedback_wire(opened):
    """Motor = (Start OR Motor before) AND NOT Stop: BOR runs first, since the feedback wire has data."""
    diagram = sheets(
        "Blocks",
        reference(IN, 0, "Start")
        + reference(IN, 1, "Stop")
        + block("BAND", 2, "Both", x=400)
        + block("BOR", 3, "Any", x=200)
        + block("BNOT", 4, "No")
        + reference(OUT, 5, "Motor", x=600)
        + wire(0, "3.In1")
        + wire("2.Out", "3.In2", feedback=True)
        + wire(1, "4.In")
        + wire("3.Out", "2.In1")
        + wire("4.Out", "2.In2")
        + wire("2.Out", 5),
    )
    kinds = {
        "BOOL": "Start Stop Motor",
        "FBD_BOOLEAN_AND": "Both",
        "FBD_BOOLEAN_OR": "Any",
        "FBD_BOOLEAN_NOT": "No",
    }
    follow(
        opened(diagram, kinds),
        ({}, {"Motor": False, "Both.EnableOut": True}),
        ({"Start": True}, {"Motor": True}),
        ({"Start": False}, {"Motor": True}),
        ({"Stop": True}, {"Motor": False, "Any.Out": True}),
        ({}, {"Motor": False, "Any.Out": False}),
        ({"Stop": False}, {"Motor": False}),
    )


def test_a_loop_starts_behind_its_feedback_wire(opened):
    """A = B before + 1, B = 2 A, as marked at A: 1, 2; 3, 6; 7, 14. Marked at B: A = 2 A before + 1."""

    def loop(marked):
        return sheets(
            "Blocks",
            block("ADD", 0, "A", x=300)
            + block("MUL", 1, "B")
            + reference(IN, 2, "1")
            + reference(IN, 3, "2")
            + wire("1.Dest", "0.SourceA", feedback=marked == "A")
            + wire(2, "0.SourceB")
            + wire("0.Dest", "1.SourceA", feedback=marked == "B")
            + wire(3, "1.SourceB"),
        )

    kinds = {"FBD_MATH": "A B"}
    follow(
        opened(loop("A"), kinds),
        ({}, {"A.Dest": 1.0, "B.Dest": 2.0}),
        ({}, {"A.Dest": 3.0, "B.Dest": 6.0}),
        ({}, {"A.Dest": 7.0, "B.Dest": 14.0}),
    )
    follow(
        opened(loop("B"), kinds),
        ({}, {"B.Dest": 0.0, "A.Dest": 1.0}),
        ({}, {"B.Dest": 2.0, "A.Dest": 3.0}),
        ({}, {"B.Dest": 6.0, "A.Dest": 7.0}),
    )


def test_a_block_wired_to_itself_gets_its_value_of_the_scan_before(opened):
    diagram = sheets(
        "Blocks",
        block("ADD", 0, "Sum")
        + reference(IN, 1, "Step")
        + wire("0.Dest", "0.SourceA")
        + wire(1, "0.SourceB"),
    )
    follow(
        opened(diagram, {"FBD_MATH": "Sum", "REAL": "Step"}),
        ({"Step": 1.5}, {"Sum.Dest": 1.5}),
        ({}, {"Sum.Dest": 3.0}),
        ({"Step": -1.0}, {"Sum.Dest": 2.0}),
    )


def test_input_references_keep_their_value_of_the_beginning(opened):
    """N is counted up by the first block, and compared afterward: the comparison gets N of the beginning."""
    diagram = sheets(
        "Blocks",
        reference(IN, 0, "N")
        + block("ADD__F", 1)
        + reference(IN, 2, "1")
        + reference(OUT, 3, "N")
        + reference(IN, 4, "N", x=300)
        + block("EQU__F", 5, x=400)
        + reference(IN, 6, "0")
        + reference(OUT, 7, "Zero", x=600)
        + block("EQU", 8, "Same", x=500)
        + wire(0, "1.SourceA")
        + wire(2, "1.SourceB")
        + wire("1.Dest", 3)
        + wire(4, "5.SourceA")
        + wire(6, "5.SourceB")
        + wire("5.Dest", 7)
        + wire(4, "8.SourceA")
        + wire(6, "8.SourceB"),
    )
    follow(
        opened(diagram, {"DINT": "N", "BOOL": "Zero", "FBD_COMPARE": "Same"}),
        ({}, {"N": 1, "Zero": True, "Same.Dest": True}),
        ({}, {"N": 2, "Zero": False, "Same.Dest": False}),
        ({"N": 0}, {"N": 1, "Zero": True, "Same.Dest": True}),
    )


def test_connectors_join_sheets_and_the_order_follows_the_data(opened):
    """The second sheet's block gives what the first one needs: B = A + 10 is known when C = B + 100 runs."""
    first = (
        connector("ICon", 0, "Link")
        + block("ADD", 1, "C")
        + reference(IN, 2, "100")
        + reference(OUT, 3, "Sum")
        + wire(0, "1.SourceA")
        + wire(2, "1.SourceB")
        + wire("1.Dest", 3)
    )
    second = (
        reference(IN, 0, "A")
        + reference(IN, 1, "10")
        + block("ADD", 2, "B", x=900)
        + connector("OCon", 3, "link")
        + connector("ICon", 4, "LINK")
        + reference(OUT, 5, "Early")
        + wire(0, "2.SourceA")
        + wire(1, "2.SourceB")
        + wire("2.Dest", 3)
        + wire(4, 5)
    )
    follow(
        opened(sheets("Blocks", first, second), {"FBD_MATH": "B C", "DINT": "A Sum Early"}),
        ({"A": 1}, {"Sum": 111, "Early": 11}),
        ({"A": -20}, {"Sum": 90, "Early": -10}),
    )


def test_feedback_through_connectors(opened):
    """A is NOT B of the scan before; the indicator is behind the ICon, or before the OCon."""
    first = (
        connector("ICon", 0, "Back")
        + block("BNOT", 1, "A")
        + connector("OCon", 2, "On")
        + wire(0, "1.In", feedback=True)
        + wire("1.Out", 2)
    )
    second = (
        connector("ICon", 0, "On")
        + block("BOR", 1, "B")
        + connector("OCon", 2, "Back")
        + wire(0, "1.In1")
        + wire("1.Out", 2)
    )
    marked_behind = (
        first.replace("FeedbackWire", "Wire"),
        second.replace(wire("1.Out", 2), wire("1.Out", 2, feedback=True)),
    )
    for parts in ((first, second), marked_behind):
        follow(
            opened(sheets("Blocks", *parts), {"FBD_BOOLEAN_NOT": "A", "FBD_BOOLEAN_OR": "B"}),
            ({}, {"A.Out": True, "B.Out": True}),
            ({}, {"A.Out": False, "B.Out": False}),
            ({}, {"A.Out": True, "B.Out": True}),
        )


def test_enable_in(opened):
    """A false EnableIn: Dest stays, EnableOut is false, the timer stands still; inputs follow their wires."""
    diagram = sheets(
        "Blocks",
        reference(IN, 0, "On")
        + reference(IN, 1, "A")
        + block("ADD", 2, "Sum")
        + block("TONR", 3, "Delay", x=200)
        + reference(OUT, 4, "Enabled")
        + wire(0, "2.EnableIn")
        + wire(1, "2.SourceA")
        + wire(1, "2.SourceB")
        + wire("2.EnableOut", "3.EnableIn")
        + wire("2.EnableOut", 4)
        + wire(5, "3.TimerEnable")
        + reference(IN, 5, "1"),
    )
    kinds = {"FBD_MATH": "Sum", "FBD_TIMER": "Delay", "BOOL": "On Enabled", "REAL": "A"}
    engines = opened(diagram, kinds)
    follow(
        engines,
        (
            {"A": 2.0, "Delay.PRE": 25},
            {"Sum.Dest": 0.0, "Sum.SourceA": 2.0, "Enabled": False, "Delay.EN": False},
        ),
        ({"On": True}, {"Sum.Dest": 4.0, "Enabled": True, "Delay.EN": True, "Delay.ACC": 0}),
        ({"A": 3.0}, {"Sum.Dest": 6.0, "Enabled": True, "Delay.ACC": 10, "Delay.EnableOut": True}),
        (
            {"On": False, "A": 5.0},
            {"Sum.Dest": 6.0, "Enabled": False, "Delay.ACC": 10, "Delay.EnableOut": False},
        ),
        ({"On": True}, {"Sum.Dest": 10.0, "Enabled": True, "Delay.ACC": 30, "Delay.DN": True}),
    )
    for engine in engines:
        engine.prescan()
        assert [engine.tags[f"Sum.{name}"] for name in ("EnableIn", "EnableOut", "Dest")] == [
            False,
            False,
            10.0,
        ]


def test_timers_counters_and_one_shots(opened):
    """20 ms after In rises Late is true, and counts once; CTUD is done at 2."""
    diagram = sheets(
        "Blocks",
        reference(IN, 0, "In")
        + reference(IN, 1, "20")
        + block("TONR", 2, "Delay")
        + reference(OUT, 3, "Late")
        + block("OSRI", 4, "Edge", x=100)
        + block("CTUD", 5, "Count", x=200)
        + reference(IN, 6, "2")
        + block("SETD", 7, "Latch", x=300)
        + reference(IN, 8, "Clear")
        + wire(0, "2.TimerEnable")
        + wire(1, "2.PRE")
        + wire("2.DN", 3)
        + wire("2.DN", "4.InputBit")
        + wire("4.OutputBit", "5.CUEnable")
        + wire(6, "5.PRE")
        + wire("5.DN", "7.Set")
        + wire(8, "7.Reset"),
    )
    kinds = {
        "BOOL": "In Late Clear",
        "FBD_TIMER": "Delay",
        "FBD_ONESHOT": "Edge",
        "FBD_COUNTER": "Count",
        "DOMINANT_SET": "Latch",
    }
    off = {"Late": False, "Edge.OutputBit": False, "Count.ACC": 0, "Latch.Out": False}
    follow(
        opened(diagram, kinds),
        ({}, off),
        ({"In": True}, off),
        ({}, off),
        ({}, {"Late": True, "Edge.OutputBit": True, "Count.ACC": 1, "Latch.Out": False}),
        ({}, {"Late": True, "Edge.OutputBit": False, "Count.ACC": 1, "Latch.Out": False}),
        ({"In": False}, {"Late": False, "Count.ACC": 1}),
        ({"In": True}, {"Late": False}),
        ({}, {"Late": False}),
        ({}, {"Late": True, "Count.ACC": 2, "Count.DN": True, "Latch.Out": True}),
        ({"In": False, "Count.ACC": 0, "Clear": True}, {"Count.DN": False, "Latch.Out": False}),
    )


def test_numbers_are_chosen_scaled_and_limited(opened):
    """MUX chooses a raw value, SCL makes 0 to 100 of 0 to 200, HLL limits it to 20 to 80."""
    diagram = sheets(
        "Blocks",
        "".join(
            reference(IN, n, each)
            for n, each in enumerate(("Which", "10", "100", "190", "0", "200", "0", "100"))
        )
        + reference(IN, 8, "80")
        + reference(IN, 9, "20")
        + block("MUX", 10, "Choice")
        + block("SCL", 11, "Scaled", x=100)
        + block("HLL", 12, "Limited", x=200)
        + reference(OUT, 13, "Level", x=300)
        + wire(0, "10.Selector")
        + "".join(wire(n, f"10.In{n}") for n in (1, 2, 3))
        + wire("10.Out", "11.In")
        + wire(4, "11.InRawMin")
        + wire(5, "11.InRawMax")
        + wire(6, "11.InEUMin")
        + wire(7, "11.InEUMax")
        + wire("11.Out", "12.In")
        + wire(8, "12.HighLimit")
        + wire(9, "12.LowLimit")
        + wire("12.Out", 13),
    )
    kinds = {
        "DINT": "Which",
        "MULTIPLEXER": "Choice",
        "SCALE": "Scaled",
        "HL_LIMIT": "Limited",
        "REAL": "Level",
    }
    follow(
        opened(diagram, kinds),
        ({"Which": 2}, {"Choice.Out": 100.0, "Scaled.Out": 50.0, "Level": 50.0, "Choice.SelectorInv": False}),
        ({"Which": 1}, {"Scaled.Out": 5.0, "Level": 20.0, "Limited.LowAlarm": True}),
        ({"Which": 3}, {"Scaled.Out": 95.0, "Level": 80.0, "Limited.HighAlarm": True}),
        ({"Which": 9}, {"Choice.Out": 190.0, "Choice.SelectorInv": True, "Choice.Status": 3, "Level": 80.0}),
        ({"Which": 8}, {"Choice.Out": 0.0, "Choice.InstructFault": False, "Choice.Status": 0, "Level": 20.0}),
    )


# the pins of a block or function with their values, its output, and that output's value
FORMULAS = [
    ("ADD", {"SourceA": 7, "SourceB": -3}, "Dest", 4),
    ("SUB", {"SourceA": 7, "SourceB": -3}, "Dest", 10),
    ("MUL", {"SourceA": 7, "SourceB": -3}, "Dest", -21),
    ("MOD", {"SourceA": 7, "SourceB": 4}, "Dest", 3),
    ("XPY", {"SourceA": 2, "SourceB": 5}, "Dest", 32),
    ("SQR", {"Source": 9}, "Dest", 3),
    ("ABS", {"Source": -9}, "Dest", 9),
    ("NEG", {"Source": 9}, "Dest", -9),
    ("NEG", {"Source": -9}, "Dest", 9),
    ("TRN", {"Source": -2.7}, "Dest", -2),
    ("TOD", {"Source": 1234}, "Dest", 0x1234),
    ("FRD", {"Source": 0x1234}, "Dest", 1234),
    ("EQU", {"SourceA": 2, "SourceB": 2}, "Dest", True),
    ("NEQ", {"SourceA": 2, "SourceB": 2}, "Dest", False),
    ("LES", {"SourceA": -1, "SourceB": 2}, "Dest", True),
    ("LEQ", {"SourceA": 3, "SourceB": 2}, "Dest", False),
    ("GRT", {"SourceA": 3, "SourceB": 2}, "Dest", True),
    ("GEQ", {"SourceA": 2, "SourceB": 3}, "Dest", False),
    ("LIM", {"LowLimit": 1, "Test": 5, "HighLimit": 5}, "Dest", True),
    ("LIM", {"LowLimit": 1, "Test": 6, "HighLimit": 5}, "Dest", False),
    ("LIM", {"LowLimit": 5, "Test": 6, "HighLimit": 1}, "Dest", True),
    ("LIM", {"LowLimit": 5, "Test": 3, "HighLimit": 1}, "Dest", False),
    ("MEQ", {"Source": 0x12F4, "Mask": 0xFF, "Compare": 0xF4}, "Dest", True),
    ("MEQ", {"Source": 0x12F4, "Mask": 0xFFF, "Compare": 0xF4}, "Dest", False),
    ("AND", {"SourceA": 12, "SourceB": 10}, "Dest", 8),
    ("OR", {"SourceA": 12, "SourceB": 10}, "Dest", 14),
    ("XOR", {"SourceA": 12, "SourceB": 10}, "Dest", 6),
    ("NOT", {"SourceA": 12}, "Dest", -13),
    ("MVMT", {"Source": 0xAB, "Mask": 0xF0, "Target": 0xCD}, "Dest", 0xAD),
    ("BAND", {"In1": 1, "In2": 1}, "Out", True),
    ("BAND", {"In1": 1, "In8": 0}, "Out", False),
    ("BOR", {"In1": 0, "In3": 1}, "Out", True),
    ("BXOR", {"In1": 1, "In2": 1}, "Out", False),
    ("BNOT", {"In": 0}, "Out", True),
]


@pytest.mark.parametrize("end", ["", "__F"], ids=["block", "function"])
@pytest.mark.parametrize(("name", "pins", "output", "expected"), FORMULAS)
def test_what_a_block_computes(opened, name, pins, output, expected, end):
    is_bool = isinstance(expected, bool)
    diagram = sheets(
        "Blocks",
        "".join(reference(IN, n, str(each)) for n, each in enumerate(pins.values()))
        + block(name + end, 10, "" if end else "It")
        + reference(OUT, 11, "Result")
        + "".join(wire(n, f"10.{each}") for n, each in enumerate(pins))
        + wire(f"10.{output}", 11),
    )
    kinds = {BLOCKS[name].structure.name: "It", "BOOL" if is_bool else "DINT": "Result"}
    follow(opened(diagram, kinds), ({}, {"Result": expected}))


def test_a_function_has_the_type_of_its_inputs(opened):
    """7 / 2 is 3 in DINT and 3.5 in REAL; the pins of a block are REAL; 3 * 2 is 6."""
    diagram = sheets(
        "Blocks",
        "".join(reference(IN, n, each) for n, each in enumerate(("I", "2", "R")))
        + block("DIV__F", 3)
        + block("DIV__F", 4)
        + block("DIV", 5, "It")
        + block("MUL__F", 6)
        + "".join(reference(OUT, 7 + n, each) for n, each in enumerate(("A", "B", "C", "D")))
        + wire(0, "3.SourceA")
        + wire(1, "3.SourceB")
        + wire(2, "4.SourceA")
        + wire(1, "4.SourceB")
        + wire(0, "5.SourceA")
        + wire(1, "5.SourceB")
        + wire("3.Dest", "6.SourceA")
        + wire(1, "6.SourceB")
        + wire("3.Dest", 7)
        + wire("4.Dest", 8)
        + wire("5.Dest", 9)
        + wire("6.Dest", 10),
    )
    engines = opened(diagram, {"INT": "I", "REAL": "R A B C D", "FBD_MATH": "It"})
    follow(engines, ({"I": 7, "R": 7.0}, {"A": 3.0, "B": 3.5, "C": 3.5, "D": 6.0}))


SCALER = add_on(
    "Scaler",
    [
        parameter("Value", "DINT", "Input"),
        parameter("Gain", "DINT", "Input", required=False, default="3"),
        parameter("Result", "DINT", "Output", required=False),
        parameter("Calls", "DINT", "InOut"),
    ],
    [],
    ladder("Logic", "MUL(Value,Gain,Result);", "ADD(Calls,1,Calls);"),
)


def call_of(key, *, name="Scaler", operand="It", argument="Number"):
    inside = f'<InOutParameter Name="Calls" Argument="{argument}"/>' if argument else ""
    head = f'<AddOnInstruction Name="{name}" ID="{key}" X="0" Y="0" Operand="{operand}">'
    return f"{head}{inside}</AddOnInstruction>\n"


def test_an_add_on_as_a_block(opened):
    """Result = 3 Value; Number counts the calls; a false EnableIn calls nothing."""
    diagram = sheets(
        "Blocks",
        reference(IN, 0, "A")
        + reference(IN, 1, "On")
        + call_of(2)
        + reference(OUT, 3, "B")
        + wire(0, "2.Value")
        + wire(1, "2.EnableIn")
        + wire("2.Result", 3),
    )
    follow(
        opened(diagram, {"DINT": "A B Number", "BOOL": "On", "Scaler": "It"}, add_ons=[SCALER]),
        ({"A": 5}, {"B": 0, "Number": 0, "It.Value": 5, "It.EnableOut": False}),
        ({"On": True}, {"B": 15, "Number": 1, "It.EnableOut": True}),
        ({"A": -2}, {"B": -6, "Number": 2}),
        ({"On": False}, {"B": -6, "Number": 2, "It.EnableOut": False}),
    )


def test_a_diagram_in_an_add_on(opened):
    """Each instance has its own function values: Sum = A + Sum before."""
    logic = sheets(
        "Logic",
        reference(IN, 0, "A")
        + block("ADD__F", 1)
        + reference(OUT, 2, "Sum")
        + wire(0, "1.SourceA")
        + wire("1.Dest", "1.SourceB", feedback=True)
        + wire("1.Dest", 2),
    )
    adder = add_on("Adder", [parameter("A", "DINT", "Input"), parameter("Sum", "DINT", "Output")], [], logic)
    diagram = sheets(
        "Blocks",
        reference(IN, 0, "2")
        + reference(IN, 1, "30")
        + call_of(2, name="Adder", operand="One", argument="")
        + call_of(3, name="Adder", operand="Two", argument="")
        + wire(0, "2.A")
        + wire(1, "3.A"),
    )
    follow(
        opened(diagram, {"Adder": "One Two"}, add_ons=[adder]),
        ({}, {"One.Sum": 2, "Two.Sum": 30}),
        ({}, {"One.Sum": 4, "Two.Sum": 60}),
    )


def test_a_diagram_calls_and_is_called(opened):
    """The diagram passes A and A + 1 to a routine that returns their product, and counts A."""
    diagram = sheets(
        "Blocks",
        reference(IN, 0, "A")
        + reference(IN, 1, "1")
        + block("ADD__F", 2)
        + '<JSR ID="3" X="500" Y="0" Routine="Text" In="First Second" Ret="Product"/>\n'
        + reference(OUT, 4, "Result")
        + block("MUL__F", 5)
        + wire("3.Product", "5.SourceA")
        + wire(0, "5.SourceB")
        + wire(0, "3.First")
        + wire(0, "2.SourceA")
        + wire(1, "2.SourceB")
        + wire("2.Dest", "3.Second")
        + wire("5.Dest", 4),
    )
    text = structured("Text", "SBR(X,Y);\nZ := X * Y;\nA := A + 1;\nRET(Z);")
    follow(
        opened(diagram, {"DINT": "A First Second Product Result X Y Z"}, routines=[text]),
        ({"A": 4}, {"Product": 20, "Result": 80, "First": 4, "Second": 5, "A": 5}),
        ({"A": -3}, {"Product": 6, "Result": -18, "A": -2}),
    )


def test_an_add_on_whose_enable_in_is_false_runs_its_other_routine(opened):
    """Logic adds 10 and EnableInFalse 1; EnableOut is EnableIn, unless the routine sets it."""
    logic = ladder("Logic", "ADD(Sum,10,Sum);")
    other = ladder("EnableInFalse", "ADD(Sum,1,Sum);", "GRT(Sum,20)OTE(EnableOut);")
    prescan = ladder("Prescan", "ADD(Scans,1,Scans);")
    sums = [
        parameter("Sum", "DINT", "Output", required=False),
        parameter("Scans", "DINT", "Output", required=False),
    ]
    tally = add_on(
        "Tally", sums, [], logic, other, prescan, runs='ExecuteEnableInFalse="true" ExecutePrescan="true"'
    )
    diagram = sheets(
        "Blocks",
        reference(IN, 0, "On")
        + call_of(1, name="Tally", argument="")
        + wire(0, "1.EnableIn")
        + reference(OUT, 2, "Out")
        + wire("1.EnableOut", 2),
    )
    follow(
        opened(diagram, {"BOOL": "On Out", "Tally": "It"}, add_ons=[tally]),
        ({}, {"It.Sum": 1, "Out": False, "It.Scans": 1}),
        ({"On": True}, {"It.Sum": 11, "Out": True, "It.EnableIn": True}),
        ({}, {"It.Sum": 21, "Out": True}),
        ({"On": False}, {"It.Sum": 22, "Out": True, "It.EnableIn": False}),
    )
