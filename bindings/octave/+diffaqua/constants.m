% SPDX-License-Identifier: MIT
% The constants of diffaqua.h as a struct, without DQA_: c = diffaqua.constants (); c.WRT_WEIGHTS
function c = constants ()
  persistent kept
  if (isempty (kept))
    here = fileparts (mfilename ('fullpath'));
    path = fullfile (here, 'diffaqua.cdef');  % installed; in a checkout where the other languages have it too
    if (~exist (path, 'file'))
      path = fullfile (here, '..', '..', 'diffaqua.cdef');
    end
    found = regexp (fileread (path), 'DQA_(\w+) = (-?\d+)', 'tokens');
    kept = struct ();
    for k = 1:numel (found)
      kept.(found{k}{1}) = str2double (found{k}{2});
    end
  end
  c = kept;
end
