% SPDX-License-Identifier: MIT
% The same numbers to the last bit, in C's order of elements.
function same (found, expected, what)
  left = permute (found, ndims (found):-1:1)(:);
  right = permute (expected, ndims (expected):-1:1)(:);
  if (numel (left) ~= numel (right))
    error ('test:same', '%s: %d numbers, expected %d', what, numel (left), numel (right));
  end
  off = find (left ~= right & ~(isnan (left) & isnan (right)), 1);
  if (~isempty (off))
    error ('test:same', '%s(%d): found %.17g, expected %.17g', what, off, left(off), right(off));
  end
end
