"""Decorated data by a regular expression: the values that the XML parser finds, or None for its turn."""

import pytest
from lxml import etree
from scanrack.rockwell.l5x.xml.data import _MARKS, _of_element, _read

HEAD, TAIL = '<Data Format="Decorated">', "</Data>"
MEMBER = '<DataValueMember Name="Speed" DataType="REAL" Radix="Float" Value="1.5e+001"/>'
ZERO = '<DataValueMember Name="On" DataType="BOOL" Value="0"/>'
TEXT = (
    '<StructureMember Name="Text" DataType="STRING">\n'
    '<DataValueMember Name="LEN" DataType="DINT" Radix="Decimal" Value="2"/>\n'
    '<DataValueMember Name="DATA" DataType="STRING" Radix="ASCII">\n'
    "<![CDATA['é]<$N']]>\n</DataValueMember>\n"
    "</StructureMember>"
)
STUDIO = (
    f'\n<Structure DataType="Recipe">\n{MEMBER}\n{ZERO}\n{TEXT}\n</Structure>\n',
    '<DataValue DataType="DINT" Radix="Hex" Value="16#0000_00ff"/>',
    '\r\n<Array DataType="INT" Dimensions="2,3" Radix="Decimal">\r\n<Element Index="[0,1]" Value="-7"/>'
    "</Array>",
    f'<Array DataType="R" Dimensions="1"><Element Index="[0]"><Structure DataType="R">{MEMBER}</Structure>'
    "</Element></Array>",
    '<Structure DataType="AB:1756_DI:C:0">'
    '<ArrayMember Name="Data" DataType="SINT" Dimensions="1" Radix="ASCII">'
    '<Element Index="[0]" Value="\'$00\'"/></ArrayMember></Structure>',
    '<Structure DataType="R"/>',
    "",
)
OTHERS = (
    f'<Structure DataType="R"><!-- said -->{MEMBER}</Structure>',
    f'<Structure DataType="R">{MEMBER.replace("1.5e", "&#49;.5e")}</Structure>',
    '<Structure DataType="R"><DataValueMember Name="S" Value="1" ForceValue="2"/></Structure>',
    f'<Structure Name="x" DataType="R">text{MEMBER}</Structure>',
    '<Element Name="x"/>',
    '<DataValueMember Index="[0]"/>',
    '<Structure DataType="R"><DataValueMember Name="Speed" DataType="REAL" Value=""/></Structure>',
    f'<Structure DataType="R">{TEXT.replace("é", chr(10))}</Structure>',
)
BROKEN = (
    f'<Structure DataType="R">{MEMBER}</Array>',
    f'<Structure DataType="R">{MEMBER}',
    "</Structure>",
    f'<Structure DataType="R">{TEXT.replace("é", chr(1))}</Structure>',
    f'<Structure DataType="R">{TEXT.replace("é", "]]>")}</Structure>',
    f'<Structure DataType="R">\f{MEMBER}</Structure>',
    '<Structure DataType="R">' * 300 + "</Structure>" * 300,
)


@pytest.mark.parametrize("inner", STUDIO)
def test_data_of_studio_5000(inner):
    read = _read(HEAD + inner + TAIL, _MARKS[True])
    assert read == _of_element(etree.fromstring(HEAD + inner + TAIL))


def test_members_that_are_zero_are_left_out():
    read = _read(HEAD + STUDIO[0] + TAIL, _MARKS[False])
    assert read is not None
    assert [each.name for each in read[0].inner] == ["Speed", "Text"]


@pytest.mark.parametrize("inner", OTHERS + BROKEN)
@pytest.mark.parametrize("zeros", [True, False])
def test_other_data_are_for_the_parser(inner, zeros):
    read = _read(HEAD + inner + TAIL, _MARKS[zeros])
    assert read is None


@pytest.mark.parametrize("inner", BROKEN)
def test_what_is_broken_is_so_for_the_parser(inner):
    with pytest.raises(etree.XMLSyntaxError):
        etree.fromstring(HEAD + inner + TAIL)
