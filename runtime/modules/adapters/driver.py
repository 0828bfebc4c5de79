"""What all controllers have in common at the far end of a link: found, lost, found again, or another one.

    ABSENT --answers--> PRESENT --configured--> READY
       ^                   ^                      |
       |                   +---- power lost ------+
       +------------ link lost, and back as it was where the position fits

A start is never repeated blindly: where its answer is lost, the controller is
looked at. Everything else may be repeated until it is answered.

B, 1,000,000, is where the controller's counter is put: one that has lost its
power counts from 0 and is noticed by that.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from enum import Enum
from typing import Generic

from ...line.master import PUBLISH, LineTiming, Master, Pause, Reply, Request, Script, Step
from .task import Drive, Task, TaskKind

BIAS = 1_000_000
REBIAS_BELOW = 500_000
PROBE_NS = 250_000_000
FAILURES_MAX = 3
SILENCE_NS = 500_000_000
NEAR_ZERO = 1_000
NS_PER_S = 1_000_000_000


class State(Enum):
    """How far the adapter has got with the controller."""

    ABSENT = "no good exchange"
    PRESENT = "it answers, and is not configured"
    READY = "configured"


class LinkLost(Exception):  # noqa: N818  # the state that follows, not a mistake
    """Three exchanges in a row have failed, or none was good for half a second."""


class PowerLost(Exception):  # noqa: N818
    """The controller's position says that it has been switched off meanwhile."""


Talk = Generator[Step, Reply | None, None]


class Driver(Generic[Drive]):
    """A controller as the link knows it, and the script that talks to it.

    Attributes:
        state: how far it has got.
        position: of the controller's counter, as read last.
        busy: whether it moves.
        task: the motion that runs.
        tasks: those that are to follow.
        cut: a hard stop is wanted, or under way.
        setup: a configuration is wanted, or under way.
        rebased: what the counter has been moved by so far without motion, steps.
        lost_power: it was found to have been switched off.
        returned: it answers again after a loss, and was not switched off.
        strayed: it has moved without being told.
        stopped_short: a motion ended before its target.
        out_of_range: a slew has come to the end of the counter's range.
        unfit: the controller says that it can't be relied on: MODULE_OK is clear while it does.
        complaints: bits of input word 0 that the controller gives rise to, each with its reason;
            whoever has taken them empties the list.

    Args:
        manners: how the line is used.
    """

    def __init__(self, line_timing: LineTiming) -> None:
        self.master = Master(line_timing)
        self.state = State.ABSENT
        self.position = 0
        self.busy = False
        self.task: Task[Drive] | None = None
        self.tasks: list[Task[Drive]] = []
        self.cut = False
        self.setup = False
        self.rebased = 0
        self.lost_power = self.returned = self.strayed = False
        self.stopped_short = self.out_of_range = False
        self.unfit = False
        self.complaints: list[tuple[int, str]] = []
        self._was_ready = False
        self._failed = 0
        self._good_ns = 0
        self._read_ns = 0
        self._top_sps = 0
        self._rebasing_to: int | None = None
        self.master.begin(self._script())

    # -- what a controller brings -------------------------------------------------------------

    def identify(self) -> Request:
        """Return the request with which it is looked for."""
        raise NotImplementedError

    def configure(self) -> Talk:
        """Bring it into the state in which motions start, its counter at B."""
        raise NotImplementedError

    def stop(self) -> Talk:
        """Stop its motion at once, and repeat that until it is answered."""
        raise NotImplementedError

    def read_status(self) -> Talk:
        """Read whether it is busy."""
        raise NotImplementedError

    def read_position(self) -> Talk:
        """Read its counter, and `note_position`."""
        raise NotImplementedError

    def read_inputs(self) -> Talk:
        """Read its inputs."""
        raise NotImplementedError

    def write_position(self, position: int) -> Talk:
        """Put its counter somewhere."""
        raise NotImplementedError

    def carry_out(self, task: Task[Drive]) -> Talk:
        """Make a motion, up to the standstill after it."""
        raise NotImplementedError

    @property
    def cycle(self) -> tuple[Callable[[], Talk], ...]:
        """What is read over and over, in order: the position is final where the status before was idle."""
        return self.read_status, self.read_position, self.read_inputs

    def rouse(self) -> Talk:
        """Try whether a controller that does not answer only speaks another language."""
        yield from ()

    def admit(self) -> Generator[Step, Reply | None, bool]:
        """Bring a controller that was found to the point at which it obeys; return whether it does."""
        yield from ()
        return True

    def errand(self) -> Talk | None:
        """Return something else that is to be done, None if there is nothing."""
        return None

    def forget(self) -> None:
        """Forget what has been written to it."""
        raise NotImplementedError

    # -- the script ---------------------------------------------------------------------------

    def _script(self) -> Script:
        while True:
            try:
                yield from self._connect()
                while True:
                    yield from self._turn()
            except LinkLost:
                self._forget_wishes()
                self.state = State.ABSENT
                yield PUBLISH
            except PowerLost:
                self._forget_wishes()
                self._was_ready = False
                self.lost_power = self.cut = True
                self.state = State.PRESENT
                yield PUBLISH

    def _forget_wishes(self) -> None:
        self.task = None
        self.tasks.clear()
        self.cut = False
        self.forget()

    def _connect(self) -> Talk:
        """Ask for the identity until it comes; then see whether it is the controller that it was."""
        while self.state is State.ABSENT:
            asked_ns = self.master.now_ns
            reply = yield self.identify()
            if reply is None:
                yield from self.rouse()
                yield Pause(max(0, asked_ns + PROBE_NS - self.master.now_ns))
                continue
            self._good()
            if self._was_ready or (yield from self.admit()):
                yield from self._see_again()
            else:
                yield PUBLISH
                yield Pause(PROBE_NS)
        self._failed = 0

    def _see_again(self) -> Talk:
        if self._was_ready:
            yield from self.halt()
        yield from self.read_all()
        self.state = State.READY if self._was_ready else State.PRESENT
        self.returned = self._was_ready
        yield PUBLISH

    def _turn(self) -> Talk:
        """Do the most urgent thing."""
        if self.cut:
            yield from self.halt()
            yield PUBLISH
        elif self.setup:
            yield from self._set_up()
        elif (errand := self.errand()) is not None:
            yield from errand
        elif self.tasks:
            self.task = self.tasks.pop(0)
            self._top_sps = self.top_sps(self.task.drive)
            yield from self.carry_out(self.task)
        else:
            yield from self._look_around()

    def top_sps(self, drive: Drive) -> int:
        """Return the speed of a motion, steps/s."""
        raise NotImplementedError

    def _set_up(self) -> Talk:
        self.forget()
        self._was_ready = False
        yield from self.configure()
        yield from self.read_all()
        self.setup = False
        self._was_ready = True
        self.state = State.READY
        yield PUBLISH

    def _look_around(self) -> Talk:
        """Read everything while nothing is to be done; what moves then was not told to."""
        before = self.position
        for read in self.cycle:
            yield from read()
            if self.state is State.READY and (self.busy or self.position != before):
                self.strayed = True
                before = self.position
            if self.cut or self.setup or self.tasks or self.errand() is not None:
                return
        yield PUBLISH
        if self.state is State.READY and not self.busy and abs(self.position) < REBIAS_BELOW:
            yield from self.rebase(BIAS)

    # -- exchanges ----------------------------------------------------------------------------

    def _good(self) -> None:
        self._failed = 0
        self._good_ns = self.master.now_ns

    def ask(self, request: Request) -> Generator[Step, Reply | None, Reply | None]:
        """Make one exchange; return its reply, None if it failed.

        Raises:
            LinkLost: it was the third in a row that failed, or the silence has lasted too long.
        """
        reply = yield request
        if reply is not None:
            self._good()
            return reply
        self._failed += 1
        if self._failed >= FAILURES_MAX or self.master.now_ns - self._good_ns >= SILENCE_NS:
            raise LinkLost
        return None

    def insist(self, request: Request) -> Generator[Step, Reply | None, Reply]:
        """Repeat an exchange that may be repeated until it is answered."""
        while True:
            reply = yield from self.ask(request)
            if reply is not None:
                return reply

    # -- parts --------------------------------------------------------------------------------

    def read_all(self) -> Talk:
        """Read status, then the position, which is final if the status was idle, then inputs."""
        yield from self.read_status()
        yield from self.read_position()
        yield from self.read_inputs()

    def note_position(self, position: int) -> None:
        """Take over a position read.

        Raises:
            PowerLost: it is near 0, and too far from the one before to have been reached.
        """
        self._settle_rebase(position)
        elapsed_ns, self._read_ns = self.master.now_ns - self._read_ns, self.master.now_ns
        way = self._top_sps * elapsed_ns // NS_PER_S + NEAR_ZERO
        before, self.position = self.position, position
        if self._was_ready and abs(position) <= NEAR_ZERO and abs(position - before) > way:
            raise PowerLost

    def rebase(self, position: int) -> Talk:
        """Put the counter elsewhere; the axis stays where it is."""
        self._rebasing_to = position
        yield from self.write_position(position)
        self._settle_rebase(position)

    def _settle_rebase(self, seen: int) -> None:
        """Find out from the counter whether it was put elsewhere: the answer may have been lost."""
        goal, self._rebasing_to = self._rebasing_to, None
        if goal is not None and abs(seen - goal) < abs(seen - self.position):
            self.rebased += goal - self.position
            self.position = goal

    def halt(self) -> Talk:
        """Stop at once, and read where."""
        yield from self.stop_and_look()
        self.task = None
        self.cut = False

    def stop_and_look(self) -> Talk:
        """Stop at once, wait until it stands still, and read where."""
        yield from self.stop()
        self.busy = True
        while self.busy:
            yield from self.read_status()
        yield from self.read_position()

    def start(self, task: Task[Drive], request: Request) -> Talk:
        """Start a motion; where the answer is lost, look before asking again."""
        before = self.position
        for _ in range(2):
            reply = yield from self.ask(request)
            self.model(task)
            if reply is not None:
                self.note_refusal(reply)
                return
            for _ in range(2):
                yield from self.read_status()
                yield from self.read_position()
                if self.cut or self.busy or self.position != before:
                    return

    def note_refusal(self, reply: Reply) -> None:
        """Take note of a start that the controller has refused."""

    def model(self, task: Task[Drive]) -> None:
        """Note what the controller is now thought to do."""
        raise NotImplementedError

    def accompany(self, task: Task[Drive]) -> Talk:
        """Watch a motion until the controller is idle, and pass on what is wanted of it."""
        slowed = marked = False
        while not self.cut:
            if task.stopping and not slowed:
                slowed = True
                yield from self.slow_down(task)
                if task.kind is TaskKind.INDEX:
                    return
            elif task.marked and not marked:
                marked = True
                yield from self.set_mark(task)
            for read in self.cycle:
                yield from read()
                if self._cut_meanwhile() or (task.stopping > slowed) or (task.marked > marked):
                    break
            else:
                yield from self.watch(task)
                if not self.busy:
                    return
                yield PUBLISH

    def slow_down(self, task: Task[Drive]) -> Talk:
        """Stop softly; an index stands still afterwards."""
        raise NotImplementedError

    def set_mark(self, task: Task[Drive]) -> Talk:
        """Set the mark of a registration move."""
        raise NotImplementedError

    def stop_and_index(self, task: Task[Drive]) -> Talk:
        """Stop, and index what is then left of the steps behind the mark, which is where it stands now."""
        yield from self.read_position()
        mark = self.position
        task.stopping = True
        yield from self.slow_down(task)
        self.busy = True
        while self.busy and not self.cut:
            yield from self.read_status()
        yield from self.read_position()
        left = task.steps - abs(self.position - mark)
        if left > 0:
            drive = self.drive_over(task.drive, left)
            task.following = Task(TaskKind.INDEX, task.direction, drive, task.ramps_up, left)

    def drive_over(self, drive: Drive, steps: int) -> Drive:
        """Return the speeds and ramps of a motion for an index over so many steps."""
        return drive

    def watch(self, task: Task[Drive]) -> Talk:
        """Look at what has been read of a motion, and do what follows."""
        raise NotImplementedError

    def _cut_meanwhile(self) -> bool:
        """Whether a hard stop was wanted while what was read was looked at."""
        return self.cut

    def conclude(self, task: Task[Drive], began_at: int) -> Talk:
        """The controller stands still: show why, before the motion counts as over."""
        if task.kind is TaskKind.INDEX and not task.stopping:
            self.stopped_short = self.position != began_at + task.direction * task.steps
        yield PUBLISH
        if not self._cut_meanwhile():
            self.task = None
            if task.following is not None:
                self.tasks.insert(0, task.following)
            yield PUBLISH
