% SPDX-License-Identifier: MIT
% Of the loaded library: '0.1.0'.
function found = version ()
  found = diffaqua.internal.call ('version');
end
