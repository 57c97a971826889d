# SPDX-License-Identifier: MIT
"""Pictures: bodies of three dimensions by PyVista, without a screen; outlines, densities and histories by
Matplotlib."""
from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import Array, ArrayLike, IntArray
from .errors import ArgumentError
from .shape_space import ShapeSpace
from .simulator import Simulator, Surface
from .tape import Tape

Picture = npt.NDArray[np.uint8]
_BODY = "#3b7ea1"


# ------------------------------------------------------------------ three dimensions
def polydata(surface: Surface) -> Any:
    """A triangle surface as pyvista.PolyData."""
    import pyvista
    if surface.vertices.shape[1] != 3:
        raise ArgumentError("surface: expected one of three dimensions; outlines are drawn by plot_outline")
    faces = np.column_stack([np.full(len(surface.elements), 3), surface.elements])
    return pyvista.PolyData(surface.vertices, faces.ravel())


def cells(simulator: Simulator) -> Any:
    """The simulated cells in the present state as pyvista.UnstructuredGrid, with `occupancy` and `speed` (m/s)."""
    import pyvista
    mesh, (q, v) = simulator.mesh(), simulator.state()
    if q.shape[1] != 3:
        raise ArgumentError("simulator: expected one of three dimensions")
    # Corners are 4 ix + 2 iy + iz; VTK goes around the lower face, then around the upper one.
    order = mesh.cell_nodes[:, [0, 4, 6, 2, 1, 5, 7, 3]]
    entries = np.column_stack([np.full(len(order), 8), order]).ravel()
    grid = pyvista.UnstructuredGrid(entries, np.full(len(order), pyvista.CellType.HEXAHEDRON), q)
    grid.cell_data["occupancy"] = mesh.occupancy
    grid.point_data["speed"] = np.linalg.norm(v, axis=1)
    return grid


def _picture_3d(surface: Surface, box: Array, size: tuple[int, int]) -> Picture:
    import pyvista
    if "DISPLAY" not in os.environ:  # VTK would complain before it finds out by itself
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size))
    try:
        plotter.add_mesh(polydata(surface), color=_BODY, smooth_shading=True, ambient=0.25, specular=0.3)
        centre, reach = box.mean(axis=0), float(np.ptp(box, axis=0).max())
        eye = centre + reach * np.array([0.9, -1.3, 0.8])
        plotter.camera_position = [tuple(eye), tuple(centre), (0.0, 0.0, 1.0)]
        plotter.camera.view_angle = 26.0
        plotter.reset_camera_clipping_range()
        return np.array(plotter.screenshot(return_img=True))[..., :3]
    finally:
        plotter.close()


# ------------------------------------------------------------------ two dimensions
def _axes(axes: Any) -> Any:
    if axes is not None:
        return axes
    import matplotlib.pyplot as plt
    return plt.subplots()[1]


def _draw_outline(vertices: Array, segments: IntArray, axes: Any, **style: Any) -> None:
    """Closed polygons, filled by the even-odd rule, so that holes stay open."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path
    following = np.full(len(vertices), -1)
    following[segments[:, 0]] = segments[:, 1]
    points: list[Array] = []
    codes: list[int] = []
    left = set(int(start) for start in segments[:, 0])
    while left:
        start = at = min(left)
        loop = []
        while at in left:
            left.remove(at)
            loop.append(at)
            at = int(following[at])
        points += [vertices[loop], vertices[[start]]]
        codes += [int(Path.MOVETO)] + [int(Path.LINETO)] * (len(loop) - 1) + [int(Path.CLOSEPOLY)]
    axes.add_patch(PathPatch(Path(np.concatenate(points), codes), **{"facecolor": _BODY, "edgecolor": "none", **style}))


def plot_outline(simulator: Simulator, axes: Any = None, **style: Any) -> Any:
    """Draws the present outline of a plane swimmer; style as of a Matplotlib patch. Returns the axes."""
    axes = _axes(axes)
    vertices, segments = simulator.surface()
    if vertices.shape[1] != 2:
        raise ArgumentError("simulator: expected one of two dimensions; bodies are drawn by polydata and picture")
    _draw_outline(vertices, segments, axes, **style)
    axes.set_aspect("equal")
    axes.autoscale_view()
    return axes


def plot_density(space: ShapeSpace, weights: ArrayLike, axes: Any = None) -> Any:
    """The density of a design seen from above (its largest value over z), with the body's edge. Returns the axes."""
    axes = _axes(axes)
    density = space.density(weights).max(axis=2)
    h = space.info().cell_size
    extent = np.array([-0.5, 0.5, -0.5, 0.5]) * h * np.repeat(density.shape, 2)
    axes.imshow(density.T, origin="lower", extent=extent, cmap="Blues", vmin=0.0, vmax=1.0)
    axes.contour(density.T, [0.5], extent=extent, colors=[_BODY])
    axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    return axes


def plot_history(series: Mapping[str, Sequence[float]], axes: Any = None) -> Any:
    """Lines over iterations, such as {"loss (m)": losses}. Returns the axes."""
    axes = _axes(axes)
    for name, values in series.items():
        axes.plot(np.arange(1, len(values) + 1), values, label=name)
    axes.set_xlabel("iteration")
    axes.legend()
    return axes


def _picture_2d(surface: Surface, box: Array, size: tuple[int, int]) -> Picture:
    # Not through pyplot: a picture more must not change what the caller draws.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    figure = Figure(figsize=(size[0] / 100, size[1] / 100), dpi=100, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    _draw_outline(surface.vertices, surface.elements, axes)
    centre, half = box.mean(axis=0), 0.55 * np.ptp(box, axis=0)
    half = np.maximum(half, half.max() * np.array([1.0, 0.4]))
    axes.set(xlim=(centre[0] - half[0], centre[0] + half[0]), ylim=(centre[1] - half[1], centre[1] + half[1]),
             aspect="equal", xlabel="x (m)", ylabel="y (m)")
    canvas.draw()
    return np.array(canvas.buffer_rgba())[..., :3]


# ------------------------------------------------------------------ both
def _box(vertices: Array) -> Array:
    return np.array([vertices.min(axis=0), vertices.max(axis=0)])


def _picture(surface: Surface, box: Array, size: tuple[int, int]) -> Picture:
    if len(surface.vertices) == 0:
        raise ArgumentError("simulator: this design has no body; nothing exceeds half of the density's peak")
    return _picture_2d(surface, box, size) if surface.vertices.shape[1] == 2 else _picture_3d(surface, box, size)


def picture(simulator: Simulator, size: tuple[int, int] = (640, 400)) -> Picture:
    """The swimmer in its present state, [height][width][3] bytes of red, green and blue."""
    surface = simulator.surface()
    return _picture(surface, _box(surface.vertices), size)


def frames(tape: Tape, simulator: Simulator, every: int = 1, size: tuple[int, int] = (640, 400)) -> Iterator[Picture]:
    """Pictures of a recorded rollout, one for every so many steps, all with the same view. The simulator must still
    have the design of the tape."""
    if every < 1:
        raise ArgumentError(f"every: expected a number >= 1, got {every}")
    elements = simulator.surface().elements
    moments = [tape.surface(step) for step in range(0, tape.n_steps + 1, every)]
    box = _box(np.concatenate(moments))
    for vertices in moments:
        yield _picture(Surface(vertices, elements), box, size)


def film(tape: Tape, simulator: Simulator, path: str | os.PathLike[str], every: int = 1,
         size: tuple[int, int] = (640, 400)) -> None:
    """Writes the motion of a recorded rollout as an animated GIF that plays in real time."""
    from PIL import Image
    images = [Image.fromarray(frame) for frame in frames(tape, simulator, every, size)]
    duration = max(20, round(1000.0 * simulator.time_step * every))
    images[0].save(path, format="GIF", save_all=True, append_images=images[1:], duration=duration, loop=0)
