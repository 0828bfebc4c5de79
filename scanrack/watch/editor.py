"""Edits of a running rack's program. A thread checks a saved file; the session replaces the program.

    file      saved
    thread          loaded, built, compiled
    scans     n     n+1   n+2 | n+3            the edited program starts in scan n+3

A ladder program keeps the values of its tags, as in an online edit. A `Logic` program keeps its fields, and
its sequences continue, see `ladder.python.online`. A Python function restarts. After a mistake the page shows
the file and line, and the running program continues. Text edited on a page is previewed first, and is saved
only when the page accepts it. With --preview a saved file is also previewed first. `online` handles edits of
drawn rungs, and `typed_text` handles edits of the text. An edit is an action that is recorded with the
program's files, see `jobs.record.program_versions`.
"""

from __future__ import annotations

import threading
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextvars import copy_context
from functools import partial
from typing import NamedTuple

from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.record.program_versions import ProgramVersion, ProgramVersions, version_of
from scanrack.jobs.run.running import JobRun
from scanrack.runtime.live.actions import Edit, Online, Source, ToEditor, names_in
from scanrack.runtime.live.session import Reply

from .edited_programs import EditedPrograms
from .history.program_file import digest, why_not_editable
from .online import OnlineEdit
from .preview import Json, mistake_of
from .typed_text import Answer, TypedText

WAITING_MOST = 8
"""Maximum number of waiting requests."""

CHECK_S = 0.3
"""Interval between two checks of the file, s."""

Takeover = Callable[[], Edit | None]
"""Called between two scans; returns the edit's action, or sends the page a message and returns None.
"""


class EditManner(NamedTuple):
    """Settings for edits."""

    preview: bool = False  # whether a saved file waits until a page accepts it
    trust: bool = False  # whether Python that is typed in a page may run
    saved: Callable[[str], None] | None = None  # called between scans with a saved file's name


class Exchange(NamedTuple):
    """A request to replace the program before the next scan, which the session may refuse."""

    takeover: Takeover
    follow: Callable[[], None] = lambda: None  # called afterwards in the thread, also after a refusal


class Editor:
    """The thread that checks the program's file and the edits from pages, and passes on edited programs.

    Args:
        job: the first program.
        rack: path of the rack file.
        run: the running session.
        editions: the versions of the program that are recorded.
        hand_over: receives a `Takeover`, to be called between two scans.
        send: sends a message to all pages.
    """

    def __init__(
        self,
        job: LoadedRack,
        rack: str,
        run: JobRun,
        editions: ProgramVersions,
        hand_over: Callable[[Takeover], None],
        send: Callable[[Mapping[str, object]], None],
        manner: EditManner,
    ) -> None:
        self._run, self._editions, self._hand_over, self._send = run, editions, hand_over, send
        self._previews, self._saved_elsewhere = manner.preview, manner.saved
        self._programs = EditedPrograms(job, rack, run, editions)
        self._online = OnlineEdit(self._programs)
        self._typed = TypedText(self._programs, run, trust=manner.trust)
        self._requests: deque[tuple[ToEditor, Reply]] = deque()
        self._exchanging = 0  # exchanges whose outcome is not handled yet; used only by the thread
        self._exchanged: deque[Exchange] = deque()  # exchanges that were carried out or refused
        self._ending, self._wake = threading.Event(), threading.Event()
        self._reload_requested = False
        self._restart = ""  # see `actions.Reload`
        self._state: Json = {}  # state of edited rungs that pages have
        context = copy_context()  # the context in which programs are loaded
        self._thread = threading.Thread(
            target=context.run, args=(self._run_thread,), name="edits", daemon=True
        )

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def end(self) -> None:
        """End the thread."""
        self._ending.set()
        self._wake.set()
        self._thread.join()

    def load_soon(self, restart: str = "") -> None:
        """Ask the thread to load the program's file; for `restart` see `actions.Reload`."""
        self._restart, self._reload_requested = restart, True
        self._wake.set()

    def lasting(self) -> Iterable[Json]:
        """Yield the message that a new monitor needs: the state of edited rungs."""
        if self._state:
            yield {"online": self._state}

    def request(self, action: ToEditor, reply: Reply) -> None:
        """Queue an action on the program's text, which the thread carries out.

        Raises:
            ValueError: too many requests are waiting.
        """
        if len(self._requests) >= WAITING_MOST:
            raise ValueError(f"{WAITING_MOST} previews are being made; try again in a moment")
        self._requests.append((action, reply))
        self._wake.set()

    def _run_thread(self) -> None:
        """Answer pages and check the file until `end`; pages see unexpected errors as mistakes."""
        if self._programs.rungs is not None and not why_not_editable(self._programs.file):
            self._send_state()
        while not self._ending.is_set():
            self._wake.wait(CHECK_S)
            self._wake.clear()
            try:
                self._attend()
            except Exception as error:  # an error in our code must not end the session or this thread
                traceback.print_exc()
                mistake = mistake_of(_reportable(error), self._programs.file)
                self._hand_over(partial(self._send, {"mistake": mistake}))

    def _attend(self) -> None:
        """Answer pages, then load or preview the program's file if it was saved or should be reloaded."""
        while self._requests:
            self._follow()  # the page may already know these outcomes from an earlier answer
            self._answer(*self._requests.popleft())
        self._follow()
        is_requested, self._reload_requested = self._reload_requested, False
        if is_requested or self._programs.is_rewritten():
            self._programs.look()
            if self._saved_elsewhere is not None and not is_requested:
                self._hand_over(partial(self._saved_elsewhere, self._programs.file.name))
            elif self._previews and not is_requested:
                self._preview_saved()
            else:
                self._load()

    # --- exchanges

    def _exchange(self, exchange: Exchange) -> None:
        """Hand over an exchange; `_follow` handles its outcome."""

        def carried_out() -> None:
            self._exchanged.append(exchange)
            self._wake.set()

        self._exchanging += 1
        self._hand_over(exchange.takeover)
        self._hand_over(carried_out)

    def _follow(self) -> None:
        """Handle the outcomes of exchanges, and send the state to the pages."""
        if not self._exchanged:
            return
        while self._exchanged:
            self._exchanging -= 1
            self._exchanged.popleft().follow()
        self._send_state()

    def _send_state(self) -> None:
        self._online.settle()
        self._hand_over(partial(self._show, self._online.state(self._programs.running)))

    def _show(self, state: Json) -> None:
        self._state = state
        self._send({"online": state})

    def _load(self) -> None:
        """Load the program's file and hand it over, unless the file has been written again meanwhile."""
        restart, self._restart = self._restart, ""
        exchange = self._from_disk(restart)
        if not self._programs.is_rewritten():  # otherwise it is just being saved: the next check loads it
            self._exchange(exchange)

    def _from_disk(self, restart: str) -> Exchange:
        """Return an exchange for the program on disk; if it can't be used, the exchange sends the mistake.

        Once the program runs, the file counts as seen.
        """
        programs = self._programs
        try:
            job = programs.usable(programs.from_disk(), restart)
            edition = programs.versions.with_copy(version_of(job))
        except (ValueError, OSError) as error:
            mistake = mistake_of(error, programs.file)
            return Exchange(lambda: self._send({"mistake": mistake}))

        def follow() -> None:
            if programs.running.files == edition.files:
                programs.seen = digest(edition.files[programs.name])

        return Exchange(partial(self._edit, edition, job, restart), follow)

    def _edit(self, edition: ProgramVersion, job: LoadedRack, restart: str) -> Edit | None:
        """Keep a version as the next one, and return the action that switches to it.

        If it is already running or can't be used, tell the pages and return None.
        """
        number = self._run.program.edits + 1
        if edition.files == self._editions[number - 1].files and not restart:
            self._send({"mistake": None})
            self._send({"note": "The program has not changed."})
            return None
        try:
            self._run.program.planned(self._run.cpu, job, names_in(restart))
        except ValueError as error:
            self._send({"mistake": mistake_of(error, self._programs.file)})
            return None
        self._editions.keep(number, edition, job)
        return Edit(number, edition.program, restart)

    # --- answers

    def _answer(self, action: ToEditor, reply: Reply) -> None:
        """Carry out an action in the thread, and hand over the answer to be sent between two scans."""
        exchange: Exchange | None = None
        try:
            if isinstance(action, Source):
                source = self._typed.source()
                make_answer: Answer = lambda: source  # noqa: E731
            elif isinstance(action, Online):
                make_answer = self._step(action)
            else:
                self._typed.check(action)
                if action.take:
                    self._programs.write(action.text.encode())
                    make_answer, exchange = lambda: {"saved": True}, self._from_disk(action.restart)
                else:
                    make_answer = self._typed.preview(action)
        except Exception as error:
            if not isinstance(error, ValueError | OSError):
                traceback.print_exc()
            reason = str(_reportable(error))
            self._hand_over(lambda: reply({"refused": reason}))
            return

        def send() -> None:
            try:
                result = {"ok": True, **make_answer()}
            except Exception as error:
                result = {"refused": str(_reportable(error))}
            reply(result)

        self._hand_over(send)
        if exchange is not None:
            self._exchange(exchange)

    def _step(self, action: Online) -> Answer:
        """Perform a step of an online edit, hand over the program's replacement, and return the answer."""
        if self._exchanging:  # the stage depends on its outcome
            raise ValueError("the program is being replaced; try again in a moment")
        step, programs = self._online.take(action), self._programs
        state = self._online.state(step.version)

        def undo_if_refused() -> None:
            if programs.running.files != step.version.files:
                self._online.undo(step)

        if step.job is not None:
            self._exchange(Exchange(partial(self._edit, step.version, step.job, ""), undo_if_refused))

        def make_answer() -> Json:
            if programs.running.files != step.version.files:
                raise ValueError(f"{action.step}: the program could not be replaced; the previous one runs")
            self._show(state)
            if step.note:
                self._send({"note": step.note})
            return state

        return make_answer

    def _preview_saved(self) -> None:
        """Send pages a preview of the saved file, or None if it is unchanged; do not change the program."""
        make_preview = self._typed.preview_saved()

        def send() -> None:
            preview = make_preview()["preview"]
            self._send({"preview": preview if preview["rows"] else None})

        self._hand_over(send)


def _reportable(error: Exception) -> Exception:
    """Return the error to show on the page; an unexpected one becomes a ValueError that names its type."""
    if isinstance(error, ValueError | OSError):
        return error
    return ValueError(f"it can't be carried out: {type(error).__name__}: {error}")
