% SPDX-License-Identifier: MIT
% A fish from above [64, 2].
function corners = outline (width)
  s = ((0:31).' + 0.5) / 32;
  half = 0.02 + width * sin (pi * s .^ 0.75) + max (0, 0.25 * (s - 0.75));
  corners = [0.5 - s, half; flipud([0.5 - s, -half])];
end
