"""When an action of a sequential function chart runs, scan by scan [1756-PM006].

Each chart is A - B - C: A is left in scan 2, so B has its first scan in scan 3; B is left in scan 7, where it
has its last scan; C has its first scan in scan 8. A scan is 10 ms, PRE is 20 ms.
"""

import pytest
from charts import BothEngines, marks, program_of, told

CHART = """
INITIAL_STEP A
END_STEP
STEP B
    ACTION Act {qualifier}
        Ran := Ran + 1; Seen := Act.Q; OnLast := B.LS; Kept [:=] 1;
    END_ACTION
END_STEP
STEP C
    {in_c}
END_STEP
TRANSITION T1 FROM A TO B
    Go
END_TRANSITION
TRANSITION T2 FROM B TO C
    Leave
END_TRANSITION
"""

DONT, PROGRAMMATIC, AUTOMATIC = (
    f"CURRENT MOST_RECENT {last}" for last in ("DONT_SCAN", "PROGRAMMATIC", "AUTOMATIC")
)
SCANS = 14


def played(qualifier, options=DONT, in_c=""):
    """Return bits A and Q after each scan, and how often the body has run up to each."""
    chart = CHART.format(qualifier=qualifier, in_c=in_c)
    tags = "Go : BOOL; Leave : BOOL; Ran : DINT; Seen : BOOL; OnLast : BOOL; Kept : DINT"
    program, preset = program_of(chart, tags=tags, options=options), {"Act.PRE": {0: 20}}
    names = "Act.A Act.Q Ran Kept Act.T Act.Count"
    found = told(program, names, SCANS, Go={2: True}, Leave={7: True}, **preset)
    runs = [int(now) - int(before) for now, before in zip(found["Ran"], [0, *found["Ran"]], strict=False)]
    return marks(found["Act.A"]), runs, found


@pytest.mark.parametrize(
    ("qualifier", "on", "runs"),
    [
        # choose a qualifier for an action: start, stop          scan 0123456789...
        pytest.param("N", "00011110000000", "00011111000000", id="N with the step"),
        pytest.param("P1", "00010000000000", "00010000000000", id="P1 once at its start"),
        pytest.param("P0", "00000001000000", "00000001000000", id="P0 once at its end"),
        pytest.param("P", "00010001000000", "00010001000000", id="P at both"),
        pytest.param("S", "00011111111111", "00011111111111", id="S until R"),
        pytest.param("L", "00011000000000", "00011000000000", id="L for PRE at most"),
        pytest.param("D", "00000110000000", "00000111000000", id="D after PRE"),
        pytest.param("SL", "00011000000000", "00011000000000", id="SL for PRE"),
        pytest.param("SD", "00000111111111", "00000111111111", id="SD after PRE until R"),
        pytest.param("DS", "00000111111111", "00000111111111", id="DS after PRE until R"),
    ],
)
def test_an_action_starts_and_stops_as_its_qualifier_says(qualifier, on, runs):
    """In scan 7 the body of N and D runs before T2 is true; their last scan is not scanned."""
    bits, ran, _ = played(qualifier)
    assert (bits, "".join(map(str, ran))) == (on, runs)


def test_a_delay_ends_with_its_step_unless_it_is_stored():
    """PRE of 60 ms ends in scan 9, when B is inactive: D and DS never start, SD does."""
    for qualifier, on in (("D", "0" * 14), ("DS", "0" * 14), ("SD", "00000000011111")):
        chart = CHART.format(qualifier=qualifier + " PRE := 60", in_c="")
        tags = "Go : BOOL; Leave : BOOL; Ran : DINT; Seen : BOOL; OnLast : BOOL; Kept : DINT"
        found = told(program_of(chart, tags=tags), "Act.A", SCANS, Go={2: True}, Leave={7: True})
        assert marks(found["Act.A"]) == on, qualifier


def test_a_stored_time_limit_runs_on_after_its_step():
    """SL with PRE of 60 ms: from scan 3 up to scan 8, in which C is active."""
    chart = CHART.format(qualifier="SL PRE := 60", in_c="")
    tags = "Go : BOOL; Leave : BOOL; Ran : DINT; Seen : BOOL; OnLast : BOOL; Kept : DINT"
    found = told(program_of(chart, tags=tags), "Act.A", SCANS, Go={2: True}, Leave={7: True})
    assert marks(found["Act.A"]) == "00011111100000"


@pytest.mark.parametrize("qualifier", ["S", "SL", "SD", "DS"])
def test_r_turns_a_stored_action_off(qualifier):
    """R of step C acts in its first scan, scan 8, after the action has run in its place."""
    bits, _, _ = played(qualifier, in_c="ACTION Act R;")
    assert bits[8:] == "000000"


class TestLastScan:
    """Choose a last scan option: what N does in scan 7, in which B is left."""

    def test_dont_scan_leaves_the_data(self):
        _, runs, found = played("N", DONT)
        assert (runs[7], found["Kept"][7]) == (1, 1)

    def test_programmatic_reset_executes_once_more_with_q_off(self):
        _, runs, found = played("N", PROGRAMMATIC)
        assert (runs[7], found["Kept"][7]) == (2, 1)

    def test_automatic_reset_clears_non_retentive_assignments(self):
        _, runs, found = played("N", AUTOMATIC)
        assert (runs[7], found["Kept"][6:9]) == (1, [1, 0, 0])

    def test_a_pulse_has_its_postscan_in_the_next_scan(self):
        """P and P0 actions execute according to their logic, and in postscan mode on the next scan."""
        _, runs, found = played("P0", AUTOMATIC)
        assert (runs[7:9], found["Kept"][7:9]) == ([1, 0], [1, 0])

    def test_a_time_limited_action_has_its_last_scan_before_that_of_the_step(self):
        """The postscan of an action occurs when it goes from active to inactive: L in scan 5."""
        _, _, found = played("L", AUTOMATIC)
        assert found["Kept"][4:6] == [1, 0]

    def test_a_stored_action_has_it_after_that_of_the_step(self):
        _, _, found = played("S", AUTOMATIC, in_c="ACTION Act R;")
        assert found["Kept"][7:9] == [1, 0]

    def test_q_is_off_in_the_last_scan_and_ls_is_on(self):
        chart = CHART.format(qualifier="N", in_c="")
        tags = "Go : BOOL; Leave : BOOL; Ran : DINT; Seen : BOOL; OnLast : BOOL; Kept : DINT"
        program = program_of(chart, tags=tags, options=PROGRAMMATIC)
        found = told(program, "Seen OnLast", 9, Go={2: True}, Leave={7: True})
        assert (marks(found["Seen"]), marks(found["OnLast"])) == ("000111100", "000000011")


STEP = """
INITIAL_STEP A
END_STEP
STEP B
    PRE := 20;
    LimitHigh := 30;
    LimitLow := 100;
    ACTION Look N
        First := First + B.FS; Later := Later + B.SA; Last := Last + B.LS;
    END_ACTION
END_STEP
TRANSITION T1 FROM A TO B
    Go
END_TRANSITION
TRANSITION T2 FROM B TO A
    Leave
END_TRANSITION
"""


def played_step(names):
    """Return values of a step that is active from scan 3 to 7."""
    tags = "Go : BOOL; Leave : BOOL; First : DINT; Later : DINT; Last : DINT; En : BOOL"
    chart = STEP.replace("Look N", "Look N").replace(
        "First := First + B.FS", "IF B.FS THEN First := First + 1; END_IF"
    )
    chart = chart.replace("Later := Later + B.SA", "IF B.SA THEN Later := Later + 1; END_IF")
    chart = chart.replace("Last := Last + B.LS", "IF B.LS THEN Last := Last + 1; END_IF")
    program = program_of(chart, tags=tags, options=PROGRAMMATIC)
    at = {"Go": {2: True, 3: False}, "Leave": {7: True}, "B.AlarmEn": {0: True}}
    both = BothEngines(program)
    rows = []
    for scan in range(10):
        engine = both.step({name: value[scan] for name, value in at.items() if scan in value})
        rows.append([engine.tags[name] for name in names.split()])
    return [list(column) for column in zip(*rows, strict=True)]


def test_a_steps_timer_and_bits():
    """Step tags: X, T, DN until the step is active again, TMax, Count."""
    x, t, dn, tmax, count = played_step("B.X B.T B.DN B.TMax B.Count")
    assert marks(x) == "0011111000"
    assert t[3:8] == [0, 10, 20, 30, 40]
    assert marks(dn) == "0000011111"
    assert (tmax[-1], count[-1]) == (40, 1)


def test_the_first_the_middle_and_the_last_scan_of_a_step():
    """FS on the first scan, LS on the last scan, SA between; FS and LS are off outside of the step."""
    first, later, last, fs, ls = played_step("First Later Last B.FS B.LS")
    assert (first[-1], later[-1], last[-1]) == (1, 4, 1)
    assert not any(fs)
    assert not any(ls)


def test_alarms_of_a_step_that_is_too_long_and_too_short():
    """LimitHigh 30 ms is reached in scan 6; the step goes inactive before LimitLow, 100 ms, in scan 7."""
    high, low = played_step("B.AlarmHigh B.AlarmLow")
    assert (marks(high), marks(low)) == ("0000001111", "0000000111")


def test_status_has_the_bits_of_a_step():
    """Status: X 31, FS 30, SA 29, LS 28, DN 27, AlarmEn 25."""
    (status,) = played_step("B.Status")
    assert status[4] & 0xFFFFFFFF == 1 << 31 | 1 << 29 | 1 << 25
