"""Partial exports: what their context leaves out is declared from its use."""

from l5x_files import after, document, ladder, program, structured


def test_a_controller_that_is_context_is_a_partial_export(imported):
    text = document(programs=[program("Main", ladder("Main", "XIC(Missing)OTE(Too);"))])
    found = imported(text.replace('<Controller Use="Target"', '<Controller Use="Context"'))
    assert (found.report.refused, found.report.ran) == ([], 1)
    assert found.report.declared == {"Missing": "BOOL", "Too": "BOOL"}


def test_structured_text_without_lines(imported):
    text = document(
        target="Routine", programs=[program("Main", structured("Main", "Missing := 3;\nToo := 4;"), main="")]
    )
    start, end = text.index("<Line"), text.rindex("</Line>") + len("</Line>")
    found = imported(text[:start] + "<![CDATA[\nMissing := 3;\nToo := 4;]]>" + text[end:])
    assert found.report.objects == []
    said = after(found)
    assert (said.Missing, said.Too) == (3, 4)


def test_a_later_use_says_what_an_earlier_one_is(imported):
    rungs = "EQU(Unit.Name,Unit.Other)OTE(Same);", "COP(Unit.Name,Spare,1);", "CONCAT(Unit.Name,'a',Spare);"
    found = imported(document(target="Routine", programs=[program("Main", ladder("Main", *rungs), main="")]))
    assert ([str(each) for each in found.report.refused], found.report.ran) == ([], 3)
    assert (found.report.declared["Spare"], found.report.declared["Same"]) == ("STRING", "BOOL")
