% SPDX-License-Identifier: MIT
% The point of the simplex (>= 0, sum 1) that is nearest to x [n], as a column.
function point = project_simplex (x)
  point = diffaqua.internal.call ('project_simplex', x);
end
