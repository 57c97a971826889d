% SPDX-License-Identifier: MIT
% A plane scene so small that a rollout takes milliseconds.
function space = small_space ()
  space = diffaqua.ShapeSpace ('dims', 2, 'cells_x', 20, 'cells_y', 8, 'sigma', 0.75);
  space.add_polygon (outline (0.0625), 'slim');
  space.add_polygon (outline (0.125), 'stout');
  space.build ();
end
