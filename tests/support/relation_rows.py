"""Rungs for every instruction: what the scan on terms computes, and what it leaves open.

A text is a group of rungs, one a line. `HAVOCKED` has rungs, too: a row that becomes known changes its place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from random import Random
from typing import Any

from relation_programs import HEAD, TAGS
from scanrack.ladder.files import parse_program
from slc_bench import imported

Texts = Mapping[str, tuple[str, ...]]

MORE_TAGS = (
    *("K2 : CONTROL", "Sorts : INT[8]", "Rs : REAL[5]", "FO : FBD_ONESHOT", "Sc : SCALE", "Hl : HL_LIMIT"),
    *("Se : SELECT", "Sn : SELECTABLE_NEGATE", "Mx : MAXIMUM_CAPTURE", "Mn : MINIMUM_CAPTURE"),
    *("Ds : DOMINANT_SET", "Dr : DOMINANT_RESET", "Fd : FLIP_FLOP_D", "Fj : FLIP_FLOP_JK"),
    *(
        "Ud : UP_DOWN_ACCUM",
        "Rl : RATE_LIMITER",
        "Su : SELECTED_SUMMER",
        "Bt : FBD_BIT_FIELD_DISTRIBUTE",
        "Pd : PID",
        "Al : ALARM_DIGITAL",
        "Aa : ALARM_ANALOG",
    ),
)
ROUTINES = """ROUTINE Sub
SBR(D1)NOP();
XIC(B6)RET(D0);
ADD(D0,1,D0);
RET(I1);
END
ROUTINE Pass
XIC(B5)BRK();
ADD(D2,Turn,D2);
END
"""


def _each(names: str, *texts: str) -> dict[str, tuple[str, ...]]:
    """Return texts for each name; `@` stands for the name."""
    return {name: tuple(text.replace("@", name) for text in texts) for name in names.split()}


_TWO = ("D0,D1,D2", "S0,U1,I2", "L0,7,L1", "D0,U0,S2", "R0,D1,R2", "R0,0.1,F1", "F0,F1,D2", "R1,R2,L2")
_ONE = ("D0,D1", "L0,L1", "S0,U1", "R0,R1", "F0,F1", "R0,D2", "U0,F2", "L2,S1", "Arr[Ix],Ps[Ix].Size")
_PAIR = ("D0,D1", "S0,U1", "L0,100", "R0,D1", "R0,0.1", "F0,R1", "U0,-1", "Arr[Ix],7", "W,V", "W,'ab'")
_LOGIC = ("D0,D1,D2", "S0,U1,I2", "L0,255,L1", "U0,-1,S2")
_ENDS = ("Arr[0],Arr[1],3", "Arr[Ix],Row[0],2", "Ps[0],Ps[1],2", "Ps[Ix],P,1", "P,Raw[0],9", "Raw[2],P,1")
_MORE_ENDS = ("R0,D0,1", "Arr[0],Row[Ix],D2", "Arr[1],Ps[0],1", "W,V,1", "F0,L0,1", "Raw[0],W,1")

ROWS: Texts = {
    **_each("XIC XIO", "@(B1)OTE(B0);", "@(D0.[Ix])OTE(B1);", "@(Ps[Ix].On)OTE(B2);"),
    **_each("OTE OTL OTU", "XIC(B1)@(B2);", "XIC(B1)@(I0.15);", "XIC(B3)@(D1.[Ix]);", "XIC(B1)@(Bits[Ix]);"),
    **_each("ONS", "XIC(B1)@(B2)OTE(B3);", "XIC(B1)@(D0.4)OTE(B3);"),
    **_each("OSR OSF", "XIC(B1)@(B2,B3);", "XIC(B1)@(B2,Bits[Ix]);"),
    **_each(
        "TON TOF RTO", "XIC(B1)@(T0,?,?)XIC(T0.DN)OTE(B2);", "XIC(B1)@(P.Time,?,?);", "@(Ps[1].Time,?,?);"
    ),
    **_each("CTU CTD", "XIC(B1)@(C0,?,?)XIC(C0.DN)OTE(B2);", "XIC(B1)@(C1,?,?);"),
    **_each("RES", "XIC(B1)@(T0);", "XIC(B1)@(C1);", "XIC(B1)@(K);"),
    **_each("CMP", "@(D0*2>D1+I0)OTE(B0);", "@(R0<=D1 OR S0>7)OTE(B1);", "@(NOT (L0<U1) XOR F0>R1)OTE(B2);"),
    **_each("EQU NEQ GRT GEQ LES LEQ", *(f"@({each})OTE(B0);" for each in _PAIR)),
    **_each("LIM", "@(1,D0,7)OTE(B0);", "@(S0,D1,U2)OTE(B1);", "@(R0,F1,L2)OTE(B2);", "@(7,I0,-1)OTE(B3);"),
    **_each("MEQ", "@(D0,255,D1)OTE(B0);", "@(S0,U1,L2)OTE(B1);"),
    **_each("ISNAN ISINF", "@(R0)OTE(B0);", "@(F1)OTE(B1);"),
    **_each("ADD SUB MUL DIV MOD", *(f"@({each});" for each in (*_TWO, "Arr[Ix],-1,Ps[Ix].Size"))),
    **_each("NEG ABS TRN MOV DEG RAD", *(f"@({each});" for each in _ONE)),
    **_each("SQR", "@(R0,R1);", "@(F0,F1);", "@(R0,D1);"),
    **_each(
        "CPT",
        "@(D0,D1+D2*3);",
        "@(I0,R0*0.75-D1/U0);",
        "@(F0,-F1+TRN(R0));",
        "@(D1,ABS(S0) MOD 7);",
        "@(D2,NOT D0 XOR D1);",
    ),
    **_each("MVM AND OR XOR", *(f"@({each});" for each in _LOGIC)),
    **_each("NOT", "@(D0,D1);", "@(S0,U1);", "@(U0,L1);"),
    **_each("BTD", "@(D0,3,D1,5,9);", "@(S0,0,I1,8,8);", "@(D0,28,D1,30,2);"),
    **_each("CLR", "@(D0);", "@(R0);", "@(Ps[Ix].Size);"),
    **_each("SWPB", "@(D0,REVERSE,D1);", "@(D0,WORD,D2);", "@(D0,HIGH/LOW,D1);", "@(I0,REVERSE,D2);"),
    **_each("COP CPS", *(f"@({each});" for each in (*_ENDS, *_MORE_ENDS))),
    **_each(
        "FLL", "@(D0,Arr[1],3);", "@(R0,Row[Ix],2);", "@(D0,Arr[0],Ix);", "@(1,Ps[1],2);", "@(L0,Rs[0],9);"
    ),
    **_each(
        "FAL",
        "XIC(B1)@(K,?,?,ALL,Row[K.POS],Arr[K.POS]+1);",
        "XIC(B1)@(K,?,?,INC,Row[K.POS],D0*2);",
        "XIC(B1)@(K,?,?,2,Arr[K.POS],Row[K.POS]/D1);",
    ),
    **_each("FSC", "XIC(B1)@(K,?,?,ALL,Arr[K.POS]>2)OTE(B2);", "XIC(B1)@(K,?,?,INC,Arr[K.POS]=Row[K.POS]);"),
    **_each("SIZE", "@(Grid[0,0],1,D0);", "@(Grid[0,0],0,S0);"),
    **_each("BSL BSR", "XIC(B1)@(Arr[0],K,B2,?);", "XIC(B1)@(Arr[0],K,D0.3,?);"),
    **_each("FFL LFL", "XIC(B1)@(D0,Arr[0],K,?,?);", "XIC(B1)@(7,Sorts[2],K,?,?);"),
    **_each("FFU LFU", "XIC(B1)@(Arr[0],D0,K,?,?);", "XIC(B1)@(Sorts[2],D1,K,?,?);"),
    **_each("SRT", "XIC(B1)@(Arr[0],0,K,?,?);"),
    **_each("SQI", "@(Arr[0],255,D1,K,?,?)OTE(B1);"),
    **_each("SQO", "XIC(B1)@(Arr[0],255,D1,K,?,?);"),
    **_each("SQL", "XIC(B1)@(Arr[0],D0,K,?,?);"),
    **_each("JMP", "XIC(B1)@(On);\nADD(D0,1,D0);\nLBL(On)XIC(B2)OTE(B3);"),
    **_each("LBL", "XIC(B1)JMP(Far);\nOTL(B4);\n@(Far)XIC(B2)OTE(B3);"),
    **_each("JSR", "XIC(B1)@(Sub,1,D2,L2);", "@(Sub,1,R0,S1)OTE(B2);"),
    **_each("SBR", "JSR(Sub,1,L0,D2);"),
    **_each("RET", "JSR(Sub,1,S0,F2);"),
    **_each("TND", "XIC(B1)@();\nADD(D0,1,D0);"),
    **_each("FOR", "XIC(B1)@(Pass,Turn,0,3,1);", "@(Pass,Turn,3,-1,-2);"),
    **_each("BRK", "XIC(B1)FOR(Pass,Turn,0,5,1);"),
    **_each("MCR", "XIC(B1)@();\nXIC(B2)OTE(B3);\nTON(T0,?,?);\nOTL(B4);\n@();"),
    **_each("AFI", "@()OTE(B1);"),
    **_each("NOP", "@()XIC(B1)OTE(B2);", "@();"),
    **_each("FRD", "@(D0,D1);", "@(S0,U1);", "@(L0,L1);"),
    **_each("CONCAT", "@(W,V,W);", "@(W,'ab',V);"),
    **_each("MID DELETE", "@(W,2,D0,V);", "@(V,D0,1,V);"),
    **_each("INSERT", "@(W,'ab',D0,V);", "@(W,V,1,W);"),
    **_each("FIND", "@(W,'b',1,D2);", "@(W,'ab',D0,I1);"),
    **_each("DTOS", "@(I0,W);", "@(L0,V);", "@(U0,W);"),
    **_each("STOD", "@(W,D0);", "@(V,S1);"),
    **_each("UPPER LOWER", "@(W,V);", "@(V,V);"),
    **_each("DTR", "@(D0,255,D1)OTE(B1);"),
    **_each("UID UIE PSC", "XIC(B1)@();"),
    **_each("ASSERT", "XIC(B1)XIC(B2)@(D0>3 OR B0)OTE(B3);", "@(W<>'never');"),
}
"""Rungs of each instruction that is computed."""

BLOCKS: Texts = {
    **_each("TONR TOFR RTOR", "@(FT);"),
    **_each("CTUD", "@(FC);"),
    **_each("OSRI OSFI", "@(FO);"),
    **_each("SCL", "@(Sc);"),
    **_each("HLL", "@(Hl);"),
    **_each("SEL", "@(Se);"),
    **_each("SNEG", "@(Sn);"),
    **_each("MAXC", "@(Mx);"),
    **_each("MINC", "@(Mn);"),
    **_each("SETD", "@(Ds);"),
    **_each("RESD", "@(Dr);"),
    **_each("DFF", "@(Fd);"),
    **_each("JKFF", "@(Fj);"),
    **_each("UPDN", "@(Ud);"),
    **_each("SSUM", "@(Su);"),
    **_each("BTDT", "Bt.SourceBit := 3; D0 := D0; Bt.Length := 9; D0 := D0; Bt.DestBit := 25; @(Bt);"),
}
"""Statements of structured text of each function block that is computed."""

GUARD = "[LES(Ix,0),GRT(Ix,1)]MOV(1,Ix);"
"""A rung that keeps the computed subscripts of the others in range."""

HAVOCKED: Texts = {
    **_each("SIN COS TAN ASN ACS ATN LN LOG", "@(R0,R1);"),
    **_each("XPY ATAN2", "@(R0,R1,R2);"),
    **_each("RTOS", "@(R0,W);"),
    **_each("STOR", "@(W,R0);"),
    **_each("AVE STD", "XIC(B1)@(Arr[0],0,D0,K,?,?);"),
    **_each("FBC DDT", "XIC(B1)@(Arr[0],Row[0],Sorts[0],K,?,?,K2,?,?);"),
    **_each("TOD", "@(D0,D1);"),
    **_each("PID", "@(Pd,R0,0,R1,0,0,0);"),
    **_each("ALMD", "XIC(B1)@(Al,0,0,0,0,?,?);"),
    **_each("ALMA", "@(Aa,R0,0,0,0,?,?,?,?);"),
    **_each("GSV", "@(WallClockTime,,DateTime,Arr[0]);"),
}
"""Rungs of each instruction that may leave anything in what it writes."""

_OUT = (
    "EVENT SSV SFR SFP EOT MSG IOT HMIBC RLIM DCS CROUT ABL ACB ACL AHL ARD ARL AWA AWT PCMD PCLF PXRQ",
    "PRNP PPD PATT PDET PFL POVR SATT SDET SCMD SCLF SOVR SASI",
    "ALM D2SD D3SD DEDT DERV ESEL FGEN HPF INTG LDL2 LDLG LPF MAVE MSTD NTCH PI PIDE PMUL POSP RMPS",
    "SCRV SOC SRTP TOT",
)
OUT = frozenset(" ".join(_OUT).split())
"""What needs tasks, charts, ports, phases, messages or a history: havocked, or without effect on tags."""

DATA = (
    *("B3:0 0 0 0 0", "N7:0 3 1 -4 100 0 0 0 0 0 0", "F8:0 2.5 -2.5 0 1e9", "L9:0 70000 0 -5"),
    *("N10:0 0 0 0 0 0 0", "T4:0 0 5 0", "C5:0 0 10 0", "R6:0 0 4 0"),
)
_SLC_TWO = ("N7:0 N7:1 N7:2", "N7:0 -7 N7:3", "F8:0 N7:1 F8:2", "L9:0 N7:1 L9:1", "L9:0 L9:1 N7:4")
_SLC_ONE = ("N7:0 N7:1", "F8:0 F8:2", "L9:0 N7:3", "N7:0 F8:1")

SLC_ROWS: Texts = {
    **_each("ADD SUB MUL", *(f"@ {each}" for each in _SLC_TWO), "@ F8:0 F8:1 N7:2"),
    **_each("NEG ABS MOV", *(f"@ {each}" for each in _SLC_ONE)),
    **_each("DIV", *(f"@ {each}" for each in _SLC_TWO), "@ N7:0 0 N7:3", "@ F8:0 N7:8 F8:2"),
    **_each("DDV", "@ N7:1 N7:2"),
    **_each("CLR", "@ N7:0", "@ F8:1"),
    **_each("CPT", "@ N7:0 N7:1 + N7:2 * 3", "@ F8:0 F8:1 - N7:2"),
    **_each("SCL", "@ N7:0 12000 5 N7:2"),
    **_each("SCP", "@ N7:0 0 10 100 200 N7:2", "@ N7:0 N7:1 3 0 10 F8:2"),
    **_each("MVM AND OR XOR", "@ N7:0 00FFh N7:2", "@ N7:0 N7:1 N7:2"),
    **_each("NOT TOD FRD DCD ENC", "@ N7:0 N7:2"),
    **_each("SWP", "@ #N10:0 3"),
    **_each("COP", "@ #N7:0 #N10:0 3", "@ #T4:0 #N10:0 3"),
    **_each("FLL", "@ N7:0 #N10:0 6"),
    **_each("BSL BSR", "XIC B3/0 @ #N10:0 R6:0 N7:0/0 19"),
    **_each("FFL LFL", "XIC B3/0 @ N7:0 #N10:0 R6:0 4 0"),
    **_each("FFU LFU", "XIC B3/0 @ #N10:0 N7:1 R6:0 4 0"),
    **_each("SQO SQC", "XIC B3/0 @ #N10:0 00FFh N7:3 R6:0 2 0"),
    **_each("SQL", "XIC B3/0 @ #N10:0 N7:3 R6:0 2 0"),
    **_each("TON TOF RTO", "XIC B3/0 @ T4:0 0.01 20 0 XIC T4:0/DN OTE B3/1", "XIC B3/2 @ T4:0 1.0 2 0"),
    **_each("CTU CTD", "XIC B3/0 @ C5:0 10 0 XIC C5:0/DN OTE B3/1"),
    **_each("RES", "XIC B3/0 @ C5:0", "XIC B3/1 @ T4:0", "XIC B3/2 @ R6:0"),
    **_each("OSR", "XIC B3/0 @ B3/1 OTE B3/4", "XIC B3/0 @ B3/2 B3/3 OTE B3/4"),
    **_each("TND", "XIC B3/0 @\nADD N7:0 1 N7:0"),
    **_each("SUS", "XIC B3/0 @ 5\nOTE B3/1"),
    **_each("IIM IOM", "@ I:1.0 00FFh 1"),
    **_each("EQU NEQ LES LEQ GRT GEQ", "@ N7:0 N7:1 OTE B3/0", "@ F8:0 N7:1 OTE B3/1"),
    **_each("XIC XIO", "@ N7:[N7:1]/3 OTE B3/2", "@ B3/1 ADD #N7:0 1 N7:5"),
}
"""Rungs of the rows of an SLC that are not those of Logix."""

SLC_HAVOCKED: Texts = {
    **_each("SQR SIN COS TAN ASN ACS ATN LN LOG DEG RAD", "@ F8:0 F8:2"),
    **_each("XPY", "@ N7:0 3 N7:1"),
}


SLC_OUT = frozenset(("END", "INT", "MSG", "REF", "STD", "STE", "STS", "UID", "UIE", "UIF"))
"""Rows of an SLC without effect on tags, and MSG."""


GROUP = 9
BY_ITSELF = ("TND", "MCR")


def groups(table: Texts) -> Iterator[tuple[str, ...]]:
    """Yield names in groups; what leaves the scan stands alone."""
    names = [name for name in table if name not in BY_ITSELF]
    yield from (tuple(names[at : at + GROUP]) for at in range(0, len(names), GROUP))
    yield from ((name,) for name in BY_ITSELF if name in table)


def texts(table: Texts, names: tuple[str, ...]) -> list[str]:
    """Return the texts of some instructions."""
    return [text for name in names for text in table[name]]


def logix(*texts: str, statements: tuple[str, ...] = (), guard: bool = True) -> Any:
    """Return a program of rungs, or of statements of structured text."""
    tags = [f"TAG {each}" for each in (*TAGS, *MORE_TAGS)]
    rungs = statements or (*[GUARD] * guard, *texts)
    main = "ROUTINE Main ST" if statements else "ROUTINE Main"
    return parse_program("\n".join([HEAD + "\n".join(tags), main, *rungs, "END", ROUTINES]))


def slc(*texts: str) -> Any:
    """Return a program of an SLC that resets the overflow trap at its end."""
    rungs = [rung for text in texts for rung in text.split("\n")]
    sub = ["SBR ADD N7:0 1 N7:0", "XIC B3/5 RET", "ADD N7:0 1 N7:0"]
    found = imported(*rungs, "JSR U:3", "OTU S:5/0", data=DATA, sub=sub)
    assert not found.report.refused, list(map(str, found.report.refused))
    return found.program


def drawn_rows(seed: int) -> Any:
    """Return a program of texts of many instructions: of Logix, of function blocks, of an SLC in turn."""
    draw = Random(seed)
    if seed % 4 == 3:
        return slc(*(draw.choice(SLC_ROWS[name]) for name in draw.sample(sorted(SLC_ROWS), 8)))
    if seed % 8 == 2:
        names = draw.sample(sorted(BLOCKS), 5)
        return logix(statements=tuple(BLOCKS[name][0] for name in names))
    names = draw.sample(sorted(ROWS), 8)
    pick = [draw.choice(ROWS[name]) for name in names]
    texts = [text if draw.random() < 0.5 or "\n" in text else f"XIO(B7){text}" for text in pick]
    return logix(*texts, guard=seed % 3 > 0)
