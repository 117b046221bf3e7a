"""Constructs of Modelica: they have the values that its specification gives them."""

from collections.abc import Callable
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.command.cli import DONE, main

Write = Callable[[str], lag.Model]

ARRAYS = {  # expressions with their values
    "A[2, 1] + A[1, end]": 5.0, "sum(A[:, 2])": 6.0, "sum(A*{1, 10})": 21.0 + 43.0, "sum({1, 10}*A)": 31.0 + 42.0,
    "sum(A*A)": 7.0 + 10.0 + 15.0 + 22.0, "sum(transpose(A)*{1, 0})": 3.0, "sum(A .* A)": 30.0, "sum(A ./ A)": 4.0,
    "sum(2*A - A/2)": 15.0, "sum(A^2) - sum(A*A)": 0.0, "sum(fill(3, 2, 2))": 12.0, "sum(zeros(3)) + sum(ones(2, 3))": 6.0,
    "sum(identity(3)*{1, 2, 4})": 7.0, "sum(linspace(0, 1, 5))": 2.5, "size(A, 1) + size({1, 2, 3}, 1)": 5.0,
    "sum(size(A))": 4.0, "ndims(A)": 2.0, "max(A) + min(A)": 5.0, "product(A)": 24.0, "sum({i*j for i in 1:2, j in 1:3})": 18.0,
    "size({i for i in 1:2, j in 1:3}, 1)": 3.0, "sum([A, {5, 6}])": 21.0, "size([A; 5, 6], 1)": 3.0,
        "sum(cat(1, {1}, {2, 3}))": 6.0,
    "sum(cross({1, 0, 0}, {0, 1, 0})*{0, 0, 7})": 7.0, "cross({1, 0}, {0, 2})": 2.0, "sum(diagonal({1, 2})*A)": 17.0,
    "sum(outerProduct({1, 2}, {3, 4}))": 21.0, "sum(skew({1, 2, 3})*{1, 2, 3})": 0.0, "scalar([5])": 5.0, "sum(vector(A))": 10.0,
    "sum(sin({0, pi/2}))": 1.0, "v[end - 1] + v[end]": 50.0, "sum(v[{1, 3}])": 40.0, "sum(v[2:end])": 50.0, "sum(v[1:2:3])": 40.0,
    "div(-7, 2) + rem(-7, 2) + mod(-7, 2)": -3.0, "integer(2.9)": 2.0, "noEvent(if 1 < 2 then 3 else 4) + smooth(0, 2)": 5.0,
    "semiLinear(-2, 3, 5)": -10.0, "sum((A + A)*v[1:2])": 2*(10 + 40 + 30 + 80.0), "sum(-A*{1, 1})": -10.0, "n": 3.0,
}


def test_arrays(scene: Write) -> None:
    lines = "\n".join(f"output Real y{k} = {text};" for k, text in enumerate(ARRAYS))
    model = scene(f"""model M
      parameter Real A[2, 2] = [1, 2; 3, 4];
      parameter Real v[:] = {{10, 20, 30}};
      parameter Integer n = size(v, 1);
      Block b(m = 1, base = world);
      {lines}
    end M;""")
    run = model.simulate(at=[0.0])
    assert {text: run[f"y{k}"][0] for k, text in enumerate(ARRAYS)} == pytest.approx(ARRAYS, abs=1e-14)


def test_matrices_move_as_their_elements_do(scene: Write) -> None:
    """K of two masses as a matrix: the potential is x*K*x/2."""
    body = "Block a(m = 1, base = world), b(m = 2, base = world, s(start = 1)); Real x[2] = {a.s/1[m], b.s/1[m]};"
    matrix = scene(f"model M {body} parameter Real K[2, 2] = [3, -1; -1, 2]; energy potential 1[J]*(x*(K*x))/2; end M;")
    plain = scene(f"model M {body} energy potential 1[J/m2]*(3*a.s^2/2 - a.s*b.s + b.s^2); end M;")
    there = plain.simulate(stop=3, interval=3)["a.s"][-1]
    assert matrix.simulate(stop=3, interval=3)["a.s"][-1] == pytest.approx(there, abs=1e-9)


CLASSES = {  # classes and the declarations of a model, with the value of its y
    "constants of a package": ("package P constant Real c = 2; constant Real d = 3*c; end P;", "Real y = P.c + P.d;", 8.0),
    "a class of a package": ("package P constant Real c = 2; model B parameter Real k = c; end B; end P;",
        "P.B b; Real y = b.k;", 2.0),
    "packages in packages": ("package P constant Real c = 1; package Q constant Real d = c + 1; end Q; end P;",
        "Real y = P.Q.d;", 2.0),
    "import": ("package P constant Real c = 2; end P;", "import P.c; Real y = c;", 2.0),
    "import with another name": ("package P package Q constant Real c = 2; end Q; end P;", "import R = P.Q; Real y = R.c;", 2.0),
    "import of several": ("package P constant Real c = 2; constant Real d = 3; end P;", "import P.{c, d}; Real y = c*d;", 6.0),
    "import of all": ("package P constant Real c = 2; type T = Real; end P;",
        "import P.*; parameter T y0 = 5; Real y = c + y0;", 7.0),
    "a function of a package": ("package P function f input Real x; output Real y = k*x; end f; constant Real k = 3; end P;",
                                "Real y = P.f(2);", 6.0),
    "enumeration": ('type E = enumeration(low "soft", high);', "parameter E e = E.high; Real y = if e == E.low then 1 else 2;",
        2.0),
    "order of an enumeration": ("type E = enumeration(a, b, c);", "parameter Boolean x = E.a < E.b and E.c > E.b; "
                                "Real y = if x then Integer(E.c) else 0;", 3.0),
    "arrays by enumeration": ("type E = enumeration(a, b);",
        "parameter Real v[E] = {4, 5}; Real y = v[E.b] + sum(v[e] for e in E);", 14.0),
    "type with a size": ("type Vector3 = Real[3](each unit = \"m\");",
        "parameter Vector3 x = {1, 2, 3}; Real y = sum(x)/1[m];", 6.0),
    "record": ("record R Real a = 1; Real b; end R;", "R r(a = 3, b = 2); Real y = r.a + r.b;", 5.0),
    "record constructor": ("record R Real a = 1; Real b; end R;",
        "parameter R r = R(b = 2); R s = R(3, 4); Real y = r.a + r.b + s.b;", 7.0),
    "record of records": ("record R Real a; end R; record S R r; Real c; end S;",
        "S s = S(R(2), 3); S t = s; Real y = t.r.a + t.c;", 5.0),
    "records equal": ("record R Real a; Real b; end R;", "R r = R(1, 2); R s; Real y = s.a + s.b; equation s = r;", 3.0),
    "array of records": ("record R Real a; end R;", "R r[2] = {R(1), R(2)}; Real y = sum(r.a);", 3.0),
    "record by a condition": ("record R Real a; end R;",
        "parameter Boolean c = false; R r = if c then R(1) else R(2); Real y = r.a;", 2.0),
    "redeclared component": ("model A parameter Real k = 1; Real z = k; end A; model B extends A; parameter Real j = 2; end B; "
                             "model C replaceable A a(k = 5); end C;", "C c(redeclare B a(j = 7)); Real y = c.a.z + c.a.j;",
                             12.0),
    "constrainedby": ("partial model P Real z; end P; model A extends P(z = 1); end A; model B extends P(z = k); "
        "parameter Real k; end B;"
                      " model C replaceable A a constrainedby P; end C;", "C c(redeclare B a(k = 3)); Real y = c.a.z;", 3.0),
    "redeclared class": ("model A Real z = 1; end A; model B Real z = k; parameter Real k = 2; end B; "
                         "model C replaceable model M = A; M m[2]; end C;",
                         "parameter Real q = 4; C c(redeclare model M = B(k = q)); Real y = sum(c.m.z);", 8.0),
    "redeclare before an element": ("model A Real z = 1; end A; model B extends A; Real w = 5; end B; model C replaceable "
        "A a; end C; "
                                    "model D extends C; redeclare B a; end D;", "D d; Real y = d.a.w;", 5.0),
    "inner and outer": ("model A outer Real g; Real z = 2*g; end A; model B A a; end B;",
        "inner Real g = 3; B b; Real y = b.a.z;", 6.0),
    "inner component": ("model E parameter Real k = 2; end E; model A outer E env; Real z = env.k; end A;",
                        "A a; inner E env(k = 9); Real y = a.z;", 9.0),
    "outer world": ("model A outer World world; Real z = -world.gravity[2]/1[m/s2]; end A;", "A a; Real y = a.z;", 9.81),
    "break": ("model A Real u = 1; Real v = 2; end A;", "extends A(break v); Real v = 5; Real y = u + v;", 6.0),
    "block and signal connectors": ("connector RealInput = input Real; connector RealOutput = output Real; block G RealInput u; "
                                    "RealOutput y; parameter Real k = 2; equation y = k*u; end G;",
                                    "G g(u = 3), h; Real y = h.y; equation connect(g.y, h.u);", 12.0),
    "connected to what is not there": ("model A Frame f; end A;", "parameter Boolean has = false; Bar bar(m = 1, L = 1); "
                                       "Bar other(m = 1, L = 1) if has; Real y = 1; equation connect(bar.a, other.b);", 1.0),
    "annotations": ("", 'Real y = 1 annotation(Dialog(group = "x")); equation connect(body.center, e.center) '
                    'annotation(Line(points = {{1, 2}, {3, 4}})); annotation(Icon(graphics = {Line(points = {{-1, 0}})}), '
                    'Documentation(info = "<html>"))', 1.0),
    "classes in a model": ("", "type Real3 = Real; model Part parameter Real k = 2; end Part; Part p; Real y = p.k;", 2.0),
    "encapsulated": ("encapsulated package P constant Real c = 2; end P;", "Real y = P.c;", 2.0),
}


@pytest.mark.parametrize("name", CLASSES)
def test_classes(name: str, scene: Write) -> None:
    classes, declarations, there = CLASSES[name]
    extra = "PointMass e(m = 1);" if "e.center" in declarations else ""
    head, equation, tail = declarations.partition("equation")
    model = scene(f"{classes} model M Block body(m = 1, base = world); {extra} {head} output Real shown = y; {equation} {tail}"
                  f"{';' if tail.endswith(')') else ''} end M;")
    assert model.simulate(at=[0.0])["shown"][0] == there


def package(folder: Path) -> None:
    """Lib with Kind, Pair and Sub.Soft, in files of their own."""
    (folder / "Lib" / "Sub").mkdir(parents=True)
    texts = {"package": "within ;\npackage Lib constant Real two = 2; type Kind = enumeration(a, b); end Lib;",
             "Pair": "within Lib;\nmodel Pair parameter Kind kind = Kind.a; Block b(m = two*(if kind == Kind.b then 5 else 1), "
                     "base = world); Sub.Soft s(stretch = b.s - 1); output Mass m = b.m; end Pair;",
             "Sub/package": "within Lib;\npackage Sub end Sub;",
             "Sub/Soft": "within Lib.Sub;\nmodel Soft extends Spring(k = two); end Soft;"}
    for name, text in texts.items():
        (folder / "Lib" / f"{name}.lag").write_text(text, encoding="utf-8")


def test_packages_in_folders(tmp_path: Path, monkeypatch) -> None:
    package(tmp_path)
    near, far = tmp_path / "scene.lag", tmp_path / "other" / "scene.lag"
    far.parent.mkdir()
    for place in (near, far):
        place.write_text("model M import L = Lib; import Lib.Kind; L.Pair p(kind = Kind.b); output Mass m = p.b.m; end M;",
        encoding="utf-8")
    assert lag.load(near).simulate(at=[0.0])["m"][0] == 10
    assert lag.load(tmp_path / "Lib" / "Pair.lag").simulate(at=[0.0])["m"][0] == 2
    with pytest.raises(lag.LagError, match="there is no 'Lib"):
        lag.load(far)
    monkeypatch.setenv("LAGRANGIA_PATH", str(tmp_path))
    assert lag.load(far).simulate(at=[0.0])["m"][0] == 10


def test_a_changed_package_is_compiled_again(tmp_path: Path) -> None:
    package(tmp_path)
    (tmp_path / "scene.lag").write_text("model M Lib.Pair p; output Mass m = p.b.m; end M;", encoding="utf-8")
    assert lag.load(tmp_path / "scene.lag").simulate(at=[0.0])["m"][0] == 2
    top = tmp_path / "Lib" / "package.lag"
    top.write_text(top.read_text(encoding="utf-8").replace("two = 2", "two = 3"), encoding="utf-8")
    assert lag.load(tmp_path / "scene.lag").simulate(at=[0.0])["m"][0] == 3


def test_the_option_path(tmp_path: Path, capsys) -> None:
    package(tmp_path / "libraries")
    (tmp_path / "scene.lag").write_text("model M Lib.Pair p; end M;", encoding="utf-8")
    assert main(["check", str(tmp_path / "scene.lag"), "--path", str(tmp_path / "libraries")]) == DONE
    assert main(["check", str(tmp_path / "scene.lag")]) == 2
    assert main(["check", str(tmp_path / "scene.lag"), "--path", str(tmp_path / "nowhere")]) == 2
    assert "there is no folder" in capsys.readouterr().err


def test_a_model_of_a_package_is_run_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "p.lag").write_text("package P model A Block b(m = 1, base = world); end A; end P;", encoding="utf-8")
    assert lag.load(tmp_path / "p.lag", model="P.A").simulate(at=[0.0])["b.s"][0] == 0
    with pytest.raises(lag.LagError, match=r"--model P\.A"):
        lag.load(tmp_path / "p.lag")


BESIDE = "Block b(m = 1, base = world); AppliedForce f(at = b.center, force = {3, 0});"


def test_elsewhen(scene: Write) -> None:
    """The branches exclude each other: each turns back what comes to its side."""
    model = scene(f"""model M {BESIDE}
    equation
      when b.s > 1[m] then reinit(der(b.s), -1); elsewhen b.s < -1[m] then reinit(der(b.s), 1); end when;
    end M;""")
    assert not model.compilation.flat.warnings
    assert max(abs(model.simulate(stop=5, interval=0.1)["b.s"])) < 1.01


@pytest.mark.parametrize(("statement", "code"), [
    ("when b.s > 1[m] then reinit(der(b.s), 0); elsewhen der(b.s) > 3[m/s] then reinit(der(b.s), 1); end when;", "L0237"),
    ('assert(n > 2, "few links", AssertionLevel.warning);', "L0238"),
])
def test_warnings(statement: str, code: str, scene: Write) -> None:
    text = f"model M parameter Integer n = 2; output Real shown = n; {BESIDE} equation {statement} end M;"
    assert [d.code for d in scene(text).compilation.flat.warnings] == [code]


def test_assertions_that_hold_say_nothing(scene: Write) -> None:
    model = scene(f"""model M parameter Integer n = 2; output Real x[n] = {{1, 2}}; {BESIDE}
    equation assert(n == 2, "two"); end M;""")
    assert not model.compilation.flat.warnings


def test_an_array_has_the_size_of_the_one_beside_it(scene: Callable[[str], lag.Model]) -> None:
    model = scene("""partial model Rows parameter Real rows[:, 2]; Real y = sum(rows[i, 2] for i in 1:size(rows, 1)); end Rows;
      model Table parameter Real points[:, 2] = [0, 1; 2, 5]; extends Rows(rows = points); end Table;
      model M Block b(m = 1, base = world); Table s, t(points = [0, 1; 1, 2; 3, 4]); output Real y = s.y + t.y; end M;""")
    assert model.simulate(at=[0.0])["y"] == pytest.approx([6 + 7])


def test_products_of_matrices_are_bounded(scene: Write) -> None:
    """A*(A*(A*x)) is written out to n^3 sums; by names of its own it is none, and n = 60 takes a second."""
    body = "model M parameter Real A[{0}, {0}] = {{{{cos(i*j) for j in 1:{0}}} for i in 1:{0}}}; " \
           "parameter Real x[{0}] = fill(1, {0}); "
    ends = "PointMass m(m = 1 + k[1]^2); end M;"
    with pytest.raises(lag.LagError, match=r"L0209.*products .* more than 300000 operations"):
        scene(body.format(60) + "parameter Real k[60] = A*(A*(A*x)); " + ends)
    named = "parameter Real y[{0}] = A*x; parameter Real z[{0}] = A*y; parameter Real k[{0}] = A*z; "
    scene((body + named).format(60) + ends)
    with pytest.raises(lag.LagError, match=r"L0209.*products .* more than 300000 operations"):
        scene(body.format(60) + "parameter Real k[60, 60] = A*A; " + ends.replace("k[1]", "k[1, 1]"))
    for product in ("A*(A*(A*x))", "A^3*x", "[1, 0.5; 0.25, 1]^100*(x - x)"):
        scene(body.format(2) + f"parameter Real k[2] = {product}; " + ends)


def test_parts_of_records_are_as_their_constructors_make_them(scene: Write) -> None:
    """Defaults are of the parts beside them, and of constants around the record, whatever is called so where it is made (2*a was
    200 of the caller's a); a record that is given as a whole is not changed by what its component was declared with."""
    model = scene("""package C
      constant Real k = 3;
      record P parameter Real a = 1; parameter Real b = 2*a; parameter Real c = k; end P;
      record Q = P(a = 9);
      record W P p(a = 4); parameter Real l = 5; end W;
    end C;
    model S parameter C.P p(a = 4); output Real y = p.a + 10*p.b; end S;
    model M
      parameter Real a = 100, k = a;
      parameter C.P one = C.P(a = 5), two = C.P(b = 1);
      parameter C.Q three = C.Q();
      parameter C.W four = C.W(l = 7), five = C.W(p = C.P(b = 8));
      S s(p = C.Q(b = 3)), t(p = C.P(b = 3));
      Block b(m = 1, base = world);
      output Real y[9] = {one.b, two.c, three.b, four.p.a, five.p.a, s.y, t.y, a, k};
    end M;""")
    assert [model.simulate(at=[0.0])[f"y[{k}]"][0] for k in range(1, 10)] == [10, 3, 18, 4, 1, 39, 31, 100, 100]


def test_each_under_each_is_of_the_array_within(scene: Write) -> None:
    model = scene("""model A parameter Real k = 1; output Real y = k; end A;
    model B A a[2]; end B;
    model M B b[3](each a(each k = 4)), c[2, 2](each a(k = {1, 2})); Block d(m = 1, base = world);
      output Real y = sum(b.a.y) + 100*sum(c.a.y); end M;""")
    assert model.simulate(at=[0.0])["y"][0] == 24 + 1200


def test_constructors_given_other_parts_compute_others(scene: Write) -> None:
    """One function served both: c of p was 51."""
    run = scene("""record O Real a = 1; Real b = 2; Real c = a + 10*b; Real d = c + a; end O;
      model M
        parameter O p = O(a = 5), q = O(b = 7), r = O();
        Prismatic s(a = world); PointMass m(m = 1, center = s.b);
        output Real x[6] = {p.c, q.c, r.c, p.d, q.d, r.d};
      end M;""").simulate(at=[0.0])
    assert run["x"][0].tolist() == [25, 71, 21, 30, 72, 22]
