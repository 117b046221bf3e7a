"""Expected texts kept in files: `pytest --update` writes them anew, to be read in the diff."""

import hashlib
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import lagrangia as lag
from helpers.kept_compilations import KeptCompilations
from lagrangia.base.memory import without_collections
from lagrangia.run.library import Runtime, start_runtime

Compare = Callable[[str, Path], None]

# A shell starts what it puts into the background with SIGINT ignored, nohup with SIGHUP, and so would be all that tests start.
for number in (signal.SIGINT, signal.SIGHUP):
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)


SLOW = Path(__file__).parent / "helpers" / "slow_tests.txt"
LONG = 0.3  # s


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update", action="store_true", help="write the expected texts anew")
    parser.addoption("--scenes", type=int, default=0, metavar="N", help="random scenes of tests/stress; 10000 before a release")
    parser.addoption("--note-slow", action="store_true", help=f"write {SLOW.name} anew: which tests took more than {LONG} s")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What took long when it was last noted is slow as well: `-m "not slow"` is for who waits for it.

    Of several processes none is to begin what takes longest when the others end."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=lambda item: item.get_closest_marker("slow") is None)
    known = set(SLOW.read_text(encoding="utf-8").splitlines())
    for item in items:
        if item.nodeid in known:
            item.add_marker(pytest.mark.slow)


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Iterator[object]:
    """Eleven thousand tests stay: looking for cycles among them takes a third as long as collecting them. They are not frozen:
    what asks whether anything is (`without_collections`, at every text and scene) would count them, 0.1 s each time."""
    with without_collections():
        return (yield)


class Durations:
    """Seconds of each test, from the reports of all processes."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration

    def pytest_sessionfinish(self) -> None:
        names = sorted(name for name, seconds in self.seconds.items() if seconds > LONG)
        SLOW.write_text("".join(f"{name}\n" for name in names), encoding="utf-8")


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(KeptCompilations(), "kept compilations")
    if config.getoption("--note-slow") and "PYTEST_XDIST_WORKER" not in os.environ:
        config.pluginmanager.register(Durations())


@pytest.hookimpl(optionalhook=True)  # of pytest-xdist
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Neighbours stay in one process, which compiles what they share once; one that is done early takes from the others' ends."""
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log) if config.getoption("dist") == "load" else None


@pytest.fixture
def compare(request: pytest.FixtureRequest) -> Compare:
    """Asserts that a text is the one kept in a file."""

    def check(text: str, file: Path) -> None:
        if request.config.getoption("--update"):
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        assert file.exists(), f"{file.name} is not there yet: pytest --update writes it"
        assert text == file.read_text(encoding="utf-8")

    return check


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Compiled scenes of the tests stay out of the cache of the person who runs them; processes that share the work share it.

    LAGRANGIA_TEST_CACHE names one that outlives the tests, for who changes a source and runs them again.
    """
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LAGRANGIA_CACHE", os.environ.get("LAGRANGIA_TEST_CACHE", str(shared / "cache")))
        yield


@pytest.fixture(scope="session")
def runtime() -> Runtime:
    """The C run time, compiled; for tests that are skipped where there is no C compiler."""
    return start_runtime()


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for caches that tests and processes share: the run time is compiled once for each other way to compile it."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "built"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(scope="session")
def shared_texts(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Path:
    """A folder for scenes that all processes read."""
    base = tmp_path_factory.getbasetemp()
    texts = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "texts"
    request.config.pluginmanager.get_plugin("kept compilations").texts = texts
    return texts


@pytest.fixture
def scene(request: pytest.FixtureRequest, tmp_path: Path, shared_texts: Path) -> Callable[[str], lag.Model]:
    """A scene from its text.

    The same text has the same place in all tests, so that what runs it by another solver, or to another tolerance, finds it
    compiled. It has one of its own where it may lie beside files of the test, or the test changes how it is compiled.
    """
    may_be_shared = "monkeypatch" not in request.fixturenames

    def write(text: str) -> lag.Model:
        path = tmp_path / "scene.lag"
        if may_be_shared and not any(tmp_path.iterdir()):
            path = shared_texts / hashlib.sha256(text.encode()).hexdigest() / path.name
        if path.parent == tmp_path or not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            written = tmp_path / "text"
            written.write_text(text, encoding="utf-8")
            written.replace(path)  # others may read it meanwhile
        return lag.load(path)

    return write
