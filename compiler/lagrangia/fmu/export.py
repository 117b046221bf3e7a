"""A compiled scene -> FMU: `export_fmu`. Equal input gives equal bytes, but for the date, which SOURCE_DATE_EPOCH sets."""

import contextlib
import hashlib
import io
import json
import os
import re
import time
import unicodedata
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path

from lagrangia.base.checked_values import by_name
from lagrangia.base.diagnostics import LagError, fail
from lagrangia.base.folders import data_folder
from lagrangia.base.records import dataclass
from lagrangia.base.result_files import Target, keep_apart
from lagrangia.base.search_path import search_path
from lagrangia.base.version import VERSION
from lagrangia.fmu.build import DARWIN, PLATFORMS, Platform, build_binaries, host_platform, read_platforms, universal
from lagrangia.fmu.exportable import Exportable
from lagrangia.fmu.page import license_text, write_page, write_terminals
from lagrangia.fmu.pictures import Icon, draw_graph, draw_icon
from lagrangia.fmu.source import scene_source, table_source
from lagrangia.fmu.stored import NAME as STORED
from lagrangia.fmu.stored import write_stored
from lagrangia.fmu.variables import FmuModel, build_fmu_model
from lagrangia.fmu.xml import About
from lagrangia.fmu.xml2 import write_fmi2
from lagrangia.fmu.xml3 import write_build_description, write_fmi3
from lagrangia.language.delays import refuse_delays
from lagrangia.native.prebuilt import find_fmu
from lagrangia.native.table_code import MOST_WRITTEN, are_long
from lagrangia.run.engines import compile_seconds, saved_seconds
from lagrangia.run.library import has_compiler
from lagrangia.run.rules import FMU_RUNS, Code, Moment, decide

VERSIONS = ("2", "3")
KINDS = ("me", "cs")
ENGINES = ("auto", "tape", "native")
INFO = ("author", "version", "copyright", "license")
EXTRA = "io.github.lagrangia"  # its folder in extra/
SCENE = "scene.json"  # in it: which model of which file was exported, and with what
_MOST_READABLE = 3  # coordinates of a scene whose equations are written out
_LONGEST_IDENTIFIER = 60
_TABLE = "scene_fmu.c"
_BUILDING = 0.5  # seconds for which zig compiles and links the smallest scene, when it has made the run time
_EARLIEST = (1980, 1, 1, 0, 0, 0)  # in an archive; files in it have no dates
_LEVEL = 4  # deflates in two thirds of the time of the usual 6, to 1.03 of its size
_VERSION_FILES = {"2": ("fmi2.c",), "3": ("fmi3.c", "fmi3_dependencies.c", "fmi3_unused.c", "fmi3_instance.h")}
# Of the run time: many runs, tables that Python reads, what it compares when it loads a library, what only the package's library
# for FMUs needs, what a page does and what compiles.
_UNUSED = ("batch.c", "batch.h", "read_numbers.c", "read_numbers.h", "reduce.c", "reduce.h", "layout.c", "layout.h", "stored.c",
           "image.c", "image.h", "play.c", "play.h", "arrange.c", "arrange.h", "hoist.c", "hoist.h", "numbering.c",
           "numbering.h", "batch_state.h", "follow.c", "follow.h", "run_lanes.c", "run_lanes.h", "wide_taylor.c",
           "wide_taylor.h", "wide_orders.c", "wide_orders.h", "wide_jet_tape.c", "wide_jet_tape.h", "wide_jets.h",
           "wide_scale.c", "wide_scale.h", "wide_steps.c", "wide_steps.h", "wide_explicit.c", "wide_explicit.h",
           "wide_power.h", "wide_attitudes.c", "wide_attitudes.h", "wide_roots.c", "wide_roots.h", "wide_starts.c",
           "wide_conditions.c", "wide_conditions.h", "lane_events.c", "lane_events.h",
           "wide_starts.h", "bare_runs.c", "bare_runs.h", "lanes_state.h", "lane_runs.c", "lane_runs.h")


@dataclass(frozen=True)
class Export:
    """What is wanted of an FMU. `info`: author, version, copyright, license; `outputs` are among those of the model already;
    `engine`: "tape": this machine's binary is the library that comes with the package, and the scene a file, "native": the scene
    is compiled, "auto": what costs less time. Without `arrays` FMI 3 has scalars, as FMI 2 does, for importers that know no
    others."""

    version: str = "2"
    kinds: tuple[str, ...] = KINDS
    platforms: tuple[str, ...] = ()
    sources: bool = True
    parameters: Mapping[str, float] = field(default_factory=dict)
    info: Mapping[str, str] = field(default_factory=dict)
    engine: str = "native"
    arrays: bool = True


@dataclass(frozen=True)
class Extras:
    """What an FMU carries beside the model: icon, component graph (SVG), equations (text), files of its own folder."""

    icon: Icon
    graph: str
    equations: str
    files: Mapping[str, bytes]


def export_fmu(model: Exportable, wanted: Export, path: Path, tell: Callable[[str], None] | None = None) -> None:
    """Writes one archive. Raises LagError."""
    described = build_fmu_model(model, wanted.parameters)
    with Target(path, binary=True) as target:
        target.stream.write(archive(described, wanted, build_extras(model, described), tell))


def export_fmus(
    model: Exportable, path: str | os.PathLike[str] | None, fmi: str | int, kind: str, platforms: str, sources: bool,
    parameters: Mapping[str, float] | None, info: Mapping[str, str] | None, engine: str, arrays: bool,
    tell: Callable[[str], None] | None,
) -> list[Path]:
    """One archive for each version, from one description of the scene. Raises LagError."""
    versions = VERSIONS if isinstance(fmi, str) and fmi == "both" else read_choice(fmi, VERSIONS, "version of FMI")
    kinds = _possible(model, read_choice(kind, KINDS, "kind of FMU"))
    chosen = read_platforms(platforms)
    (asked,) = read_choice(engine, ENGINES, "engine of an FMU")
    if asked == "tape" and chosen != (host_platform(),):
        fail("L0706", "only this machine's binary runs tapes: others are compiled", None, "leave --engine or --platforms out")
    if platforms != "host" and asked == "auto":
        asked = "native"  # others are meant, too
    wanted = Export("", kinds, chosen, sources, parameters or {}, _checked_info(info), asked, arrays)
    described = build_fmu_model(model, wanted.parameters)
    extras = build_extras(model, described)
    name = f"{identifier_of(model.scene.name)}.fmu"
    target = Path(name) if path is None else Path(path, name) if os.path.isdir(path) else Path(path)
    both = {version: target.with_name(f"{target.stem}_fmi{version}{target.suffix or '.fmu'}") for version in versions}
    keep_apart([target, *both.values()], [model.path, *model.scene.notes["files"]])
    written = []
    for version in versions:
        here = target if len(versions) == 1 else both[version]
        content = archive(described, replace(wanted, version=version), extras, tell)
        with Target(here, binary=True) as opened:
            opened.stream.write(content)
        written.append(here)
    return written


def _possible(model: Exportable, kinds: tuple[str, ...]) -> tuple[str, ...]:
    """The kinds that the scene can be. Raises LagError L0901."""
    if model.compilation.flat.delays and kinds == ("me",):
        refuse_delays(model.compilation.flat, "an FMU for Model Exchange", "an importer's integrator keeps no past of its steps; "
                      "Co-Simulation does: --kind cs")
    return ("cs",) if model.compilation.flat.delays else kinds


def _checked_info(info: Mapping[str, str] | None) -> Mapping[str, str]:
    found = by_name("info", info)
    for name, text in found.items():
        if name not in INFO:
            fail("L0706", f"the info of an FMU has no '{name}'", None, f"it has {', '.join(INFO)}")
        if not isinstance(text, str):
            fail("L0706", f"the {name} of an FMU must be a text, not {text!r}"[:200])
    return found


def archive(described: FmuModel, wanted: Export, extras: Extras, tell: Callable[[str], None] | None = None) -> bytes:
    """The bytes of an FMU. Raises LagError L0706 where nothing would be in it."""
    described = described if wanted.arrays else replace(described, arrays=())
    scene = described.scene
    identifier = identifier_of(scene.name)
    sources = _sources(described, wanted.version)
    names = tuple(sorted(name for name in sources if name.endswith(".c")))
    content = hashlib.sha256(repr((sorted(sources.items()), list(described.variables), described.arrays, described.dependencies,
                                   VERSION, wanted.kinds)).encode()).hexdigest()
    token = f"{{{content[:8]}-{content[8:12]}-{content[12:16]}-{content[16:20]}-{content[20:32]}}}"
    sources[_TABLE] = _side_by_side(table_source(described, token))
    library = _shipped(described, wanted)
    if are_long(scene.tables) and (library is None or wanted.sources):
        fail("L0901", "not supported yet: an FMU that is compiled, or has its sources, of tables with more than "
             f"{MOST_WRITTEN} numbers in all", None, "a binary for this machine alone reads them: --engine tape --no-sources")
    binaries = build_binaries(identifier, sources, wanted.platforms, tell) if library is None else library
    if not binaries and not wanted.sources:
        fail("L0706", "an FMU without binaries and without sources cannot be used", None, "leave one of the two options out")
    listed = names if wanted.sources else ()
    about = About(token, identifier, wanted.kinds, listed, f"Lagrangia {VERSION}", _date(), wanted.info)
    write = write_fmi2 if wanted.version == "2" else write_fmi3
    files: dict[str, bytes] = {"modelDescription.xml": write(described, about).encode()}
    if wanted.version == "2" and all(name in binaries for name in DARWIN):
        binaries[DARWIN[0]] = universal([binaries[name] for name in DARWIN])
    for name, binary in binaries.items():
        files[f"binaries/{_folder(PLATFORMS[name], wanted.version)}/{identifier}{PLATFORMS[name].suffix}"] = binary
    if library is not None:
        files[f"resources/{STORED}"] = write_stored(described, token)
    if wanted.sources:
        files |= {f"sources/{name}": text.encode() for name, text in sources.items()}
        files["sources/buildDescription.xml"] = write_build_description(wanted.version, identifier, names).encode()
    files |= _documents(described, about, wanted, extras)
    return zipped(files)


def _shipped(described: FmuModel, wanted: Export) -> dict[str, bytes] | None:
    """The library that came with the package, for this machine's platform; None where the scene is to be compiled. Raises
    LagError L0706 where it was asked for and is not there."""
    host = host_platform()
    if wanted.engine == "native" or host is None or wanted.platforms != (host,):
        return None
    library = find_fmu(data_folder("runtime"), wanted.version)
    saved = saved_seconds(described.scene, FMU_RUNS * described.evaluations)
    facts = {"is_shipped": library is not None, "saved": saved, "compiling": _BUILDING + compile_seconds(described.scene),
             "has_compiler": wanted.engine == "auto" and has_compiler()}
    if decide(Moment.BINARY, facts).takes is Code.TAPE and library is not None:
        return {host: library.read_bytes()}
    if wanted.engine == "tape":
        fail("L0706", "no library for FMUs came with the package: it can only compile them", None,
             "leave --engine out, or install lagrangia where there is a C compiler")
    return None


def _documents(described: FmuModel, about: About, wanted: Export, extras: Extras) -> dict[str, bytes]:
    """All that people look at, and the model's source."""
    has_windows = any(PLATFORMS[name].suffix == ".dll" for name in wanted.platforms)
    files = {"documentation/index.html": write_page(described, about, extras.equations, extras.graph).encode(),
             "documentation/licenses/license.txt": license_text(about, has_windows).encode()}
    if wanted.version == "2":
        files["model.png"] = extras.icon.png
    else:
        files |= {"terminalsAndIcons/icon.png": extras.icon.png, "terminalsAndIcons/icon.svg": extras.icon.svg,
                  "terminalsAndIcons/terminalsAndIcons.xml": write_terminals(described).encode()}
    return files | {f"extra/{EXTRA}/{name}": content for name, content in extras.files.items()}


def build_extras(model: Exportable, described: FmuModel) -> Extras:
    """Pictures, equations when the scene is small, the .lag files, the CasADi functions."""
    import casadi as ca

    files, equations = model_files(model), ""
    flat = model.compilation.flat
    if not (flat.samplers or flat.delays):  # whose accelerations the state alone does not tell
        functions = ca.StringSerializer()
        functions.pack(list(model.functions().values()))
        files = {"functions.casadi": functions.encode().encode()} | files
    if described.scene.n <= _MOST_READABLE:
        with contextlib.suppress(LagError):
            equations = model.equations()
    return Extras(draw_icon(model, described.state_start), draw_graph(model.compilation), equations, files)


def model_files(model: Exportable) -> dict[str, bytes]:
    """The .lag files and their tables, as they lie to each other so that they find each other, and what to compile of them."""
    names = (str(model.path), *model.compilation.flat.read, *model.scene.notes["files"])
    places = {Path(name).resolve(): Path(name).read_bytes() for name in names}
    base = os.path.commonpath([place.parent for place in places])
    files = {place.relative_to(base).as_posix(): content for place, content in places.items()}
    scene = {"file": model.path.resolve().relative_to(base).as_posix(), "model": model.model,
             "path": [folder.resolve().relative_to(base).as_posix() for folder in search_path()
                      if folder.resolve().is_relative_to(base)],
             "structural": dict(model.structural), "outputs": list(model.outputs)}
    return files | {SCENE: (json.dumps(scene, indent=2, sort_keys=True) + "\n").encode()}


def _folder(platform: Platform, version: str) -> str:
    return platform.fmi2 if version == "2" else platform.fmi3


def identifier_of(name: str) -> str:
    """A C identifier for a model's name; names that are none, or too long, keep apart by a hash."""
    plain = unicodedata.normalize("NFKD", name.strip("'")).encode("ascii", "ignore").decode()
    identifier = re.sub(r"\W+", "_", plain).strip("_") or "model"
    if not identifier[0].isalpha():
        identifier = f"m_{identifier}"
    if identifier == name and len(name) <= _LONGEST_IDENTIFIER:
        return name
    return f"{identifier[:_LONGEST_IDENTIFIER]}_{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def _sources(described: FmuModel, version: str) -> dict[str, str]:
    """All C files of an FMU, side by side in one folder: the run time's, the scene, and the table of an FMU without a token."""
    others = {name for key, names in _VERSION_FILES.items() if key != version for name in names}
    files = [file for file in data_folder("runtime").rglob("*.[ch]")
             if file.name not in others | set(_UNUSED) and file.parent.name != "standard"]
    found = {file.name: file.read_text(encoding="utf-8") for file in files}
    found["scene.c"] = scene_source(described)
    found[_TABLE] = table_source(described, token="")
    return {name: _side_by_side(text) for name, text in sorted(found.items())}


def _side_by_side(text: str) -> str:
    """C with all headers in the same folder: file names are unique."""
    return re.sub(r'^#include "\w+/(\w+\.h)"$', r'#include "\1"', text, flags=re.MULTILINE)


def _date() -> str:
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    seconds = float(epoch) if epoch and epoch.isdigit() else time.time()
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(seconds))


def zipped(files: Mapping[str, bytes]) -> bytes:
    """An archive that every importer can open: deflated, no dates, no links, names in ASCII, the description first."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, allowZip64=False) as archived:
        for name in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
            entry = zipfile.ZipInfo(name, _EARLIEST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archived.writestr(entry, files[name], compresslevel=_LEVEL)
    return buffer.getvalue()


def read_choice(given: object, known: Sequence[str], what: str) -> tuple[str, ...]:
    """Names between commas, or a number that is one. Raises LagError L0706."""
    chosen = tuple(dict.fromkeys(part.strip() for part in str(given).split(",") if part.strip()))
    for name in chosen:
        if name not in known:
            fail("L0706", f"there is no {what} '{name}'", None, f"there are {', '.join(known)}")
    if not chosen:
        fail("L0706", f"no {what} is chosen", None, f"there are {', '.join(known)}")
    return chosen
