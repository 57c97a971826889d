% SPDX-License-Identifier: MIT
% The package as it is installed and compiled there, with the lines of its README; and the example, which must gain.
function test_examples ()
  runner ({'the lines of the README, installed', @readme
           'the example gains', @example});
end

function [status, text] = shell (pattern, varargin)
  [status, text] = system (sprintf ([pattern, ' 2>&1'], varargin{:}));
  assert (status == 0, [strrep(pattern, '%', '%%') ': ' strrep(text, '%', '%%')]);
end

function readme ()
  home = fullfile (pwd (), 'home');
  prefix = fullfile (home, '.local');
  for component = {'runtime', 'octave'}
    shell ('"%s" --install "%s" --prefix "%s" --component %s', getenv ('CMAKE'), getenv ('DQA_BUILD'), prefix, ...
           component{1});
  end
  % Of the component dev only what the gateway needs: the rest of it may not have been built (abi/install tests it).
  shell ('mkdir "%s/include" && cp "%s/capi/diffaqua.h" "%s/include"', prefix, getenv ('DQA_ROOT'), prefix);
  shell ('ln -s "$(basename %s/lib/libdiffaqua.so.?)" "%s/lib/libdiffaqua.so"', prefix, prefix);
  blocks = regexp (fileread (fullfile (getenv ('DQA_ROOT'), 'bindings', 'octave', 'README.md')), ...
                   '```matlab\n(.*?)```', 'tokens');
  assert (numel (blocks), 2);
  file = fopen ('lines.m', 'w');
  fprintf (file, '%s', blocks{1}{1}, blocks{2}{1});
  fclose (file);
  [~, text] = shell ('cd "%s" && HOME="%s" octave-cli --norc --no-history "%s"', getenv ('DQA_ROOT'), home, ...
                     fullfile (pwd (), 'lines.m'));
  numbers = str2double (regexp (text, '-?\d\.\d+e[+-]\d+', 'match'));
  assert (numel (numbers), 1 + 2 + 3, strrep (text, '%', '%%'));
  assert (numbers(1) ~= 0);
  assert (numbers(2), -numbers(3), 1e-12);  % by the weights: mean-free
end

function example ()
  addpath (fullfile (getenv ('DQA_ROOT'), 'bindings', 'octave', 'examples'));
  travels = swim (6, 20);
  assert (numel (travels), 6);
  assert (travels(6) > 1.5 * travels(1));
end
