% SPDX-License-Identifier: MIT
% The JSON file of the test vectors, with numbers to the last bit: those of jsondecode may be off by one. Numbers are
% read as texts, which sscanf turns into the nearest double. Lists of objects become cell arrays.
function value = read_vectors (path)
  text = strrep (fileread (path), sprintf ('\n'), ' ');
  text = regexprep (text, '": \[([-\d][-\d.eE+, ]*)\]', '": "=$1"');
  text = regexprep (text, '": (-?\d[\d.eE+-]*)', '": "=$1"');
  value = exact (jsondecode (text));
end

function value = exact (value)
  if (ischar (value) && ~isempty (value) && value(1) == '=')
    value = sscanf (strrep (value(2:end), ',', ' '), '%f');
  elseif (iscell (value))
    value = cellfun (@exact, value, 'UniformOutput', false);
  elseif (isstruct (value) && numel (value) ~= 1)
    value = arrayfun (@exact, value, 'UniformOutput', false);
  elseif (isstruct (value))
    value = structfun (@exact, value, 'UniformOutput', false);
  end
end
