# SPDX-License-Identifier: MIT
"""The space of shapes between base meshes, outlines or images."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import Array, ArrayLike, numbers, output, pointer
from ._callbacks import Progress, progress_callback
from ._handle import Handle, path_bytes
from ._library import check, ffi, lib, text
from .structs import ActuatorOptions, SignalInfo, SpaceInfo, actuator_options, options, record, told

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .structs import SpaceOptions


class CancelToken(Handle):
    """Stops calls from another thread or a signal handler: the objects that were made with it as `cancel` raise
    CancelledError and stay usable."""

    _what = "cancel token"

    def __init__(self) -> None:
        super().__init__(lib.dqa_cancel_token_create, "dqa_cancel_token", lib.dqa_cancel_token_free)

    def set(self) -> None:
        """Asks every call that watches the token to stop."""
        with self._use(shared=True) as token:
            check(lib.dqa_cancel_token_set(token))

    def reset(self) -> None:
        """Lets the calls that watch the token run again."""
        with self._use(shared=True) as token:
            check(lib.dqa_cancel_token_reset(token))


class ShapeSpace(Handle):
    """A box of cells with base shapes and the Wasserstein interpolation between them. Add bases, then build().

    Options are keyword arguments (see SpaceOptions), e.g. ShapeSpace(cells_x=40, cells_y=12, cells_z=20, sigma=0.7)."""

    _what = "shape space"

    def __init__(self, *, cancel: CancelToken | None = None, **settings: Unpack[SpaceOptions]) -> None:
        with _optional(cancel) as token:
            filled = options("dqa_shape_space_options", lib.dqa_shape_space_options_init, settings, cancel=token)
            super().__init__(lambda out: lib.dqa_shape_space_create(filled, out), "dqa_shape_space",
                             lib.dqa_shape_space_free)
        self._built = False

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ShapeSpace:
        """The built space of a file that save() wrote."""
        space = cls.__new__(cls)
        name = path_bytes(path)
        Handle.__init__(space, lambda out: lib.dqa_shape_space_load(name, out), "dqa_shape_space",
                        lib.dqa_shape_space_free)
        space._built = True
        return space

    def _use(self, shared: bool = False) -> Any:
        # Only a built space may be read by several threads at once.
        return super()._use(shared and self._built)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a built space, so that it is prepared only once."""
        with self._use(shared=True) as space:
            check(lib.dqa_shape_space_save(space, path_bytes(path)))

    # -------------------------------------------------------------- bases
    def add_mesh(self, vertices: ArrayLike, triangles: ArrayLike, name: str = "") -> int:
        """Adds a closed mesh, vertices [n][3] in any unit and triangles [m][3]; returns the index of the base."""
        points = numbers("vertices", vertices, (None, 3))
        corners = numbers("triangles", triangles, (None, 3), np.int32)
        return self._add(lib.dqa_shape_space_add_mesh, name.encode(), pointer(points), len(points), pointer(corners),
                         len(corners))

    def add_mesh_file(self, path: str | os.PathLike[str]) -> int:
        """Adds a mesh from an STL, OBJ or PLY file; the base is named after the file."""
        return self._add(lib.dqa_shape_space_add_mesh_file, path_bytes(path))

    def add_density(self, cells: ArrayLike, name: str = "") -> int:
        """Adds covered fractions in [0, 1], shape [cells_x][cells_y][cells_z]."""
        values = numbers("cells", cells, self.shape)
        return self._add(lib.dqa_shape_space_add_density, name.encode(), pointer(values), values.size)

    def add_polygon(self, corners: ArrayLike, name: str = "") -> int:
        """Adds a closed simple polygon [n][2] to a space of two dimensions."""
        points = numbers("corners", corners, (None, 2))
        return self._add(lib.dqa_shape_space_add_polygon, name.encode(), pointer(points), len(points))

    def add_image(self, pixels: ArrayLike, name: str = "") -> int:
        """Adds grey values in [0, 1] (1: body) [rows][columns], the first row on top, to a space of two dimensions."""
        values = numbers("pixels", pixels, (None, None))
        return self._add(lib.dqa_shape_space_add_image, name.encode(), pointer(values), *values.shape)

    def _add(self, function: Any, *arguments: Any) -> int:
        base = ffi.new("int32_t *")
        with self._use() as space:
            check(function(space, *arguments, base))
        return int(base[0])

    def add_actuator(self, base: int, actuator: ActuatorOptions) -> None:
        """Gives a base an actuator; bases without one get theirs from their geometry. Needs the option cell_size."""
        filled = actuator_options(actuator)
        with self._use() as space:
            check(lib.dqa_shape_space_add_actuator(space, base, filled))

    def actuator(self, base: int, category: int, side: int = 0) -> ActuatorOptions:
        """The actuator of a base; after build() also an automatic one."""
        filled = actuator_options(ActuatorOptions())
        with self._use(shared=True) as space:
            check(lib.dqa_shape_space_get_actuator(space, base, category, side, filled))
        return record(ActuatorOptions, filled)

    def build(self, progress: Progress | None = None) -> ShapeSpace:
        """Freezes the space and returns it."""
        with self._use() as space:
            check(lib.dqa_shape_space_build(space, progress_callback(progress), ffi.NULL))
            self._built = True
        return self

    # -------------------------------------------------------------- questions
    def info(self) -> SpaceInfo:
        """Sizes of the space."""
        with self._use(shared=True) as space:
            return told(SpaceInfo, lib.dqa_shape_space_get_info, space)

    @property
    def shape(self) -> tuple[int, int, int]:
        """(cells_x, cells_y, cells_z); cells_z is 1 in two dimensions."""
        info = self.info()
        return info.cells_x, info.cells_y, info.cells_z

    @property
    def names(self) -> list[str]:
        """Of the bases, in order."""
        count = self.info().n_bases
        with self._use(shared=True) as space:
            return [text(lib.dqa_shape_space_base_name(space, base)) for base in range(count)]

    def signal(self, signal: int) -> SignalInfo:
        """What an actuation signal drives."""
        with self._use(shared=True) as space:
            return told(SignalInfo, lib.dqa_shape_space_signal, space, signal)

    def base(self, base: int, out: Array | None = None) -> Array:
        """Covered fractions of a base [cells_x][cells_y][cells_z]."""
        cells = output("out", out, self.shape)
        with self._use(shared=True) as space:
            check(lib.dqa_shape_space_get_base(space, base, pointer(cells), cells.size))
        return cells

    def density(self, weights: ArrayLike, out: Array | None = None) -> Array:
        """Density of the barycentre over its peak [cells_x][cells_y][cells_z]; weights [n_bases] on the simplex."""
        share = numbers("weights", weights, (None,))
        cells = output("out", out, self.shape)
        with self._use(shared=True) as space:
            check(lib.dqa_shape_space_density(space, pointer(share), share.size, pointer(cells), cells.size))
        return cells

    def pullback(self, weights: ArrayLike, density_bar: ArrayLike) -> Array:
        """Gradient with respect to the weights [n_bases], mean-free, of a loss whose gradient with respect to the
        density is density_bar [cells_x][cells_y][cells_z]."""
        share = numbers("weights", weights, (None,))
        bar = numbers("density_bar", density_bar, self.shape)
        result = np.zeros(share.size)
        with self._use(shared=True) as space:
            check(lib.dqa_shape_space_pullback(space, pointer(share), share.size, pointer(bar), bar.size,
                                               pointer(result)))
        return result


class _optional:
    """The handle of an object that may be None, for the time of a `with` block."""

    def __init__(self, handle: Handle | None, shared: bool = True) -> None:
        self._context = None if handle is None else handle._use(shared)  # pylint: disable=protected-access

    def __enter__(self) -> Any:
        return ffi.NULL if self._context is None else self._context.__enter__()

    def __exit__(self, *what: Any) -> None:
        if self._context is not None:
            self._context.__exit__(*what)
