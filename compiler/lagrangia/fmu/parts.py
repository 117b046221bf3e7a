"""Rules for the parts of an FMU beside its variables: interface flags, sources, binaries, terminals."""

import re
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import PurePosixPath

from lagrangia.base.diagnostics import Diagnostic, LagError, Severity
from lagrangia.fmu.archive import Archive
from lagrangia.fmu.binary import Library, read_library
from lagrangia.fmu.description import INTERFACES, Description
from lagrangia.fmu.xmltree import Element

FLAGS, SOURCES, BINARIES, TERMINALS = "L0735", "L0736", "L0737", "L0738"
BUILD = "sources/buildDescription.xml"
_COMMON = {"modelIdentifier", "needsExecutionTool", "canBeInstantiatedOnlyOncePerProcess"}
_FLAGS = {  # of each version; both interfaces together
    "2": _COMMON | {"canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate", "canSerializeFMUstate",
                    "providesDirectionalDerivative", "completedIntegratorStepNotNeeded", "canHandleVariableCommunicationStepSize",
                    "canInterpolateInputs", "maxOutputDerivativeOrder", "canRunAsynchronuously"},
    "3": _COMMON | {"canGetAndSetFMUState", "canSerializeFMUState", "providesDirectionalDerivatives",
                    "providesAdjointDerivatives", "providesPerElementDependencies", "needsCompletedIntegratorStep",
                    "providesEvaluateDiscreteStates", "canHandleVariableCommunicationStepSize", "fixedInternalStepSize",
                    "maxOutputDerivativeOrder", "recommendedIntermediateInputSmoothness", "providesIntermediateUpdate",
                    "mightReturnEarlyFromDoStep", "canReturnEarlyAfterIntermediateUpdate", "hasEventMode"},
}
_HEADERS = ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h", "fmi3Functions.h", "fmi3FunctionTypes.h",
            "fmi3PlatformTypes.h", "fmiFunctions.h", "fmiModelFunctions.h", "fmiPlatformTypes.h")
_SUFFIX = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}
_FMI2_FOLDERS = {"linux64": ("x86_64", "linux"), "linux32": ("x86", "linux"), "win64": ("x86_64", "windows"),
                 "win32": ("x86", "windows"), "darwin64": ("x86_64", "darwin"), "darwin32": ("x86", "darwin")}
_TUPLE = re.compile(r"(aarch32|aarch64|riscv32|riscv64|x86|x86_64|ppc32|ppc64)-(linux|windows|darwin)(-\w+)?")
_OF_THE_SYSTEM = {
    "linux": ("libc.so*", "libm.so*", "libpthread.so*", "libdl.so*", "librt.so*", "ld-linux*", "libgcc_s.so*", "libstdc++.so*"),
    "windows": tuple(f"{name}.dll" for name in (
        "kernel32", "user32", "advapi32", "msvcrt", "ucrtbase", "api-ms-win-*", "ntdll", "ws2_32", "shell32", "ole32", "oleaut32",
        "shlwapi", "bcrypt", "gdi32", "version", "dbghelp", "psapi", "winmm")),
    "darwin": ("/usr/lib/*", "/System/*", "@rpath/*", "@loader_path/*"),
}
_NEWEST_GLIBC = 28  # of Debian 10 and Red Hat 8
_LARGEST_BINARY = 1 << 30


def part_rules(archive: Archive, description: Description) -> Iterator[Diagnostic]:
    """Faults of what lies in the archive beside the description: flags, sources, binaries, terminals."""
    yield from _flag_rules(description)
    yield from _source_rules(archive, description)
    yield from _binary_rules(archive, description)
    yield from _terminal_rules(archive, description)


def _fault(code: str, message: str, *hints: str, severity: Severity = "error") -> Diagnostic:
    return Diagnostic(severity, code, message, None, "", hints)


# -------------------------------------------------------------------- flags


def _flag_rules(description: Description) -> Iterator[Diagnostic]:
    own, other = _FLAGS[description.version], _FLAGS["3" if description.version == "2" else "2"]
    if not description.interfaces:
        yield description.root.fault(FLAGS, "neither Model Exchange nor Co-Simulation is offered")
    for interface in (element for tag in INTERFACES for element in description.root.all(tag)):
        for name in interface.attributes:
            if name in own or ":" in name:
                continue
            spelled = {known.lower().rstrip("s"): known for known in own}.get(name.lower().rstrip("s"))
            if name in other or spelled:
                hint = f"write {spelled}" if spelled else "this version has nothing of the kind"
                yield interface.fault(FLAGS, f"'{name}' is the spelling of FMI {'3' if description.version == '2' else '2'}, and "
                                      f"has no effect in FMI {description.version}", name, hint)
            else:
                yield interface.fault(FLAGS, f"'{name}' is no attribute of <{interface.tag}>", name, severity="warning")
        identifier = interface.get("modelIdentifier") or ""
        if not re.fullmatch(r"[A-Za-z_]\w*", identifier, re.ASCII):
            yield interface.fault(FLAGS, f"'{identifier}' is no C identifier", "modelIdentifier")
        if _is_set(interface, "canSerializeFMU") and not _is_set(interface, "canGetAndSetFMU"):
            yield interface.fault(FLAGS, "states are said to be serialised, but not to be got and set", severity="warning")
    experiment = description.root.first("DefaultExperiment")
    if experiment is not None:
        yield from _experiment_rules(experiment)


def _is_set(element: Element, start: str) -> bool:
    return any(value in ("true", "1") for name, value in element.attributes.items() if name.startswith(start))


def _experiment_rules(experiment: Element) -> Iterator[Diagnostic]:
    def number(name: str, usual: float) -> float:
        try:
            return float(experiment.get(name) or usual)
        except ValueError:
            return usual

    if number("stopTime", float("inf")) < number("startTime", 0.0):
        yield experiment.fault(FLAGS, "the experiment stops before it starts", "stopTime")
    for name in ("tolerance", "stepSize"):
        if number(name, 1.0) <= 0:
            yield experiment.fault(FLAGS, f"the {name} of the experiment is not positive", name)


# -------------------------------------------------------------------- sources


def _source_rules(archive: Archive, description: Description) -> Iterator[Diagnostic]:
    for interface in description.interfaces.values():
        yield from _files_are_there(archive, interface.all("SourceFiles", "File"))
    for name in sorted(archive.names):
        if name.startswith("sources/") and PurePosixPath(name).name in _HEADERS:
            yield _fault(SOURCES, f"'{name}' is a header of the standard, which importers bring themselves", "leave it out: with "
                         "another version of it the sources do not compile", severity="warning")
    if BUILD not in archive.names:
        has_sources = any(name.startswith("sources/") and name.endswith((".c", ".cpp")) for name in archive.names)
        if has_sources and description.version == "3":
            yield _fault(SOURCES, f"there are sources, and no {BUILD} that says how to compile them")
        return
    try:
        build = archive.read_xml(BUILD)
    except LagError as error:
        yield from error.diagnostics
        return
    yield from _build_rules(archive, build, description)


def _build_rules(archive: Archive, build: Element, description: Description) -> Iterator[Diagnostic]:
    stated, wanted = build.get("fmiVersion") or "", description.root.get("fmiVersion") or ""
    if description.version == "3" and stated != wanted:  # FMI 2 has taken the file over from FMI 3: schemas.py
        yield build.fault(SOURCES, f"it is for FMI '{stated}', and {archive.path.name} is of '{wanted}'", "fmiVersion")
    known = {interface.get("modelIdentifier") for interface in description.interfaces.values()}
    for configuration in build.all("BuildConfiguration"):
        identifier = configuration.get("modelIdentifier")
        if identifier not in known:
            yield configuration.fault(SOURCES, f"no interface is called '{identifier}'", "modelIdentifier",
                                      f"the description has {', '.join(sorted(filter(None, known)))}")
        yield from _files_are_there(archive, configuration.all("SourceFileSet", "SourceFile"))
        for folder in configuration.all("SourceFileSet", "IncludeDirectory"):
            inside = f"sources/{PurePosixPath(folder.get('name') or '.')}/".replace("/./", "/")
            if not any(name.startswith(inside) for name in archive.names):
                yield folder.fault(SOURCES, f"there is no folder '{inside}'", "name")


def _files_are_there(archive: Archive, files: Iterator[Element]) -> Iterator[Diagnostic]:
    for file in files:
        name = f"sources/{file.get('name') or ''}"
        if name not in archive.names:
            yield file.fault(SOURCES, f"there is no file '{name}'", "name", "who compiles the FMU needs it")


# -------------------------------------------------------------------- binaries


def _binary_rules(archive: Archive, description: Description) -> Iterator[Diagnostic]:
    files = sorted(name for name in archive.names if name.startswith("binaries/") and name.count("/") >= 2)
    folders = list(dict.fromkeys(name.split("/")[1] for name in files))
    identifiers = sorted({i.get("modelIdentifier") or "" for i in description.interfaces.values()})
    if not folders and not any(name.startswith("sources/") for name in archive.names):
        yield _fault(BINARIES, "there are neither binaries nor sources: nothing can run it")
    for folder in folders:
        platform = _platform(folder, description.version)
        if platform is None:
            yield from _unknown_folder(folder, description.version)
            continue
        for identifier in identifiers:
            name = f"binaries/{folder}/{identifier}{_SUFFIX[platform[1]]}"
            if name not in archive.names:
                yield _fault(BINARIES, f"there is no '{name}'", "importers look for the model identifier and the system's suffix")
                continue
            try:
                content = archive.read(name, _LARGEST_BINARY)
            except LagError as error:
                yield from error.diagnostics
                continue
            yield from _library_rules(name, content, platform, archive, description)


def _platform(folder: str, version: str) -> tuple[str, str] | None:
    """Processor and system."""
    if version == "2" and folder in _FMI2_FOLDERS:
        return _FMI2_FOLDERS[folder]
    match = _TUPLE.fullmatch(folder)
    return (match[1], match[2]) if match else None


def _unknown_folder(folder: str, version: str) -> Iterator[Diagnostic]:
    if version == "3" and folder in _FMI2_FOLDERS:
        yield _fault(BINARIES, f"'binaries/{folder}' is the spelling of FMI 2", f"write {'-'.join(_FMI2_FOLDERS[folder])}")
    else:
        yield _fault(BINARIES, f"no importer knows the platform 'binaries/{folder}'", severity="warning")


def _library_rules(name: str, content: bytes, platform: tuple[str, str], archive: Archive,
                   description: Description) -> Iterator[Diagnostic]:
    library = read_library(content)
    processor, system = platform
    if library is None:
        yield _fault(BINARIES, f"'{name}' is no shared library that could be loaded")
        return
    if library.system != system or processor not in library.processors:
        yield _fault(BINARIES, f"'{name}' is made for {' and '.join(library.processors)}-{library.system}")
        return
    yield from _need_rules(name, library, archive)
    if system != "darwin":  # there, names of functions are packed
        prefix = f"fmi{description.version}".encode()
        wanted = {"me": b"SetContinuousStates", "cs": b"DoStep"}
        for function in (b"GetVersion", b"FreeInstance", *(wanted[k] for k in description.interfaces if k in wanted)):
            if prefix + function + b"\0" not in content:
                yield _fault(BINARIES, f"'{name}' has no function {(prefix + function).decode()}")


def _need_rules(name: str, library: Library, archive: Archive) -> Iterator[Diagnostic]:
    folder = name.rpartition("/")[0]
    beside = {PurePosixPath(other).name.lower() for other in archive.names if other.startswith(f"{folder}/")}
    for need in library.needs:
        known = any(fnmatch(need.lower(), pattern.lower()) for pattern in _OF_THE_SYSTEM[library.system])
        if not known and PurePosixPath(need).name.lower() not in beside:
            yield _fault(BINARIES, f"'{name}' needs {need}, which is not in the FMU",
                         "link it statically, or put it beside the binary", severity="warning")
    if library.glibc is not None and library.glibc > _NEWEST_GLIBC:
        yield _fault(BINARIES, f"'{name}' needs glibc 2.{library.glibc}",
                     "older systems cannot load it: build it for an older one", severity="warning")


# -------------------------------------------------------------------- terminals


def _terminal_rules(archive: Archive, description: Description) -> Iterator[Diagnostic]:
    name = "terminalsAndIcons/terminalsAndIcons.xml"
    if name not in archive.names:
        return
    try:
        root = archive.read_xml(name)
    except LagError as error:
        yield from error.diagnostics
        return
    waiting = list(root.all("Terminals", "Terminal"))
    while waiting:
        terminal = waiting.pop()
        waiting += terminal.all("Terminal")
        for member in terminal.children:
            named = member.get("variableName")
            if member.tag.endswith("Variable") and named is not None and named not in description.by_name:
                yield member.fault(TERMINALS, f"the terminal '{terminal.get('name')}' names '{named}', which is no variable",
                                   "variableName")
