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
        id: the name on the command line, in JSON and in suppressions; it never changes.
        words: a short description of the mistake.
        remedy: the action that corrects it.
        level: "error": it can't work; "warning": it is probably a mistake; "note": someone may rely on it.
        checks: functions that find the mistake in the table of facts. Collectors report additional findings.
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
        "a wired input that no configuration uses",
        "add the input to the configuration, or remove it from the machine",
        checks=(rack.wired_but_not_configured,),
    ),
    Rule(
        "search-without-switch",
        "a home search on a machine without a home switch, or with a home switch beyond a limit",
        "wire a home switch, or set the position instead",
        "error",
        (rack.search_without_switch,),
    ),
    Rule(
        "wrong-level",
        "a home, limit or stop input that is active at rest, because its contact and its level do not match",
        "change the bit of the input in configuration word 1, or `normally_closed` of its switch",
        "error",
        (rack.active_at_rest,),
    ),
    Rule(
        "unused-terminal",
        "a card's wired input or output that no program uses",
        "use it, or remove it from the rack file",
        "note",
        (rack.unused_terminals,),
    ),
    Rule(
        "no-place",
        "an input, output or axis that the rack lacks or that has two owners; a module that is not a 3601",
        "correct the slot or the terminal",
        "error",
    ),
    Rule(
        "unknown-tag",
        "a pattern of recorded tags that matches no tag",
        "correct the pattern",
        checks=(rack.unknown_tags,),
    ),
    # bits and tags
    Rule(
        "repeated-coil",
        "a bit with two coils, a timer in two rungs, or a value that is overwritten in each scan",
        "combine the conditions as branches of one rung, or use OTL and OTU",
        checks=(data.overwritten,),
    ),
    Rule(
        "coil-and-latch",
        "a bit that both a coil and OTL or OTU write",
        "use only OTL and OTU, or only OTE",
        checks=(data.coil_and_latch,),
    ),
    Rule(
        "move-over-coil",
        "a word that is written both as a whole and bit by bit",
        "write either the word or its bits",
        checks=(data.move_over_coil,),
    ),
    Rule(
        "never-written",
        "a tag or field that is read but never written",
        "write it, or set an initial value",
        checks=(data.never_written, data.never_set),
    ),
    Rule(
        "never-run",
        "a counter or timer that is read but never runs, or runs for only one scan",
        "add the instruction that runs it, or correct its condition",
    ),
    Rule(
        "never-read",
        "a tag or field that is written but never read",
        "read it, record it with `tags` in the rack file, or remove it",
        "note",
        (data.never_read,),
    ),
    Rule("unused-tag", "a tag or field that is never used", "use it, or remove it", "note"),
    Rule(
        "latch-never-cleared",
        "a bit that is set but never cleared",
        "clear it when its condition ends",
        checks=(data.latch_never_cleared,),
    ),
    Rule("input-written", "an assignment to an input", "write to another tag", "error"),
    Rule(
        "several-tasks",
        "a tag that several tasks write",
        "write it in only one task, which reads requests from the other tasks",
        checks=(data.several_tasks,),
    ),
    # conditions
    Rule(
        "shorted-branch",
        "a branch with an empty leg, which has no effect",
        "remove the branch, or fill the empty leg",
    ),
    Rule(
        "contradiction",
        "conditions that exclude each other, such as XIC A XIO A",
        "correct one of them",
        "error",
    ),
    Rule(
        "constant-condition",
        "a condition that is always true or always false",
        "correct the comparison, or remove it",
    ),
    Rule("unreachable", "a rung, statement or routine that is never reached", "call it, or remove it"),
    Rule("unreached-step", "a step of a chart that no path reaches", "add a transition to it, or remove it"),
    Rule(
        "step-without-exit",
        "a step that the program never leaves",
        "add a transition to another step",
        checks=(steps.without_way_out,),
    ),
    Rule("recursion", "a routine or function that calls itself", "use a loop"),
    Rule("preset-zero", "a timer or counter that is done at once because its preset is 0", "set a preset"),
    Rule(
        "negative-preset",
        "a timer with a negative preset, which is a major fault",
        "set a preset of 0 or more",
        "error",
    ),
    Rule(
        "no-interlock",
        "two outputs with opposite names, such as Up and Down, that inputs can switch on together",
        "add a contact of each output to the rung of the other output as an interlock",
        checks=(interlocks.opposite_outputs,),
    ),
    Rule(
        "preset-unit",
        "a time of a few scans, such as a preset of 2, which is probably in the wrong unit",
        "use milliseconds; in Python, add the unit, or use nanoseconds with scan.now_ns",
    ),
    # numbers and names
    Rule(
        "subscript",
        "a subscript that is outside its array, that a table lacks, or that nothing limits",
        "limit the subscript, or correct it",
        "error",
    ),
    Rule(
        "real-equality",
        "a calculated REAL, an elapsed time or an analog input that is compared for equality",
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
        "a number that does not fit into its target",
        "use a wider type, or round and limit the number first",
    ),
    Rule(
        "unused-parameter",
        "a parameter that is never used",
        "use it, or remove it",
        "note",
        (data.parameters_never_read,),
    ),
    Rule("shadowed-name", "a name that hides another name", "rename it"),
    Rule(
        "unknown-attribute",
        "a name, or an attribute of an object, that does not exist",
        "correct the name, or declare it",
        "error",
    ),
    Rule(
        "not-deterministic",
        "random numbers, the clock, files or threads in the logic",
        "use dwell, OnDelay or scan.now_ns, so that every run gives the same result",
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
        "FFL and FFU with different CONTROLs, or a CONTROL shared by unrelated instructions",
        "use one CONTROL for both instructions of a queue, and for no other instruction",
    ),
    Rule(
        "block-order",
        "the block that owns an axis is missing or not the last block",
        "call Amci3601 once, as the last rung",
    ),
    Rule(
        "execute-never-falls",
        "a block whose Execute never turns off",
        "clear Execute when the block is done",
        checks=(motion.execute_stays,),
    ),
    Rule(
        "command-held",
        "a command bit that is never cleared, or not before the next command",
        "clear the command word after the command",
        checks=(steps.not_zeroed,),
    ),
    Rule(
        "torn-command",
        "a command that is sent together with its parameters, although an update may arrive in two parts",
        "send the parameters first: parameters_first=True, CPS, or the command bit in a later scan",
        checks=(motion.torn,),
    ),
    Rule(
        "out-of-range",
        "a value that the module refuses, such as a speed, a starting speed or a configuration",
        "correct the value",
        "error",
        (motion.out_of_range, words.images_out_of_range),
    ),
    Rule(
        "refused-command",
        "a command that the module refuses, such as two command bits or data in unused words",
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
        "a blend that runs without being programmed",
        "program the blend first",
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
        "an absolute move of an axis whose position never becomes valid",
        "home the axis or set the position first",
        "error",
        (motion.without_position,),
    ),
    Rule(
        "beyond-limit",
        "an absolute move to a position beyond a limit switch",
        "correct the position, or the limit switch of the machine",
        "error",
        (motion.beyond_limits,),
    ),
    Rule(
        "move-interrupted",
        "a motion that begins before the previous motion is complete",
        "wait for the end of the previous motion",
        checks=(motion.interrupted, steps.unfinished),
    ),
    # sequences
    Rule(
        "two-sequences",
        "two sequences that write the same output or move the same axis",
        "use it in only one sequence, or protect it with a lock",
        checks=(data.several_writers, motion.two_movers),
    ),
    Rule(
        "lock-order",
        "locks in an order that can block sequences forever",
        "take the locks in the same order in all sequences",
        "error",
    ),
    Rule(
        "never-waits",
        "a loop that never ends, or a loop of a sequence without an await",
        "add an await, or change a value that the loop tests",
        "error",
    ),
    # with `--for`
    Rule(
        "drive-differs",
        "with `--for`: a word or bit of a 3601 that means something else on a networked drive",
        "see docs/replacing.md",
        "note",
    ),
    Rule("bad-call", "a command or wait that raises an exception", "correct the call", "error"),
)
"""The rules, in reporting order."""

BY_ID = {rule.id: rule for rule in RULES}
