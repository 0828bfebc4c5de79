"""Random small programs for the relation: rungs, structured text, an add-on instruction, calls, strings."""

from __future__ import annotations

from random import Random

NUMBERS = {"S": "SINT", "I": "INT", "D": "DINT", "L": "LINT", "R": "REAL", "U": "UDINT", "F": "LREAL"}
"""Types of numbers by the letter of their tags."""

HEAD = """PROGRAM drawn
ALLOW repeated coils
ALLOW repeated timers
TYPE Part (Size : INT, On : BOOL, Off : BOOL, Weight : REAL, Marks : SINT[3], Time : TIMER)
INSTRUCTION Tally
INPUT On : BOOL REQUIRED
INPUT Amount : DINT REQUIRED
OUTPUT Sum : DINT REQUIRED
OUTPUT Late : BOOL
INOUT Shared : DINT
INOUT Row : DINT[6]
LOCAL Kept : DINT
LOCAL Edge : BOOL
LOCAL Time : TIMER
ROUTINE Logic
XIC(On)ADD(Amount,Kept,Sum);
TON(Time,20,0)XIC(Time.DN)OTE(Late);
XIC(On)ONS(Edge)ADD(Kept,1,Kept);
GRT(Sum,50)MOV(Shared,Row[Kept]);
XIC(Late)OTE(EnableOut);
END
ROUTINE EnableInFalse
MOV(Amount,Kept);
END
END INSTRUCTION
"""

TAGS = [
    *(f"B{at} : BOOL" for at in range(8)),
    *(f"T{at} : TIMER" for at in range(3)),
    *(f"C{at} : COUNTER" for at in range(2)),
    *(f"{letter}{at} : {kind}" for letter, kind in NUMBERS.items() for at in range(3)),
    *(
        "Arr : DINT[6]",
        "Row : DINT[6]",
        "Bits : BOOL[32]",
        "Ix : DINT",
        "K : CONTROL",
        "P : Part",
        "Ps : Part[3]",
    ),
    *("W : STRING", "V : STRING", "M : Tally", "Ms : Tally[2]", "Turn : DINT", "Raw : SINT[24]"),
    *("FT : FBD_TIMER", "FC : FBD_COUNTER", "Grid : INT[2,3]"),
]


COPIES = """PROGRAM cop3
TAG In : DINT[8] := [10,11,12,13,14,15,16,17]
TAG S : STRING
TAG A : DINT
TAG B : DINT
TAG C : DINT
TAG Go : BOOL
TAG Na : BOOL
TAG Nc : BOOL
ROUTINE Main
XIC(Na)[ADD(A,1,A),ADD(B,1,B)];
GRT(A,5)[MOV(0,A),MOV(0,B)];
XIC(Nc)ADD(C,1,C);
GRT(C,5)MOV(0,C);
XIC(Go)[COP(In[A],S.DATA[0],3),COP(In[B],S.DATA[0],6),COP(In[C],S.DATA[0],3)];
END
"""
"""Three copies of computed elements to bytes, none of which has terms."""

SHORT = """PROGRAM short
TAG In : DINT[8] := [10,11,12,13,14,15,16,17]
TAG D : SINT[8]
TAG B : DINT
TAG Go : BOOL
TAG Nb : BOOL
ROUTINE Main
XIC(Nb)ADD(B,1,B);
GRT(B,5)MOV(0,B);
XIC(Go)[MOV(7,D[0]),COP(In[B],D[0],6)];
END
"""
"""The same with one copy, to what the same rung has just written."""

DEEPEST = 12
"""Calls of which the relation does not follow the last one."""


def nested(depth: int) -> str:
    """Return add-on instructions in one another; the innermost one sets Y where it has no power."""
    parts = ["PROGRAM nested"]
    for n in range(depth, 0, -1):
        contact = "XIC(Go)" if n == depth - 1 else ""
        body = (
            "ROUTINE Logic\nNOP();\nEND\nROUTINE EnableInFalse\nOTL(Z);\nEND"
            if n == depth
            else f"LOCAL Inner : A{n + 1}\nROUTINE Logic\n{contact}A{n + 1}(Inner,Go,Z);\nEND"
        )
        parts.append(f"INSTRUCTION A{n}\nINPUT Go : BOOL REQUIRED\nINOUT Z : BOOL\n{body}\nEND INSTRUCTION")
    tags = ["TAG Top : A1", "TAG G : BOOL", "TAG Y : BOOL", "TAG Q : BOOL"]
    rungs = ["XIC(Q)OTU(Y);", "XIC(Q)OTU(G);", "A1(Top,G,Y);"]
    return "\n".join([*parts, *tags, "ROUTINE Main", *rungs, "END", ""])


PROVED_WRONGLY = (COPIES, SHORT, nested(DEEPEST))
"""Programs of which something false was proved."""


class Drawn:
    """One program while it is drawn."""

    def __init__(self, seed: int) -> None:
        self._draw = Random(seed)
        self.numbers = [f"{letter}{at}" for letter in NUMBERS for at in range(3)]
        self.numbers += [
            "Arr[Ix]",
            "Arr[2]",
            "T0.ACC",
            "C1.ACC",
            "C0.PRE",
            "P.Size",
            "Ps[Ix].Size",
            "Grid[1,Ix]",
        ]
        self.whole = [each for each in self.numbers if each[0] not in "RF"]

    def one(self, *choices: str) -> str:
        """Return one of them."""
        return self._draw.choice(choices)

    def bit(self) -> str:
        """Return a bit."""
        draw = self._draw
        return self.one(
            f"B{draw.randrange(8)}",
            f"B{draw.randrange(8)}",
            f"T{draw.randrange(3)}.{self.one('DN', 'TT', 'EN')}",
            f"D{draw.randrange(3)}.{draw.randrange(32)}",
            f"Arr[{draw.randrange(6)}].{draw.randrange(32)}",
            f"Bits[{draw.randrange(32)}]",
            f"I0.{draw.randrange(16)}",
            f"C{draw.randrange(2)}.DN",
            *("D1.[Ix]", "Bits[Ix]", "P.On", "Ps[1].Off", "Ps[Ix].On", "M.Late"),
        )

    def number(self) -> str:
        """Return a number that is read."""
        constant = str(self._draw.choice((0, 1, -1, 7, 100, 2147483647)))
        return self.one(*self._draw.choices(self.numbers, k=3), constant, self.one("2.5", "0.1"))

    def integer(self) -> str:
        """Return an integer that is read."""
        return self.one(*self._draw.choices(self.whole, k=3), str(self._draw.choice((0, 1, -1, 255, 4096))))

    def target(self) -> str:
        """Return a number that is written."""
        return self._draw.choice(self.numbers)

    def expression(self) -> str:
        """Return an expression."""
        a, b = self._draw.choice(self.numbers), self._draw.choice(self.numbers)
        tail = self.one("+1", "*2", "-D0", " MOD 7", "")
        return self.one(f"{a}{self.one('+', '-', '*', '/')}{b}{tail}", f"ABS({a})-{b}", f"-{a}+TRN({b})")

    # --- rungs

    def condition(self, depth: int = 2) -> str:
        """Return an input instruction, or a branch of them."""
        kind = self._draw.randrange(10 if depth else 9)
        if kind < 4:
            return f"{self.one('XIC', 'XIO')}({self.bit()})"
        if kind < 6:
            name = self.one("EQU", "NEQ", "GRT", "LES", "GEQ", "LEQ")
            return f"{name}({self.number()},{self._draw.choice(self.numbers)})"
        if kind == 6:
            return self.one(
                f"LIM({self.number()},{self._draw.choice(self.numbers)},{self.number()})",
                f"MEQ({self._draw.choice(self.whole)},{self.integer()},{self.integer()})",
                f"CMP({self.expression()}>{self.number()})",
                f"{self.one('ISNAN', 'ISINF')}({self.one('R0', 'F1', 'R2')})",
                *(f"EQU(W,{self.one('V', chr(39) + 'abc' + chr(39))})", "LES(V,W)"),
            )
        if kind < 9:
            return f"ONS(B{self._draw.randrange(8)})"
        legs = [self.condition(depth - 1), self.condition(depth - 1) + self.condition(depth - 1)]
        return f"[{','.join(legs)}]"

    def output(self, depth: int = 2) -> str:
        """Return an output instruction, or a branch of them."""
        kind = self._draw.randrange(15 if depth else 14)
        if kind == 14:
            legs = [self.condition(0) + self.output(depth - 1) for _ in range(2)]
            return f"[{','.join(legs)}]"
        return getattr(self, _OUTPUTS[kind])()

    def _coil(self) -> str:
        return self.one(
            f"{self.one('OTE', 'OTL', 'OTU')}({self.bit()})",
            f"{self.one('OTE', 'OTL', 'OTU')}({self.bit()})",
            f"{self.one('OSR', 'OSF')}(B{self._draw.randrange(8)},{self.bit()})",
        )

    def _timer(self) -> str:
        timer = self.one("T0", "T1", "T2", "P.Time", "Ps[1].Time")
        return f"{self.one('TON', 'TOF', 'RTO')}({timer},?,?)"

    def _counter(self) -> str:
        return self.one(
            *(f"{self.one('CTU', 'CTD')}(C{self._draw.randrange(2)},?,?)",) * 2,
            f"RES({self.one('T', 'C')}{self._draw.randrange(2)})",
        )

    def _arithmetic(self) -> str:
        name = self.one("ADD", "SUB", "MUL", "DIV", "MOD")
        return f"{name}({self.number()},{self.number()},{self.target()})"

    def _move(self) -> str:
        return f"MOV({self.number()},{self.target()})"

    def _computed(self) -> str:
        return f"CPT({self.target()},{self.expression()})"

    def _bits(self) -> str:
        into, a, b = self._draw.choice(self.whole), self.integer(), self.integer()
        return self.one(
            *(f"AND({a},{b},{into})", f"OR({a},{b},{into})", f"XOR({a},{b},{into})", f"MVM({a},{b},{into})"),
            *(f"NOT({self._draw.choice(self.whole)},{into})", f"CLR({self.target()})", "BTD(D0,3,D1,5,9)"),
            *("SWPB(D0,REVERSE,D1)", "SWPB(D0,WORD,D2)", "SWPB(I0,REVERSE,D2)"),
        )

    def _single(self) -> str:
        name = self.one("NEG", "ABS", "TRN", "DEG", "RAD")
        return f"{name}({self.number()},{self.target()})"

    def _file(self) -> str:
        return self.one(
            *("COP(Arr[0],Arr[3],2)", "COP(Arr[Ix],Row[0],2)", "COP(Ps[0],Ps[1],2)", "COP(Ps[Ix],P,1)"),
            *(
                "COP(P,Raw[0],9)",
                "COP(Raw[2],P,1)",
                "COP(Arr[1],Ps[0],1)",
                "COP(R0,D0,1)",
                "CPS(Arr[0],Row[Ix],D2)",
            ),
            *("FLL(D0,Arr[1],3)", "FLL(R0,Row[Ix],2)", "FLL(D0,Arr[0],Ix)", "FLL(1,Ps[1],2)"),
            *(
                "SIZE(Grid[0,0],1,D0)",
                "SQO(Arr[0],255,D1,K,3,?)",
                "SQL(Arr[0],D0,K,?,?)",
                "FFL(D0,Arr[0],K,?,?)",
            ),
            *("FAL(K,?,?,ALL,Row[K.POS],Arr[K.POS]+1)", "BSL(Arr[0],K,B1,?)", "FFU(Arr[0],D0,K,?,?)"),
        )

    def _string(self) -> str:
        return self.one(
            *(
                "CONCAT(W,V,W)",
                "MID(W,2,D0,V)",
                "DELETE(V,D1,1,W)",
                "INSERT(W,'ab',D0,V)",
                "FIND(W,'b',1,D2)",
            ),
            *("DTOS(I0,W)", "STOD(W,D0)", "UPPER(W,V)", "LOWER(V,W)", "MOV(3,W.LEN)", "MOV(I1,V.LEN)"),
        )

    def _call(self) -> str:
        return self.one(
            *(
                "JSR(Sub,1,D2,L2)",
                "JSR(Sub,1,R0,F1)",
                "JSR(Text,0)",
                "FOR(Pass,Turn,0,3,1)",
                "FOR(Pass,Turn,S0,I0,2)",
            ),
            f"Tally(M,{self.bit()},{self.integer()},{self.target()},Arr[1],Row)",
            f"Tally(Ms[Ix],{self.bit()},{self.integer()},D2,D1,Arr)",
        )

    def _control(self) -> str:
        return self.one("MCR()", f"OTE({self.bit()})")

    def rung(self, *, last: str = "") -> str:
        """Return a rung."""
        before = "".join(self.condition() for _ in range(self._draw.randint(0, 2)))
        return f"{before}{last or self.output()};"

    # --- structured text

    def statement(self, depth: int = 2) -> str:
        """Return a statement."""
        kind = self._draw.randrange(10 if depth else 5)
        if kind < 2:
            return f"{self.target()} := {self.expression()};"
        if kind < 4:
            return f"{self.bit()} := {self.truth()};"
        if kind == 4:
            return self.one(
                "TONR(FT);", "FT.TimerEnable := B1;", "CTUD(FC);", "FC.CUEnable := B2;", "W := V;"
            )
        inner = self.statements(depth - 1)
        if kind < 7:
            other = f"ELSIF {self.truth()} THEN\n{self.statements(depth - 1)}\nELSE\nB6 := 0;"
            return f"IF {self.truth()} THEN\n{inner}\n{other}\nEND_IF;"
        if kind == 7:
            choices = f"1:\n{inner}\n2,5..9:\nD0 := D0 + 1;\nELSE\nB3 := 1;"
            return f"CASE {self._draw.choice(self.whole)} OF\n{choices}\nEND_CASE;"
        if kind == 8:
            end = self.one("3", "2", "2", "S1") if depth == 2 else "2"
            head = f"FOR Turn := {self.one('0', '1')} TO {end} DO"
            leaves = f"IF B{self._draw.randrange(8)} THEN EXIT; END_IF;"
            return f"{head}\n{leaves}\n{inner}\nEND_FOR;"
        return f"REPEAT\nD1 := D1 + 1;\n{inner}\nUNTIL D1 > 3 OR B4 END_REPEAT;"

    def truth(self) -> str:
        """Return a condition of structured text."""
        return self.one(
            self.bit(),
            f"NOT {self.bit()}",
            f"{self.bit()} {self.one('AND', 'OR', 'XOR')} {self.bit()}",
            f"{self.number()} {self.one('<', '<=', '=', '<>', '>')} {self._draw.choice(self.numbers)}",
        )

    def statements(self, depth: int) -> str:
        """Return one to three statements."""
        return "\n".join(self.statement(depth) for _ in range(self._draw.randint(1, 2)))

    # --- the program

    def text(self) -> str:
        """Return the program."""
        draw = self._draw
        main = [self.rung() for _ in range(draw.randint(3, 8))]
        if draw.random() < 0.3:
            main.insert(1, self.rung(last="JMP(Skip)"))
            main.append(f"LBL(Skip){self.output()};")
        if draw.random() < 0.2:
            main.insert(2, self.rung(last="MCR()"))
        if draw.random() < 0.5:
            main.append("JSR(Text,0);")
        flags = ["XIC(S:V)OTL(B0);", "XIC(S:Z)OTE(B7);"] if draw.random() < 0.3 else []
        sub = ["SBR(D1)NOP();", self.rung(), self.rung(last="RET(D0)"), self.rung(), "RET(I1);"]
        parts = [
            HEAD + "\n".join(f"TAG {each}" for each in TAGS),
            *("ROUTINE Main", *main, *flags, "END", "ROUTINE Sub", *sub, "END"),
            *("ROUTINE Pass", self.rung(), "XIC(B5)BRK();", "ADD(D2,Turn,D2);", "END"),
            *("ROUTINE Text ST", *(self.statement() for _ in range(draw.randint(1, 4))), "END"),
        ]
        return "\n".join(parts) + "\n"


_OUTPUTS = (
    *("_coil", "_coil", "_coil", "_timer", "_counter", "_arithmetic", "_arithmetic", "_move", "_computed"),
    *("_bits", "_single", "_file", "_string", "_call"),
)


def drawn(seed: int) -> str:
    """Return the program of a seed."""
    return Drawn(seed).text()
