% SPDX-License-Identifier: MIT
% Runs tests, a cell array of {name, function; ...}, and ends Octave with 0 when all pass.
function runner (tests)
  failures = 0;
  for k = 1:size (tests, 1)
    word = 'ok    ';
    problem = [];
    try
      tests{k, 2} ();
    catch problem
      word = 'FAILED';
      failures = failures + 1;
    end
    printf ('%s %s\n', word, tests{k, 1});
    if (~isempty (problem))
      printf ('%s: %s\n', problem.identifier, problem.message);
      for frame = problem.stack(:)'
        printf ('    %s:%d\n', frame.name, frame.line);
      end
    end
  end
  printf ('%d tests, %d failed\n', size (tests, 1), failures);
  exit (double (failures > 0 || isempty (tests)));
end
