"""The parts of the project whose tests are measured: their files, and the tests that are tried on them.

The tests of a room are those that a change in it would be expected to break, the quick ones. A mutant that
another room's tests notice still counts as survived: each room answers for itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

LAYER = "runtime/modules/amci3601"


@dataclass(frozen=True, slots=True)
class Room:
    """Some folders of the project and their tests.

    Attributes:
        folders: whose Python files get mutants, from the project's root.
        tests: files, folders and glob patterns of tests.
        names: the only files of the folders that get any, without .py; empty = all of them.
        without: beginnings of paths that get none.
        sources: files that decide what the room does, as glob patterns: a change voids verdicts.
    """

    folders: tuple[str, ...]
    tests: tuple[str, ...]
    names: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    sources: tuple[str, ...] = ("io_images/**/*.py", "runtime/**/*.py")

    def files(self, root: Path) -> dict[str, str]:
        """Return the files that get mutants, by name; paths are from the root."""
        paths: dict[str, str] = {}
        for folder in self.folders:
            for path in sorted((root / folder).rglob("*.py")):
                name = path.relative_to(root / folder).with_suffix("").as_posix()
                there = path.relative_to(root).as_posix()
                if (not self.names or name in self.names) and not there.startswith(self.without):
                    paths[name if len(self.folders) == 1 else there.removesuffix(".py")] = there
        return paths


COMMAND_LAYER = (
    "command_layer",
    "commands",
    "configuring",
    "refusals",
    "latches",
    "operations/profile_move",
    "operations/manual_move",
    "operations/registration_move",
    "operations/encoder_move",
    "operations/blending",
    "operations/homing",
    "operations/axis_homing",
    "operations/follower",
    "operation",
    "command_words",
    "state",
    "inputs",
    "blend_session",
    "report",
)

PROGRAMS = ("io_images/**/*.py", "ladder/**/*.py", "ladder/**/*.rung", "rockwell/**/*.py", "runtime/**/*.py")
EVERYTHING = (*PROGRAMS, "scanrack/**/*.py", "traces/**/*.py")

ROOMS: dict[str, Room] = {
    "amci3601": Room(
        (LAYER,),
        (
            "tests/manual",
            "tests/properties/test_module_in_pieces.py",
            "tests/properties/test_against_oracle.py",
            "tests/unit/adapters/test_adapter_pcl601.py",
            "tests/unit/adapters/test_adapter_pcl601_options.py",
            "tests/unit/adapters/test_adapter_pmc006.py",
            "tests/unit/adapters/test_adapter_refusals.py",
            "tests/unit/modules/test_module_latches.py",
            "tests/unit/modules/test_module_options.py",
        ),
        names=COMMAND_LAYER,
    ),
    "pcl601": Room(
        ("runtime/controllers/pcl601",),
        (
            "tests/manual/test_pcl601_*.py",
            "tests/properties/test_pcl601_*.py",
            "tests/unit/controllers/test_pcl*.py",
            "tests/unit/line/test_client_pcl601.py",
        ),
    ),
    "pmc006": Room(
        ("runtime/controllers/pmc006",),
        (
            "tests/manual/test_pmc006_*.py",
            "tests/properties/test_pmc006.py",
            "tests/unit/pages/test_pmc006_doc.py",
            "tests/unit/line/test_client_pmc006.py",
        ),
    ),
    "adapters": Room(
        ("runtime/modules/adapters",),
        (
            "tests/manual/test_adapter_worked_bytes.py",
            "tests/manual/test_one_list_three_hardwares.py",
            "tests/properties/test_adapter_late_replies.py",
            "tests/unit/adapters",
        ),
    ),
    "line": Room(
        ("runtime/line",),
        (
            "tests/manual/test_pcl601_frames.py",
            "tests/manual/test_pcl601_network.py",
            "tests/manual/test_pmc006_frames.py",
            "tests/properties/test_pcl601_in_pieces.py",
            "tests/properties/test_wire_strategies.py",
            "tests/unit/adapters/test_adapter_driver.py",
            "tests/unit/line",
        ),
    ),
    "ladder": Room(
        ("ladder",),
        (
            "tests/manual/test_ladder_*.py",
            "tests/properties/test_ladder_*.py",
            "tests/unit/ladder",
        ),
        sources=PROGRAMS,
    ),
    "instructions": Room(
        ("ladder/instructions",),
        (
            "tests/manual/test_ladder_semantics_*.py",
            "tests/manual/test_slc_*.py",
            "tests/manual/test_structured_text_regulation.py",
            "tests/properties/test_ladder_lockstep.py",
            "tests/properties/test_timers_against_rungs.py",
            "tests/unit/ladder/*.py",
        ),
        sources=PROGRAMS,
    ),
    "st": Room(
        ("ladder/st",),
        (
            "tests/properties/test_ladder_structured_text.py",
            "tests/unit/ladder/test_structured_text*.py",
            "tests/unit/ladder/test_messages_in_text.py",
            "tests/unit/rockwell",
        ),
        sources=PROGRAMS,
    ),
    "l5x": Room(
        ("rockwell/l5x",),
        (
            "tests/properties/test_l5x_mutated.py",
            "tests/unit/rockwell",
            "tests/unit/ladder/test_ladder_module_*.py",
            "tests/unit/ladder/test_ladder_text_of_exports.py",
        ),
        sources=PROGRAMS,
    ),
    "diff": Room(
        ("rockwell/diff",),
        ("tests/properties/test_diff_of_edits.py", "tests/unit/rockwell/test_diff.py"),
        sources=PROGRAMS,
    ),
    "slc": Room(
        ("rockwell/slc", "ladder/instructions/slc"),
        (
            "tests/manual/test_slc_*.py",
            "tests/properties/test_slc_mutated.py",
            "tests/unit/rockwell/test_slc_import.py",
        ),
        sources=PROGRAMS,
    ),
    "debug": Room(
        ("ladder/debug",),
        (
            "tests/properties/test_ladder_debugger_agrees.py",
            "tests/properties/test_ladder_observed_lockstep.py",
            "tests/unit/jobs/test_bench*.py",
            "tests/unit/ladder/test_ladder_*.py",
            "tests/unit/ladder/test_structured_text_debugged.py",
        ),
        sources=PROGRAMS,
    ),
    "sequences": Room(
        ("ladder/python/sequences",),
        (
            "tests/properties/test_waits_against_arithmetic.py",
            "tests/unit/jobs/test_edit_sequences.py",
            "tests/unit/jobs/test_sequences_seen.py",
            "tests/unit/python",
        ),
        sources=PROGRAMS,
    ),
    "axis3601": Room(
        ("ladder/python/axis3601",),
        ("tests/properties/test_axis_against_rungs.py", "tests/unit/python"),
        sources=PROGRAMS,
    ),
    "cards": Room(
        ("runtime/modules/cards",),
        (
            "tests/manual/test_analog_cards.py",
            "tests/unit/fuzz/test_fuzz_cards.py",
            "tests/unit/modules",
            "tests/unit/traces/test_card_plot.py",
        ),
    ),
    "config": Room(
        ("runtime/config",),
        ("tests/unit/config", "tests/unit/machine", "tests/unit/modules"),
    ),
    "live": Room(
        ("runtime/live",),
        ("tests/unit/jobs/test_bench_edits.py", "tests/unit/live"),
        sources=PROGRAMS,
    ),
    "watch": Room(
        ("scanrack/watch",),
        ("tests/unit/live", "tests/unit/share"),
        sources=EVERYTHING,
    ),
    "check": Room(
        ("scanrack/jobs/check",),
        ("tests/unit/jobs/test_check*.py", "tests/unit/pages/test_panel_doc.py"),
        sources=PROGRAMS,
    ),
    "why": Room(
        ("scanrack/jobs/why",),
        (
            "tests/unit/jobs/test_why_*.py",
            "tests/unit/jobs/test_sequences_seen.py",
            "tests/unit/pages/test_panel_doc.py",
        ),
        sources=EVERYTHING,
    ),
    "bench": Room(
        ("scanrack/jobs/bench",),
        (
            "tests/unit/jobs/test_bench*.py",
            "tests/unit/jobs/test_steps.py",
            "tests/unit/python/test_examples_*.py",
        ),
        sources=PROGRAMS,
    ),
    "fuzz": Room(
        ("scanrack/jobs/fuzz",),
        ("tests/unit/fuzz",),
        sources=EVERYTHING,
    ),
    "trust": Room(
        ("scanrack/jobs/trust",),
        ("tests/unit/traces/test_forged_traces.py", "tests/unit/live/test_watch_security.py"),
        names=("trust",),
        sources=EVERYTHING,
    ),
    "traces": Room(
        ("traces",),
        (
            "tests/peers/test_export_read_back.py",
            "tests/peers/test_trace_stock_reader.py",
            "tests/properties/test_compare_in_blocks.py",
            "tests/properties/test_compare_mutated.py",
            "tests/properties/test_query_columns.py",
            "tests/properties/test_trace_fuzz.py",
            "tests/unit/commands/test_cli_bad_traces.py",
            "tests/unit/commands/test_cli_compare.py",
            "tests/unit/commands/test_cli_query_plot_export.py",
            "tests/unit/commands/test_cli_replay.py",
            "tests/unit/pages/test_query_doc.py",
            "tests/unit/traces",
            "tests/unit/pages/test_traces_doc.py",
        ),
        sources=("io_images/**/*.py", "runtime/**/*.py", "traces/**/*.py"),
    ),
    "io_images": Room(
        ("io_images",),
        (
            "tests/manual/test_*_words.py",
            "tests/manual/test_pcl601_frames.py",
            "tests/manual/test_pcl601_modbus.py",
            "tests/manual/test_pcl601_sample_programs.py",
            "tests/manual/test_pmc006_frames.py",
            "tests/manual/test_pmc006_instructions.py",
            "tests/manual/test_pmc006_programs.py",
            "tests/manual/test_thousands_examples.py",
            "tests/properties/test_*_both_ways.py",
            "tests/properties/test_image_*.py",
            "tests/properties/test_thousands_pairs.py",
            "tests/properties/test_wire_strategies.py",
            "tests/unit/controllers/test_pclt_text.py",
            "tests/unit/io_images/test_rules_table.py",
            "tests/unit/pages/test_strategies_doc.py",
        ),
        without=("io_images/amci3601/rules/",),  # the room amci3601 has them
    ),
    "prove": Room(
        ("ladder/prove", "scanrack/jobs/prove"),
        (
            "tests/properties/test_proofs_hold.py",
            "tests/properties/test_relation_lockstep.py",
            "tests/unit/commands/test_cli_prove.py",
            "tests/unit/prove",
        ),
        sources=EVERYTHING,
    ),
    "outside": Room(
        ("runtime/tag_servers",),
        (
            "tests/properties/test_tags_of_bytes.py",
            "tests/unit/jobs/test_tags_from_outside.py",
            "tests/unit/live/test_tag_*.py",
            "tests/unit/tag_servers",
        ),
        sources=PROGRAMS,
    ),
    "loop": Room(
        ("runtime/loop",),
        ("tests/unit/jobs/test_tag_bounds.py", "tests/unit/loop"),
    ),
    "machine": Room(
        ("runtime/machine", "runtime/kinematics"),
        (
            "tests/properties/test_kinematics*.py",
            "tests/properties/test_look_ahead.py",
            "tests/properties/test_machine*.py",
            "tests/unit/machine",
        ),
    ),
    "modules": Room(
        ("runtime/modules",),
        ("tests/properties/test_against_oracle.py", "tests/unit/modules"),
        without=(LAYER, "runtime/modules/adapters/", "runtime/modules/cards/"),  # rooms of their own
    ),
    "jobs": Room(
        (
            "scanrack/jobs/captures",
            "scanrack/jobs/conform",
            "scanrack/jobs/drive",
            "scanrack/jobs/first",
            "scanrack/jobs/imports",
            "scanrack/jobs/load",
            "scanrack/jobs/record",
            "scanrack/jobs/replay",
            "scanrack/jobs/run",
            "scanrack/jobs/serve",
            "scanrack/jobs/start",
        ),
        (
            "tests/unit/commands/test_cli_re*.py",
            "tests/unit/commands/test_cli_run.py",
            "tests/unit/commands/test_cli_serve.py",
            "tests/unit/commands/test_conform_command.py",
            "tests/unit/commands/test_drive*.py",
            "tests/unit/commands/test_start.py",
            "tests/unit/jobs",
        ),
        sources=EVERYTHING,
    ),
    "commands": Room(
        ("scanrack/commands", "scanrack/terminal"),
        ("tests/unit/commands", "tests/unit/scanrack"),
        sources=EVERYTHING,
    ),
    "lsp": Room(("scanrack/lsp",), ("tests/unit/lsp",), sources=EVERYTHING),
    "testing": Room(
        ("scanrack",),
        ("tests/unit/testing",),
        without=(
            "scanrack/__",
            "scanrack/commands/",
            "scanrack/jobs/",
            "scanrack/lsp/",
            "scanrack/terminal/",
            "scanrack/watch/",
        ),
        sources=EVERYTHING,
    ),
}
"""The rooms by name; the first is the one that is measured without --room."""
