"""What a redeclaration says beside the name of a class, and what a constraining clause says of it (Modelica 3.6, 7.3.2)."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]

HEAD = "Block b(m = 1, base = world);"
CLASSES = """
package P
  package A constant Real k = 1; end A;
  package Z constant Real k = 4; end Z;
  model Q parameter Real k = 1; output Real y = k; end Q;
  model Q2 parameter Real k = 7; output Real y = k; end Q2;
  model T1 replaceable package M = A constrainedby A(k = 9); output Real y = M.k; end T1;
  model T2 replaceable package M = A(k = 2); output Real y = M.k; end T2;
  model T3 replaceable Q q constrainedby Q(k = 3); output Real y = q.y; end T3;
  model T4 replaceable model QQ = Q(k = 2); QQ q; output Real y = q.y; end T4;
  model T5 replaceable model QQ = Q constrainedby Q(k = 3); QQ q; output Real y = q.y; end T5;
  model T6 replaceable model QQ Real y = 5; Real z = y; end QQ; QQ q; end T6;
  model Again extends T2(redeclare replaceable package M = Z(k = 5)); end Again;
end P;
"""
GIVEN = {  # what is y of each
    "P.T1 t;": 9, "P.T1 t(redeclare package M = P.Z);": 9, "P.T1 t(redeclare package M = P.Z(k = 8));": 8, "P.T2 t;": 2,
    "P.T2 t(redeclare package M = P.Z);": 2, "P.Again t;": 5, "P.Again t(redeclare package M = P.A);": 2,
    "P.T3 t;": 3, "P.T3 t(redeclare P.Q2 q);": 3, "P.T3 t(redeclare P.Q2 q(k = 8));": 8, "P.T4 t;": 2,
    "P.T4 t(redeclare model QQ = P.Q2);": 2, "P.T5 t;": 3, "P.T5 t(redeclare model QQ = P.Q2);": 3,
    "P.T5 t(redeclare model QQ = P.Q2(k = 8));": 8, "P.T4 t(redeclare model QQ = P.Q2 constrainedby P.Q(k = 6));": 6}


def test_limits_modify_what_takes_a_place(scene: Write) -> None:
    texts = [text.replace(" t", f" t{k}", 1) for k, text in enumerate(GIVEN)]
    read = " ".join(f"output Real y{k} = t{k}.y;" for k in range(len(GIVEN)))
    run = scene(f"{CLASSES} model M {HEAD} {' '.join(texts)} {read} end M;").simulate(at=[0.0])
    assert {text: run[f"y{k}"][0] for k, text in enumerate(GIVEN)} == GIVEN


WRONG = {
    "P.T1 t(redeclare package M = P.A constrainedby Nope(k = 7));": "L0201.*'Nope'",
    "P.T5 t(redeclare model QQ = P.Q constrainedby Nope);": "L0201.*'Nope'",
    "P.T3 t(redeclare P.Q q constrainedby Nope);": "L0201.*'Nope'",
    "model C replaceable model X = P.Q constrainedby Nope; X x; end C; C t;": "L0201.*'Nope'",
    "P.T1 t(redeclare model M = P.A);": "L0235.*'M' is a package, no model",
    "P.T5 t(redeclare function QQ = P.Q);": "L0235.*'QQ' is a model, no function",
    "P.T6 t(redeclare model QQ = P.Q);": "L0235.*lacks 'z' of",
    "model C replaceable type T = enumeration(:); parameter T x; end C; C t(redeclare type T = Real, x = 2);":
        "L0235.*'T' is any enumeration: Real"}


@pytest.mark.parametrize("text", WRONG)
def test_what_a_redeclaration_says_is_looked_at(scene: Write, text: str) -> None:
    with pytest.raises(lag.LagError, match=WRONG[text]):
        scene(f"{CLASSES} model M {HEAD} {text} end M;")


PLACES = """
partial model Base parameter Real p = 1; end Base;
model Small extends Base; Block b(m = p, base = world, along = {1, 0}); end Small;
model Big extends Base; Block c[2](each m = p, each base = world, each along = {1, 0}); end Big;
model Huge extends Base; Block c[200000](each m = p, each base = world, each along = {1, 0}); end Huge;
model Nested replaceable model A = Big constrainedby Base; model B A a; end B; B b; end Nested;
model Short replaceable model A = Big constrainedby Base; model AA = A; AA b; end Short;
model Around replaceable model X = Big constrainedby Base; X x; end Around;
model Handed replaceable model A = Big constrainedby Base; Around w(redeclare model X = A); end Handed;
model Bare replaceable model A = Big constrainedby Base; end Bare;
model Before A a; extends Bare; end Before;
model Heir extends Nested(redeclare model A = Small(p = 3)); end Heir;
model Deep Nested q; end Deep;
model Foreseen replaceable model A = Huge constrainedby Base; model AA = A; AA b; end Foreseen;
model Within Foreseen q; end Within;
package P replaceable model A = Big constrainedby Base; model M A a; end M; model N M m; end N; end P;
package P2 = P(redeclare model A = Small);
"""
USED = {  # the coordinates of each
    "Nested q(redeclare model A = Small);": ["b.a.b.s"], "Nested q;": ["b.a.c[1].s", "b.a.c[2].s"],
    "Short q(redeclare model A = Small(p = 2));": ["b.b.s"], "Handed q(redeclare model A = Small);": ["w.x.b.s"],
    "Before q(redeclare model A = Small);": ["a.b.s"], "Heir q;": ["b.a.b.s"],
    "Deep q(q(redeclare model A = Small));": ["q.b.a.b.s"], "Within q(q(redeclare model A = Small));": ["q.b.b.s"],
    "P2.N q;": ["m.a.b.s"], "P.N q;": ["m.a.c[1].s", "m.a.c[2].s"]}


def test_models_are_redeclared_for_what_uses_them(scene: Write) -> None:
    """In other classes, by short names, and handed on: each instance by what is said of it."""
    texts = [text.replace(" q", f" q{k}", 1) for k, text in enumerate(USED)]
    many = "Nested each_one[2](each redeclare model A = Small);"
    found = scene(f"{PLACES} model M {' '.join(texts)} {many} end M;").coordinate_names
    wanted = [f"q{k}.{name}" for k, names in enumerate(USED.values()) for name in names]
    assert list(found) == [*wanted, "each_one[1].b.a.b.s", "each_one[2].b.a.b.s"]


def test_model_redeclared_for_components_is_not_named_elsewhere(scene: Write) -> None:
    own = "model R replaceable model A = Big; A a; end R; model R2 extends R(redeclare model A = Small); end R2;"
    with pytest.raises(lag.LagError, match=r"L0901.*'A' of R2"):
        scene(f"{PLACES} {own} model M R2.A a; end M;")


def test_texts_and_variables_of_its_name_do_not_use_a_model(scene: Write) -> None:
    """`A a "A"` does not keep A from being redeclared with what moves, nor does a parameter A of another class."""
    own = """model R replaceable model A = Big constrainedby Base; model K "A" parameter Real A = 2; Real y = A; end K;
          A a "A"; K k(A = 3); end R;
        model R2 parameter Real z = 3; extends R(redeclare model A = Small(p = z)); end R2;"""
    assert list(scene(f"{PLACES} {own} model M R2 q; end M;").coordinate_names) == ["q.a.b.s"]


def test_what_is_not_there_has_what_its_class_redeclares(scene: Write) -> None:
    own = """model C replaceable Small w constrainedby Base; end C; model H extends Small; parameter Real extra = 2; end H;
        model C2 extends C(redeclare H w); end C2; model M parameter Boolean has = false; Block b(m = 1, base = world);"""
    assert list(scene(f"{PLACES} {own} C2 c(w(extra = 3)) if has; end M;").coordinate_names) == ["b.s"]
    with pytest.raises(lag.LagError, match=r"L0203.*'other'"):
        scene(f"{PLACES} {own} C2 c(w(other = 3)) if has; end M;")
