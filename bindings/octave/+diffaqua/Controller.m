% SPDX-License-Identifier: MIT
% Parameters theta and the map (sensors, step) -> actuation, each signal in [-1, 1]. Made by
%   diffaqua.Controller.sinusoid (n_signals, time_step)
%   diffaqua.Controller.perceptron ('n_signals', 1, 'dims', 2, 'hidden', [64, 64])
%   diffaqua.Controller.callback (evaluate, pullback, 'n_signals', 1, 'theta', theta)
%   diffaqua.Controller.load (path)
classdef Controller < diffaqua.internal.Handle
  properties (SetAccess = private, Hidden)
    functions = []
  end

  methods
    function self = Controller (handle, functions)
      if (nargin < 1 || ~isa (handle, 'uint64'))
        error ('diffaqua:DQA_ERROR_ARGUMENT', 'use Controller.sinusoid, .perceptron, .callback or .load');
      end
      self.id = handle;
      if (nargin > 1)
        self.functions = functions;
      end
    end

    function save (self, path)
      % Writes settings and parameters; Controller.load reads them.
      diffaqua.internal.call ('controller_save', self.id, path);
    end

    function record = info (self)
      % Kind and sizes: dqa_controller_info.
      record = diffaqua.internal.call ('controller_get_info', self.id);
    end

    function theta = parameters (self)
      % A copy of theta [n_parameters].
      theta = diffaqua.internal.call ('controller_get_parameters', self.id);
    end

    function set_parameters (self, theta)
      % Replaces theta [n_parameters].
      diffaqua.internal.call ('controller_set_parameters', self.id, theta);
    end

    function actuation = evaluate (self, step, sensors)
      % Actuation [n_signals] at a step, from sensors [n_sensors], in the order of the header, where it reads them.
      if (nargin < 3)
        sensors = [];
      end
      actuation = diffaqua.internal.call ('controller_evaluate', self.id, step, sensors);
    end
  end

  methods (Static)
    function made = sinusoid (n_signals, time_step)
      % Open loop: a sin (omega t + phi) per signal; theta = (a in [0, 1], omega in rad/s, phi in rad) of each.
      if (nargin < 2)
        time_step = 1 / 30;
      end
      made = diffaqua.Controller (diffaqua.internal.call ('controller_create_sinusoid', n_signals, time_step));
    end

    function made = perceptron (varargin)
      % Closed loop, tanh after every layer; options are the fields of dqa_mlp_options, where `hidden` has the neurons
      % of each hidden layer.
      values = diffaqua.internal.options (varargin{:});
      if (isfield (values, 'n_hidden'))
        error ('diffaqua:DQA_ERROR_ARGUMENT', ...
               'unknown option ''n_hidden'': give `hidden`, the neurons of each hidden layer');
      end
      if (isfield (values, 'hidden'))
        values.n_hidden = numel (values.hidden);
        values.hidden = [values.hidden(:).', ones(1, 5 - values.n_hidden)];  % the rest has no meaning
      end
      made = diffaqua.Controller (diffaqua.internal.call ('controller_create_mlp', values));
    end

    function made = callback (evaluate, pullback, varargin)
      % Functions of Octave's, which must depend on their arguments alone (step counts from 0, time in s; columns):
      %   actuation = evaluate (step, time, sensors, theta)
      %   [theta_bar, sensors_bar] = pullback (step, time, sensors, theta, actuation_bar)      []: no derivatives
      % Options: n_signals, n_sensors (0, or 5 dims; in the order of the header), theta, time_step.
      values = diffaqua.internal.options (varargin{:});
      theta = [];
      if (isfield (values, 'theta'))
        theta = values.theta;
        values = rmfield (values, 'theta');
      end
      if (isempty (evaluate))
        error ('diffaqua:DQA_ERROR_ARGUMENT', 'evaluate: expected a function handle, got nothing');
      end
      functions = diffaqua.internal.Functions ('evaluate', evaluate, 'pullback', pullback);
      made = diffaqua.Controller (diffaqua.internal.call ('controller_create_callback', values, theta, functions.id, ...
                                                          ~isempty (pullback)), functions);
    end

    function made = load (path)
      % The controller of a file that save wrote.
      made = diffaqua.Controller (diffaqua.internal.call ('controller_load', path));
    end
  end
end
