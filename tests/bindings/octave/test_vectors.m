% SPDX-License-Identifier: MIT
% The test vectors of tests/bindings/vectors, to the last bit of what the C program wrote in this run.
function test_vectors ()
  vectors = read_vectors (getenv ('DQA_VECTORS'));
  spaces = cellfun (@build, vectors.spaces, 'UniformOutput', false);
  runner ({'helpers', @() helpers(vectors)
           'spaces', @() space_vectors(vectors, spaces)
           'rollouts', @() rollouts(vectors, spaces)
           'optimisation', @() optimisation(vectors, spaces)
           'errors', @() errors(vectors, spaces)});
end

function helpers (vectors)
  entry = vectors.project_simplex;
  same (diffaqua.project_simplex (entry.x), entry.result, 'project_simplex');
  entry = vectors.adam_step;
  [x, first, second] = diffaqua.adam_step (entry.x, entry.gradient, entry.rates, entry.first_moment, ...
                                           entry.second_moment, entry.iteration);
  same (x, entry.x_after, 'x_after');
  same (first, entry.first_moment_after, 'first_moment_after');
  same (second, entry.second_moment_after, 'second_moment_after');
end

function space = build (entry)
  space = diffaqua.ShapeSpace (entry.options);
  if (isfield (entry, 'polygons'))
    for k = 1:numel (entry.polygons)
      base = entry.polygons{k};
      space.add_polygon (reshape (base.corners, 2, []).', base.name);
    end
  else
    for k = 1:numel (entry.meshes)
      base = entry.meshes{k};
      space.add_mesh (reshape (base.vertices, 3, []).', reshape (base.triangles, 3, []).', base.name);
    end
  end
  space.build ();
end

function space_vectors (vectors, spaces)
  assert (numel (spaces), 2);
  for k = 1:numel (spaces)
    entry = vectors.spaces{k};
    density = spaces{k}.density (entry.weights);
    same (density, entry.density, 'density');
    bar = permute (reshape (entry.density_bar, flip (size (density))), ndims (density):-1:1);
    same (spaces{k}.pullback (entry.weights, bar), entry.weights_bar, 'weights_bar');
  end
end

function rollouts (vectors, spaces)
  c = diffaqua.constants ();
  assert (numel (vectors.rollouts), 3);
  for k = 1:numel (vectors.rollouts)
    entry = vectors.rollouts{k};
    simulator = diffaqua.Simulator (spaces{entry.space + 1}, entry.options);
    simulator.set_weights (entry.weights);
    described = entry.controller;
    if (strcmp (described.kind, 'sinusoid'))
      controller = diffaqua.Controller.sinusoid (1, simulator.options.time_step);
      controller.set_parameters (described.theta);
    else
      assert (described.options.n_hidden, 1);
      controller = diffaqua.Controller.perceptron (rmfield (described.options, 'n_hidden'));
      same (controller.parameters (), described.theta, 'theta');
    end
    tape = diffaqua.Tape (simulator);
    simulator.rollout (controller, entry.n_steps, tape);
    [loss, per_term] = tape.objective (entry.terms);
    [q, v] = simulator.state ();
    same (loss, entry.loss, 'loss');
    same (per_term, entry.per_term, 'per_term');
    same (q, entry.q, 'q');
    same (v, entry.v, 'v');
    same (simulator.sensors (), entry.sensors, 'sensors');
    same (simulator.forces (), entry.forces, 'forces');
    names = {'weights', 'control', 'actuation', 'initial_position', 'material'};
    wrt = cellfun (@(name) c.(['WRT_' upper(name)]), names, 'UniformOutput', false);
    found = cell (size (names));
    [found{:}] = tape.gradient (entry.terms, wrt{:});
    for g = 1:numel (names)
      same (found{g}, entry.(['gradient_' names{g}]), ['gradient_' names{g}]);
    end
  end
end

function optimisation (vectors, spaces)
  entry = vectors.optimisation;
  c = diffaqua.constants ();
  travel = struct ('kind', c.OBJECTIVE_TRAVEL);
  simulator = diffaqua.Simulator (spaces{entry.space + 1}, entry.options);
  sine = diffaqua.Controller.sinusoid (1, simulator.options.time_step);
  tape = diffaqua.Tape (simulator);
  n = entry.n_bases;
  x = entry.x;
  [first, second] = deal (zeros (size (x)));
  losses = zeros (entry.iterations, 1);
  points = zeros (entry.iterations, numel (x));
  for iteration = 1:entry.iterations
    tape.clear ();
    simulator.set_weights (x(1:n));
    sine.set_parameters (x(n + 1:end));
    simulator.rollout (sine, entry.n_steps, tape);
    losses(iteration) = tape.objective (travel);
    [by_weights, by_control] = tape.gradient (travel, c.WRT_WEIGHTS, c.WRT_CONTROL);
    [x, first, second] = diffaqua.adam_step (x, [by_weights; by_control], entry.rates, first, second, iteration);
    x(1:n) = diffaqua.project_simplex (x(1:n));
    x(n + 1) = min (max (x(n + 1), 0), 1);
    points(iteration, :) = x;
  end
  same (losses, entry.losses, 'losses');
  same (points, entry.x_after, 'x_after');
  assert (losses(end) < 2 * losses(1));
end

function errors (vectors, spaces)
  c = diffaqua.constants ();
  simulator = diffaqua.Simulator (spaces{1}, vectors.optimisation.options);
  assert (numel (vectors.errors), 2);
  for k = 1:numel (vectors.errors)
    entry = vectors.errors{k};
    if (strcmp (entry.call, 'step'))
      simulator.set_weights ([0.5, 0.5]);
    end
    problem = throws (entry.name, '.', @() simulator.(entry.call)(entry.argument));
    assert (problem.message, entry.message);
    assert (c.(strrep (entry.name, 'DQA_', '')), entry.status);
  end
end
