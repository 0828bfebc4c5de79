"""Values are those of the file: an independent reader finds the same, in each form and for modules, too.

The values of an L5X, read plainly: lxml, and a parser of L5K of its own. Nothing of it is scanrack's.

Values come as pairs of an address, such as `Line.Steps[2]`, and a number or text. Decorated data say all
addresses; L5K data have the order of the memory: members of the document's types, and for add-ons words of 32
BOOLs, then what lies between them [1756-RM084S, page 131].
"""

import re
import struct
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from l5x_files import add_on, data_type, document, ladder, machine, member, module, parameter, program, tag
from lxml import etree
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.rockwell.l5x import import_l5x

WHOLE = {"SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT"}
PLAIN = {"BOOL", "BIT", "REAL", "LREAL"} | WHOLE
STATUS = {
    "TIMER": (("EN", 31), ("TT", 30), ("DN", 29), "PRE", "ACC"),
    "COUNTER": (("CU", 31), ("CD", 30), ("DN", 29), ("OV", 28), ("UN", 27), "PRE", "ACC"),
    "CONTROL": (
        *((name, 31 - at) for at, name in enumerate(["EN", "EU", "DN", "EM", "ER", "UL", "IN", "FD"])),
        *("LEN", "POS"),
    ),
}
Value = int | float | str
Values = Iterator[tuple[str, Value]]
_TOKEN = re.compile(r"\s*(\[|\]|,|'(?:[^'$]|\$.)*'|[^\s,\[\]']+)", re.DOTALL)
_ESCAPE = re.compile(r"\$([0-9A-Fa-f]{2}|.)", re.DOTALL)
_NAMED = {"L": "\n", "N": "\n", "P": "\f", "R": "\r", "T": "\t"}


def plain(text: str) -> str:
    """The characters of a literal."""
    return _ESCAPE.sub(
        lambda at: chr(int(at[1], 16)) if len(at[1]) == 2 else _NAMED.get(at[1].upper(), at[1]), text
    )


def number(text: str, kind: str) -> Value:
    """A value in any radix, as its type keeps it."""
    if kind == "REAL":
        single: float = struct.unpack("<f", struct.pack("<f", float(text)))[0]
        return single
    if kind == "LREAL":
        return float(text)
    base, mark, digits = text.rpartition("#")
    found = int(digits.replace("_", ""), int(base)) if mark else int(text)
    bits = {"SINT": 8, "INT": 16, "DINT": 32, "LINT": 64}.get(kind, 0)
    return found - (1 << bits) if bits and found >> bits - 1 == 1 else found


def tree(text: str) -> Any:
    """L5K data as lists of texts."""
    stack: list[list[Any]] = [[]]
    for token in _TOKEN.findall(text):
        if token == "[":
            stack.append([])
        elif token == "]":
            inner = stack.pop()
            stack[-1].append(inner)
        elif token != ",":
            stack[-1].append(token)
    return stack[0][0]


class Document:
    """An L5X."""

    def __init__(self, path: Path) -> None:
        self.root = etree.fromstring(path.read_bytes(), etree.XMLParser(huge_tree=True))
        self.types = {each.get("Name"): each for each in self.root.iter("DataType")}
        self.add_ons = {each.get("Name"): each for each in self.root.iter("AddOnInstructionDefinition")}

    def tags(self) -> Iterator[tuple[str, Any]]:
        """Full names and elements of the tags of the controller and of programs."""
        for each in self.root.iterfind("Controller/Tags/Tag"):
            yield each.get("Name"), each
        for owner in self.root.iterfind("Controller/Programs/Program"):
            for each in owner.iterfind("Tags/Tag"):
                yield rf"\{owner.get('Name')}.{each.get('Name')}", each

    def values(self, name: str, tag: Any) -> Values:
        """The values of a tag, as decorated data and as L5K data have them."""
        for data in tag.iterfind("Data[@Format='Decorated']"):
            for each in data:
                yield from self.shown(name, each)
        for data in tag.iterfind("Data[@Format='L5K']"):
            dims = [int(each) for each in re.findall(r"\d+", tag.get("Dimensions") or "")]
            yield from self.listed(name, tag.get("DataType"), dims, tree("".join(data.itertext())))

    # --- decorated

    def shown(self, path: str, element: Any) -> Values:
        """The values in an element of decorated data."""
        kind = element.get("DataType", "")
        if element.tag.startswith("DataValue") and element.get("Value") is not None:
            yield path, number(element.get("Value"), kind)
        elif element.tag.startswith("DataValue"):
            yield path.removesuffix(".DATA"), plain(element.text.strip()[1:-1])
        for each in element.iterchildren("*"):
            if each.tag == "Element" and each.get("Value") is not None:
                yield path + each.get("Index"), number(each.get("Value"), kind)
            elif each.tag == "Element":
                yield from self.shown(path + each.get("Index"), each[0])
            elif not (each.get("Name") == "LEN" and element.find("*[@Name='DATA']") is not None):
                yield from self.shown(f"{path}.{each.get('Name')}", each)

    # --- L5K

    def listed(self, path: str, kind: str, dims: list[int], data: Any) -> Values:
        """The values in L5K data of a type; nothing of types whose memory is not known."""
        if dims:
            flat = data
            for _ in dims[1:]:
                flat = [each for inner in flat for each in inner]
            for index, each in zip(product(*map(range, dims)), flat, strict=True):
                yield from self.listed(f"{path}[{','.join(map(str, index))}]", kind, [], each)
        elif kind in PLAIN:
            yield path, number(data, kind)
        elif kind in STATUS:
            yield from self.status(path, STATUS[kind], data)
        elif kind == "STRING" or (kind in self.types and self.types[kind].get("Family") == "StringFamily"):
            yield path, plain(data[1][1:-1])[: int(data[0])]
        elif kind in self.types:
            yield from self.members(path, self.types[kind], data)
        elif kind in self.add_ons:
            yield from self.instance(path, self.add_ons[kind], data)

    def status(self, path: str, parts: Any, data: Any) -> Values:
        word, rest = int(data[0]), iter(data[1:])
        for part in parts:
            if isinstance(part, tuple):
                yield f"{path}.{part[0]}", word >> part[1] & 1
            else:
                yield f"{path}.{part}", int(next(rest))

    def members(self, path: str, kind: Any, data: Any) -> Values:
        words: dict[str, int] = {}
        parts = iter(data)
        for each in kind.iterfind("Members/Member"):
            name, dim = each.get("Name"), int(each.get("Dimension") or 0)
            if each.get("DataType") == "BIT":
                yield f"{path}.{name}", words[each.get("Target")] >> int(each.get("BitNumber")) & 1
                continue
            part = next(parts)
            if each.get("Hidden") == "true":
                words[name] = int(number(part, each.get("DataType")))
            else:
                yield from self.listed(f"{path}.{name}", each.get("DataType"), [dim] if dim else [], part)

    def instance(self, path: str, definition: Any, data: Any) -> Values:
        own = [
            each
            for each in (
                *definition.iterfind("Parameters/Parameter"),
                *definition.iterfind("LocalTags/LocalTag"),
            )
            if each.get("Usage") != "InOut" and not each.get("AliasFor")
        ]
        parts, word, bit = iter(data), 0, 32
        for each in own:
            name, kind = each.get("Name"), each.get("DataType")
            dims = [int(at) for at in re.findall(r"\d+", each.get("Dimensions") or "")]
            if kind == "BOOL" and not dims:
                if bit == 32:
                    word, bit = int(next(parts)), 0
                yield f"{path}.{name}", word >> bit & 1
                bit += 1
            else:
                yield from self.listed(f"{path}.{name}", kind, dims, next(parts))


TOP = Path(__file__).parents[3]
FILES = sorted(
    each for folder in ("examples", "benchmarks", "tests") for each in (TOP / folder).rglob("*.L5X")
)


def with_data(made, *forms):
    """A tag with data: bytes, L5K text, or decorated data."""
    return made.replace("</Tag>", f"{''.join(map(form, forms))}</Tag>")


def form(data):
    if isinstance(data, bytes):
        return f"<Data>{data.hex(' ').upper()}</Data>"
    if data.startswith("<"):
        return f'<Data Format="Decorated">{data}</Data>'
    return f'<Data Format="L5K"><![CDATA[{data}]]></Data>'


def local(name, kind, dims=""):
    return f'<LocalTag Name="{name}" DataType="{kind}"{dims and f" Dimensions={dims!r}"}/>'


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_values_of_a_file_are_those_of_an_independent_reader(path):
    controller: Any = import_l5x(path, trial=True).controller
    tags = controller.interpret().tags
    plain = Document(path)
    listed = [pair for name, each in plain.tags() for pair in plain.values(name, each)]
    assert listed
    assert [(name, tags[name]) for name, _ in listed] == listed


# --- add-ons


TALLY = add_on(
    "Tally",
    [
        *(parameter(f"P{number}", "BOOL", "Output", required=False) for number in range(31)),
        parameter("Out", "DINT", "Output", required=False),
        parameter("By", "DINT", "InOut"),
    ],
    [local("Kept", "DINT"), local("Busy", "BOOL"), local("Wait", "TIMER"), local("Small", "INT", "3")],
    ladder("Logic", "ADD(Kept,By,Kept)MOV(Kept,Out);"),
)
WORD = 1 | 1 << 31
"""EnableIn and P29; P30 and Busy are in the second word of BOOLs."""

L5K = f"[{WORD - (1 << 32)},2,500,501,[536870912,800,70],[7,-8,9]]"
BYTES = struct.pack("<5iIii3hxx", WORD - (1 << 32), 2, 500, 501, 0, 1 << 29, 800, 70, 7, -8, 9)
BYTES = BYTES[:16] + BYTES[20:]
SHOWN = (
    '<Structure DataType="Tally"><DataValueMember Name="EnableIn" DataType="BOOL" Value="1"/>'
    '<DataValueMember Name="P29" DataType="BOOL" Value="1"/>'
    '<DataValueMember Name="P30" DataType="BOOL" Value="0"/>'
    '<DataValueMember Name="Out" DataType="DINT" Value="500"/></Structure>'
)
HOLDER = data_type("Holder", member("Level", "DINT"), member("In", "Tally", 2))


@pytest.mark.parametrize("data", [(L5K, SHOWN), (BYTES, SHOWN), (L5K,), (BYTES,)])
def test_local_tags_of_an_add_on_begin_with_the_file(imported, data):
    tags = [with_data(tag("T", "Tally"), *data), tag("One", "DINT", data=_value(1))]
    found = imported(machine("Tally(T,One);", add_ons=[TALLY], tags=tags))
    assert (found.report.notes, found.report.refused, found.report.faults) == ([], [], {})
    for engine in (found.controller.compile(), found.controller.interpret()):
        first = engine.tags["T"]
        assert [first[name] for name in ("P29", "P30", "Busy", "Out", "Kept")] == [
            True,
            False,
            True,
            500,
            501,
        ]
        assert (first["Wait"]["DN"], first["Wait"]["ACC"], first["Small"]) == (True, 70, [7, -8, 9])
        engine.step()
        assert (engine.tags["T.Out"], engine.tags["T.Kept"]) == (502, 502)


def _value(number):
    return f'<DataValue DataType="DINT" Value="{number}"/>'


def test_add_ons_in_structures_and_arrays(imported):
    blank = L5K.replace("501", "0").replace("500", "0")
    both = f"[[3,[{L5K},{blank}]],[4,[{blank},{L5K}]]]"
    tags = [with_data(tag("H", "Holder", "2"), both), tag("One", "DINT")]
    found = imported(machine("Tally(H[0].In[0],One);", add_ons=[TALLY], types=[HOLDER], tags=tags))
    assert found.report.notes == []
    kept = [[found.controller.tags[f"H[{at}].In[{place}].Kept"] for place in (0, 1)] for at in (0, 1)]
    assert (kept, found.controller.tags["H[1].Level"]) == ([[501, 0], [0, 501]], 4)


def test_a_member_with_an_unknown_memory_has_its_decorated_data_and_a_note_in_local_tags(imported):
    outer = add_on(
        "Outer", [], [local("Loop", "PID_ENHANCED"), local("Kept", "DINT")], ladder("Logic", "NOP();")
    )
    plain = data_type("Plain", member("Level", "DINT"), member("Loop", "PID_ENHANCED"))
    loop = (
        '<Structure DataType="Plain"><DataValueMember Name="Level" DataType="DINT" Value="7"/>'
        '<StructureMember Name="Loop" DataType="PID_ENHANCED"><DataValueMember Name="PGain" DataType="REAL" '
        'Value="2.5"/></StructureMember></Structure>'
    )
    tags = [
        with_data(tag("O", "Outer"), "[1,[0,0,1.5],9]"),
        with_data(tag("P", "Plain"), "[7,[0,0,9]]", loop),
    ]
    found = imported(machine("Outer(O);", add_ons=[outer], types=[plain], tags=tags))
    tags = found.controller.tags
    assert (tags["O.Kept"], tags["P.Level"], tags["P.Loop.PGain"]) == (9, 7, 2.5)
    assert found.report.lost == ["O"]
    assert "PID_ENHANCED in local tags start with their defaults" in found.report.notes[0].text


def test_data_of_another_version_of_an_add_on_are_lost_and_said(imported):
    tags = [with_data(tag("T", "Tally"), "[3,1,2]", SHOWN), tag("One", "DINT")]
    found = imported(machine("Tally(T,One);", add_ons=[TALLY], tags=tags))
    assert found.controller.tags["T.Out"] == 500
    assert [each.text for each in found.report.notes] == ["its data are of another version of Tally"]


# --- forms that differ


@pytest.mark.parametrize(
    ("made", "forms", "value", "says"),
    [
        (
            tag("T", "DINT"),
            (struct.pack("<i", 7), "6", _value(5)),
            7,
            "its forms differ: bytes 7, L5K 6, Decorated 5; the bytes count",
        ),
        (tag("T", "DINT"), ("6", _value(0)), 6, "its forms differ: L5K 6, Decorated 0; the L5K count"),
        (tag("T", "DINT"), ("0", _value(5)), 0, "its forms differ: L5K 0, Decorated 5; the L5K count"),
        (
            tag("T", "Pair", "2"),
            (
                "[[1,1.5],[0,2.5]]",
                '<Array DataType="Pair" Dimensions="2"><Element Index="[1]"><Structure DataType="Pair">'
                '<DataValueMember Name="On" DataType="BOOL" Value="1"/>'
                '<DataValueMember Name="Speed" DataType="REAL" Value="2.5"/></Structure></Element></Array>',
            ),
            [{"On": True, "Speed": 1.5}, {"On": False, "Speed": 2.5}],
            "its forms differ at [1].On: L5K False, Decorated True; the L5K count",
        ),
    ],
)
def test_forms_that_differ_are_named_with_their_values(imported, made, forms, value, says):
    pair = data_type(
        "Pair", member("Z", "SINT", hidden=True), member("On", "BIT", target="Z"), member("Speed", "REAL")
    )
    found = imported(machine("NOP();", types=[pair], tags=[with_data(made, *forms)]))
    assert found.controller.tags["T"] == value
    assert [each.text for each in found.report.notes] == [says]
    assert found.report.lost == ["T"]


@pytest.mark.parametrize(
    ("kind", "forms"),
    [
        ("REAL", (struct.pack("<f", 0.1), "1.00000001e-001", '<DataValue DataType="REAL" Value="0.1"/>')),
        ("LREAL", ("1.23456789012346e+000", '<DataValue DataType="LREAL" Value="1.2345678901234567"/>')),
        (
            "STRING",
            (
                "[3,'it$'$00$00']",
                '<Structure DataType="STRING"><DataValueMember Name="LEN" '
                'DataType="DINT" Value="3"/><DataValueMember Name="DATA" DataType="STRING">'
                "<![CDATA['it$'']]></DataValueMember></Structure>",
            ),
        ),
        (
            "TIMER",
            (
                "[-536655872,100,7]",
                '<Structure DataType="TIMER"><DataValueMember Name="PRE" '
                'DataType="DINT" Value="100"/><DataValueMember Name="ACC" DataType="DINT" Value="7"/>'
                '<DataValueMember Name="EN" DataType="BOOL" Value="1"/></Structure>',
            ),
        ),
    ],
)
def test_forms_of_one_value_agree(imported, kind, forms):
    found = imported(machine("NOP();", tags=[with_data(tag("T", kind), *forms)]))
    assert (found.report.notes, found.report.lost) == ([], [])


# --- modules


def io(kind, type_, members, *forms):
    """A tag of a module: `InputTag`, the name of its type, decorated members, and other forms."""
    shown = f'<Structure DataType="{type_}">{members}</Structure>'
    return f"<{kind}>{''.join(forms)}{form(shown)}</{kind}>"


def one(name, kind, value):
    return f'<DataValueMember Name="{name}" DataType="{kind}" Value="{value}"/>'


def built(modules, *rungs, tags=()):
    main = ladder("Main", *(rungs or ("NOP();",)))
    return document(modules=modules, tags=tags, programs=[program("Main", main)])


STATE = 0b1010_0000_0000_0001 - (1 << 16)
BITS = "".join(one(f"Bit{place}", "BOOL", place in (0, 13, 15)) for place in range(16)).replace("True", "1")
BITS = BITS.replace("False", "0")


def test_a_word_and_its_bits_are_one_memory(imported):
    """As many BOOLs as the word before them has bits are its bits; `Data` says nothing else."""
    word = struct.pack("<hh", STATE, 60)
    drive = io(
        "OutputTag",
        "AB:Drive:O:0",
        one("Command", "INT", STATE) + BITS + one("Speed", "INT", 60),
        form(word),
        f"<ForceData>{word.hex(' ')} 00 20 FF FF 00 20 07 00</ForceData>",
    )
    rungs = ("OTE(Local:5:O.Bit1);", "MOV(Local:5:O.Command,Seen);", "MOV(Local:5:O.Speed,Hz);")
    found = imported(built([module("Drive", 5, drive)], *rungs, tags=[tag("Seen", "INT"), tag("Hz", "INT")]))
    report = found.report
    assert (report.notes, report.refused, report.lost) == ([], [], [])
    assert report.forces == {"Local:5:O.Command.13": True, "Local:5:O.Speed": 7}
    for engine in (found.controller.compile(), found.controller.interpret()):
        engine.step()
        assert (engine.tags["Seen"], engine.tags["Hz"]) == (STATE | 2, 60)
        engine.tags["Local:5:O.Command"] = 4
        assert [engine.tags[f"Local:5:O.Bit{place}"] for place in (0, 1, 2)] == [False, False, True]


@pytest.mark.parametrize(
    ("names", "word", "values", "places"),
    [
        (["Ch0Status", "Ch1Status", "Ch2Status"], 4, "001", [0, 1, 2]),
        (["Low_2", "High_9", "On"], 1 << 9, "010", [2, 9, None]),
        (["Ready", "Active"], 1, "10", [None, None]),
        (["Ch0Status", "Ch1Status"], 1, "01", [None, None]),  # the values are other ones
    ],
)
def test_bits_that_the_file_does_not_place_have_their_own_memory(imported, names, word, values, places):
    bits = "".join(one(name, "BOOL", value) for name, value in zip(names, values, strict=True))
    panel = io("InputTag", "X:Panel:I:0", one("Fault", "DINT", 0) + one("Status", "INT", word) + bits)
    report = imported(built([module("Panel", 5, panel)])).report
    noted = "BOOLs of its Status have their own memory" in "".join(each.text for each in report.notes)
    assert (noted, report.lost) == (None in places, [])
    tags = imported(built([module("Panel", 5, panel)])).controller.tags
    assert [tags[f"Local:5:I.{name}"] for name in names] == [value == "1" for value in values]
    tags["Local:5:I.Status"] = -1
    placed = [value == "1" if place is None else True for value, place in zip(values, places, strict=True)]
    assert [tags[f"Local:5:I.{name}"] for name in names] == placed


@pytest.mark.parametrize(
    ("kind", "inside", "size", "where", "value"),
    [
        ("InputTag", f"<ForceData>{'00 ' * 4}0B 00 16 00{' 00' * 16}</ForceData>", 4, "I.Data[1]", 22),
        ("OutputTag", form("[[33,44]]"), 4, "O.Data[1]", 44),
        ("OutputTag", form("[[1,2,3,-4]]"), 4, "O.Data[3]", -4),
        ("OutputTag", form(struct.pack("<hh", 33, 44)), 4, "O.Data[1]", 44),
    ],
)
def test_tags_without_decorated_data_have_the_size_of_their_connection(
    imported, kind, inside, size, where, value
):
    drive = module("Drive", 5, f"<{kind}>{inside}</{kind}>", catalog="ETHERNET-MODULE")
    drive = drive.replace('RPI="20000"', f'RPI="20000" InputSize="{size}" OutputSize="{size}"')
    found = imported(built([drive]))
    assert (found.controller.tags[f"Local:5:{where}"], found.report.lost) == (value, [])


def test_values_of_a_module_that_show_no_type_are_the_reason_of_its_rungs(imported):
    panel = module("Panel", 5).replace(
        "<Connections>", f"<ConfigTag>{form('[1,2,3]')}</ConfigTag><Connections>"
    )
    report = imported(built([panel])).report
    assert report.lost == ["Local:5:C"]


def test_outputs_of_a_simulated_module_begin_with_the_file(tmp_path):
    """What the program does not write keeps the value of the file; prescan clears the coil."""
    words = "".join(f'<Element Index="[{at}]" Value="{at + 10}"/>' for at in range(8))
    data = f'<ArrayMember Name="Data" DataType="INT" Dimensions="8">{words}</ArrayMember>'
    feed = module("Feed", 1, io("OutputTag", "AB:1769_MODULE:O:0", data), catalog="1769-MODULE")
    text = built(
        [feed],
        "MOV(3,Local:1:O.Data[2]);",
        "XIC(Never)OTE(Local:1:O.Data[1].1);",
        tags=[tag("Never", "BOOL")],
    )
    (tmp_path / "machine.L5X").write_text(text, encoding="utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text('program = "machine.L5X"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n', encoding="utf-8")
    job = load_job(str(rack))
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions())
        run.run(2)
        assert list(run.rack.slots[1].outputs) == [10, 11 & ~2, 3, 13, 14, 15, 16, 17]


def test_a_bit_that_differs_in_a_structure_inside_another_is_named(imported):
    flags = data_type("Flags", member("Z", "SINT", hidden=True), member("On", "BIT", target="Z"))
    outer = data_type("Outer", member("Inner", "Flags"))
    decorated = (
        '<Structure DataType="Outer"><StructureMember Name="Inner" DataType="Flags">'
        '<DataValueMember Name="On" DataType="BOOL" Value="1"/></StructureMember></Structure>'
    )
    found = imported(
        machine("NOP();", types=[flags, outer], tags=[with_data(tag("T", "Outer"), "[[0]]", decorated)])
    )
    assert [each.text for each in found.report.notes] == [
        "its forms differ at .Inner.On: L5K False, Decorated True; the L5K count"
    ]
