"""Members of axes that rungs name and that the types of axes do not have."""

import l5x_files as files

TAGS = (
    files.tag("Feed", "AXIS_SERVO_DRIVE"),
    files.tag("Press", "AXIS_SERVO"),
    files.alias("Line", "Feed"),
    files.tag("Lamp", "BOOL"),
    files.tag("Word", "DINT"),
    files.tag("Level", "REAL"),
)


def test_they_are_added_to_the_type_and_listed(imported):
    text = files.machine(
        "XIC(Feed.SERCOSRingFault)XIC(Line.DriveThermalFault)OTE(Lamp);",
        "MOV(Feed.InternalWord,Word)XIC(Feed.OtherWord.4)OTE(Lamp);",
        "MUL(Feed.InternalGain,2.5,Level)XIC(Feed.ServoActionStatus)OTE(Lamp);",
        tags=TAGS,
    )
    found = imported(text)
    assert ([str(each) for each in found.report.refused], found.report.ran) == ([], 3)
    listed = found.report.declared["type AXIS_SERVO_DRIVE"].split(", ")
    assert listed == ["SERCOSRingFault", "DriveThermalFault", "InternalWord", "OtherWord", "InternalGain"]


def test_such_an_axis_can_be_handed_to_an_add_on(imported):
    definition = files.add_on(
        "Watch",
        [
            files.parameter("Axis", "AXIS_SERVO_DRIVE", "InOut"),
            files.parameter("Bad", "BOOL", "Output", required=False),
        ],
        [],
        files.ladder("Logic", "XIC(Axis.SERCOSRingFault)OTE(Bad);"),
    )
    rungs = "Watch(Watching,Feed);", "XIC(Feed.ModuleHardFault)MSF(Feed,Do);"
    tags = (*TAGS, files.tag("Watching", "Watch"), files.tag("Do", "MOTION_INSTRUCTION"))
    found = imported(files.machine(*rungs, tags=tags, add_ons=[definition]))
    assert ([str(each) for each in found.report.refused], found.report.ran) == ([], 3)


def test_the_drive_fault_of_an_analog_axis_is_a_bit(imported):
    found = imported(
        files.machine("XIC(Press.DriveFault)OTE(Lamp);", "MOV(Feed.DriveFault,Word);", tags=TAGS)
    )
    assert ([str(each) for each in found.report.refused], found.report.declared) == ([], {})


def test_an_attribute_that_the_axis_does_not_have_is_a_member_too(imported):
    rungs = (
        "SSV(Axis,Press,DampingFactor,Level);",
        "GSV(Axis,Press,DampingFactor,Copy);",
        "GSV(Axis,Line,DriveFaultBits,Word);",
    )
    level = files.tag("Level", "REAL", data=files.value("REAL", "2.5")), files.tag("Copy", "REAL")
    found = imported(files.machine(*rungs, tags=(*TAGS[:5], *level)))
    assert (found.report.ran, found.report.refused) == (3, [])
    assert found.report.declared["type AXIS_SERVO"] == "DampingFactor"
    assert files.after(found).Copy == 2.5


def test_a_partial_export_has_the_axis_of_which_an_attribute_is_read(imported):
    rungs = (
        "GSV(Axis,Lift,ActualPosition,Height);",
        "GSV(Axis,Lift,HomeMode,Mode);",
        "GSV(MotionGroup,All,TaskMaximumScanTime,Slowest);",
    )
    found = imported(
        files.document(target="Routine", programs=[files.program("P", files.ladder("R", *rungs))])
    )
    assert (found.report.ran, found.report.refused) == (3, [])
    assert found.report.declared == {
        "Lift": "AXIS_CIP_DRIVE",
        "Height": "REAL",
        "Mode": "DINT",
        "All": "MOTION_GROUP",
        "Slowest": "DINT",
    }
