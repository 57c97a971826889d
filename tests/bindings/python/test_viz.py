# SPDX-License-Identifier: MIT
"""diffaqua.viz without a screen: pictures show a body where it is, films move, VTK's cells are not inside out."""
import os
import tempfile
import unittest

import matplotlib

matplotlib.use("agg")
import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

import diffaqua as dq  # noqa: E402
import scene  # noqa: E402
from diffaqua import viz  # noqa: E402
from diffaqua.gym import SwimmerEnv  # noqa: E402


def spindle():
    space = dq.ShapeSpace(cells_x=16, cells_y=8, cells_z=8, sigma=0.75)
    i, j, k = np.meshgrid(*(np.arange(n) + 0.5 - n / 2 for n in space.shape), indexing="ij")
    space.add_density(((i / 6)**2 + (j / 2.5)**2 + (k / 2.5)**2 < 1).astype(float), "spindle")
    simulator = dq.Simulator(space.build())
    simulator.set_weights([1.0])
    return simulator


class Pictures(unittest.TestCase):
    def shows_a_body(self, picture, size):
        self.assertEqual((picture.shape, picture.dtype), ((size[1], size[0], 3), np.uint8))
        blue = (picture[..., 2].astype(int) - picture[..., 0]) > 40
        self.assertTrue(0.03 < blue.mean() < 0.7, blue.mean())
        rows, columns = np.nonzero(blue)
        self.assertLess(abs(columns.mean() / size[0] - 0.5), 0.1)
        self.assertLess(abs(rows.mean() / size[1] - 0.5), 0.15)

    def test_plane(self):
        self.shows_a_body(viz.picture(scene.swimmer(), (400, 250)), (400, 250))

    def test_body(self):
        simulator = spindle()
        self.shows_a_body(viz.picture(simulator, (320, 240)), (320, 240))
        simulator.step([0.5])
        cells = viz.cells(simulator)
        self.assertEqual(cells.n_cells, simulator.info().n_active_cells)
        volumes = cells.compute_cell_sizes()["Volume"]
        h = simulator.info().cell_size
        self.assertTrue(np.all(volumes > 0.2 * h**3) and np.all(volumes < 5.0 * h**3))
        mesh = viz.polydata(simulator.surface())
        self.assertTrue(mesh.is_manifold)
        with self.assertRaisesRegex(dq.ArgumentError, "plot_outline"):
            viz.polydata(scene.swimmer().surface())

    def test_film(self):
        swimmer = scene.swimmer()
        tape = dq.Tape(swimmer)
        swimmer.rollout(dq.Sinusoid(1), 6, tape)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "film.gif")
            viz.film(tape, swimmer, path, every=2, size=(200, 120))
            with Image.open(path) as film:
                self.assertEqual(film.n_frames, 4)
                self.assertEqual(film.info["duration"], 60)  # hundredths of a second are what the format has
        frames = list(viz.frames(tape, swimmer, 6, (200, 120)))
        self.assertTrue(np.any(frames[0] != frames[1]))

    def test_drawings(self):
        import matplotlib.pyplot as plt
        figure, axes = plt.subplots(3)
        viz.plot_outline(scene.swimmer(), axes[0], facecolor="red")
        viz.plot_density(scene.space(), [0.5, 0.5], axes[1])
        viz.plot_history({"loss (m)": [3.0, 2.0, 1.0]}, axes[2])
        figure.canvas.draw()
        self.assertEqual([len(axes[0].patches), len(axes[1].images), len(axes[2].lines)], [1, 1, 1])

    def test_environment(self):
        env = SwimmerEnv(scene.swimmer(), render_mode="rgb_array")
        env.reset(seed=1)
        self.shows_a_body(env.render(), (640, 400))


if __name__ == "__main__":
    unittest.main(verbosity=1)
