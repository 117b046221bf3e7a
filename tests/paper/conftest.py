"""Pages of one scene share its derivation: most of the time of this room's tests went into deriving the same equations again."""

from collections.abc import Iterator

import pytest

from lagrangia.paper import sheet


def source(path, model, structural, given):
    """What a scene is read from, and its values."""
    return (path, path.stat().st_mtime_ns if path.exists() else 0, model, tuple(sorted((structural or {}).items())),
            repr(sorted((given or {}).items())))


@pytest.fixture(scope="session", autouse=True)
def shared_derivations() -> Iterator[None]:
    """The four expensive steps of a page are remembered by what they are made of."""
    known: dict[object, object] = {}
    compile_energies, build_symbolic, derive, start_of = (
        sheet.compile_energies, sheet.build_symbolic, sheet.derive, sheet.start_of)

    def started(parameters, path, model=None, structural=None, angles=""):
        key = "start", source(path, model, structural, parameters), angles
        if key not in known:
            known[key] = start_of(parameters, path, model, structural, angles)
        return known[key]

    def compiled(path, model=None, structural=None, given=None, has_angles=False, has_quaternions=False):
        key = source(path, model, structural, given), has_angles, has_quaternions
        if key not in known:
            known[key] = compile_energies(path, model, structural, given, has_angles, has_quaternions)
        return known[key]

    def symbolic(kinematics, constraints, is_small=False, angles="", is_signed=False):
        if is_signed and not any(q.is_positive for q in symbolic(kinematics, constraints, is_small, angles).q):
            is_signed = False  # signs are the same
        key = id(kinematics), is_small, angles, is_signed
        if key not in known:
            known[key] = build_symbolic(kinematics, constraints, is_small, angles, is_signed), kinematics  # its id stays its own
        return known[key][0]

    def derived(scene, most_products, most_terms=None):
        key = id(scene), most_products, most_terms
        if key not in known:
            known[key] = derive(scene, most_products, most_terms), scene
        equations = known[key][0]
        equations.ring.products = 0  # each page has its own bound
        return equations

    with pytest.MonkeyPatch.context() as patch:
        for name, replacement in (("compile_energies", compiled), ("build_symbolic", symbolic), ("derive", derived),
                                  ("start_of", started)):
            patch.setattr(sheet, name, replacement)
        yield
