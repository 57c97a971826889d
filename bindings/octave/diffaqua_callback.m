% SPDX-License-Identifier: MIT
% The functions that the library calls, by number, and what they throw. The gateway (diffaqua_mex) calls
%   [stop, first, second] = diffaqua_callback (what, id, arguments ...)
% An error never crosses the library: it is kept here, the call is told to stop, and diffaqua.internal.call throws it
% again where the call returns. The first one counts.
function [stop, first, second] = diffaqua_callback (what, varargin)
  persistent functions pending
  if (isempty (functions))
    functions = {};
  end
  first = [];
  second = [];
  switch (what)
    case 'register'  % (struct of functions) -> id
      stop = find (cellfun (@isempty, functions), 1);
      if (isempty (stop))
        stop = numel (functions) + 1;
      end
      functions{stop} = varargin{1};
    case 'forget'  % (id)
      stop = 0;
      functions{varargin{1}} = [];
    case 'count'
      stop = sum (~cellfun (@isempty, functions));
    case 'take'  % what was thrown, or []
      stop = pending;
      pending = [];
    otherwise
      outer = pending;  % calls inside the function must not throw what is another call's to throw
      pending = [];
      thrown = [];
      stop = 1;
      try
        [stop, first, second] = run (what, functions{varargin{1}}, varargin(2:end));
      catch problem
        if (strcmp (what, 'log'))  % there is no call that it could come out of
          warning ('diffaqua:log', 'the log handler failed: %s', problem.message);
        else
          thrown = problem;
        end
      end
      pending = outer;
      if (isempty (pending))
        pending = thrown;
      end
  end
end

function [stop, first, second] = run (what, entry, given)
  stop = 0;
  first = [];
  second = [];
  switch (what)
    case 'progress'
      stop = double (is_true (entry.progress, given));
    case 'log'
      entry.log (given{:});
    case 'current'
      first = vector ('current', entry.current (given{2}), given{1});
    case 'current_pullback'
      entry.pullback (given{:});
    case 'evaluate'
      first = vector ('evaluate', entry.evaluate (given{2:end}), given{1});
    case 'pullback'
      [first, second] = entry.pullback (given{:});
      first = vector ('pullback: by theta', first, numel (given{4}));
      second = vector ('pullback: by sensors', second, numel (given{3}));
  end
end

% A function may return nothing; of an anonymous one that cannot be known before.
function yes = is_true (progress, given)
  answer = [];
  if (nargout (progress) == 0)
    progress (given{:});
  else
    try
      answer = progress (given{:});
    catch problem
      if (~isempty (regexp (problem.message, '[Tt]oo many output', 'once')))  % it was not run
        progress (given{:});
      elseif (isempty (regexp (problem.message, '^value on the right hand side', 'once')))  % nor did it end so
        rethrow (problem);
      end
    end
  end
  yes = ~isempty (answer) && any (answer(:));
end

function values = vector (name, values, n)
  if (~(isnumeric (values) || islogical (values)) || ~isreal (values) || numel (values) ~= n)
    error ('diffaqua:DQA_ERROR_ARGUMENT', '%s: expected %d real numbers, got %s [%s]', name, n, class (values), ...
           strjoin (arrayfun (@(m) sprintf ('%d', m), size (values), 'UniformOutput', false), ', '));
  end
  values = double (full (values(:)));
end
