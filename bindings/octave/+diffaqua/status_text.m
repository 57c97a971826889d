% SPDX-License-Identifier: MIT
% One sentence on what a status means: diffaqua.status_text (c.ERROR_MESH).
function sentence = status_text (status)
  sentence = diffaqua.internal.call ('status_text', status);
end
