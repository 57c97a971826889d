% SPDX-License-Identifier: MIT
% Compiles the gateway into the build folder.
function make_gateway ()
  setenv ('CFLAGS', '-std=c99 -O2 -fPIC -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror');
  folder = getenv ('DQA_GATEWAY');
  diffaqua_make ({fullfile(getenv ('DQA_ROOT'), 'capi'), getenv('DQA_LIBRARY_FOLDER')}, folder);
  assert (exist (fullfile (folder, ['diffaqua_mex.' mexext()]), 'file') > 0);
  printf ('the gateway knows %d commands\n', numel (diffaqua_mex ('commands')));
end
