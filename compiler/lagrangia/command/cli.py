"""The command `lag`: what was asked, done; what goes wrong, told. A scene compiled before starts at once: see parser.py."""

import argparse
import atexit
import contextlib
import gc
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

from lagrangia.base.diagnostics import EngineWarning, InputWarning, LagError, RunError, RunWarning, render_all
from lagrangia.base.environment import environment_remarks
from lagrangia.base.folders import kept_remarks, remark, remarks_kept
from lagrangia.base.interruptions import INTERRUPTED, ended_as_by_control_c, is_ended
from lagrangia.base.search_path import searching_in
from lagrangia.base.spelling import plain_text, prepare_output
from lagrangia.command.idle_options import refuse_idle
from lagrangia.command.parser import WRONG, build_parser

DONE, FAILED = 0, 1
_RARELY = 50_000  # objects more than were freed: then cycles are looked for
_WITHOUT_MEMORY = ("std::bad_alloc", "failed to map segment", "Cannot allocate memory")  # in words of CasADi and of the system
_SLEEP_SOON = "4"  # threads of NumPy's OpenBLAS that have nothing to do: else they spin for 30 ms when it is imported


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit codes: 0 done, 1 the run failed, 2 the input is wrong, 130 interrupted."""
    gc.set_threshold(_RARELY)  # modules and what a scene is made of stay: a fortieth of a first answer went into looking at them
    atexit.register(gc.freeze)  # what ends with the process need not be searched for cycles
    prepare_output()
    os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", _SLEEP_SOON)
    words = sys.argv[1:] if arguments is None else arguments
    warnings.filterwarnings("ignore", category=RuntimeWarning)  # of NumPy: what is not finite is told in our words
    for told in (EngineWarning, InputWarning):  # so are these
        warnings.filterwarnings("ignore", category=told)
    with ended_as_by_control_c():
        return _execute(words)


def _execute(words: Sequence[str]) -> int:
    try:
        parsed = build_parser(*words[:1]).parse_args(words)  # what it imports may find no memory
        refuse_idle(parsed, parsed.parser.get_default)
        with remarks_kept(), searching_in(getattr(parsed, "path", [])), _failing_for_lost_runs():
            for text in environment_remarks():
                remark(text)
            code = int(parsed.command(parsed))
            _tell_rest(parsed)
        sys.stdout.flush()
        return code
    except LagError as error:
        print(render_all(error.diagnostics, _is_colored()), file=sys.stderr)
        return WRONG
    except RunError as error:
        print(f"error: {error}", file=sys.stderr)
        return FAILED
    except BrokenPipeError:
        _drop_output()
        return FAILED
    except KeyboardInterrupt:
        return _interrupted()
    except MemoryError:
        return _out_of_memory()
    except OSError as error:
        where = f"'{error.filename}': " if error.filename else ""
        print(plain_text(f"error: {where}{error.strerror or error}"), file=sys.stderr)
        _drop_output()
        return FAILED
    except Exception as error:
        if is_ended():
            return _interrupted()
        if any(words in str(error) for words in _WITHOUT_MEMORY):
            return _out_of_memory()
        try:
            return _refused(error) or _confess(error)
        except MemoryError:
            return _out_of_memory()


@contextlib.contextmanager
def _failing_for_lost_runs() -> Iterator[None]:
    """Commands that show runs end as `lag simulate` does where rows are no motion of the scene. Raises RunError."""
    found: dict[str, None] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("always", RunWarning)
        shown = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
            if issubclass(category, RunWarning):
                found[str(message)] = None
            else:
                shown(message, category, *where, **more)

        warnings.showwarning = show
        yield
    if found:
        raise RunError("\n".join(found))


def _tell_rest(parsed: argparse.Namespace) -> None:
    """Of commands that tell no warnings of a model. Raises LagError L0710."""
    if hasattr(parsed, "allow") and (kept := kept_remarks()):
        from lagrangia.command.arguments import tell_texts

        tell_texts(parsed, kept)


def _refused(error: Exception) -> int:
    """Where the C compiler could not do its work: no place for its files, an installation that lacks its headers."""
    from lagrangia.native.build import CompilerError

    if not isinstance(error, CompilerError):
        return DONE
    print(f"error: the C compiler refused\n{error}\n   = LAGRANGIA_CC names another one, or none", file=sys.stderr)
    return FAILED


def _interrupted() -> int:
    print("interrupted", file=sys.stderr)
    return INTERRUPTED


def _out_of_memory() -> int:
    print("error: not enough memory", file=sys.stderr)
    return FAILED


def _drop_output() -> None:
    """What could not be written is not tried again when the interpreter ends."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _confess(error: Exception) -> int:
    """What arrives here is a fault of the compiler, not of the model."""
    if os.environ.get("LAGRANGIA_TRACEBACK"):
        raise error
    print(f"bug: {type(error).__name__}: {error}", file=sys.stderr)
    print("This is a fault of lagrangia, not of your model. Please report it with the model;\n"
          "LAGRANGIA_TRACEBACK=1 shows where it happened.", file=sys.stderr)
    return FAILED


def _is_colored() -> bool:
    return sys.stderr.isatty() and "NO_COLOR" not in os.environ


if __name__ == "__main__":
    sys.exit(main())
