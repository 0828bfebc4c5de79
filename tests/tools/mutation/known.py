"""Mutants that behave as the original, each with its reason; and those that CI tries."""

from __future__ import annotations

from typing import NamedTuple

from .operators import Mutant
from .rooms import LAYER


class Equivalent(NamedTuple):
    """A mutant that behaves like the original.

    Attributes:
        path: the file, from the project's root.
        scope: function or table.
        old: the text that is replaced.
        new: the text in its place.
        reason: why no test can notice it.
    """

    path: str
    scope: str
    old: str
    new: str
    reason: str


BEFORE_CONFIGURATION = "commands count after a configuration only, and its words take the place of these"
NO_COUNTS = "an encoder move by no counts is complete at once, without a direction"
IN_PLACE_OF_UNKNOWN = "any legal value may stand for an argument that the text does not tell"
A_DIRECTION = "a motion's direction is +1 or -1"

EQUIVALENT = (
    Equivalent(f"{LAYER}/state.py", "", "0", "1", BEFORE_CONFIGURATION),
    Equivalent(f"{LAYER}/state.py", "", "8", "9", BEFORE_CONFIGURATION),
    Equivalent(
        f"{LAYER}/command_layer.py",
        "CommandLayer.next_wake_ns",
        "is_waiting and self.state.running",
        "is_waiting",
        "a tick more changes nothing",
    ),
    Equivalent(
        f"{LAYER}/command_layer.py",
        "CommandLayer.next_wake_ns",
        "self.state.command.configures and not self.state.in_configuration_mode",
        "(self.state.command.configures or not self.state.in_configuration_mode)",
        "a tick more changes nothing",
    ),
    Equivalent(
        f"{LAYER}/command_layer.py", "CommandLayer.next_wake_ns", "1", "2", "ticks are 250,000 ns apart"
    ),
    Equivalent(
        f"{LAYER}/inputs.py",
        "InputWatch._leaves_home",
        "axis.direction > 0",
        "axis.direction >= 0",
        A_DIRECTION,
    ),
    Equivalent(f"{LAYER}/commands.py", "_start_encoder_move", "counts >= 0", "counts > 0", NO_COUNTS),
    Equivalent(f"{LAYER}/commands.py", "_start_encoder_move", "0", "1", NO_COUNTS),
    Equivalent(
        f"{LAYER}/commands.py",
        "resume",
        "not refuse_if_broken(host, now_ns, command) and held_move is not None",
        "not refuse_if_broken(host, now_ns, command)",
        "without a held move it is refused",
    ),
    Equivalent(
        f"{LAYER}/refusals.py",
        "manual_parameters_illegal",
        "speed is None or target_illegal(host, command)",
        "target_illegal(host, command)",
        "None is in no range",
    ),
    Equivalent(
        f"{LAYER}/operations/registration_move.py",
        "RegistrationMove._change_speed",
        "8",
        "9",
        "there are eight words",
    ),
    Equivalent(
        "runtime/controllers/pcl601/fly.py",
        "OutputOnFly.settle",
        "True",
        "False",
        "the axis then looks at the rest in the same pass, not in the next one of the same instant",
    ),
    Equivalent(
        "runtime/controllers/pcl601/controller.py",
        "Pcl601Controller.aim_at",
        "distance > 0",
        "distance >= 0",
        "a distance of 0 is left out one line above",
    ),
    Equivalent(
        "ladder/compiler/value_writer.py",
        "ValueWriter.converted",
        "width or LINT.bits",
        "LINT.bits",
        "no tag is wider than the computation whose result it takes",
    ),
    Equivalent(
        "runtime/machine/contacts.py",
        "Contact.edge_after",
        "direction > 0",
        "direction >= 0",
        A_DIRECTION,
    ),
    Equivalent("traces/export/vcd.py", "_written_values", "True", "False", "both have a row for each value"),
    Equivalent(
        "traces/read/packed.py", "PackedScans.__init__", "1", "2", "how well it compresses shows nowhere"
    ),
    Equivalent("scanrack/jobs/check/python/reader.py", "", "0", "1", IN_PLACE_OF_UNKNOWN),
    Equivalent(
        "scanrack/jobs/trust/trust.py", "fingerprints", "0", "1", "without files no line has the width"
    ),
    Equivalent(f"{LAYER}/operation.py", "limit_of", "direction > 0", "direction >= 0", A_DIRECTION),
)


def reason_for(mutant: Mutant) -> str | None:
    """Return why a mutant is equivalent, or None if it is not known to be."""
    for known in EQUIVALENT:
        if (mutant.path, mutant.scope, mutant.old, mutant.new) == known[:4]:
            return known.reason
    return None


class Smoke(NamedTuple):
    """A mutant that SMOKE_TESTS have to kill: path, scope, old and new text."""

    path: str
    scope: str
    old: str
    new: str


SMOKE_TESTS = "tests/manual/test_moves_in_time.py"

SMOKE: tuple[Smoke, ...] = (
    Smoke("runtime/modules/amci3601/operations/profile_move.py", "ProfileMove.on_end", "HOLD_STATE", "0"),
    Smoke("runtime/modules/amci3601/command_layer.py", "CommandLayer.cut", "self.axis.cut(now_ns)", "pass"),
    Smoke(
        "runtime/modules/amci3601/operations/manual_move.py",
        "ManualMove._stop",
        "not self.stopping",
        "self.stopping",
    ),
)
