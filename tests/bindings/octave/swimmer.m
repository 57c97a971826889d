% SPDX-License-Identifier: MIT
% A swimmer in the small space; solves are tight, since finite differences see their noise.
function made = swimmer (varargin)
  made = diffaqua.Simulator (small_space (), 'young_modulus', 2e5, 'muscle_stiffness', 1e6, 'tolerance', 1e-12, ...
                             'adjoint_tolerance', 1e-12, varargin{:});
  made.set_weights ([0.5, 0.5]);
end
