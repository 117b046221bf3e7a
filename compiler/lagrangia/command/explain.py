"""`lag explain`: what a scene needs, and how it is run."""

from argparse import Namespace

from lagrangia.base.spelling import plain_text
from lagrangia.command.arguments import load_given
from lagrangia.run.request import check_parameters, check_values


def explain_command(options: Namespace) -> int:
    """The scene with the parameters given, as it would be run."""
    from lagrangia.needs.table import find_needs
    from lagrangia.study.casadi_solvers import casadi_refusal
    from lagrangia.study.explain import as_json, as_text, chosen_for, without_compiler

    model, parameters = load_given(options)
    values = check_values(model.scene, parameters)
    c = model.compilation
    scene = model.scene
    if model.engine is None:
        scene = without_compiler(scene, (casadi_refusal(c) or ("",))[0])
    numbers = c.functions.table["parameters"](values.parameters, values.mask)
    check_parameters(model.scene, numbers.elements())
    needs = find_needs(c.kinematics, c.constraints, c.energies, c.run, c.initial, scene, numbers)
    print(plain_text((as_json if options.json else as_text)(scene, needs, chosen_for(scene, model.engine))))
    return 0
