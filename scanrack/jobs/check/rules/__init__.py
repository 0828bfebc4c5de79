"""The rules of `scanrack check`, one row each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from ..facts import Violation
from ..subject import Subject
from . import blends, data, interlocks, motion, rack, steps, words

Check = Callable[[Subject], Iterator[Violation]]


class Rule(NamedTuple):
    """A rule.

    Attributes:
        id: its name on the command line, in JSON and in suppressions; it never changes.
        words: what it finds, in a few words.
        remedy: what to do.
        level: "error": it can't work; "warning": it is probably a mistake; "note": someone may rely on it.
        checks: find it in the table of facts, in addition to the remarks of the collectors.
    """

    id: str
    words: str
    remedy: str
    level: str = "warning"
    checks: tuple[Check, ...] = ()


RULES = (
    # the files
    Rule("refused", "a program or rack file that can't be loaded", "correct the line", "error"),
    # the rack
    Rule(
        "not-configured",
        "an input is wired that no configuration uses",
        "add the input to the configuration, or take it out of the machine",
        checks=(rack.wired_but_not_configured,),
    ),
    Rule(
        "search-without-switch",
        "a home search on a machine without a home switch, or with one that lies beyond a limit",
        "wire a home switch, or set the position instead",
        "error",
        (rack.search_without_switch,),
    ),
    Rule(
        "wrong-level",
        "a home, limit or stop input that is active at rest: its contact and its level contradict each other",
        "change the bit of the input in configuration word 1, or `normally_closed` of its switch",
        "error",
        (rack.active_at_rest,),
    ),
    Rule(
        "unused-terminal",
        "a card's wired input or output that no program uses",
        "use it, or take it out of the rack file",
        "note",
        (rack.unused_terminals,),
    ),
    Rule(
        "no-place",
        "an input, output or axis that the rack lacks, or that two own; a module that is no 3601",
        "correct the slot or the terminal",
        "error",
    ),
    Rule(
        "unknown-tag",
        "a pattern of recorded tags that matches none",
        "correct the pattern",
        checks=(rack.unknown_tags,),
    ),
    # bits and tags
    Rule(
        "repeated-coil",
        "a bit with two coils, a timer with two rungs, or a value that is written over in each scan",
        "join the conditions as branches of one rung, or use OTL and OTU",
        checks=(data.overwritten,),
    ),
    Rule(
        "coil-and-latch",
        "a bit that a coil writes, and that OTL or OTU writes, too",
        "use OTL and OTU only, or OTE only",
        checks=(data.coil_and_latch,),
    ),
    Rule(
        "move-over-coil",
        "a word that is written as a whole, and bit by bit",
        "write the word, or its bits",
        checks=(data.move_over_coil,),
    ),
    Rule(
        "never-written",
        "a tag or field that is read, and that nothing writes",
        "write it, or give it an initial value",
        checks=(data.never_written, data.never_set),
    ),
    Rule(
        "never-run",
        "a counter or timer that is read, and that nothing runs, or for one scan only",
        "add the instruction that runs it, or what enables it",
    ),
    Rule(
        "never-read",
        "a tag or field that is written, and that nothing reads",
        "read it, record it with `tags` of the rack file, or take it out",
        "note",
        (data.never_read,),
    ),
    Rule("unused-tag", "a tag or field that nothing names", "use it, or take it out", "note"),
    Rule(
        "latch-never-cleared",
        "a bit that is set, and that nothing clears",
        "clear it where it is over",
        checks=(data.latch_never_cleared,),
    ),
    Rule("input-written", "an assignment to an input", "write a tag of your own", "error"),
    Rule(
        "several-tasks",
        "a tag that several tasks write",
        "write it in one task, and let it read what the others wish",
        checks=(data.several_tasks,),
    ),
    # conditions
    Rule(
        "shorted-branch",
        "a branch with an empty leg, which decides nothing",
        "take the branch out, or fill the empty leg",
    ),
    Rule(
        "contradiction",
        "conditions that exclude each other, such as XIC A XIO A",
        "correct one of them",
        "error",
    ),
    Rule(
        "constant-condition",
        "a condition that always holds, or never does",
        "correct the comparison, or take it out",
    ),
    Rule("unreachable", "a rung, a statement or a routine that is never reached", "call it, or take it out"),
    Rule(
        "unreached-step", "a step of a chart that no path leads to", "add a transition to it, or take it out"
    ),
    Rule(
        "step-without-exit",
        "a step that nothing leaves",
        "add the way on to it",
        checks=(steps.without_way_out,),
    ),
    Rule("recursion", "a routine or function that calls itself", "use a loop"),
    Rule("preset-zero", "a timer or counter that is done at once, since its preset is 0", "give it a preset"),
    Rule(
        "negative-preset",
        "a timer with a negative preset, which is a major fault",
        "give it a preset of 0 or more",
        "error",
    ),
    Rule(
        "no-interlock",
        "two outputs of opposite names, such as Up and Down, that inputs can switch on together",
        "let each one exclude the other, or add the other's contact",
        checks=(interlocks.opposite_outputs,),
    ),
    Rule(
        "preset-unit",
        "a time of a few scans, such as a preset of 2: it is meant in another unit",
        "give it in milliseconds; in Python with its unit, or in nanoseconds of scan.now_ns",
    ),
    # numbers and names
    Rule(
        "subscript",
        "a subscript that leaves its array, or that nothing limits; one that a table does not have",
        "limit the subscript, or correct it",
        "error",
    ),
    Rule(
        "real-equality",
        "a calculated REAL, a running time or an analog input that is compared for equality",
        "compare with a tolerance, or with >= or <=",
    ),
    Rule(
        "integer-zero",
        "a division of integers whose result is always 0",
        "multiply first, or divide REALs",
    ),
    Rule("division-by-zero", "a division by a constant 0", "divide by another number", "error"),
    Rule(
        "lossy-conversion",
        "a number that its target can't hold, or only a part of it",
        "use a wider type, or round and limit it before",
    ),
    Rule(
        "unused-parameter",
        "a parameter that nothing uses",
        "use it, or take it out",
        "note",
        (data.parameters_never_read,),
    ),
    Rule("shadowed-name", "a name that hides another one", "give it another name"),
    Rule(
        "unknown-attribute",
        "a name, or an attribute of an object, that does not exist",
        "correct the name, or declare it",
        "error",
    ),
    Rule(
        "not-deterministic",
        "random numbers, the clock, files or threads in the logic",
        "use dwell, OnDelay or scan.now_ns: two runs must be the same",
        "error",
    ),
    # blocks and commands
    Rule(
        "block-twice",
        "an instance of a block that is called twice in a scan",
        "give each call its own instance",
    ),
    Rule(
        "control-mixed",
        "FFL and FFU with different CONTROLs, or a CONTROL of two that do not belong together",
        "give both instructions of a queue the same CONTROL, and no other one",
    ),
    Rule(
        "block-order",
        "the block that owns an axis is not the last one, or is missing",
        "call Amci3601 once, as the last rung",
    ),
    Rule(
        "execute-never-falls",
        "a block whose Execute never falls",
        "clear Execute when the block is done",
        checks=(motion.execute_stays,),
    ),
    Rule(
        "command-held",
        "a command bit that is set and never taken back, or not before the next command",
        "zero the command word after the command",
        checks=(steps.not_zeroed,),
    ),
    Rule(
        "torn-command",
        "a command together with its parameters, where an update can be torn",
        "send the parameters first: parameters_first=True, CPS, or the command bit in a later scan",
        checks=(motion.torn,),
    ),
    Rule(
        "out-of-range",
        "a value that the module refuses: ranges, the starting speed, a configuration",
        "correct the value",
        "error",
        (motion.out_of_range, words.images_out_of_range),
    ),
    Rule(
        "refused-command",
        "a command that the module refuses: two command bits, data that it must not have, the configuration",
        "change the command, its words or the configuration",
        "error",
        (motion.refused, words.refused_images, interlocks.both_commands),
    ),
    Rule(
        "blend-profile",
        "a blend profile that the module refuses",
        "correct its segments",
        "error",
        (blends.blends,),
    ),
    Rule(
        "no-blend",
        "a blend that runs, and that nothing programs",
        "program the blend before",
        "error",
        (blends.without_blend,),
    ),
    Rule(
        "motion-unconfigured",
        "a motion before the configuration",
        "configure the axis first",
        "error",
        (motion.without_configuration,),
    ),
    Rule(
        "no-position",
        "an absolute move of an axis whose position nothing makes valid",
        "search for home or set the position first",
        "error",
        (motion.without_position,),
    ),
    Rule(
        "beyond-limit",
        "an absolute move to a place behind a limit switch",
        "correct the position, or the limit switch of the machine",
        "error",
        (motion.beyond_limits,),
    ),
    Rule(
        "move-interrupted",
        "a motion that begins before the one before it is complete",
        "wait for its end",
        checks=(motion.interrupted, steps.unfinished),
    ),
    # sequences
    Rule(
        "two-sequences",
        "two sequences that write one output or move one axis",
        "let one own it, or hold a lock",
        checks=(data.several_writers, motion.two_movers),
    ),
    Rule(
        "lock-order",
        "locks that can block each other for good",
        "take locks in one order everywhere",
        "error",
    ),
    Rule(
        "never-waits",
        "a loop of a sequence without an await, or one that never ends",
        "await something in it, or change what it tests",
        "error",
    ),
    # with `--for`
    Rule(
        "drive-differs",
        "with `--for`: a word or bit of a 3601 that means something else on a networked drive",
        "see docs/replacing.md",
        "note",
    ),
    Rule("bad-call", "a command or wait that fails when it is reached", "correct the call", "error"),
)
"""The rules, in the order in which they are reported."""

BY_ID = {rule.id: rule for rule in RULES}
