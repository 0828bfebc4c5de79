"""Texts of SLC 500 and MicroLogix programs as RSLogix 500 saves them, put together from parts."""

from collections.abc import Iterable, Mapping

HEAD = """START Bul.1766    % Bul.1766     MicroLogix 1400 Series B %

% PROCESSOR RACK CONFIGURATION INFORMATION %
% SLOT CONFIGURATION INFORMATION %
"""
CARD = "IOCARD 4625 0 8 0 0 6 0 0 0 2 0 0"


def slot(number: int, catalog: str, name: str = "", words_in: int = 0, words_out: int = 0) -> str:
    return f"SLOT {number} {catalog}   % {name} %  SCAN_IN {words_in} SCAN_OUT {words_out}  {CARD}\n"


def processor() -> str:
    """Slot 0, whose settings go over two lines."""
    first = "SLOT 0 Bul.1766    % Bul.1766     MicroLogix 1400 Series B %  SCAN_IN 8 SCAN_OUT 6  G_FILE 17\n"
    return f"{first}     526 0 0 0 0 0 0 0 0 0 0 0 0 0 0 255 255 {CARD}\n"


def ladder(number: int, *rungs: str) -> str:
    lines = [f"% Rung: {place} %\nSOR {rung} EOR \n" for place, rung in enumerate(rungs)]
    return f"\nLADDER {number}\n{''.join(lines)}"


def words(file: str, values: Iterable[object], per_line: int = 10) -> str:
    """Values of a file B, N, L or F."""
    listed = list(values)
    lines = [
        f"% {file}:{at:<2} % {' '.join(f'{each!s:>6}' for each in listed[at : at + per_line])} \n"
        for at in range(0, len(listed), per_line)
    ]
    return f"\nDATA {file}:0 \n{''.join(lines)}"


def elements(file: str, values: Iterable[tuple[str, int, int]], names: str = ".PRE   .ACC") -> str:
    """Elements of a file T, C or R: control word and two numbers each."""
    lines = [
        f"{control} {first:>6} {second:>6} % {file}:{place:<2} %\n"
        for place, (control, first, second) in enumerate(values)
    ]
    return f"\nDATA {file}:0 \n% .CTL   {names}    %\n{''.join(lines)}"


def image(name: str, *values: str) -> str:
    """The words of a slot: `O:3`."""
    return f"\nDATA {name}\n% {name}.0 % {' '.join(values)} \n"


def texts(file: str, *values: str) -> str:
    lines = [f'% {file}:{place} %\n"{each}"\n' for place, each in enumerate(values)]
    return f"\nDATA {file}:0\n{''.join(lines)}"


FUNCTION_FILES = """
DATA HSC0:0
% HSC0:0  %
     0      0 0X0002 0X000F      0
            0    2147483647   -2147483648    2147483647   -2147483648
     0      0      0

DATA RTC0:0
% RTC0:0  %
     0      0      0      0      0      0      0 0X0000

DATA DLS0:0
"""


def forces(name: str, *lines: tuple[str, str]) -> str:
    """Bits that are forced: those on, and those that are not off."""
    rows = "".join(
        f"{on} {off} % FORCE {name[:2]}{int(name[2:])}.{at} %\n" for at, (on, off) in enumerate(lines)
    )
    return f"\nFORCE {name}\n% ON     OFF  %\n{rows}\n"


def export(
    *parts: str, slots: Iterable[str] = (), names: Mapping[int, str] | None = None, project: str = "LINE"
) -> str:
    """A file: head, slots, then its ladder and data files."""
    listed = "".join(f'   {number} "{name}"\n' for number, name in (names or {}).items())
    return f'{HEAD}{processor()}{"".join(slots)}\n\nPROJECT "{project}"\n{listed}{"".join(parts)}'
