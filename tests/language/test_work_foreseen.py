"""What is too much is refused by counting, before it is made; what only looks so is not."""

import pytest

import lagrangia as lag
from lagrangia.language.instantiation import Instantiation
from lagrangia.language.loops import Loops

BLOCK = "Block b(m = 1, base = world, along = {1, 0});"
DOUBLED = "".join(f"model A{k} A{k - 1} x, y; end A{k}; " for k in range(1, 31))
INHERITED = "".join(f"model A{k} extends A{k - 1}; extends A{k - 1}; end A{k}; " for k in range(1, 31))
ARRAYS = "".join(f"model A{k} A{k - 1} x[10]; end A{k}; " for k in range(1, 8))
POINT = "model A0 parameter Real p = 1; end A0; "
SUMS = "sum(2*sum(-sum(i*j*k*p for i in 1:n) for j in 1:n) for k in 1:n)"
LOOPS = "".join(f"for i{k} in 1:n loop " for k in range(60)) + "y := y + 1; " + "end for; " * 60


@pytest.mark.parametrize("text, said", [
    (f"{POINT}{DOUBLED}model M A30 z; {BLOCK} end M;", "more than 100000 components"),
    (f"{POINT}{ARRAYS}model M A7 z; {BLOCK} end M;", "more than 100000 components"),
    (f"{POINT}{INHERITED}model M extends A30; {BLOCK} end M;", "inherits more than 10000 classes"),
    (f"model M parameter Integer n = 1000; parameter Real p = 1; {BLOCK} output Real o = {SUMS}; end M;", "300000 operations"),
    (f"function f input Integer n; input Real x; output Real y; algorithm y := x; {LOOPS} end f; "
     f"model M parameter Integer n = 2; {BLOCK} output Real o = f(n, 1); end M;", "300000 operations"),
    (f"model M parameter Real A[:, :] = identity(5000); {BLOCK} end M;", "an array of more than 100000 elements"),
    (f"model M parameter Integer n = 60; parameter Real p[n, n, n] = {{{{{{i*j*k for i in 1:n}} for j in 1:n}} for k in 1:n}}; "
     f"{BLOCK} end M;", "'p' has 216000 elements; at most 100000 are possible"),
], ids=["doubled", "arrays", "inherited", "sums", "loops", "identity", "comprehension"])
def test_too_much_is_refused_before_it_is_made(text: str, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made = [0]
    for owner, name in ((Instantiation, "instantiate"), (Instantiation, "_members"), (Loops, "loop")):
        def counted(*given: object, plain: object = getattr(owner, name), **named: object) -> object:
            made[0] += 1
            assert made[0] < 200, "this is made, not counted"
            return plain(*given, **named)  # type: ignore[operator]
        monkeypatch.setattr(owner, name, counted)
    with pytest.raises(lag.LagError, match=f"L0209.*{said}"):
        lag.loads(text, model="M")


@pytest.mark.parametrize("text", [
    f"{POINT}model B A0 x[99990]; end B; model A replaceable B q constrainedby A0; end A; "
    f"model M A a[2](each redeclare A0 q); {BLOCK} end M;",
    f"{POINT}model B A0 x[99990]; end B; model A B q; end A; model M extends A(break q); A0 z[20]; {BLOCK} end M;",
    f"{POINT}model B A0 x[60000] if k; parameter Boolean k = false; end B; model M B z, y; {BLOCK} end M;",
    "function f input Real x; output Real y; protected Integer k; algorithm k := 5000; y := x; "
    f"for i in 1:100 loop for j in 1:k loop y := y + 1; k := 0; end for; end for; end f; "
    f"model M {BLOCK} output Real o = f(1); end M;",
], ids=["redeclared", "left out", "absent", "given in the loop"])
def test_what_only_looks_like_too_much_is_made(text: str) -> None:
    assert lag.loads(text, model="M")
