# SPDX-License-Identifier: MIT
"""What the examples share: two fish seen from above and the sine that bends a mix of them, optimised for the distance
travelled; and a log of the iterations, also for TensorBoard (--tensorboard FOLDER)."""
import argparse

import numpy as np

import diffaqua as dq


def outline(width):
    s = (np.arange(40) + 0.5) / 40
    half = 0.02 + width * np.sin(np.pi * s**0.7) + np.maximum(0.0, 0.25 * (s - 0.75))
    left = np.stack([0.5 - s, half], axis=1)
    return np.concatenate([left, (left * [1, -1])[::-1]])


def rollout(steps):
    """(the function of (w, theta), a start of both)."""
    space = dq.ShapeSpace(dims=2, cells_x=32, cells_y=12, sigma=0.7)
    space.add_polygon(outline(0.05), "slim")
    space.add_polygon(outline(0.12), "stout")
    simulator = dq.Simulator(space.build(), young_modulus=5e5, muscle_stiffness=1e6)
    sine = dq.Sinusoid(1)
    return dq.rollout.Rollout(simulator, sine, steps, dq.ObjectiveTerm()), np.array([0.5, 0.5]), np.array(
        [0.6, 15.0, 0.0])


def arguments(text, iterations):
    parser = argparse.ArgumentParser(description=text)
    parser.add_argument("--iterations", type=int, default=iterations)
    parser.add_argument("--steps", type=int, default=30, help="length of a rollout")
    parser.add_argument("--tensorboard", metavar="FOLDER", help="write the loss there (needs tensorboardX)")
    return parser.parse_args()


class Log:
    """A line for each iteration, the best loss, and TensorBoard if asked for."""

    def __init__(self, folder):
        self.best, self.first, self.count, self.writer = np.inf, None, 0, None
        if folder:
            from tensorboardX import SummaryWriter
            self.writer = SummaryWriter(folder)

    def __call__(self, loss, w, theta):
        self.count += 1
        self.first = loss if self.first is None else self.first
        self.best = min(self.best, loss)
        shares = ", ".join(f"{100 * share:.0f} %" for share in w / np.sum(w))
        print(f"{self.count:3d}: travels {-1e3 * loss:7.2f} mm with {shares}, amplitude {theta[0]:.2f}, "
              f"{theta[1]:.1f} rad/s")
        if self.writer:
            self.writer.add_scalar("loss_m", loss, self.count)
            for name, value in (("slim", w[0] / np.sum(w)), ("amplitude", theta[0]), ("omega_rad_per_s", theta[1])):
                self.writer.add_scalar(name, value, self.count)

    def close(self):
        if self.writer:
            self.writer.close()
        print(f"first {-1e3 * self.first:.2f} mm, best {-1e3 * self.best:.2f} mm")
