% SPDX-License-Identifier: MIT
% Proves (or refutes) a gradient by finite differences along a random direction: dqa_gradient_check_report. controller
% may be []; options are the fields of dqa_gradient_check_options. The simulator is unchanged.
function report = check_gradient (simulator, controller, terms, varargin)
  scene = diffaqua.internal.id ('simulator', simulator, 'diffaqua.Simulator');
  driver = diffaqua.internal.id ('controller', controller, 'diffaqua.Controller');
  report = diffaqua.internal.call ('check_gradient', scene, driver, terms, diffaqua.internal.options (varargin{:}));
end
