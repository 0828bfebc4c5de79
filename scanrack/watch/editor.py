"""Edits a running rack's program: checks a saved file beside the scans, and replaces the program between two.

    file      saved
    thread          loaded, built, compiled
    scans     n     n+1   n+2 | n+3            the edited program begins with scan n+3

A ladder program keeps the values of its tags, as in an online edit. A `Logic` program keeps its fields, and
its sequences continue, see `ladder.python.online`. A Python function is loaded again. For a mistake, the page
shows the file and line, and the running program continues. A text that was edited in a page is previewed, and
saved only when the page takes it over. If the session has previews, a saved file is also previewed first.
`online` handles edits of drawn rungs, `typed_text` edits of the text. An edit is an order that is recorded
with the program's files, see `jobs.record.program_versions`.
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
from .history.program_file import digest, why_not
from .online import OnlineEdit
from .preview import Json, mistake_of
from .typed_text import Answer, TypedText

ASKED_MOST = 8
"""Largest number of waiting requests."""

LOOK_S = 0.3
"""Time between two checks of the file, s."""

Takeover = Callable[[], Edit | None]
"""Returns the order of an edit, or reports a mistake or a preview; called between two scans."""


class EditManner(NamedTuple):
    """Settings for edits."""

    preview: bool = False  # whether a saved file waits until a page takes it over
    trust: bool = False  # whether Python that is typed in a page may run
    saved: Callable[[str], None] | None = None  # called between scans with a saved file's name


class Exchange(NamedTuple):
    """The replacement of the program before the next scan; it may be refused."""

    takeover: Takeover
    follow: Callable[[], None] = lambda: None  # called beside the scans once it was carried out or refused


class Editor:
    """Watches the files of a program, and passes on edited programs.

    Args:
        hand_over: receives a `Takeover`, to be called between two scans.
    """

    def __init__(
        self,
        job: LoadedRack,
        rack: str,
        run: JobRun,
        editions: ProgramVersions,
        hand_over: Callable[[Takeover], None],
        tell: Callable[[Mapping[str, object]], None],
        manner: EditManner,
    ) -> None:
        self._run, self._editions, self._hand_over, self._tell = run, editions, hand_over, tell
        self._previews, self._saved_elsewhere = manner.preview, manner.saved
        self._programs = EditedPrograms(job, rack, run, editions)
        self._online = OnlineEdit(self._programs)
        self._typed = TypedText(self._programs, run, trust=manner.trust)
        self._orders: deque[tuple[ToEditor, Reply]] = deque()
        self._exchanging = 0  # exchanges whose outcome is not yet handled; used only by this thread
        self._exchanged: deque[Exchange] = deque()
        self._ending, self._wake = threading.Event(), threading.Event()
        self._requested = False
        self._restart = ""
        self._state: Json = {}  # state of edited rungs, as last sent to pages
        context = copy_context()  # the context in which programs are loaded
        self._thread = threading.Thread(target=context.run, args=(self._watch,), name="edits", daemon=True)

    def start(self) -> None:
        """Start the thread that watches the files."""
        self._thread.start()

    def end(self) -> None:
        """End the thread."""
        self._ending.set()
        self._wake.set()
        self._thread.join()

    def load_soon(self, restart: str = "") -> None:
        """Have the program's current version loaded beside the scans; `restart` is as in an order."""
        self._restart, self._requested = restart, True
        self._wake.set()

    def lasting(self) -> Iterable[Json]:
        """Yield the messages that a new monitor needs: the state of edited rungs."""
        if self._state:
            yield {"online": self._state}

    def ask(self, order: ToEditor, reply: Reply) -> None:
        """Queue a request to answer beside the scans: the program's text, a preview of an edit, or a step.

        Raises:
            ValueError: too many requests are waiting.
        """
        if len(self._orders) >= ASKED_MOST:
            raise ValueError(f"{ASKED_MOST} previews are being made: ask again in a moment")
        self._orders.append((order, reply))
        self._wake.set()

    def _watch(self) -> None:
        if self._programs.rungs is not None and not why_not(self._programs.file):
            self._tell_state()
        while not self._ending.is_set():
            self._wake.wait(LOOK_S)
            self._wake.clear()
            try:
                self._attend()
            except Exception as error:  # an error of our own must not end the session or this thread
                traceback.print_exc()
                mistake = mistake_of(_named(error), self._programs.file)
                self._hand_over(partial(self._tell, {"mistake": mistake}))

    def _attend(self) -> None:
        """Answer pages, then load or preview the program if an order or a saved file requires it."""
        while self._orders:
            self._follow()  # handles outcomes that a page may know from an earlier answer
            self._answer(*self._orders.popleft())
        self._follow()
        is_requested, self._requested = self._requested, False
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
        self._tell_state()

    def _tell_state(self) -> None:
        self._online.settle()
        self._hand_over(partial(self._show, self._online.state(self._programs.running)))

    def _show(self, state: Json) -> None:
        self._state = state
        self._tell({"online": state})

    def _load(self) -> None:
        restart, self._restart = self._restart, ""
        exchange = self._from_disk(restart)
        if not self._programs.is_rewritten():  # else it is being saved: the next check loads it
            self._exchange(exchange)

    def _from_disk(self, restart: str) -> Exchange:
        programs = self._programs
        try:
            job = programs.usable(programs.from_disk(), restart)
            edition = programs.versions.with_copy(version_of(job))
        except (ValueError, OSError) as error:
            mistake = mistake_of(error, programs.file)
            return Exchange(lambda: self._tell({"mistake": mistake}))

        def follow() -> None:
            if programs.running.files == edition.files:
                programs.seen = digest(edition.files[programs.name])

        return Exchange(partial(self._order, edition, job, restart), follow)

    def _order(self, edition: ProgramVersion, job: LoadedRack, restart: str) -> Edit | None:
        """Return the order to continue with a program; None if it already runs."""
        number = self._run.program.edits + 1
        if edition.files == self._editions[number - 1].files and not restart:
            self._tell({"mistake": None})
            self._tell({"note": "The program has not changed: it goes on."})
            return None
        try:
            self._run.program.planned(self._run.cpu, job, names_in(restart))
        except ValueError as error:
            self._tell({"mistake": mistake_of(error, self._programs.file)})
            return None
        self._editions.keep(number, edition, job)
        return Edit(number, edition.program, restart)

    # --- answers

    def _answer(self, order: ToEditor, reply: Reply) -> None:
        """Do the work for an answer beside the scans; hand over the answer, to be sent between two scans."""
        then: Exchange | None = None
        try:
            if isinstance(order, Source):
                source = self._typed.source()
                answer: Answer = lambda: source  # noqa: E731
            elif isinstance(order, Online):
                answer = self._step(order)
            else:
                self._typed.check(order)
                if order.take:
                    self._programs.write(order.text.encode())
                    answer, then = lambda: {"saved": True}, self._from_disk(order.restart)
                else:
                    answer = self._typed.preview(order)
        except Exception as error:
            if not isinstance(error, ValueError | OSError):
                traceback.print_exc()
            reason = str(_named(error))
            self._hand_over(lambda: reply({"refused": reason}))
            return

        def send() -> None:
            try:
                result = {"ok": True, **answer()}
            except Exception as error:
                result = {"refused": str(_named(error))}
            reply(result)

        self._hand_over(send)
        if then is not None:
            self._exchange(then)

    def _step(self, order: Online) -> Answer:
        """Take a step with edited rungs; hand over the replacement of the program; return the answer."""
        if self._exchanging:  # whether the step fits depends on the outcome
            raise ValueError("the program is being exchanged: ask again in a moment")
        step, programs = self._online.take(order), self._programs
        state = self._online.state(step.version)

        def undo_if_refused() -> None:
            if programs.running.files != step.version.files:
                self._online.undo(step)

        if step.job is not None:
            self._exchange(Exchange(partial(self._order, step.version, step.job, ""), undo_if_refused))

        def answer() -> Json:
            if programs.running.files != step.version.files:
                raise ValueError(f"{order.step}: the program could not be exchanged: the one before runs")
            self._show(state)
            if step.note:
                self._tell({"note": step.note})
            return state

        return answer

    def _preview_saved(self) -> None:
        """Send pages a preview, or None without changes; the file waits until a page takes it over."""
        make_preview = self._typed.preview_saved()

        def send() -> None:
            preview = make_preview()["preview"]
            self._tell({"preview": preview if preview["rows"] else None})

        self._hand_over(send)


def _named(error: Exception) -> Exception:
    """Return an error to report; an unexpected one is wrapped with the name of its type."""
    if isinstance(error, ValueError | OSError):
        return error
    return ValueError(f"it can't be carried out: {type(error).__name__}: {error}")
