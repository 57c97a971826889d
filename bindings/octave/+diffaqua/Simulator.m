% SPDX-License-Identifier: MIT
% One scene in a built space: material, water, solver; its present design and state.
%
%   simulator = diffaqua.Simulator (space, 'time_step', 1 / 60);
%   simulator.set_weights ([0.5, 0.5]);
%
% Options are the fields of dqa_simulator_options, as pairs or as a struct. Indices count from 0, as in diffaqua.h.
classdef Simulator < diffaqua.internal.Handle
  properties (SetAccess = private)
    options  % as the scene was made
  end

  properties (SetAccess = private, Hidden)
    n_cells
    design = 0      % counts designs: tapes remember theirs
    functions = []  % of the current
    table_rows = 1
  end

  methods
    function self = Simulator (space, varargin)
      parent = diffaqua.internal.id ('space', space, 'diffaqua.ShapeSpace');
      [values, cancel] = diffaqua.internal.options (varargin{:});
      [self.id, self.options] = diffaqua.internal.call ('simulator_create', parent, values, cancel);
      record = space.info ();
      self.n_cells = record.n_cells;
    end

    function record = info (self)
      % Sizes, totals and the clock: dqa_simulator_info.
      record = diffaqua.internal.call ('simulator_get_info', self.id);
    end

    % ---------------------------------------------------------------- design
    function set_weights (self, weights, progress)
      % New design from weights [n_bases] on the simplex; the state goes back to rest and the clock to 0. progress
      % (done, total): a true result, or an error, stops the call.
      if (nargin < 3)
        progress = [];
      end
      run = diffaqua.internal.Functions ('progress', progress);
      diffaqua.internal.call ('simulator_set_weights', self.id, weights, run.id);
      self.design = self.design + 1;
    end

    function share = weights (self)
      % Of the present design [n_bases].
      share = diffaqua.internal.call ('simulator_get_weights', self.id);
    end

    function set_material (self, young_modulus, muscle_stiffness)
      % Moduli (Pa) by cell of the full box [n_cells], or [] for the uniform one of the options; state to rest.
      if (nargin < 2)
        young_modulus = [];
      end
      if (nargin < 3)
        muscle_stiffness = [];
      end
      diffaqua.internal.call ('simulator_set_material', self.id, young_modulus, muscle_stiffness, self.n_cells);
      self.design = self.design + 1;
    end

    function set_fixed_nodes (self, nodes)
      % Nodes of the full box that keep their place, by index; [] frees all. State to rest.
      diffaqua.internal.call ('simulator_set_fixed_nodes', self.id, nodes);
      self.design = self.design + 1;
    end

    function nodes = node_box_index (self)
      % Index in the full box of each node [n_nodes].
      nodes = diffaqua.internal.call ('simulator_node_box_index', self.id);
    end

    function [threshold, estimate] = suggest_threshold (self, weights, tolerance)
      % The option 'threshold' that keeps the estimated error at or below `tolerance`.
      [threshold, estimate] = diffaqua.internal.call ('simulator_suggest_threshold', self.id, weights, tolerance);
    end

    % ---------------------------------------------------------------- water
    function set_current_table (self, times, velocities)
      % Velocity of the water, linear between velocities [n_times, dims] (m/s) at times [n_times] (s); [], []: back to
      % the option 'current'.
      diffaqua.internal.call ('simulator_set_current_table', self.id, times, velocities);
      self.functions = [];
      self.table_rows = max (1, numel (times));
    end

    function set_current (self, current, pullback)
      % Velocity of the water current (time) -> [dims] (m/s), asked once a step; backward sweeps give pullback (time,
      % current_bar [dims]) the gradient of each step, last step first. []: back to the options.
      if (nargin < 3)
        pullback = [];
      end
      entry = diffaqua.internal.Functions ('current', current, 'pullback', pullback);
      if (isempty (current))
        diffaqua.internal.call ('simulator_set_current_callback', self.id, 0, 0);
        entry = [];
      else
        diffaqua.internal.call ('simulator_set_current_callback', self.id, entry.id, ~isempty (pullback));
      end
      self.functions = entry;
      self.table_rows = 1;
    end

    % ---------------------------------------------------------------- motion
    function step (self, actuation, tape)
      % One step with actuation [n_signals], each in [-1, 1]. On failure the state is that before the call.
      record = [];
      if (nargin > 2)
        record = diffaqua.internal.id ('tape', tape, 'diffaqua.Tape');
      end
      if (~isempty (record))
        tape.will_record (self, []);
      end
      diffaqua.internal.call ('simulator_step', self.id, actuation, record);
    end

    function rollout (self, controller, n_steps, tape, progress)
      % n_steps steps driven by a controller; tape and progress may be [] or missing. On failure or when stopped, the
      % state is that after the last whole one, and the tape holds the whole ones.
      driver = diffaqua.internal.id ('controller', controller, 'diffaqua.Controller');
      record = [];
      if (nargin > 3)
        record = diffaqua.internal.id ('tape', tape, 'diffaqua.Tape');
      end
      if (nargin < 5)
        progress = [];
      end
      run = diffaqua.internal.Functions ('progress', progress);
      if (~isempty (record))
        tape.will_record (self, controller);
      end
      diffaqua.internal.call ('simulator_rollout', self.id, driver, n_steps, record, run.id);
    end

    function [q, v] = state (self)
      % Positions (m) and velocities (m/s), each [n_nodes, dims].
      [q, v] = diffaqua.internal.call ('simulator_get_state', self.id);
    end

    function set_state (self, q, v)
      % Sets the state, each [n_nodes, dims], and the clock to step 0. []: rest positions, zero velocities.
      if (nargin < 2)
        q = [];
      end
      if (nargin < 3)
        v = [];
      end
      diffaqua.internal.call ('simulator_set_state', self.id, q, v);
    end

    function seen = sensors (self)
      % [5, dims]: velocities of head, centre and tail (m/s), offsets of head and tail from the centre (m).
      seen = diffaqua.internal.call ('simulator_sensors', self.id);
    end

    function totals = forces (self)
      % [4, dims]: drag and thrust of the last step (N), then their means over the wet surface (N/m^2).
      totals = diffaqua.internal.call ('simulator_forces', self.id);
    end

    % ---------------------------------------------------------------- geometry
    function [vertices, elements] = surface (self)
      % The isosurface of the body, carried by the present state: vertices [n, dims] (m), elements [m, dims] of indices
      % that count from 0: patch ('Faces', elements + 1, 'Vertices', vertices).
      [vertices, elements] = diffaqua.internal.call ('simulator_surface', self.id);
    end

    function found = mesh (self)
      % The simulated cells: cell_nodes [n, 2^dims], box_index [n], occupancy [n].
      [nodes, index, occupancy] = diffaqua.internal.call ('simulator_mesh', self.id);
      found = struct ('cell_nodes', nodes, 'box_index', index, 'occupancy', occupancy);
    end

    function record = actuator (self, category, side)
      % What the interpolation made of an actuator: dqa_actuator_info; matrices by rows.
      if (nargin < 3)
        side = 0;
      end
      record = diffaqua.internal.call ('simulator_actuator', self.id, category, side);
    end

    function found = muscles (self)
      % The fibres, one row per cell and fibre group: cells, signals, signs [n], directions [n, dims], stiffness [n].
      [cells, signals, signs, directions, stiffness] = diffaqua.internal.call ('simulator_muscles', self.id);
      found = struct ('cells', cells, 'signals', signals, 'signs', signs, 'directions', directions, ...
                      'stiffness', stiffness);
    end
  end
end
