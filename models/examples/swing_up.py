"""A pole is swung up by energy and caught by linear-quadratic feedback, which is computed from the model's own small motion.

python swing_up.py        (scipy)
"""

import math

import numpy as np
from scipy.linalg import solve_continuous_are

import lagrangia as lag

SCENE = """model SwingUp "a cart with a hanging pole, pushed by F"
  parameter Mass M = 1, m = 0.2; parameter Length L = 1;
  input Force F;
  Block    cart(m = M, base = world, along = {1, 0});
  Revolute hinge(a = turn(cart.center, 90[deg]), phi(start = 179[deg])) "phi is measured from upright";
  Bar      pole(m = m, L = L, a = hinge.b);
  AppliedForce push(at = cart.center, force = {F, 0});
  annotation(experiment(StopTime = 10, Tolerance = 1e-8));
end SwingUp;
"""


def gains(model: lag.Model) -> np.ndarray:
    """Of x = (cart.s, hinge.phi, der(cart.s), der(hinge.phi)), by Riccati's equation about the upright position."""
    linear = model.linearize(about="start", excitations="F", initial={"hinge.phi": 0.0})
    A, B = linear.A, linear.B
    P = solve_continuous_are(A, B, np.diag([1.0, 10.0, 1.0, 1.0]), np.array([[0.1]]))
    return (B.T @ P / 0.1).ravel()


def controller(model: lag.Model) -> "lag.model.Controller":
    """Near the top feedback of all states, else a push that brings the pole's energy to what it has there."""
    K, p = gains(model), dict(zip(model.parameter_names, model.parameter_values(), strict=True))
    m, L, g = p["m"], p["L"], 9.81

    def push(t: float, run: lag.SteppedRun) -> float:
        phi = math.remainder(run["hinge.phi"], 2 * math.pi)
        rate = run["der(hinge.phi)"]
        if abs(phi) < 0.4 and abs(rate) < 3:
            return max(-10.0, min(10.0, float(-K @ [run["cart.s"], phi, run["der(cart.s)"], rate])))
        energy = m * L**2 / 6 * rate**2 + m * g * L / 2 * (math.cos(phi) - 1)
        swing = -30 * energy * (1 if rate * math.cos(phi) >= 0 else -1)
        return max(-6.0, min(6.0, swing - 2 * run["cart.s"] - 1.5 * run["der(cart.s)"]))

    return push


if __name__ == "__main__":
    model = lag.loads(SCENE)
    run = model.simulate(controllers={"F": controller(model)}, every=0.01)
    print(f"at {run.time[-1]:g} s: {math.degrees(math.remainder(run['hinge.phi'][-1], 2 * math.pi)):.3g} deg from upright, "
          f"cart at {run['cart.s'][-1]:.3g} m, F up to {abs(run['F']).max():.3g} N")
