"""Structured text as text: what is read, how it prints, what is refused where, where comments go."""

import math

import pytest
from scanrack.jobs import ProgramError, load_program
from scanrack.ladder import (
    BOOL,
    DINT,
    REAL,
    STRING,
    BuildError,
    LadderError,
    LadderFault,
    Program,
    RungTextError,
    read_program,
    write_program,
)
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.model.statements import Assignment, Case, Empty, If, block_lines
from scanrack.ladder.model.tree import Address, Number, Operation
from scanrack.ladder.st import parse_statements

A, B, C = map(Address, "ABC")


def block_text(block):
    return "\n".join(block_lines(block))


def value(text):
    (statement,) = parse_statements(f"X := {text};")
    assert isinstance(statement, Assignment)
    return statement.value


def test_a_text_prints_one_statement_a_line():
    text = """if Run & (Level<5) or not Word.5 then Valve:=1;;
    elsif A = 1 then else Name := 'It$'s // $0A'; end_if;
    #region Timers here
    case N+1 of 1: X := .5; Y := 1.; 2, 4..6, 16#ff: RES(Fill); cop(D[0],E,3); 3: ; else Z [:=] 1_000;
    end_case;
    #endregion
    for I := 0 to 9 by -2 do exit; end_for;  while Word.[I] do return; end_while;
    repeat X := sqrt(Y) mod 3; until X >= 1.5e3 end_repeat;
    Local:1:O.Data[0].14 := S:FS; SWPB(A, high/low, B); JSR(Sub,1,A,B); EXIT; RETURN;"""
    expected = """IF Run AND Level<5 OR NOT Word.5 THEN
    Valve := 1;
    ;
ELSIF A=1 THEN
ELSE
    Name := 'It$'s // $0A';
END_IF;
#region Timers here
    CASE N+1 OF
        1:
            X := 0.5;
            Y := 1.;
        2, 4..6, 16#FF:
            RES(Fill);
            COP(D[0],E,3);
        3:
            ;
    ELSE
        Z [:=] 1000;
    END_CASE;
#endregion
FOR I := 0 TO 9 BY -2 DO
    EXIT;
END_FOR;
WHILE Word.[I] DO
    RETURN;
END_WHILE;
REPEAT
    X := SQR(Y) MOD 3;
UNTIL X>=1.5e3
END_REPEAT;
Local:1:O.Data[0].14 := S:FS;
SWPB(A,HIGH/LOW,B);
JSR(Sub,1,A,B);
EXIT;
RETURN;"""
    block = parse_statements(text)
    assert block_text(block) == expected
    assert parse_statements(expected) == block


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("A OR B AND C", "A OR (B AND C)"),
        ("A OR B XOR C", "A OR (B XOR C)"),
        ("A XOR B & C", "A XOR (B AND C)"),
        ("A AND B = C", "A AND (B = C)"),
        ("A = B < C", "A = (B < C)"),
        ("A <> B <= C", "A <> (B <= C)"),
        ("A < B + C", "A < (B + C)"),
        ("A + B * C", "A + (B * C)"),
        ("A - B - C", "(A - B) - C"),
        ("A / B MOD C", "(A / B) MOD C"),
        ("NOT A = B", "(NOT A) = B"),
        ("NOT A * B", "(NOT A) * B"),
        ("-A ** B", "-(A ** B)"),
        ("-2 ** B", "-(2 ** B)"),
        ("A ** B ** C", "(A ** B) ** C"),
        ("A * -B", "A * (-B)"),
        ("NOT -A", "NOT (-A)"),
        ("ABS(A) ** 2", "(ABS(A)) ** 2"),
    ],
)
def test_operators_bind_as_the_manual_has_it(text, same):
    """1756-PM007, order of execution."""
    assert value(text) == value(same)


def test_a_number_takes_its_sign_and_an_expression_gets_one():
    assert value("-5") == Number(-5, "-5")
    assert value("-(5)") == Operation("NEG", (Number(5, "5"),))
    assert str(value("-(5)")) == "-(5)"


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("16#8000_0001", -0x7FFF_FFFF),
        ("8#17", 15),
        ("2#1010_1010", 0xAA),
        ("1_000", 1000),
        ("1.5e3", 1500.0),
        (".5", 0.5),
        ("2.", 2.0),
        ("1e-2", 0.01),
        ("1.$", math.inf),
        ("1.#INF00", math.inf),
        ("T#1m30s", 90_000),
        ("time#1.5s", 1500),
    ],
)
def test_literals(text, number):
    assert value(text).value == number
    assert value(str(value(text))) == value(text)


def test_literals_beside_other_text():
    assert math.isnan(value("1.#QNAN").value)
    assert value("T+1") == Operation("+", (Address("T"), Number(1, "1")))
    (case,) = parse_statements("CASE A OF T#1ms..T#3ms: B := 1; 5..7: B := 2; END_CASE;")
    assert isinstance(case, Case)
    assert [(str(each.low), str(each.high)) for choice in case.choices for each in choice.labels] == [
        ("T#1MS", "T#3MS"),
        ("5", "7"),
    ]
    with pytest.raises(LadderError, match=r"expected a time such as T#5s"):
        value("T#5")
    with pytest.raises(LadderError, match=r"expected a number, 1\.\$"):
        value("1.#HM")


def test_comments_stay_with_their_statements():
    text = """// above
    A := 1; // behind
    (* two
       lines *)
    IF A THEN /* in it */ B := 1;
    // last
    END_IF; // after
    CASE A OF
    // of the first
    1: B := 2;
    // of the second
    2: B := 3; // behind that
    END_CASE;
    B := 'no // comment (* here *)';
    // end"""
    block = parse_statements(text)
    first, choice, cases, string, end = block
    assert first.comment == "above\nbehind"
    assert choice.comment == "two\nlines\nafter"
    assert isinstance(choice, If)
    assert [each.comment for each in choice.arms[0].body] == ["in it", "last"]
    assert choice.arms[0].body[1] == Empty(comment="last")
    assert isinstance(cases, Case)
    assert [each.comment for each in cases.choices] == ["of the first", "of the second"]
    assert cases.choices[1].body[0].comment == "behind that"
    assert isinstance(string, Assignment)
    assert end == Empty(comment="end")
    assert parse_statements(block_text(block)) == block


def test_statements_know_their_lines():
    block = parse_statements(
        "A := 1;\n\nIF A THEN\n  B := 2;\nELSIF B THEN\n ;\nEND_IF;", file="f.st", line=10
    )
    assert (block[0].line, block[0].origin.line) == (1, 10)
    choice = block[1]
    assert isinstance(choice, If)
    assert [arm.line for arm in choice.arms] == [3, 5]
    assert choice.arms[0].body[0].origin.line == 13
    assert choice.origin.file == "f.st"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "line", "column", "expected"),
    [
        ("X := ;", 1, 6, "an expression"),
        ("X = 1;", 1, 3, ":= or [:=]"),
        ("\n  X := 1", 2, 9, "an operator or ;"),
        ("IF A THEN", 1, 10, "END_IF"),
        ("IF A THEN END_IF", 1, 17, ";"),
        ("END_IF;", 1, 1, "a statement or the end"),
        ("foo(1);", 1, 1, "an instruction; foo is unknown"),
        ("X := foo(1);", 1, 6, "a function"),
        ("X := (1;", 1, 8, "an operator or )"),
        ("X := 'a$q';", 1, 6, "escapes"),
        ("X := 'a\n';", 1, 6, "structured text"),
        ("X := 16#;", 1, 8, "structured text"),
        ("X := 99999999999999999999;", 1, 6, "a number of at most 64 bits"),
        ("(* A := 1;", 1, 1, "*) at the end of the comment"),
        ("CASE A OF b: END_CASE;", 1, 11, "a number"),
        ("RES();", 1, 1, "1 operands of RES"),
        ("SWPB(A,5,B);", 1, 1, "one of REVERSE"),
        ("IF A THEN\n" * 40 + "END_IF;" * 40, 34, 1, "at most 32 nested statements"),
        ("WHILE A DO\n" * 14 + "END_WHILE;" * 14, 1, 1, "fewer"),
        (f"X := {'(NOT ' * 5000}A{')' * 5000};", 1, 1, "at most 100 levels"),
        (f"X := A{'+A' * 5000};", 1, 1, "at most 100 levels"),
    ],
    ids=lambda each: str(each)[:20],
)
def test_refusals_name_line_and_column(text, line, column, expected):
    with pytest.raises(RungTextError) as refused:
        parse_statements(text)
    assert (refused.value.site.line, refused.value.site.column) == (line, column)
    assert expected in refused.value.expected


FILE = """(* a header
   of two lines *)
PROGRAM line   // its name
TAG Go : BOOL
// of the tag
TAG N : DINT := 5  // so many

// of the first statement
IF Go THEN
    N := N + 1;
END_IF;
"""


def test_a_file_of_structured_text_declares_its_tags_first(tmp_path):
    path = tmp_path / "some name.st"
    path.write_text(FILE, encoding="utf-8")
    program = read_program(path)
    program.tags.Go = True
    program.step()
    assert program.tags.N == 6
    (routine,) = program.routines
    assert routine.statements is not None
    first = routine.statements[0]
    assert (first.line, first.origin.line, first.comment) == (9, 9, "of the first statement")
    write_program(program, path)
    again = read_program(path)
    assert again.routines == program.routines
    assert again.declarations == program.declarations
    assert load_program(str(path)).name == "line"


def test_a_file_of_statements_alone_is_a_program(tmp_path):
    path = tmp_path / "3-axes.st"
    path.write_text("Local:1:O.Data[0].3 := S:FS;", encoding="utf-8")
    assert read_program(path).name == "3_axes"
    path.write_text("X := 1;", encoding="utf-8")
    with pytest.raises(ProgramError, match=r"3-axes\.st:1: routine Main, line 1: no tag X"):
        load_program(str(path))


def test_a_program_file_has_routines_of_both_kinds(tmp_path):
    text = """PROGRAM both

TAG A : BOOL
TAG N : DINT

ROUTINE Main
XIC(A)JSR(Sub,1,2,N);
END

ROUTINE Sub ST
// take it
SBR(N);
N := N*10; // and grow
RET(N);
END
"""
    program = parse_program(text)
    for engine in (program.compile(), program.interpret()):
        engine.tags["A"] = True
        engine.step()
        assert engine.tags["N"] == 20
    again = parse_program(program_text(program))
    assert again.routines == program.routines
    assert program.text("Sub") == "// take it\nSBR(N);\n// and grow\nN := N*10;\nRET(N);"
    with pytest.raises(LadderError, match="is not one routine of structured text"):
        write_program(program, tmp_path / "both.st")
    with pytest.raises(RungTextError, match="expected END of the routine"):
        parse_program("PROGRAM p\nROUTINE Main ST\n;")


def test_a_routine_of_structured_text_from_python():
    program = Program("p")
    program.declare("N", DINT)
    program.statements("Main", "N := 7;")
    program.step()
    assert program.tags.N == 7


@pytest.mark.parametrize(
    ("statement", "says"),
    [
        ("N := A;", "A is a BOOL, a number is needed; decide with IF"),
        ("A := N;", "N is a DINT, a bit or a condition is needed; compare it"),
        ("A := 3;", "3 is the number 3, a bit or a condition is needed"),
        ("IF N THEN END_IF;", "N is a DINT, a bit or a condition is needed"),
        ("A := A > 2;", "A>2 is an expression, a bit or a condition is needed"),
        ("T := N;", "N is a DINT, a string is needed"),
        ("N := T;", "T is a STRING, a number is needed"),
        ("D := D;", "D is an array of DINT, which is not assigned as a whole"),
        ("FOR R := 0 TO 3 DO END_FOR;", "FOR counts in a REAL; must be an integer"),
        ("CASE A OF 1: ; END_CASE;", "A is a BOOL, a number is needed"),
        ("EXIT;", "EXIT is outside of a loop"),
        ("MOV(N,N);", "MOV is not an instruction of structured text; write an assignment"),
        ("XIC(A);", "XIC is not an instruction of structured text; write a condition"),
        ("JSR(Nowhere);", "no routine NOWHERE"),
        ("Q := 1;", "no tag Q"),
    ],
)
def test_what_the_language_does_not_allow_is_refused_with_its_line(statement, says):
    program = Program("p")
    for names, kind, *dims in (("A", BOOL), ("N", DINT), ("D", DINT, 4), ("R", REAL), ("T", STRING)):
        program.declare(names, kind, *dims)
    program.statements("Main", f"A := 1;\n{statement}")
    with pytest.raises(BuildError) as refused:
        program.build()
    (problem,) = refused.value.problems
    assert says in str(problem)
    assert "routine Main, line 2" in problem.where


@pytest.mark.slow
@pytest.mark.parametrize("loop", ["WHILE 1 DO N := 1; END_WHILE;", "REPEAT N := 1; UNTIL 0 END_REPEAT;"])
def test_a_loop_without_end_is_stopped_by_the_watchdog(loop):
    program = Program("p")
    program.declare("N", DINT)
    program.statements("Main", loop)
    for engine in (program.compile(), program.interpret()):
        with pytest.raises(LadderFault, match=r"routine Main, line 1, .* loop: watchdog: more than 200,000"):
            engine.step()


def test_a_non_retentive_assignment_clears_its_target_in_prescan():
    program = Program("p")
    program.declare("N M", DINT, initial=5)
    program.declare("B", BOOL, initial=True)
    program.declare("T", STRING, initial="abc")
    text = "IF S:MINOR THEN N [:=] 1; M := 1; B [:=] 1; T [:=] 'x'; END_IF;"
    program.statements("Main", text)
    for engine in (program.compile(), program.interpret()):
        engine.step()
        assert (engine.tags.N, engine.tags.M, engine.tags.B, engine.tags.T) == (0, 5, False, "")


def test_regions_that_do_not_nest_with_the_statements_are_comments():
    text = """if Run then
    #region Fill
        Valve := 1;
    end_if;
    #endregion
    // the end
    X := 2;"""
    expected = """IF Run THEN
    // #region Fill
    Valve := 1;
END_IF;
// #endregion
// the end
X := 2;"""
    block = parse_statements(text)
    assert "\n".join(map(str, block)) == expected


def test_a_mistake_in_a_text_with_regions_has_its_place():
    with pytest.raises(RungTextError, match="line 2: column 6"):
        parse_statements("#region Fill\nX := := 1;\n#endregion")


TRUTHS = """Run := TRUE;
IF Run AND NOT FALSE THEN N := N + 1; END_IF;
Stop := FALSE OR NOT Run;"""


@pytest.mark.parametrize(
    ("tags", "expected"),
    [
        ({}, (True, 1, False)),
        ({"TRUE": False}, (False, 0, True)),  # tags of these names, as many exports have them
        ({"False": True}, (True, 0, True)),
    ],
)
def test_truth_values_are_constants_unless_tags_have_their_names(tags, expected):
    program = Program("truths")
    program.declare("Run Stop", BOOL)
    program.declare("N", DINT)
    for name, value in tags.items():
        program.declare(name, BOOL, initial=value)
    program.statements("Main", TRUTHS)
    for engine in (program.compile(), program.interpret()):
        engine.step()
        assert (engine.tags.Run, engine.tags.N, engine.tags.Stop) == expected
