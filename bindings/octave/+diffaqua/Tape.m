% SPDX-License-Identifier: MIT
% The record of one rollout of a simulator: diffaqua.Tape (simulator, 'memory_bytes', budget).
%
% A loss is a struct array of terms, or a cell array of structs: fields of dqa_objective_term and `path` [n, 1 + dims],
% such as struct ('kind', c.OBJECTIVE_TRAVEL) with c = diffaqua.constants (). It is their weighted sum.
classdef Tape < diffaqua.internal.Handle
  properties (SetAccess = private, Hidden)
    simulator
    functions = {}  % that the library may call for the steps
    design = 0
    n_nodes = 0
    n_parameters = []
    table_rows = 1
    sizes           % of the simulator: dims, n_bases, n_signals, n_cells
  end

  methods
    function self = Tape (simulator, varargin)
      parent = diffaqua.internal.id ('simulator', simulator, 'diffaqua.Simulator');
      self.id = diffaqua.internal.call ('tape_create', parent, diffaqua.internal.options (varargin{:}));
      record = simulator.info ();
      self.simulator = simulator;
      self.sizes = struct ('dims', record.dims, 'n_bases', record.n_bases, 'n_signals', record.n_signals, ...
                           'n_cells', simulator.n_cells);
    end

    function will_record (self, simulator, controller)
      % What the library calls for these steps must outlive the tape, even if recording fails half-way.
      if (~isempty (simulator.functions))
        self.functions{end + 1} = simulator.functions;
      end
      if (~isempty (controller))
        if (~isempty (controller.functions))
          self.functions{end + 1} = controller.functions;
        end
        record = controller.info ();
        self.n_parameters = record.n_parameters;
      end
      if (self.design == 0 || self.n_steps () == 0)
        record = simulator.info ();
        self.design = simulator.design;
        self.n_nodes = record.n_nodes;
      end
      self.table_rows = simulator.table_rows;
    end

    function clear (self)
      % Empties the tape for another rollout; throws while an adjoint of it lives.
      diffaqua.internal.call ('tape_clear', self.id);
      self.functions = {};
      self.design = 0;
      self.n_parameters = [];
    end

    function n = n_steps (self)
      % Recorded so far.
      n = diffaqua.internal.call ('tape_n_steps', self.id);
    end

    function must_have_steps (self)
      if (self.design == 0)
        error ('diffaqua:DQA_ERROR_STATE', 'nothing is recorded on this tape');
      end
    end

    function [q, v] = state (self, step)
      % Positions and velocities after `step` steps, each [n_nodes, dims]; cheapest in order under a budget.
      self.must_have_steps ();
      [q, v] = diffaqua.internal.call ('tape_get_state', self.id, step, [self.n_nodes, self.sizes.dims]);
    end

    function values = actuation (self, step)
      % Used in step `step` [n_signals]; steps count from 0.
      values = diffaqua.internal.call ('tape_get_actuation', self.id, step, self.sizes.n_signals);
    end

    function values = current (self, step)
      % Velocity of the water [dims] (m/s) during step `step`.
      values = diffaqua.internal.call ('tape_get_current', self.id, step, self.sizes.dims);
    end

    function vertices = surface (self, step, n_vertices)
      % Vertices [n_vertices, dims] of the surface after `step` steps; its elements are those of simulator.surface for
      % the same design. Their number must be given once the simulator has another design.
      if (nargin < 3)
        if (self.simulator.design ~= self.design)
          error ('diffaqua:DQA_ERROR_STATE', ...
                 'the simulator has another design now: give n_vertices of that of the tape');
        end
        n_vertices = size (self.simulator.surface (), 1);
      end
      vertices = diffaqua.internal.call ('tape_get_surface', self.id, step, [n_vertices, self.sizes.dims]);
    end

    function record = statistics (self)
      % Memory, iterations and residuals: dqa_tape_statistics.
      record = diffaqua.internal.call ('tape_stats', self.id);
    end

    function [loss, per_term] = objective (self, terms)
      % The loss of the recorded rollout, and its unweighted terms [n_terms].
      [loss, per_term] = diffaqua.internal.call ('tape_objective', self.id, terms);
    end

    function varargout = gradient (self, terms, varargin)
      % Gradients of a loss, one result for each of c.WRT_WEIGHTS, ... : a whole backward sweep.
      adjoint = diffaqua.Adjoint (self);
      closing = onCleanup (@() adjoint.close ());
      adjoint.seed_objective (terms);
      adjoint.backward ();
      for k = 1:numel (varargin)
        varargout{k} = adjoint.gradient (varargin{k});
      end
    end
  end
end
