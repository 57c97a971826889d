% SPDX-License-Identifier: MIT
% [options, cancel] = options (struct) or options ('name', value, ...): a struct for the gateway, without the cancel
% token that may be among them, whose handle comes second.
function [values, cancel] = options (varargin)
  cancel = [];
  if (numel (varargin) == 1 && isstruct (varargin{1}))
    values = varargin{1};
  else
    if (mod (numel (varargin), 2) ~= 0 || ~iscellstr (varargin(1:2:end)))
      error ('diffaqua:DQA_ERROR_ARGUMENT', 'options: expected a struct, or pairs of names and values');
    end
    values = struct ();
    for k = 1:2:numel (varargin)
      values.(varargin{k}) = varargin{k + 1};
    end
  end
  if (isfield (values, 'cancel'))
    cancel = diffaqua.internal.id ('cancel', values.cancel, 'diffaqua.CancelToken');
    values = rmfield (values, 'cancel');
  end
end
