% SPDX-License-Identifier: MIT
% One step of Adam (Kingma & Ba 2015), all [n] (columns come back); iterations count from 1.
function [x, first_moment, second_moment] = adam_step (x, gradient, rates, first_moment, second_moment, iteration)
  [x, first_moment, second_moment] = diffaqua.internal.call ('adam_step', x, gradient, rates, first_moment, ...
                                                             second_moment, iteration);
end
