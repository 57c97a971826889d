# SPDX-License-Identifier: MIT
"""A plane scene so small that a rollout takes milliseconds."""
import numpy as np

import diffaqua as dq

#: Tight solves: finite differences see their noise.
SETTINGS = {"young_modulus": 2e5, "muscle_stiffness": 1e6, "tolerance": 1e-12, "adjoint_tolerance": 1e-12}


def outline(width, n=32):
    """A fish from above [2 n][2]."""
    s = (np.arange(n) + 0.5) / n
    half = 0.02 + width * np.sin(np.pi * s**0.75) + np.maximum(0.0, 0.25 * (s - 0.75))
    left = np.stack([0.5 - s, half], axis=1)
    return np.concatenate([left, (left * [1, -1])[::-1]])


def space(**settings):
    made = dq.ShapeSpace(**{"dims": 2, "cells_x": 20, "cells_y": 8, "sigma": 0.75, **settings})
    made.add_polygon(outline(0.0625), "slim")
    made.add_polygon(outline(0.125), "stout")
    return made.build()


def simulator(**settings):
    return dq.Simulator(space(), **{**SETTINGS, **settings})


def swimmer(**settings):
    made = simulator(**settings)
    made.set_weights([0.5, 0.5])
    return made
