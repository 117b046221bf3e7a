"""Attributes of what moves in MJCF, by the elements that have them: others are misspelt, or newer than what is known here.

Source: https://mujoco.readthedocs.io/en/stable/XMLreference.html, whose names these are.
"""

from collections.abc import Iterator, Sequence

from lagrangia.base.diagnostics import suggest
from lagrangia.fmu.xmltree import Element

_PLACED = "name pos quat axisangle xyaxes zaxis euler user "
_KNOWN = {tag: frozenset(words.split()) for tag, words in {
    "body": _PLACED + "childclass mocap gravcomp sleep",
    "frame": _PLACED + "childclass",
    "inertial": _PLACED + "mass diaginertia fullinertia",
    "freejoint": "name group align",
    "joint": "name class type group pos axis springdamper limited actuatorfrclimited solreflimit solimplimit solreffriction "
             "solimpfriction stiffness range actuatorfrcrange actuatorgravcomp margin ref springref damping frictionloss "
             "armature user",
    "geom": _PLACED + "class type contype conaffinity condim group priority size material rgba friction mass density "
            "shellinertia solmix solref solimp margin gap fromto hfield mesh fitscale fluidshape fluidcoef plugin",
    "compiler": "autolimits boundmass boundinertia settotalmass balanceinertia strippath coordinate angle fitaabb eulerseq "
                "meshdir texturedir assetdir discardvisual usethread fusestatic inertiafromgeom exactmeshinertia alignfree "
                "inertiagrouprange saveinertial",
    "option": "timestep apirate impratio tolerance ls_tolerance noslip_tolerance ccd_tolerance sleep_tolerance mpr_tolerance "
              "gravity wind magnetic density viscosity o_margin o_solref o_solimp o_friction integrator cone jacobian solver "
              "iterations ls_iterations noslip_iterations ccd_iterations mpr_iterations sdf_iterations sdf_initpoints "
              "actuatorgroupdisable",
}.items()}
_HOLDERS = ("body", "frame", "default", "replicate")


def unknown_words(root: Element) -> Iterator[str]:
    """What is told of each attribute that nothing reads, in the order of the text."""
    for tag in ("compiler", "option"):
        for element in root.all(tag):
            yield from _of(element)
    for tag in ("default", "worldbody"):
        for element in root.all(tag):
            yield from _inside(element.children)


def _inside(elements: Sequence[Element]) -> Iterator[str]:
    """Of bodies, frames and classes and what is in them: <composite> and others have elements of these names with other words."""
    for element in elements:
        yield from _of(element)
        if element.tag in _HOLDERS:
            yield from _inside(element.children)


def _of(element: Element) -> Iterator[str]:
    known = _KNOWN.get(element.tag, element.attributes.keys())
    for name in element.attributes:
        if name not in known:
            meant = suggest(name, known)
            yield f"the attribute {name} of <{element.tag}>, which is unknown{f' ({meant})' if meant else ''}"
