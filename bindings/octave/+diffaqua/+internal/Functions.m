% SPDX-License-Identifier: MIT
% Functions that the library may call for as long as this object lives.
classdef Functions < handle
  properties (SetAccess = private)
    id = 0  % for the gateway; 0: none
  end

  methods
    function self = Functions (name, f, varargin)
      % Functions ('progress', f): f may be empty, then there is none. More pairs: more functions.
      entry = struct ();
      given = [{name, f}, varargin];
      for k = 1:2:numel (given)
        if (isempty (given{k + 1}))
          continue
        end
        if (~isa (given{k + 1}, 'function_handle'))
          error ('diffaqua:DQA_ERROR_ARGUMENT', '%s: expected a function handle, got %s', given{k}, ...
                 class (given{k + 1}));
        end
        entry.(given{k}) = given{k + 1};
      end
      if (~isempty (fieldnames (entry)))
        self.id = diffaqua_callback ('register', entry);
      end
    end

    function delete (self)
      if (self.id ~= 0)
        diffaqua_callback ('forget', self.id);
      end
    end
  end
end
