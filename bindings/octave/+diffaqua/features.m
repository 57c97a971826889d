% SPDX-License-Identifier: MIT
% What the library was built with, as a cell array: {'stl', 'openmp', ...}.
function list = features ()
  list = strsplit (strtrim (diffaqua.internal.call ('features')), ' ');
end
