"""Documents that are valid and too large, and trials that would not end."""

import pytest
from l5x_files import document, ladder, machine, program, structured, tag, task
from scanrack.ladder.compiler import writer
from scanrack.rockwell.l5x import L5xError, trial
from scanrack.rockwell.l5x.xml import limits

TAGS = [tag("a", "BOOL"), tag("b", "BOOL"), tag("i", "DINT")]


def _routines(count):
    return document(programs=[program("P", *[ladder(f"R{number}", "NOP();") for number in range(count)])])


@pytest.mark.parametrize(
    ("noun", "text"),
    [
        ("programs", document(programs=[program(f"P{number}") for number in range(5)])),
        ("routines", _routines(5)),
        ("rungs", machine(*["XIC(a)OTE(b);"] * 5, tags=TAGS)),
        (
            "lines of structured text",
            document(programs=[program("P", structured("Main", "i:=1;\n" * 5))], tags=TAGS),
        ),
        ("characters of logic", machine("XIC(a);", tags=TAGS)),
        ("instructions in rungs", machine("XIC(a)XIC(a);", "XIC(a)XIC(b)OTE(b);", tags=TAGS)),
    ],
)
def test_a_document_beyond_a_limit_is_refused(imported, monkeypatch, noun, text):
    row = next(each for each in limits.LIMITS if each.noun == noun)
    monkeypatch.setattr(limits, "LIMITS", (row._replace(most=5),))
    if noun != "characters of logic":
        imported(text)
    monkeypatch.setattr(limits, "LIMITS", (row._replace(most=4),))
    with pytest.raises(L5xError, match=f"it has [5-9] {noun}; 4 are allowed"):
        imported(text)


def test_a_rung_with_too_many_instructions_is_refused(imported):
    report = imported(machine("NOP();", "XIC(a)" * 5_000 + "OTE(b);", tags=TAGS)).report
    assert [(each.rung, each.reason) for each in report.refused] == [
        (1, "it has 5,001 instructions; 5,000 are allowed")
    ]
    assert report.ran == 1


@pytest.mark.slow
def test_calls_that_multiply_end_the_trial(imported):
    calls = [
        ladder(f"R{number}" if number else "Main", *[f"JSR(R{number + 1},0);"] * 8) for number in range(12)
    ]
    text = document(programs=[program("P", *calls, ladder("R12", "NOP();"))], tasks=[task("T", "P")])
    report = imported(text).report
    assert (report.imported, report.ran) == (97, 0)
    assert "more than 1,000,000 rungs and statements run in it" in report.faults["P"]


def test_a_trial_counts_the_rungs_of_all_its_scans(imported, monkeypatch):
    text = machine(*["XIC(a)OTE(b);"] * 10, tags=TAGS)
    monkeypatch.setattr(trial, "MOST_IN_ALL", 10 * (trial.SCANS + 1) + 1)  # prescan, and all scans
    assert imported(text).report.ran == 10
    monkeypatch.setattr(trial, "MOST_IN_ALL", 10 * (trial.SCANS + 1))
    report = imported(text).report
    assert (report.imported, report.ran) == (10, 0)
    assert list(report.faults) == ["Plant", "Main"]


def test_a_routine_that_compiles_to_too_much_is_refused_alone(imported, monkeypatch):
    monkeypatch.setattr(writer, "MOST_LINES", 20)
    tags = [tag("A", "DINT"), tag("B", "BOOL")]
    long = ladder("Long", *["ADD(A,1,A);"] * 20)
    main = ladder("Main", "JSR(Long,0);", "OTE(B);")
    found = imported(document(tags=tags, programs=[program("P", main, long)], tasks=[task("T", "P")]))
    assert (len(found.report.refused), found.report.imported, found.report.ran) == (20, 2, 2)
    assert found.report.refused[0].reason == r"routine \P.Long compiles to more than 20 lines of Python"
