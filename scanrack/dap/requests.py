"""The table of requests; the reply to `initialize` and the documentation page are generated from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import looking, moving, setting, starting
from .breakpoints import FILTERS
from .protocol import Json

if TYPE_CHECKING:
    from .adapter import Adapter


@dataclass(frozen=True, slots=True)
class Request:
    """A request."""

    handle: Callable[[Adapter, Json], Json | None]  # returns the body of the response
    description: str  # for the docs
    needs: str = "subject"  # "nothing"; "subject": after launch or attach; "stop": while execution is stopped
    capability: str = ""  # the capability that announces it; "" for a request that every adapter answers


REQUESTS: Mapping[str, Request] = {
    "initialize": Request(
        lambda _adapter, _arguments: capabilities(), "returns the capabilities of the adapter", "nothing"
    ),
    "launch": Request(starting.launch, "runs a rack, or opens a trace", "nothing"),
    "attach": Request(starting.attach, "opens a trace", "nothing"),
    "configurationDone": Request(
        starting.configured,
        "starts execution after all breakpoints are set",
        capability="supportsConfigurationDoneRequest",
    ),
    "disconnect": Request(starting.disconnect, "ends the session", "nothing"),
    "terminate": Request(starting.disconnect, "ends the session", "nothing", "supportsTerminateRequest"),
    "setBreakpoints": Request(setting.lines, "sets the breakpoints of a file"),
    "setFunctionBreakpoints": Request(
        setting.functions,
        "sets breakpoints on rungs, routines, tags and conditions by name",
        capability="supportsFunctionBreakpoints",
    ),
    "setExceptionBreakpoints": Request(setting.exceptions, "stops at error bits, rules, faults or scans"),
    "dataBreakpointInfo": Request(
        setting.data_info,
        "returns whether a value can have a breakpoint, and its last change",
        "stop",
        "supportsDataBreakpoints",
    ),
    "setDataBreakpoints": Request(
        setting.data, "sets breakpoints on values", capability="supportsDataBreakpoints"
    ),
    "breakpointLocations": Request(
        setting.locations, "lists the lines with a rung", capability="supportsBreakpointLocationsRequest"
    ),
    "continue": Request(moving.go, "runs to the next breakpoint", "stop"),
    "pause": Request(moving.pause, "stops after the current scan"),
    "next": Request(moving.next_, "goes to the next rung, instruction or scan", "stop"),
    "stepIn": Request(moving.step_in, "goes into a routine or an add-on instruction", "stop"),
    "stepOut": Request(moving.step_out, "goes to the caller; from the main routine to the next scan", "stop"),
    "stepBack": Request(
        moving.step_back, "goes to the previous rung or instruction", "stop", "supportsStepBack"
    ),
    "reverseContinue": Request(
        moving.reverse, "runs backwards to the previous breakpoint", "stop", "supportsStepBack"
    ),
    "threads": Request(looking.threads, "returns the only thread, which is the scan"),
    "stackTrace": Request(
        looking.stack,
        "lists the rung, its callers, the task and the scan",
        "stop",
        "supportsDelayedStackTraceLoading",
    ),
    "scopes": Request(looking.scopes, "lists inputs, outputs, tags, timers and locals", "stop"),
    "variables": Request(looking.variables, "lists the values of one level", "stop"),
    "setVariable": Request(
        looking.set_variable, "sets a tag, or forces a word or bit", "stop", "supportsSetVariable"
    ),
    "setExpression": Request(looking.set_expression, "sets a watched tag", "stop", "supportsSetExpression"),
    "evaluate": Request(
        looking.evaluate,
        "evaluates a tag, an expression of the query language, or a command of the console",
        "stop",
        "supportsEvaluateForHovers",
    ),
    "exceptionInfo": Request(
        looking.exception_info, "returns the reason for a stop", "stop", "supportsExceptionInfoRequest"
    ),
    "loadedSources": Request(
        looking.sources, "lists the files of the program", capability="supportsLoadedSourcesRequest"
    ),
    "completions": Request(looking.completions, "completes tag names", "stop", "supportsCompletionsRequest"),
}

ALSO: Mapping[str, Any] = {
    "supportsConditionalBreakpoints": True,
    "supportsHitConditionalBreakpoints": True,
    "supportsLogPoints": True,
    "supportsExceptionFilterOptions": True,
    "supportsSteppingGranularity": True,
    "supportsValueFormattingOptions": False,
    "exceptionBreakpointFilters": [
        {
            "filter": name,
            "label": label,
            "description": description,
            "default": name == "fault",
            "supportsCondition": True,
            "conditionDescription": "an expression such as Position > 4000",
        }
        for name, (label, description) in FILTERS.items()
    ],
}
"""Additional capabilities, for the arguments of requests."""


def capabilities() -> Json:
    """Return the capabilities that `initialize` announces."""
    announced: Json = {request.capability: True for request in REQUESTS.values() if request.capability}
    return {**announced, **ALSO}
