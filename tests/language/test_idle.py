"""What is declared and acts on nothing is pointed at; what is meant to be looked at is not."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
PULL = "model Pull Frame a, b; Force f; {more} end Pull; "\
       "model M PointMass p(m = 2), q(m = 3); Pull pull(a = p.center, b = q.center); end M;"
BLOCK = "model M Block b(m = 1, base = world); {} end M;"
ARRAY = "model M parameter Integer n = 1; Block b[n](each m = 1, each base = world); parameter Real k[{}; "\
        "AppliedForce f(at = b[1].center, force = {{{}, 0}}); end M;"
MATERIAL = "record D Real E; Real nu; end D; model M parameter Boolean on = false; parameter D d = D(2, 0.3); {} "\
           "Block b(m = d.E, base = world); end M;"
IDLE = {  # the text, and what is named
    "a force by an equation": (BLOCK.format("Force f; equation f = 3[N/m]*b.s;"), "force acts on nothing: nothing reads 'f'"),
    "a force by its declaration": (BLOCK.format("Force f = 3;"), "'f'"),
    "a torque": (BLOCK.format("Torque tau = 3*sin(1[rad/s]*time);"), "'tau'"),
    "a force in components": (BLOCK.format("Force f[2] = {1, 2};"), "'f'"),
    "the last of a chain": (BLOCK.format("Force f = 3; Force g = -f;"), "'g'"),
    "a chain that ends in a number": (BLOCK.format("Force f, z; Real y; equation f = 3[N/m]*b.s; z = 2*f; y = z/1[N];"),
                                      "nothing reads 'y', which reads 'z'"),
    "in a component of one's own": (PULL.format(more="equation f = 5[N/m]*distance(a, b);"), "'pull.f'"),
    "an input": (BLOCK.format("input Force u;"), "nothing reads the input 'u'"),
    "one force of several": (BLOCK.format("Force f[3] = {1, 2, 3}; "
                            "AppliedForce p(at = b.center, force = {f[1] + f[3], 0});"),
                             "nothing reads 'f[2]'"),
    "one that a loop gives": (BLOCK.format("Force f[2]; AppliedForce p(at = b.center, force = {f[2], 0}); "
                                           "equation for i in 1:2 loop f[i] = i*b.s*1[N/m]; end for;"), "nothing reads 'f[1]'"),
    "elements of parameters": (BLOCK.format("parameter Force f[2,3] = {{1, 2, 3}, {4, 5, 6}}; AppliedForce p(at = b.center, "
                                            "force = {f[1,2] + sum(f[2]), 0});"),
                               "nothing reads the parameter 'f[1,1]', 'f[1,3]'"),
    "elements of inputs": (BLOCK.format("input Force u[5]; AppliedForce p(at = b.center, force = {u[5], 0});"),
                           "the input 'u[1]', 'u[2]', 'u[3]' and 1 more"),
    "of a record": ("record D Mass m; Length L; end D; model M parameter D d = D(m = 2, L = 3); Block b(m = d.m, base = world); "
                    "end M;", "nothing reads 'L' of D 'd'"),
    "of a record, by its place": ("record D Mass m; Length L = 1; end D; model C parameter D d; Block b(m = d.m, "
                                  "base = world); end C; model M C c(d = D(2, 3)); end M;", "nothing reads 'L' of D 'c.d'"),
    "of a record in a record": ("record D Mass m; Length L = 1; end D; record E D d; end E; model M "
                                "parameter E e = E(D(2, L = 3)); Block b(m = e.d.m, base = world); end M;",
                                "nothing reads 'L' of D 'e.d'"),
    "of a material, read nowhere": ("record D Real E; Real nu; end D; model M parameter D d = D(2, 0.3); Block b(m = d.E, "
                                    "base = world); end M;", "nothing reads 'nu' of D 'd'"),
    "a number beside what is looked at": (
        "record Bus Real x; Real y; end Bus; model M Block b(m = 1, base = world); Bus u(x = b.s/1[m], y = 20); end M;",
        "nothing reads 'y' of Bus 'u'"),
    "by a loop over numbers": (ARRAY.format("3] = {1, 2, 3}", "sum(k[i] for i in 1:2)"), "'k[3]'"),
    "behind what is read": (ARRAY.format("3] = {1, 2, 3}", "k[1]"), "read what is left, or make the array smaller"),
    "before what is read": (ARRAY.format("3] = {1, 2, 3}", "k[3]"), "read what is left, or write 0 in its place"),
    "of values": ("type E = enumeration(low, high); " + ARRAY.format("E] = {1, 2}", "k[E.low]"), "or write 0 in its place"),
    "of a matrix": (ARRAY.format("2, 2] = [1, 2; 3, 0]", "k[1, 1]"), "'k[1,2]', 'k[2,1]'"),
    "a parameter": (BLOCK.format("parameter Length L = 2;"), "nothing reads the parameter 'L'"),
}
USED = {
    "it works": BLOCK.format("Force f = 3; AppliedForce push(at = b.center, force = {f, 0});"),
    "it works on something": PULL.format(more="equation f = 5[N/m]*distance(a, b); energy work -f on distance(a, b);"),
    "a chain that ends in a component": BLOCK.format(
        "Force f = 3; Real y = f/2[N]; AppliedForce push(at = b.center, force = {y*1[N], 0});"),
    "each of several": BLOCK.format("Force f[2] = {1, 2}; AppliedForce push(at = b.center, force = {sum(f), 0});"),
    "a record that is an output": "record D Mass m; Length L = 1; end D; model M Block b(m = 1, base = world); "
                                  "output D d = D(m = 2); end M;",
    "it is an output": BLOCK.format("output Force f = 3;"),
    "an output reads it": BLOCK.format("Force f = 3; output Power P = f*b.v;"),
    "a contact's": BLOCK.format("Stop s(gap = b.s); Force N = s.force;"),
    "a joint's": BLOCK.format("Force N = norm(b.reaction);"),
    "only to be looked at": BLOCK.format("Length x = 2*b.s; Energy E = b.m*b.v^2/2;"),
    "an input and a parameter that are read": BLOCK.format(
        "input Force u; parameter Real c = 2; AppliedForce push(at = b.center, force = {c*u, 0});"),
    "as long as it is": ARRAY.format("3] = {1, 2, 3}", "size(k, 1)"),
    "said at the end": BLOCK.format('parameter Real c = 2; equation when b.s > 1 then terminate("at " + String(c)); end when;'),
    "chosen by a parameter": ARRAY.format("3] = {1, 2, 3}", "k[n]"),
    "chosen by an expression": ARRAY.format("3] = {1, 2, 3}", "k[n + 1]"),
    "chosen by another array": ARRAY.format("3] = {1, 2, 3}; parameter Integer order[2] = {3, 1}", "k[order[n]]"),
    "a row of cases": ARRAY.format("3, 2] = [1, 2; 3, 4; 5, 6]", "sum(k[n])"),
    "as many as there are": ARRAY.format(":] = {1, 2, 3}", "sum(k[i] for i in 1:n)"),
    "chosen by a value": "type E = enumeration(low, high); " + ARRAY.format("E] = {1, 2}; parameter E e = E.low", "k[e]"),
    "zeros of a vector": ARRAY.format("3] = {0, 0, -9.81}", "k[3]"),
    "zeros of a matrix": ARRAY.format("2, 2] = [3, 0; 0, 2]", "k[1, 1] + k[2, 2]"),
    "one component of several":
        "model G parameter Real r = 1; Force f = 2[N/s]*time; end G; model M parameter Integer n = 2; G g[3](r = {1, 2, 3}); "
        "Block b(m = 1, base = world); AppliedForce a(at = b.center, force = {g[n].r*g[n].f, 0}); end M;",
    "one record of several": "record D Real E; Real nu; end D; " + ARRAY.format(
        "1] = {1}; parameter D d[2] = {D(1, 2), D(3, 4)}; parameter Boolean on = false",
        "k[1]*d[n].E*(if on then d[n].nu else 1)"),
    "in a branch": MATERIAL.format("Spring s(k = if on then 1/(1 + d.nu) else 3, stretch = b.s);"),
    "in what is not there": MATERIAL.format("Spring s(k = d.nu, stretch = b.s) if on;"),
    "of a record as a whole in a branch": "function g input D d; output Real y; algorithm y := d.nu; end g; "
                                          + MATERIAL.format("Spring s(k = if on then g(d) else 3, stretch = b.s);"),
    "in a component's branch": "model C parameter Boolean on = false; parameter D d; Real k = if on then d.nu else 1; end C; "
                               + MATERIAL.format("C c(d = d); Spring s(k = c.k, stretch = b.s);"),
    "parameters in a branch": BLOCK.format("parameter Boolean on = false; parameter Real nu = 1, k[2] = {1, 2}; "
                                           "Spring s(k = k[1]*(if on then k[2]*nu else 3), stretch = b.s);"),
    "a record to be looked at": "record Bus Real x; Real y; end Bus; model M Block b(m = 1, base = world); "
                                "Bus u(x = b.s/1[m], y = 2*u.x); end M;",
    "a parameter of a start": BLOCK.format("parameter Length L = 2; initial equation b.s = L;"),
}


def _told(model: lag.Model) -> list[str]:
    return [text for text in model.scene.notes["warnings"] if "L0224" in text]


@pytest.mark.parametrize("case", IDLE)
def test_what_acts_on_nothing_is_named(case: str, scene: Write) -> None:
    text, what = IDLE[case]
    (told,) = _told(scene(text))
    assert what in told


@pytest.mark.parametrize("case", USED)
def test_what_is_used_or_looked_at_is_not(case: str, scene: Write) -> None:
    assert _told(scene(USED[case])) == []
