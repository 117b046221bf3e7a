"""Results of a sweep as they come in: in memory, and in a file from which a sweep that was killed goes on.

The journal is a line of JSON that says whose it is, then entries: first run, number of runs, check sum, results, outcomes.
Entries are only appended; a damaged one (the machine went down while it was written) and what follows it is dropped.
"""

import contextlib
import json
import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING

from lagrangia.base.diagnostics import fail
from lagrangia.run.batch import OUTCOME, Ending, Lanes, outcome_type
from lagrangia.study.sweep.plan import Job

if TYPE_CHECKING:
    import numpy as np

_ENTRY = struct.Struct("<QQI")
_TITLE = {"what": "sweep of lagrangia, to be continued"}
_BEGIN = json.dumps(_TITLE)[:-1].encode()


def _open_itself(path: str, flags: int) -> int:
    """As `opener` of open(): a link that somebody has put there is not written through. Raises OSError."""
    return os.open(path, flags | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0), 0o666)


class Ledger:
    """results (runs, measures), NaN where there is none, and outcomes (runs,); `entered` runs are done."""

    def __init__(self, job: Job) -> None:
        import numpy as np

        self.results = np.full((job.runs, len(job.measures)), np.nan)
        self.outcomes = np.zeros(job.runs, dtype=outcome_type())
        self.outcomes["kind"] = int(Ending.NOT_RUN)  # NumPy asks an enum long
        self.entered = 0
        self.lanes = Lanes()  # of the runs made here and now
        self.wanted = job.runs  # the first so many

    def first(self, job: Job) -> "Ledger":
        """Of a job that has the first of these runs."""
        found = Ledger(job)
        found.enter(0, self.results[: job.runs], self.outcomes[: job.runs])
        found.lanes = self.lanes
        return found

    def enter(self, first: int, results: "np.ndarray", outcomes: "np.ndarray") -> None:
        """Results and outcomes of the runs from `first` on."""
        import numpy as np

        last = first + len(outcomes)
        self.entered += int(np.count_nonzero(self.outcomes["kind"][first:last] == int(Ending.NOT_RUN)))
        self.results[first:last] = results
        whole = f"V{outcomes.itemsize}"  # NumPy copies records field by field
        self.outcomes.view(whole)[first:last] = outcomes.view(whole)

    def missing(self) -> list[tuple[int, int]]:
        """What is still to be run of those that are wanted: first <= k < last."""
        import numpy as np

        if not self.entered:
            return [(0, self.wanted)] if self.wanted else []
        is_open = np.concatenate([[False], self.outcomes["kind"][: self.wanted] == int(Ending.NOT_RUN), [False]])
        edges = np.flatnonzero(is_open[1:] != is_open[:-1])
        return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


class Journal(Ledger):
    """A ledger that is kept in a file too; use it in a `with` statement. Raises LagError L0714 for the journal of another sweep.

    `found` runs were in the file already.
    """

    def __init__(self, job: Job, path: Path, restart: bool = False) -> None:
        super().__init__(job)
        self.path = path
        self.header = json.dumps({**_TITLE, "fingerprint": job.fingerprint(), "runs": job.runs, "record": len(OUTCOME),
                                  "measures": len(job.measures)}).encode() + b"\n"
        try:
            self.stream: IO[bytes] = open(path, "r+b" if path.exists() else "x+b", opener=_open_itself)  # noqa: SIM115
        except OSError as error:
            fault = "it is a link" if os.path.islink(path) else error.strerror or "it is no file"
            fail("L0004", f"'{path}' cannot be written: {fault}")
        try:
            self._lock()
            self._take_over(restart)
        except BaseException:
            self.stream.close()
            raise
        self.found = self.entered

    def _lock(self) -> None:
        """Two sweeps into the same file at the same time would each lose what the other computes."""
        try:
            import fcntl
        except ImportError:
            return  # Windows: a file that is open elsewhere cannot be removed there, which is told later
        try:
            fcntl.flock(self.stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            fail("L0714", f"'{self.path}' is in use: the same sweep is running already")

    def _take_over(self, restart: bool) -> None:
        begin = self.stream.readline(100_000)
        if not begin.startswith(_BEGIN) and not _BEGIN.startswith(begin):  # not even one cut off as it was begun
            fail("L0714", f"'{self.path}' is in the way: it is no journal of a sweep", None, "move it, or choose another -o")
        if len(begin) > len(_BEGIN) and begin != self.header and not restart:
            fail("L0714", f"'{self.path}' belongs to another sweep", None,
                 "to continue it, give the command it was started with; to give it up, say --restart; or choose another -o")
        if begin != self.header or restart:
            self.stream.seek(0)
            self.stream.truncate()
            self._append(self.header)
            return
        for first, results, outcomes in self._entries():
            super().enter(first, results, outcomes)
        self.stream.truncate(self.stream.tell())

    def _entries(self) -> "Iterator[tuple[int, np.ndarray, np.ndarray]]":
        """Those that are whole; leaves the stream behind the last of them."""
        import numpy as np

        runs, measures = self.results.shape
        width = 8 * measures + self.outcomes.itemsize
        place = self.stream.tell()
        while len(head := self.stream.read(_ENTRY.size)) == _ENTRY.size:
            first, count, check = _ENTRY.unpack(head)
            body = self.stream.read(count * width) if first + count <= runs else b""
            if not count or len(body) != count * width or zlib.crc32(body, zlib.crc32(head[:16])) != check:
                break
            results = np.frombuffer(body, dtype="<f8", count=count * measures).reshape(count, measures)
            yield first, results, np.frombuffer(body, dtype=outcome_type(), offset=8 * count * measures)
            place = self.stream.tell()
        self.stream.seek(place)

    def enter(self, first: int, results: "np.ndarray", outcomes: "np.ndarray") -> None:
        """The same, and appends them to the file with their check sum. Raises OSError."""
        if not len(outcomes):
            return
        body = results.astype("<f8").tobytes() + outcomes.tobytes()
        place = struct.pack("<QQ", first, len(outcomes))
        self._append(place + struct.pack("<I", zlib.crc32(body, zlib.crc32(place))) + body)
        super().enter(first, results, outcomes)

    def _append(self, data: bytes) -> None:
        try:
            self.stream.write(data)
            self.stream.flush()
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self.path)) from None

    def __enter__(self) -> "Journal":
        return self

    def __exit__(self, *rest: object) -> None:
        if not self.entered:  # nothing to go on with
            self.remove()
        with contextlib.suppress(OSError):
            self.stream.close()

    def remove(self) -> None:
        """The results are safe elsewhere."""
        self.stream.close()
        with contextlib.suppress(OSError):
            os.unlink(self.path)
