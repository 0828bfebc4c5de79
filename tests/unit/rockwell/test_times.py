"""Types and values of dates and durations."""

import l5x_files as files
import pytest


@pytest.mark.parametrize(
    ("kind", "text", "number"),
    [
        ("LDT", "LDT#1970-01-01-00:00:00.000_000_001(UTC+00:00)", 1),  # ns since 1970
        ("LINT", "DT#1970-01-01-02:00:00.000_001(UTC+02:00)", 1),  # us
        ("DT", "DT#1970-01-01-00:00:00(UTC-00:30)", 1_800_000_000),
        ("TIME32", "T32#1s_500ms", 1_500_000),  # us
        ("TIME", "T#1d_2h3m_4.5s_6ms_7us", 93_784_506_007),
        ("TIME", "T#-1s", -1_000_000),
        ("LTIME", "LT#4us_1ns", 4001),  # ns
    ],
)
def test_a_date_or_a_duration(imported, kind, text, number):
    tags = files.tag("Moment", kind, data=files.value(kind, text)), files.tag("Later", "LINT")
    found = imported(files.machine("ADD(Moment,1,Later);", tags=tags))
    assert (found.report.ran, found.report.notes) == (1, [])
    assert found.controller.tags.Moment == number


def test_a_type_of_the_file_has_precedence(imported):
    time = files.data_type("TIME", files.member("Hour", "DINT"))
    found = imported(files.machine("MOV(12,Now.Hour);", types=[time], tags=[files.tag("Now", "TIME")]))
    assert (found.report.ran, found.report.refused) == (1, [])


def test_what_is_no_duration_is_noted(imported):
    tags = [files.tag("Moment", "LINT", data=files.value("LINT", "T#5"))]
    (note,) = imported(files.machine("NOP();", tags=tags)).report.notes
    assert "'T#5' is not a number" in note.text
