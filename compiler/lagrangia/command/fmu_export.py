"""`lag export --to fmu`: options -> archives."""

import sys
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.command.arguments import assignments, load_given, load_model, names_once, refuse_idle_sharing
from lagrangia.native.build import CompilerError
from lagrangia.run.scene import ALL_REACTIONS
from lagrangia.view.statics import tells_reactions

if TYPE_CHECKING:
    from lagrangia.model import Model

OPTIONS = ("fmi", "kind", "platforms", "sources", "engine", "arrays")  # of export_fmu, under their names there


def export_fmu_command(options: Namespace) -> int:
    """`lag export --to fmu`: writes the FMU of a scene. Raises LagError."""
    if options.output == "-":
        fail("L0704", "an FMU is no text: it cannot go to standard output", None, "give a file with -o")
    outputs = names_once(options.outputs, "--outputs")
    model, parameters = load_given(options, outputs)
    if tells_reactions(model.scene):
        model = load_model(options, assignments(options.parameter, "-p"), (*outputs, ALL_REACTIONS))
    refuse_idle_sharing(model)
    info = dict(assignments(options.info, "--info"))
    if options.output is None:
        _keep_others(model.scene.name, ("_fmi2", "_fmi3") if options.fmi == "both" else ("",))
    if options.arrays is not None and options.fmi not in ("3", "both"):
        fail("L0704", "FMI 2 has no arrays: --arrays and --no-arrays change nothing", None, "they are for --fmi 3 and --fmi both")
    try:
        chosen = {name: value for name in OPTIONS if (value := getattr(options, name)) is not None}
        written = model.export_fmu(options.output, **chosen, parameters=parameters, info=info, tell=_tell)
    except CompilerError as error:
        raise RunError(f"the C compiler refused\n{error}") from None
    for path in written:
        print(_summary(model, path))
        if path.suffix.lower() != ".fmu":
            _tell(f"'{path}' is an FMU: importers, as lag simulate, know these by names that end in .fmu")
    return 0


def _keep_others(name: str, endings: Iterable[str]) -> None:
    """Raises LagError L0004 where nobody named a file and the usual one is no FMU of ours."""
    import zipfile

    from lagrangia.fmu.export import identifier_of

    for path in (Path(f"{identifier_of(name)}{ending}.fmu") for ending in endings):
        if not path.is_file():
            continue
        try:
            with zipfile.ZipFile(path) as archive, archive.open("modelDescription.xml") as stream:
                is_ours = b'generationTool="Lagrangia' in stream.read(2000)
        except (OSError, KeyError, ValueError, NotImplementedError, zipfile.BadZipFile):
            is_ours = False
        if not is_ours:
            fail("L0004", f"'{path}' is there already, and no FMU that Lagrangia wrote: it is kept", None,
                 f"-o {path} writes over it; another name after -o keeps it")


def _tell(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _summary(model: "Model", path: Path) -> str:
    import zipfile

    from lagrangia.fmu.stored import NAME as STORED

    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
    binaries = sorted(name.split("/")[1] for name in names if name.startswith("binaries/"))
    tape = " (tape)" if f"resources/{STORED}" in names else ""
    scene, size = model.scene, path.stat().st_size / 1024
    return (f"{path}: {scene.name}, {scene.n + len(scene.told_positions)} states, {len(scene.parameters)} parameters, "
            f"{len(scene.inputs)} inputs, {len(scene.own_outputs)} outputs; {', '.join(binaries) or 'no binaries'}{tape}; "
            f"{size:.0f} kB")
