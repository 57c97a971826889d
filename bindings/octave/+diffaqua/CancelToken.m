% SPDX-License-Identifier: MIT
% Stops the calls of the objects that were made with it as option 'cancel', for instance from a progress function.
classdef CancelToken < diffaqua.internal.Handle
  methods
    function self = CancelToken ()
      self.id = diffaqua.internal.call ('cancel_token_create');
    end

    function set (self)
      diffaqua.internal.call ('cancel_token_set', self.id);
    end

    function reset (self)
      diffaqua.internal.call ('cancel_token_reset', self.id);
    end
  end
end
