% SPDX-License-Identifier: MIT
% run () must throw an error with that identifier (diffaqua: may be left out) whose message has the pattern.
function problem = throws (identifier, pattern, run)
  if (~any (identifier == ':'))
    identifier = ['diffaqua:' identifier];
  end
  problem = [];
  try
    run ();
  catch problem
  end
  if (isempty (problem))
    error ('test:throws', 'nothing was thrown, expected %s: %s', identifier, pattern);
  end
  if (~strcmp (problem.identifier, identifier) || isempty (regexp (problem.message, pattern, 'once')))
    error ('test:throws', 'thrown: %s: %s; expected %s: %s', problem.identifier, problem.message, identifier, pattern);
  end
end
