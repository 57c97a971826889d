% SPDX-License-Identifier: MIT
% handler (level, message) for the library's messages of at most that level (default LOG_INFO); [] silences them. What
% it throws becomes a warning. Messages of threads other than the interpreter's are left out.
function set_log_handler (handler, level)
  persistent kept
  if (nargin < 2)
    c = diffaqua.constants ();
    level = c.LOG_INFO;
  end
  functions = diffaqua.internal.Functions ('log', handler);
  diffaqua.internal.call ('set_log_handler', functions.id, level);
  kept = functions;
end
