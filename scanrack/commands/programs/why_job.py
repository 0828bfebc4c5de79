"""Answers about the cause of a value, and about the uses of tags."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from scanrack.io_images.times import seconds
from scanrack.jobs.bench.moment import NotReachedError, Question, ScanChoice
from scanrack.jobs.bench.of_trace import why_of_trace
from scanrack.jobs.load.loading import recording_of, runs
from scanrack.ladder import LadderError
from scanrack.ladder.debug import CauseLink, Remedies, cross_reference
from scanrack.ladder.debug.crossref import Mention
from scanrack.ladder.model.resolver import AddressError
from scanrack.runtime.loop.faults import CpuFault
from scanrack.terminal.reading import print_notes
from scanrack.terminal.status import BAD_INPUT, NO, complain, reason
from scanrack.terminal.terminal import say
from scanrack.traces.read.reader import open_trace

if TYPE_CHECKING:
    from scanrack.jobs.bench import Bench
    from scanrack.jobs.why.acts import Acts

    from .why_arguments import WhyArguments


def _run(bench: Bench, moment: ScanChoice) -> None:
    """Run a bench to the scan that the question is about.

    Raises:
        ValueError: a time or a tag can't be used.
        NotReachedError: the bit did not become true.
    """
    default_time = f"{bench.spec.run_for_s or 10:f} s"
    if moment.until is not None:
        bench.run_until(moment.until, within=default_time)
    else:
        scans = moment.scans_from_power_up(bench.cpu.period_ns)
        bench.scan(scans or ScanChoice(default_time).scans_from_power_up(bench.cpu.period_ns) or 1)


def why(options: WhyArguments) -> None:
    """Explain the value of a tag by its scan, its rung or line, and the values that caused it.

    Raises:
        SystemExit: with the status of the command, unless it is 0.
    """
    file = options.file
    try:
        moment = ScanChoice(at=options.at, until=options.until)
        question = Question(options.what, moment, options.deep, options.want)
        if runs(file):
            answer = _ask_bench(file, question)
        else:
            answer = _ask_trace(Path(recording_of(file)), question, trust=options.trust)
    except NotReachedError as error:
        raise SystemExit(complain(str(error), NO)) from error
    except (LadderError, ValueError) as error:
        raise _refused(error) from error
    except OSError as error:
        raise SystemExit(complain(f"{file}: {reason(error)}", BAD_INPUT)) from error
    if options.as_json:
        from scanrack.terminal.as_json import say_json

        say_json({"what": options.what, **_as_json(answer)})
    else:
        say(f"{answer.when}\n{answer.text}")
        if answer.acts is not None:
            say(str(answer.acts))
        elif answer.remedies is not None:
            say(str(answer.remedies))


class _Answer(NamedTuple):
    """The answer to a question."""

    scan: int
    now_ns: int
    fault: str | None  # the earlier fault of the CPU, or None
    notes: Sequence[str]  # sentences about omissions
    when: str  # the scan and its time, as text
    text: str
    chain: CauseLink | None = None  # the chain of causes
    remedies: Remedies | None = None  # inputs of the program that give the requested value
    acts: Acts | None = None  # operator actions that give the requested value; None for a recording


def _as_json(answer: _Answer) -> dict[str, object]:
    """Return the answer for --json: the plain fields, then chain, inputs and operator actions, if any."""
    fields = {
        name: value for name, value in answer._asdict().items() if name not in ("chain", "remedies", "acts")
    }
    if answer.chain is not None:
        fields |= {
            "since": answer.chain.since,
            "chain": answer.chain.as_json(),
            "path": answer.chain.path_json(),
        }
    if answer.remedies is not None:
        fields["takes"] = answer.remedies.as_json()
    if answer.acts is not None:
        fields["acts"] = answer.acts.as_json()
    return fields


def _ask_bench(file: str, question: Question) -> _Answer:
    """Run a rack to the scan of the question, or to a fault, and answer there."""
    from scanrack.jobs.bench.opening import open_bench  # a trace needs no bench
    from scanrack.jobs.why.acts import acts_for
    from scanrack.jobs.why.answer import parse_value

    subject, moment, want = question.what, question.moment, question.want
    bench = open_bench(file, watched=True)
    bench.check(*(tag for tag in (subject, moment.until) if tag is not None))
    fault = None
    try:
        _run(bench, moment)
    except CpuFault as error:
        fault = str(error)
        say(f"the CPU has faulted in {error}", err=True)
    when = f"after {bench.scans:,} scans, {seconds(bench.now_ns)} s:"
    text, chain = (bench.why(), None) if subject is None else bench.answer(subject, deep=question.deep)
    remedies = acts = None
    if subject is not None and chain is not None and want is not None:
        remedies = bench.suggest_inputs(subject, want)
        acts = acts_for(bench, chain, subject, parse_value(want))
    return _Answer(
        scan=bench.scans - 1,
        now_ns=bench.now_ns,
        fault=fault,
        notes=(),
        when=when,
        text=text,
        chain=chain,
        remedies=remedies,
        acts=acts,
    )


def _ask_trace(path: Path, question: Question, *, trust: bool) -> _Answer:
    """Answer a question about a recording; print the notes on the trace and on the answer."""
    with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
        try:
            answer = why_of_trace(trace, Path(folder), question, trust=trust)
        finally:
            print_notes(trace)
    print_notes(answer)
    when = f"scan {answer.scan:,}, {seconds(answer.now_ns)} s:"
    return _Answer(
        scan=answer.scan,
        now_ns=answer.now_ns,
        fault=None,
        notes=answer.notes,
        when=when,
        text=answer.text,
        chain=answer.chain,
        remedies=answer.remedies,
    )


def xref(file: str, tag: str | None, as_json: bool) -> None:
    """List where tags are read and written.

    Raises:
        SystemExit: with the status of the command, unless it is 0.
    """
    from scanrack.terminal.as_json import say_json

    from .ladder import load_rungs

    try:
        references = cross_reference(load_rungs(file).build())
        mentions = references.mentions if tag is None else references.of(tag)
    except (LadderError, ValueError, OSError) as error:
        raise _refused(error) from error
    if tag is None:
        mentions = tuple(sorted(mentions, key=lambda mention: mention.text.upper()))
    if as_json:
        say_json({"tag": tag, "mentions": list(map(_mention_row, mentions))})
    else:
        for mention in mentions:
            site = mention.site
            say(f"{mention.text:<28} {mention.way:<14} {site.routine}, {site.place}: {site.instruction}")
    if not mentions:
        say(f"nothing in the program mentions {tag}", err=True)
        raise SystemExit(NO)


def _mention_row(mention: Mention) -> dict[str, object]:
    """Return a mention for --json; `number` is the number of the rung or line."""
    site = mention.site
    return {
        "tag": mention.text,
        "reads": mention.reads,
        "writes": mention.writes,
        "program": site.program,
        "routine": site.routine,
        "unit": site.unit,
        "number": site.rung,
        "text": site.instruction,
    }


def _refused(error: Exception) -> SystemExit:
    """Report an error and its remedy; return the exception that ends the command."""
    remedy = f"; {error.remedy}" if isinstance(error, AddressError) else ""
    return SystemExit(complain(f"{error}{remedy}", BAD_INPUT))
