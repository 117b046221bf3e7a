"""A scene as an environment for reinforcement learning, by the interface of Gymnasium (which need not be installed).

python environment.py
"""

import numpy as np

import lagrangia as lag

SCENE = """model Balance "a pole on a cart that is pushed by F"
  input Force F;
  Block    cart(m = 1, base = world, along = {1, 0});
  Revolute hinge(a = turn(cart.center, 90[deg]));
  Bar      pole(m = 0.1, L = 1, a = hinge.b);
  AppliedForce push(at = cart.center, force = {F, 0});
  annotation(experiment(StopTime = 10, Tolerance = 1e-6));
end Balance;
"""


class Balance:
    """The pole stands as long as it leans less than 0.2 rad and the cart stays within 2.4 m; a reward of 1 a step."""

    def __init__(self) -> None:
        self.run = lag.loads(SCENE).start()
        self.rest = self.run.save()

    def reset(self, seed: int | None = None) -> tuple[np.ndarray, dict[str, float]]:
        """At rest, pushed for a moment by a random force."""
        self.run.restore(self.rest)
        self.run.set(F=np.random.default_rng(seed).uniform(-5, 5))
        return self.run.step(0.02).copy(), {}

    def step(self, action: float) -> tuple[np.ndarray, float, bool, bool, dict[str, float]]:
        """A force of -10 to 10 N for 0.02 s."""
        self.run.set(F=float(np.clip(action, -10, 10)))
        x = self.run.step(0.02).copy()
        fallen = bool(abs(x[0]) > 2.4 or abs(x[1]) > 0.2)
        return x, 1.0, fallen, self.run.time > 10, {}


if __name__ == "__main__":
    environment = Balance()
    x, _ = environment.reset(seed=1)
    total, done = 0.0, False
    while not done:
        x, reward, fallen, over, _ = environment.step(float(np.array([3, -60, 5, -15]) @ x))
        total, done = total + reward, fallen or over
    print(f"{total:g} steps upright, x = {x.round(4)}")
