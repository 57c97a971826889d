% SPDX-License-Identifier: MIT
% A box of cells with base shapes and the Wasserstein interpolation between them. Add bases, then build.
%
%   space = diffaqua.ShapeSpace ('dims', 2, 'cells_x', 40, 'cells_y', 12);
%
% Options are the fields of dqa_shape_space_options, as pairs or as a struct. Indices count from 0, as in diffaqua.h.
classdef ShapeSpace < diffaqua.internal.Handle
  methods
    function self = ShapeSpace (varargin)
      if (nargin == 1 && isa (varargin{1}, 'uint64'))  % a handle, from load
        self.id = varargin{1};
        return
      end
      [values, cancel] = diffaqua.internal.options (varargin{:});
      self.id = diffaqua.internal.call ('shape_space_create', values, cancel);
    end

    function save (self, path)
      % Writes a built space, so that it is prepared only once; ShapeSpace.load reads it.
      diffaqua.internal.call ('shape_space_save', self.id, path);
    end

    function base = add_mesh (self, vertices, triangles, name)
      % A closed mesh: vertices [n, 3] in any unit, triangles [m, 3] of indices that count from 0. Index of the base.
      if (nargin < 4)
        name = '';
      end
      base = diffaqua.internal.call ('shape_space_add_mesh', self.id, vertices, triangles, name);
    end

    function base = add_mesh_file (self, path)
      % An STL, OBJ or PLY file; the base is named after it.
      base = diffaqua.internal.call ('shape_space_add_mesh_file', self.id, path);
    end

    function base = add_density (self, cells, name)
      % Covered fractions in [0, 1], [cells_x, cells_y, cells_z].
      if (nargin < 3)
        name = '';
      end
      base = diffaqua.internal.call ('shape_space_add_density', self.id, cells, name);
    end

    function base = add_polygon (self, corners, name)
      % A closed simple polygon [n, 2], for two dimensions.
      if (nargin < 3)
        name = '';
      end
      base = diffaqua.internal.call ('shape_space_add_polygon', self.id, corners, name);
    end

    function base = add_image (self, pixels, name)
      % Grey values in [0, 1] (1: body) [rows, columns], the first row on top, for two dimensions.
      if (nargin < 3)
        name = '';
      end
      base = diffaqua.internal.call ('shape_space_add_image', self.id, pixels, name);
    end

    function add_actuator (self, base, varargin)
      % Gives a base an actuator; options are the fields of dqa_actuator_options. Needs the space's option cell_size.
      diffaqua.internal.call ('shape_space_add_actuator', self.id, base, diffaqua.internal.options (varargin{:}));
    end

    function found = actuator (self, base, category, side)
      % The actuator of a base; after build also an automatic one.
      if (nargin < 4)
        side = 0;
      end
      found = diffaqua.internal.call ('shape_space_get_actuator', self.id, base, category, side);
    end

    function self = build (self, progress)
      % Freezes the space. progress (done, total): a true result, or an error, stops the call.
      if (nargin < 2)
        progress = [];
      end
      functions = diffaqua.internal.Functions ('progress', progress);
      diffaqua.internal.call ('shape_space_build', self.id, functions.id);
    end

    function record = info (self)
      % Sizes: dqa_shape_space_info.
      record = diffaqua.internal.call ('shape_space_get_info', self.id);
    end

    function list = names (self)
      % Of the bases, in order.
      record = self.info ();
      list = cell (1, record.n_bases);
      for base = 1:record.n_bases
        list{base} = diffaqua.internal.call ('shape_space_base_name', self.id, base - 1);
      end
    end

    function record = signal (self, index)
      % What an actuation signal drives: dqa_signal_info.
      record = diffaqua.internal.call ('shape_space_signal', self.id, index);
    end

    function cells = base (self, index)
      % Covered fractions of a base [cells_x, cells_y, cells_z].
      cells = diffaqua.internal.call ('shape_space_get_base', self.id, index);
    end

    function cells = density (self, weights)
      % Density of the barycentre over its peak [cells_x, cells_y, cells_z]; weights [n_bases] on the simplex.
      cells = diffaqua.internal.call ('shape_space_density', self.id, weights);
    end

    function weights_bar = pullback (self, weights, density_bar)
      % Gradient by the weights [n_bases], mean-free, of a loss whose gradient by the density is density_bar.
      weights_bar = diffaqua.internal.call ('shape_space_pullback', self.id, weights, density_bar);
    end
  end

  methods (Static)
    function space = load (path)
      % The built space of a file that save wrote.
      space = diffaqua.ShapeSpace (diffaqua.internal.call ('shape_space_load', path));
    end
  end
end
