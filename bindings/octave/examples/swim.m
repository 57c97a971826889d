% SPDX-License-Identifier: MIT
% Two fish seen from above and the sine that bends a mix of them, optimised for the distance travelled:
%   swim (iterations, steps)
% Returns the distance (m) of each iteration.
function travels = swim (iterations, steps)
  if (nargin < 1)
    iterations = 20;
  end
  if (nargin < 2)
    steps = 30;
  end
  c = diffaqua.constants ();
  space = diffaqua.ShapeSpace ('dims', 2, 'cells_x', 32, 'cells_y', 12, 'sigma', 0.7);
  space.add_polygon (outline_of (0.05), 'slim');
  space.add_polygon (outline_of (0.12), 'stout');
  simulator = diffaqua.Simulator (space.build (), 'young_modulus', 5e5, 'muscle_stiffness', 1e6);
  sine = diffaqua.Controller.sinusoid (1);
  tape = diffaqua.Tape (simulator);
  travel = struct ('kind', c.OBJECTIVE_TRAVEL);

  % x: two weights on the simplex, then amplitude in [0, 1], frequency (rad/s) and phase of the sine.
  x = [0.5; 0.5; 0.6; 15; 0];
  rates = [0.05; 0.05; 0.05; 0.5; 0.1];
  first = zeros (5, 1);
  second = zeros (5, 1);
  travels = zeros (1, iterations);
  for iteration = 1:iterations
    tape.clear ();
    simulator.set_weights (x(1:2));
    sine.set_parameters (x(3:5));
    simulator.rollout (sine, steps, tape);
    travels(iteration) = -tape.objective (travel);
    fprintf ('%3d: travels %7.2f mm with %2.0f %% slim, amplitude %.2f, %.1f rad/s\n', iteration, ...
             1e3 * travels(iteration), 100 * x(1), x(3), x(4));
    [by_weights, by_control] = tape.gradient (travel, c.WRT_WEIGHTS, c.WRT_CONTROL);
    [x, first, second] = diffaqua.adam_step (x, [by_weights; by_control], rates, first, second, iteration);
    x(1:2) = diffaqua.project_simplex (x(1:2));
    x(3) = min (max (x(3), 0), 1);
  end
end

function corners = outline_of (width)
  s = ((0:39).' + 0.5) / 40;
  half = 0.02 + width * sin (pi * s .^ 0.7) + max (0, 0.25 * (s - 0.75));
  corners = [0.5 - s, half; flipud([0.5 - s, -half])];
end
