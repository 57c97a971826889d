% SPDX-License-Identifier: MIT
% A cursor over a finished tape that walks back from its last step: diffaqua.Adjoint (tape). Seeds add up.
classdef Adjoint < diffaqua.internal.Handle
  properties (SetAccess = private, Hidden)
    functions
    nodes   % [n_nodes, dims]
    shapes  % by with_respect_to + 1
  end

  methods
    function self = Adjoint (tape)
      parent = diffaqua.internal.id ('tape', tape, 'diffaqua.Tape');
      tape.must_have_steps ();
      self.id = diffaqua.internal.call ('adjoint_create', parent);
      self.functions = tape.functions;
      self.nodes = [tape.n_nodes, tape.sizes.dims];
      c = diffaqua.constants ();
      steps = tape.n_steps ();
      s = tape.sizes;
      self.shapes = cell (1, 12);
      self.shapes{c.WRT_WEIGHTS + 1} = s.n_bases;
      self.shapes{c.WRT_CONTROL + 1} = tape.n_parameters;
      self.shapes{c.WRT_ACTUATION + 1} = [steps, s.n_signals];
      self.shapes{c.WRT_INITIAL_POSITION + 1} = self.nodes;
      self.shapes{c.WRT_INITIAL_VELOCITY + 1} = self.nodes;
      self.shapes{c.WRT_WATER + 1} = s.dims + 9;
      self.shapes{c.WRT_CURRENT + 1} = [steps, s.dims];
      self.shapes{c.WRT_CURRENT_TABLE + 1} = [tape.table_rows, s.dims];
      self.shapes{c.WRT_YOUNGS_MODULUS + 1} = s.n_cells;
      self.shapes{c.WRT_MUSCLE_STIFFNESS + 1} = s.n_cells;
      self.shapes{c.WRT_MATERIAL + 1} = 4;
      self.shapes{c.WRT_LAME + 1} = 2;
    end

    function seed (self, step, quantity, bar)
      % Adds bar [n_nodes, dims] to dL/dq or dL/dv (c.SEED_POSITION, c.SEED_VELOCITY) of the state after `step` steps.
      diffaqua.internal.call ('adjoint_seed', self.id, step, quantity, bar, self.nodes);
    end

    function seed_objective (self, terms)
      % Adds the seeds of a loss; only before the sweep has begun.
      diffaqua.internal.call ('adjoint_seed_objective', self.id, terms);
    end

    function backward (self, to_step, progress)
      % Runs the sweep back to the state after `to_step` steps (default 0); goes on where it was stopped.
      if (nargin < 2)
        to_step = 0;
      end
      if (nargin < 3)
        progress = [];
      end
      run = diffaqua.internal.Functions ('progress', progress);
      diffaqua.internal.call ('adjoint_backward', self.id, to_step, run.id);
    end

    function values = gradient (self, wrt)
      % A gradient, in the shape that the header gives. All but ACTUATION and CURRENT need the whole sweep.
      if (~isnumeric (wrt) || ~isscalar (wrt) || ~any (wrt == 0:numel (self.shapes) - 1))
        error ('diffaqua:DQA_ERROR_ARGUMENT', 'wrt: expected one of WRT_WEIGHTS, ... of diffaqua.constants');
      end
      shape = self.shapes{wrt + 1};
      if (isempty (shape))
        error ('diffaqua:DQA_ERROR_STATE', ...
               'wrt: no controller drove this tape; its steps have the gradient WRT_ACTUATION');
      end
      values = diffaqua.internal.call ('adjoint_get', self.id, wrt, shape);
    end
  end
end
