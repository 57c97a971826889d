% SPDX-License-Identifier: MIT
% Calls a command of the gateway. Throws what a callback threw, as it was, or diffaqua:<name of the status> with the
% library's message.
function varargout = call (command, varargin)
  try
    [varargout{1:nargout}] = diffaqua_mex (command, varargin{:});
  catch problem
    own = diffaqua_callback ('take');
    if (~isempty (own))
      rethrow (own);
    end
    if (isempty (problem.identifier))
      rethrow (problem);  % not the gateway's
    end
    error (problem.identifier, '%s', regexprep (problem.message, '^diffaqua_mex: ', ''));
  end
end
