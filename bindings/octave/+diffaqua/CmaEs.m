% SPDX-License-Identifier: MIT
% CMA-ES: minimises a function of n numbers from its values alone. diffaqua.CmaEs (mean, scales, 'seed', 1): scales [n]
% or [] (all 1); options are the fields of dqa_cma_es_options.
classdef CmaEs < diffaqua.internal.Handle
  methods
    function self = CmaEs (mean, scales, varargin)
      if (isa (mean, 'uint64'))  % a handle, from load
        self.id = mean;
        return
      end
      if (nargin < 2)
        scales = [];
      end
      self.id = diffaqua.internal.call ('cma_es_create', diffaqua.internal.options (varargin{:}), mean, scales);
    end

    function save (self, path)
      % Writes the state, which goes on with the same bits; CmaEs.load reads it.
      diffaqua.internal.call ('cma_es_save', self.id, path);
    end

    function record = info (self)
      % Sizes, generation, and how wide the search still is: dqa_cma_es_info.
      record = diffaqua.internal.call ('cma_es_get_info', self.id);
    end

    function candidates = ask (self)
      % [population, n] of this generation.
      candidates = diffaqua.internal.call ('cma_es_ask', self.id);
    end

    function tell (self, values)
      % Values [population] of the candidates in their order, Inf for what could not be evaluated.
      diffaqua.internal.call ('cma_es_tell', self.id, values);
    end

    function [x, value] = best (self)
      % The candidate [n] of the lowest value so far, and that value.
      [x, value] = diffaqua.internal.call ('cma_es_best', self.id);
    end

    function x = mean (self)
      % Centre of the distribution [n]: often better than any candidate.
      x = diffaqua.internal.call ('cma_es_mean', self.id);
    end
  end

  methods (Static)
    function search = load (path)
      % The search of a file that save wrote.
      search = diffaqua.CmaEs (diffaqua.internal.call ('cma_es_load', path));
    end
  end
end
