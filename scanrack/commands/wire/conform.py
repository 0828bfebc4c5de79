"""`scanrack conform`: test a real 3601, operated by its controller, against the manual."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from scanrack.io_images.times import parse_time
from scanrack.jobs.conform.findings import ConformResult
from scanrack.jobs.conform.moments import Timing
from scanrack.jobs.conform.page import save_report
from scanrack.jobs.conform.paths.captured import scenes_of
from scanrack.jobs.conform.paths.counter import counter_rung
from scanrack.jobs.conform.paths.logix_path import (
    LogixPath,
    ModuleTags,
    connect,
    counter_of,
    is_real,
    product_of,
    wiring_of,
)
from scanrack.jobs.conform.plan import PlannedScene, ScenePlan, load_plan
from scanrack.jobs.conform.playing import play
from scanrack.jobs.conform.report import FORMAT, PlayedPlan, as_object, lines, load_played, next_steps
from scanrack.jobs.conform.verdicts import Judge
from scanrack.jobs.replay.resumed import configuration_words
from scanrack.terminal.as_json import JsonOption, say_json
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.grouped import grouped
from scanrack.terminal.reading import print_notes
from scanrack.terminal.shared_options import QuietOption
from scanrack.terminal.status import DONE, NO, complain
from scanrack.terminal.terminal import on_a_line, say
from scanrack.traces.files.guard import PAGE, beginning, check_output
from scanrack.traces.files.newfile import new_file

RESULT = beginning("a result of conform", f'{{"format": "{FORMAT}'.encode())
SAFETY = (
    "this controller is real, and its axis moves: disable the drive, then uncouple the motor; "
    "read the page of the docs about conform; then give --live --allow-writes"
)


class RungKind(StrEnum):
    """Formats of the file that contains the counter's rung."""

    L5X = "l5x"
    SLC = "slc"


@dataclass(frozen=True, slots=True, kw_only=True)
class ConformOptions:
    """The argument and the options of `scanrack conform`."""

    plan: Annotated[str, typer.Argument(metavar="PLAN", help="Plan: hour, quick, or a TOML file.")] = "hour"
    path: Annotated[
        str | None,
        typer.Option("--path", metavar="HOST[:PORT][,SLOT]", help="The controller.", show_default=False),
    ] = None
    source: Annotated[
        Path | None,
        typer.Option("--judge", metavar="FILE", help="Judge a result, or a trace of scanrack import."),
    ] = None
    module: Annotated[int, typer.Option("--slot", metavar="N", help="The module's slot.", min=1, max=30)] = 1
    counter: Annotated[
        str | None,
        typer.Option("--counter", metavar="TAG:MS", help="Tag that counts every MS milliseconds."),
    ] = None
    wire: Annotated[
        list[str] | None,
        typer.Option("--wire", metavar="INPUT=TAG", help="Tag that energizes an input; may be repeated."),
    ] = None
    encoder: Annotated[bool, typer.Option("--encoder", help="An encoder is wired, and is at rest.")] = False
    scene: Annotated[
        list[str] | None, typer.Option("--scene", metavar="NAME", help="Only this scene; may be repeated.")
    ] = None
    scan: Annotated[
        str | None,
        typer.Option("--max-scan-time", metavar="TIME", help="Longest scan time of the controller."),
    ] = None
    live: Annotated[
        bool, typer.Option("--live", help="A real axis may move. This is not a safety system.")
    ] = False
    control: Annotated[
        bool, typer.Option("--allow-writes", help="With --live: write the module's words.")
    ] = False
    result_file: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="File of the result, without your names.",
            show_default="conform.json; none with --judge",
        ),
    ] = None
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="Also write a one-page HTML report.")
    ] = None
    configuration: Annotated[
        str | None,
        typer.Option(
            "--configuration",
            metavar="WORDS",
            help="Configuration words when the trace begins: '843Ch 003Ch 0 500'.",
        ),
    ] = None
    rung: Annotated[
        RungKind | None,
        typer.Option("--print-counter", metavar="l5x|slc", help="Print the counter's rung for an import."),
    ] = None
    listed: Annotated[
        bool, typer.Option("--list", help="List the scenes, and the interpretations that they settle.")
    ] = False
    as_json: JsonOption = False
    quiet: QuietOption = False


def _conform_command(
    options: ConformOptions,
) -> None:
    """Test a real 3601 against its manual.

    It plays a plan of scenes through the controller that owns the module. It reports a difference only if it
    can't be explained by any instant at which the words may have taken effect. Each rule agrees with the
    manual, differs, or is open. The report names each interpretation that a scene settles.

    Examples:
        scanrack conform hour --path 192.168.1.10,0 --counter ConformScan:2 --live --allow-writes

    Exit status: 0 no difference, 1 a difference, 2 a file, option or path can't be used, 3 the result can't
    be written.
    """
    with reported_mistakes():
        if options.rung is not None:
            say(counter_rung(options.rung.value).rstrip(), whole=True)
            raise typer.Exit(DONE)
        plan = load_plan(options.plan)
        if options.listed:
            _say_list(plan)
            raise typer.Exit(DONE)
        result_file, files_in_use = _checked_outputs(options)
        around = _with_result(files_in_use, result_file)
        recorded = _recorded_scenes(options, plan)
        result = _judge(recorded, shown=not (options.quiet or options.as_json))
        result_object = as_object(recorded, result)
        name = "" if result_file is None else result_file.name
        if result_file is not None:
            with new_file(result_file, RESULT, used=files_in_use) as file:
                json.dump(result_object, file, separators=(", ", ": "))
                file.write("\n")
        if options.html is not None:
            save_report(options.html, recorded, result, around, name)
        if options.as_json or not options.quiet:
            _say_result(result_object, result, recorded, name, as_json=options.as_json)
        raise typer.Exit(NO if result.differs else DONE)


def _judge(recorded: PlayedPlan, *, shown: bool) -> ConformResult:
    """Judge each scene, and with `shown`, print its verdict."""
    judge = Judge(recorded.firmware, recorded.timing)
    for scene in recorded.scenes:
        verdict = judge.judge(scene)
        if shown:
            complain(f"{scene.name}: {verdict.verdict}")
    return judge.conclude()


def _checked_outputs(options: ConformOptions) -> tuple[Path | None, dict[Path, str]]:
    """Return the result file, or None, and the files that no output may replace.

    Raises:
        ValueError: an output can't be written, or would replace one of these files.
    """
    files_in_use = {options.source: "the file that is judged"} if options.source is not None else {}
    files_in_use |= {Path(options.plan): "the plan"} if Path(options.plan).is_file() else {}
    result_file = options.result_file or (None if options.path is None else Path("conform.json"))
    if result_file is not None:
        check_output(result_file, RESULT, files_in_use)
    if options.html is not None:
        check_output(options.html, PAGE, _with_result(files_in_use, result_file))
    return result_file, files_in_use


def _with_result(used: dict[Path, str], result_file: Path | None) -> dict[Path, str]:
    """Return the files in use, including the result file."""
    return used if result_file is None else used | {result_file: "the result"}


def _recorded_scenes(options: ConformOptions, plan: ScenePlan) -> PlayedPlan:
    """Return the played scenes of a module, or the scenes in a recording.

    Raises:
        ValueError: options exclude each other or can't be used.
    """
    tag, period_ns = counter_of(options.counter)
    tags = ModuleTags(options.module, tag, period_ns, wiring_of(options.wire or []))
    plan = replace(plan, timing=_timing(plan.timing, options.scan, period_ns))
    if (options.path is None) == (options.source is None):
        raise ValueError("give --path HOST[,SLOT] for a controller, or --judge FILE for a recording")
    if options.source is not None:
        words = configuration_words(options.configuration)
        return _recorded(options.source, options.module, plan.timing, words)
    if options.configuration is not None:
        raise ValueError("--configuration needs --judge: a plan has a configuration")
    return _play(options, plan, tags)


def _timing(timing: Timing, scan: str | None, period_ns: int) -> Timing:
    """Return the times of the path; with a counter, the scan is 0, because the windows include it."""
    counted_ns = 0 if period_ns else timing.scan_ns
    scan_ns = counted_ns if scan is None else parse_time(scan)
    return replace(timing, scan_ns=scan_ns)


def _recorded(source: Path, slot: int, timing: Timing, configuration: Sequence[int] | None) -> PlayedPlan:
    """Return the scenes of a conform result (JSON), or the scenes found in an imported trace."""
    with source.open("rb") as file:
        begin = file.read(1)
    if begin == b"{":
        if configuration is not None:
            raise ValueError("--configuration needs a trace: a result has a configuration")
        return load_played(source)
    captured = scenes_of(source, slot, timing, configuration)
    print_notes(captured)
    return PlayedPlan(captured.firmware, timing, captured.scenes, slot, date=captured.captured_at)


def _play(options: ConformOptions, plan: ScenePlan, tags: ModuleTags) -> PlayedPlan:
    """Play the chosen scenes on a controller; refuse a real controller without --live and --allow-writes."""
    path = str(options.path)
    scene_names = {scene.name for scene in plan.scenes}
    unknown = [name for name in options.scene or () if name not in scene_names]
    if unknown:
        raise ValueError(f"plan {plan.name}: no scene {unknown[0]!r}; --list prints the scenes")
    client = connect(path)
    with closing(client):
        if is_real(client) and not (options.live and options.control):
            raise ValueError(SAFETY)
        try:
            logix = LogixPath(client, tags)
            date = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
            scenes = [play(scene, logix, plan) for scene in _playable_scenes(options, plan, tags)]
        except OSError as error:
            raise ValueError(f"{path}: {error}") from error
        product = product_of(client)
    return PlayedPlan(
        plan.firmware, plan.timing, scenes, slot=tags.slot, controller=product, date=date, plan=plan.name
    )


def _playable_scenes(options: ConformOptions, plan: ScenePlan, tags: ModuleTags) -> list[PlannedScene]:
    """Return the scenes that can be played; report each scene that can't be played."""
    chosen = []
    for scene in plan.scenes:
        if options.scene and scene.name not in options.scene:
            continue
        missing = _missing(scene, tags, has_encoder=options.encoder)
        if missing and not (options.quiet or options.as_json):
            complain(f"{scene.name}: left out, {missing}")
        if not missing:
            chosen.append(scene)
    return chosen


def _missing(scene: PlannedScene, tags: ModuleTags, *, has_encoder: bool) -> str:
    """Return an unmet requirement of a scene, or "" if all are met."""
    wired = sum(bit.value for bit in tags.wiring or {})
    if any(step.inputs & ~wired for step in scene.steps) or ("inputs" in scene.needs and not wired):
        return "needs inputs that are wired to outputs (--wire)"
    return "needs an encoder (--encoder)" if "encoder" in scene.needs and not has_encoder else ""


def _say_list(plan: ScenePlan) -> None:
    for scene in plan.scenes:
        needs = f"; needs {', '.join(scene.needs)}" if scene.needs else ""
        settles = f" [{', '.join(scene.settles)}]" if scene.settles else ""
        say(on_a_line(f"{scene.name}: {scene.why}{settles}{needs}"))


def _say_result(
    result_object: dict[str, object], result: ConformResult, recorded: PlayedPlan, name: str, *, as_json: bool
) -> None:
    """Print the result as lines with the next steps, or as JSON without the images that were read."""
    if as_json:
        say_json({key: part for key, part in result_object.items() if key != "moments"})
    else:
        for line in lines(result, recorded.reads):
            say(line)
        for advice in next_steps(recorded, result, name):
            say(f"next: {advice}")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("conform")(grouped(_conform_command, options=ConformOptions))
