% SPDX-License-Identifier: MIT
% An object of the library: closed by close, by clear, or when nothing refers to it any more, in any order.
classdef Handle < handle
  properties (SetAccess = protected, Hidden)
    id = uint64 (0)  % what the gateway knows it by; 0: closed
  end

  methods
    function close (self)
      % Gives its memory back; further use throws. Again: nothing happens. What was made from it stays.
      if (self.id ~= 0)
        diffaqua.internal.call ('free', self.id);
        self.id = uint64 (0);
      end
    end

    function yes = is_open (self)
      yes = self.id ~= 0;
    end

    function delete (self)
      if (self.id ~= 0)
        try
          diffaqua_mex ('free', self.id);
        catch
          % at the end of the session the gateway may be gone first, and has closed everything
        end
      end
    end
  end
end
