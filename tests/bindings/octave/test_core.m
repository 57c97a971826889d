% SPDX-License-Identifier: MIT
% The package over the C interface: declarations, arrays, options, errors, lives of objects, callbacks.
function test_core ()
  runner ({'every function of the header is used', @declared
           'structs and constants', @structs
           'what goes in', @arrays
           'options', @options
           'handles', @handles
           'errors', @errors
           'objects close in any order', @lives
           'a child outlives its parents', @children
           'objects close when they are cleared', @cleared
           'not closed while a call uses it', @in_use
           'progress', @progress
           'errors come out of callbacks unchanged', @thrown
           'a controller of functions and its pullback', @callback_controller
           'what callbacks return', @returned
           'currents', @currents
           'log', @logged
           'cancel token', @cancel_token
           'space', @space
           'bases', @bases
           'simulator', @simulator
           'tape', @tape
           'controllers', @controllers
           'search', @search});
end

function t = travel ()
  c = diffaqua.constants ();
  t = struct ('kind', c.OBJECTIVE_TRAVEL);
end

function list = declared_functions ()
  text = fileread (fullfile (getenv ('DQA_ROOT'), 'bindings', 'diffaqua.cdef'));
  list = regexp (text, '\<dqa_(\w+)\([\w *,]*\);', 'tokens');
  list = cellfun (@(t) t{1}, list, 'UniformOutput', false);
end

% ------------------------------------------------------------------ declarations
function declared ()
  known = diffaqua_mex ('commands');
  reasons = {'abi_version', 'compared when the gateway is loaded'
             'last_error', 'the message of every error'};
  functions = declared_functions ();
  assert (numel (functions) >= 90);
  for k = 1:numel (functions)
    name = functions{k};
    if (any (strcmp (name, known)) || any (strcmp (name, reasons(:, 1))))
      continue
    end
    % Options are filled by the functions that take them; free closes any object.
    assert (~isempty (regexp (name, '(_options|_term)_init$|_free$', 'once')), [name ' cannot be reached']);
  end
  % And every command is used by the package.
  files = [dir(fullfile (getenv ('DQA_ROOT'), 'bindings', 'octave', '+diffaqua', '*.m'))
           dir(fullfile (getenv ('DQA_ROOT'), 'bindings', 'octave', '+diffaqua', '+internal', '*.m'))];
  text = '';
  for k = 1:numel (files)
    text = [text, fileread(fullfile (files(k).folder, files(k).name))];
  end
  unused = known(cellfun (@(name) isempty (strfind (text, ['''' name ''''])), known));
  % The identifier says the name; info has the number; the others are for tests.
  assert (sort (unused(:)), sort ({'status_name'; 'controller_n_parameters'; 'n_objects'; 'fields'; 'commands'}));
end

function structs ()
  text = fileread (fullfile (getenv ('DQA_ROOT'), 'bindings', 'diffaqua.cdef'));
  found = regexp (text, 'typedef struct (\w+) \{(.*?)\} \w+;', 'tokens');
  assert (numel (found) >= 17);
  for k = 1:numel (found)
    fields = regexp (found{k}{2}, '(double|u?int(?:32|64)_t) (\w+)(?:\[\d+\])?;', 'tokens');
    names = cellfun (@(f) f{2}, fields, 'UniformOutput', false);
    names = names(~ismember (names, {'struct_size', 'flags', 'padding', 'n_path'}));
    assert (diffaqua_mex ('fields', found{k}{1})(:), names(:), found{k}{1});
  end
  throws ('DQA_ERROR_ARGUMENT', 'there is no dqa_fish', @() diffaqua_mex ('fields', 'dqa_fish'));
  c = diffaqua.constants ();
  assert ([c.WRT_LAME, c.DIVERGED], [11, -9]);
  assert (diffaqua_mex ('status_name', c.ERROR_MESH), 'DQA_ERROR_MESH');
  assert (~isempty (strfind (diffaqua.status_text (c.ERROR_MESH), 'mesh')));
  header = fileread (fullfile (getenv ('DQA_ROOT'), 'capi', 'diffaqua.h'));
  numbers = regexp (header, '#define DQA_VERSION_(?:MAJOR|MINOR|PATCH) +(\d+)', 'tokens');
  assert (diffaqua.version (), strjoin (cellfun (@(n) n{1}, numbers, 'UniformOutput', false), '.'));
  assert (iscellstr (diffaqua.features ()));
end

% ------------------------------------------------------------------ arrays and options
function arrays ()
  A = 'DQA_ERROR_ARGUMENT';
  s = small_space ();
  expected = s.density ([0.25, 0.75]);
  assert (size (expected), [20, 8]);
  same (s.density ([0.25; 0.75]), expected, 'column');
  same (s.density (single ([0.25, 0.75])), expected, 'single');
  same (s.density (int8 ([1, 0])), s.density ([1, 0]), 'int8');
  same (s.density ([true, false]), s.density ([1, 0]), 'logical');
  throws (A, 'weights: expected real numbers, got complex double', @() s.density ([1i, 0]));
  throws (A, 'weights: expected real numbers, got sparse double', @() s.density (sparse ([1, 0])));
  throws (A, 'weights: expected real numbers, got char', @() s.density ('ab'));
  throws (A, 'weights: expected real numbers, got cell', @() s.density ({1, 0}));
  throws (A, 'weights: expected shape \[any\], got \[2, 2\]', @() s.density (ones (2) / 4));
  throws (A, 'weights', @() s.density ([0.3, 0.3]));
  throws (A, 'weights', @() s.density ([NaN, 1]));
  throws (A, 'weights', @() s.density (1));
  throws (A, 'weights', @() s.density ([]));
  throws (A, 'density_bar: expected shape \[20, 8, 1\], got \[8, 20\]', @() s.pullback ([0.5, 0.5], expected.'));
  throws (A, 'density_bar: expected shape .* got \[20, 8, 2\]', @() s.pullback ([0.5, 0.5], zeros (20, 8, 2)));
  open = diffaqua.ShapeSpace ('dims', 2, 'cells_x', 20, 'cells_y', 8);
  throws (A, 'corners: expected shape \[any, 2\], got \[2, 5\]', @() open.add_polygon (zeros (2, 5)));
  throws (A, 'n_corners|corners', @() open.add_polygon ([]));
  throws (A, 'name: expected a text, got double', @() open.add_polygon (outline (0.1), 7));
  solid = diffaqua.ShapeSpace ();
  throws (A, 'triangles: expected a whole number, got 1.5', @() solid.add_mesh (zeros (3), [0, 1, 1.5]));
  throws (A, 'triangles: expected a number in', @() solid.add_mesh (zeros (3), [0, 1, 2^31]));
  throws ('DQA_ERROR_MESH', '.', @() solid.add_mesh ([0, 0, 0; 1, 0, 0; 0, 1, 0], [0, 1, 2]));
  throws (A, 'path: expected a text, got double', @() solid.add_mesh_file (3));
end

function options ()
  A = 'DQA_ERROR_ARGUMENT';
  make = @(varargin) diffaqua.ShapeSpace (varargin{:});
  throws (A, 'unknown option ''sigmoid'', expected one of .*sigma', @() make ('sigmoid', 1));
  throws (A, 'unknown option ''struct_size''', @() make (struct ('struct_size', 1)));
  throws (A, 'cells_x: expected real numbers, got char', @() make ('cells_x', '2'));
  throws (A, 'cells_x: expected a whole number, got 20.5', @() make ('cells_x', 20.5));
  throws (A, 'cells_x: expected a number in', @() make ('cells_x', 2^31));
  throws (A, 'cells_x: expected 1 number, got 2', @() make ('cells_x', [1, 2]));
  throws (A, 'sigma', @() make ('sigma', -1));
  throws (A, 'pairs of names and values', @() make ('sigma'));
  throws (A, 'pairs of names and values', @() make (3, 4));
  throws (A, 'cancel: expected a diffaqua.CancelToken, got double', @() make ('cancel', 3));
  s = small_space ();
  throws (A, 'current: expected 3 numbers, got 2', @() diffaqua.Simulator (s, 'current', [1, 2]));
  assert (diffaqua.Simulator (s, 'time_step', 0.25).options.time_step, 0.25);
  network = @(varargin) diffaqua.Controller.perceptron (varargin{:});
  throws (A, 'seed: expected a number in \[0', @() network ('seed', -1));
  throws (A, 'give `hidden`', @() network ('n_hidden', 1));
  throws (A, 'hidden: expected 5 numbers, got 6', @() network ('hidden', ones (1, 6)));
  same (network ('seed', 2^53, 'hidden', 2).parameters (), ...
        network ('seed', uint64 (9007199254740992), 'hidden', 2).parameters (), 'seed of 64 bits');
  throws (A, 'Controller.sinusoid', @() diffaqua.Controller ());
end

% ------------------------------------------------------------------ errors and lives
function handles ()
  A = 'DQA_ERROR_ARGUMENT';
  sine = diffaqua.Controller.sinusoid (1);
  throws (A, 'simulator: expected a simulator, got a controller', ...
          @() diffaqua.internal.call ('simulator_get_info', sine.id));
  throws (A, 'expected a handle, got double', @() diffaqua.internal.call ('simulator_get_info', 3));
  throws (A, 'expected a handle, got uint64', @() diffaqua.internal.call ('simulator_get_info', uint64 ([1, 2])));
  throws ('DQA_ERROR_STATE', 'this simulator is closed', ...
          @() diffaqua.internal.call ('simulator_get_info', uint64 (12345)));
  old = sine.id;
  sine.close ();
  throws ('DQA_ERROR_STATE', 'this controller is closed', @() diffaqua.internal.call ('controller_get_info', old));
  diffaqua.internal.call ('free', old);  % again: nothing happens
  again = diffaqua.Controller.sinusoid (1);
  assert (again.id ~= old);
  throws (A, 'unknown command ''fish''', @() diffaqua.internal.call ('fish'));
  throws (A, 'command: expected the name', @() diffaqua_mex ());
  throws (A, 'simulator_step: expected 2 to 3 arguments, got 1', ...
          @() diffaqua.internal.call ('simulator_step', again.id));
end

function errors ()
  caught = throws ('DQA_ERROR_IO', 'fish\.stl', @() diffaqua.ShapeSpace ().add_mesh_file ('/nowhere/fish.stl'));
  assert (caught.identifier, 'diffaqua:DQA_ERROR_IO');
  path = tempname ();
  fclose (fopen (path, 'w'));
  throws ('DQA_ERROR_FILE', '.', @() diffaqua.ShapeSpace.load (path));
  delete (path);
  before = diffaqua_mex ('n_objects');
  throws ('DQA_ERROR_STATE', '.', @() diffaqua.Simulator (diffaqua.ShapeSpace ()));
  throws ('DQA_ERROR_ARGUMENT', 'n_signals', @() diffaqua.Controller.sinusoid (0));
  throws ('DQA_ERROR_ARGUMENT', 'space: expected a diffaqua.ShapeSpace, got double', @() diffaqua.Simulator (3));
  throws ('DQA_ERROR_ARGUMENT', 'space: expected a handle', @() diffaqua.Simulator ([]));
  throws ('DQA_ERROR_ARGUMENT', 'n_steps: expected a whole number', ...
          @() swimmer ().rollout (diffaqua.Controller.sinusoid (1), 1.5));
  throws ('DQA_ERROR_ARGUMENT', 'controller: expected a diffaqua.Controller', ...
          @() swimmer ().rollout (small_space (), 1));
  assert (diffaqua_mex ('n_objects'), before);  % failures leave nothing
end

function lives ()
  for order = {{'space', 'simulator', 'sine', 'tape', 'adjoint'}, {'adjoint', 'tape', 'sine', 'simulator', 'space'}}
    o.space = small_space ();
    o.simulator = diffaqua.Simulator (o.space);
    o.simulator.set_weights ([0.5, 0.5]);
    o.sine = diffaqua.Controller.sinusoid (1);
    o.tape = diffaqua.Tape (o.simulator);
    o.simulator.rollout (o.sine, 3, o.tape);
    o.adjoint = diffaqua.Adjoint (o.tape);
    for name = order{1}
      assert (o.(name{1}).is_open ());
      o.(name{1}).close ();
      o.(name{1}).close ();
      assert (~o.(name{1}).is_open ());
    end
    S = 'DQA_ERROR_STATE';
    throws (S, 'this shape space is closed', @() o.space.info ());
    throws (S, 'this shape space is closed', @() diffaqua.Simulator (o.space));
    throws (S, 'this simulator is closed', @() o.simulator.step (0));
    throws (S, 'this controller is closed', @() o.sine.parameters ());
    throws (S, 'this tape is closed', @() o.tape.n_steps ());
    throws (S, 'this adjoint is closed', @() o.adjoint.backward ());
  end
end

function children ()
  c = diffaqua.constants ();
  s = swimmer ();
  t = diffaqua.Tape (s);
  s.rollout (diffaqua.Controller.sinusoid (1), 3, t);
  s.close ();
  assert (any (t.gradient (travel (), c.WRT_WEIGHTS) ~= 0));
end

function cleared ()
  before = diffaqua_mex ('n_objects');
  functions = diffaqua_callback ('count');
  s = swimmer ();
  t = diffaqua.Tape (s);
  driver = diffaqua.Controller.callback (@(varargin) 0.5, [], 'n_signals', 1);
  s.rollout (driver, 2, t);
  assert (diffaqua_mex ('n_objects'), before + 3);  % the space is the simulator's alone
  clear s
  assert (diffaqua_mex ('n_objects'), before + 3);  % the tape keeps its simulator
  clear driver
  assert (diffaqua_callback ('count'), functions + 1);  % and what may be called for its steps
  assert (diffaqua_mex ('n_objects'), before + 2);
  t = 3;
  assert (diffaqua_mex ('n_objects'), before);
  assert (diffaqua_callback ('count'), functions);
end

function in_use ()
  s = swimmer ();
  sine = diffaqua.Controller.sinusoid (1);
  throws ('DQA_ERROR_STATE', 'simulator cannot be closed while', @() s.rollout (sine, 3, [], @(d, n) s.close ()));
  throws ('DQA_ERROR_STATE', 'controller cannot be closed while', @() s.rollout (sine, 3, [], @(d, n) sine.close ()));
  t = diffaqua.Tape (s);
  changed = 'this %s cannot be changed while';
  S = 'DQA_ERROR_STATE';
  throws (S, sprintf (changed, 'simulator'), @() s.rollout (sine, 3, t, @(d, n) s.set_weights ([1, 0])));
  throws (S, sprintf (changed, 'tape'), @() s.rollout (sine, 3, t, @(d, n) t.clear ()));
  throws (S, sprintf (changed, 'controller'), @() s.rollout (sine, 3, t, @(d, n) sine.set_parameters ([1, 1, 1])));
  throws (S, sprintf (changed, 'simulator'), @() s.rollout (sine, 3, [], @(d, n) s.step (0)));
  t.clear ();
  s.rollout (sine, 3, t, @(d, n) isempty ({s.state(), sine.parameters(), t.n_steps()}));  % questions are welcome
  s.set_weights ([1, 0]);  % the counts are right again
  s.close ();
  sine.close ();
end

% ------------------------------------------------------------------ callbacks
function remember (done, total)
  global dqa_seen
  dqa_seen = [dqa_seen, done / total];
end

function progress ()
  global dqa_seen
  dqa_seen = [];
  s = swimmer ();
  sine = diffaqua.Controller.sinusoid (1);
  s.rollout (sine, 4, [], @remember);
  assert (dqa_seen, (1:4) / 4);
  s.rollout (sine, 2, [], @(d, n) remember (d, n));  % a function around one that returns nothing
  assert (dqa_seen, [(1:4) / 4, 1 / 2, 1]);
  s.rollout (sine, 2, [], @(d, n) fprintf (''));
  s.rollout (sine, 2, [], @(d, n) []);
  throws ('DQA_CANCELLED', '.', @() s.rollout (sine, 9, [], @(done, total) done == 2));
  assert (s.info ().steps, 12);
  throws ('DQA_ERROR_ARGUMENT', 'progress: expected a function handle, got double', @() s.rollout (sine, 1, [], 7));
end

function varargout = fail (varargin)
  error ('my:own', 'mine');
end

function thrown ()
  c = diffaqua.constants ();
  s = swimmer ();
  sine = diffaqua.Controller.sinusoid (1);
  throws ('my:own', '^mine$', @() s.rollout (sine, 3, [], @fail));
  throws ('my:own', '^mine$', @() s.set_weights ([1, 0], @fail));
  s.set_weights ([0.5, 0.5]);
  throws ('my:own', '^mine$', @() s.rollout (diffaqua.Controller.callback (@fail, [], 'n_signals', 1), 3));
  s.set_current (@fail);
  throws ('my:own', '^mine$', @() s.step (0));
  s.set_current (@(time) [0, 0], @fail);
  t = diffaqua.Tape (s);
  s.step (0, t);
  throws ('my:own', '^mine$', @() t.gradient (travel (), c.WRT_WEIGHTS));
  s.set_current ([]);
  t.clear ();
  s.rollout (diffaqua.Controller.callback (@(varargin) 0.5, @fail, 'n_signals', 1, 'theta', 1), 2, t);
  throws ('my:own', '^mine$', @() t.gradient (travel (), c.WRT_CONTROL));
  s.step (0);  % nothing is left over
  % A call inside a callback throws its own error, there; the outer one carries on.
  s.rollout (sine, 2, [], @(d, n) isempty (throws ('DQA_ERROR_ARGUMENT', 'n_signals', ...
                                                   @() diffaqua.Controller.sinusoid (0))));
  % Calls may nest.
  s.rollout (sine, 2, [], @(d, n) s.info ().steps < 0);
end

function a = act (~, time, sensors, theta)
  a = tanh (theta(1) * sin (12 * time) + theta(2) * sensors(4));
end

function [by_theta, by_sensors] = pull (~, time, sensors, theta, bar)
  z = theta(1) * sin (12 * time) + theta(2) * sensors(4);
  slope = bar / cosh (z)^2;
  by_theta = slope * [sin(12 * time); sensors(4)];
  by_sensors = zeros (10, 1);
  by_sensors(4) = slope * theta(2);
end

function callback_controller ()
  c = diffaqua.constants ();
  s = swimmer ();
  make = @(pullback) diffaqua.Controller.callback (@act, pullback, 'n_signals', 1, 'n_sensors', 10, ...
                                                   'theta', [0.7, 0.4]);
  for wrt = [c.WRT_CONTROL, c.WRT_WEIGHTS]
    report = diffaqua.check_gradient (s, make (@pull), travel (), 'with_respect_to', wrt, 'n_steps', 5);
    assert (report.relative_error < 1e-6);
    assert (report.taylor_slope, 2, -0.05);
  end
  t = diffaqua.Tape (s);
  s.rollout (make (@pull), 5, t);
  adjoint = diffaqua.Adjoint (t);
  clear t  % the adjoint keeps what it calls
  adjoint.seed_objective (travel ());
  adjoint.backward ();
  assert (numel (adjoint.gradient (c.WRT_CONTROL)), 2);
  t = diffaqua.Tape (s);
  s.rollout (make ([]), 2, t);
  throws ('DQA_ERROR_STATE', '.', @() diffaqua.Adjoint (t));
  throws ('DQA_ERROR_UNSUPPORTED', '.', @() make ([]).save ('nowhere'));
  assert (make (@pull).evaluate (0, zeros (5, 2)(:)), 0);
end

function returned ()
  A = 'DQA_ERROR_ARGUMENT';
  c = diffaqua.constants ();
  s = swimmer ();
  driven = @(f) s.rollout (diffaqua.Controller.callback (f, [], 'n_signals', 1), 1);
  throws (A, 'evaluate: expected 1 real numbers, got double \[1, 2\]', @() driven (@(varargin) [0, 0]));
  throws (A, 'evaluate: expected 1 real numbers, got char', @() driven (@(varargin) 'a'));
  throws (A, 'evaluate: expected 1 real numbers', @() driven (@(varargin) 1i));
  throws (A, '\[-1, 1\]', @() driven (@(varargin) 3));
  throws (A, 'evaluate: expected a function handle, got nothing', @() driven ([]));
  throws (A, 'unknown option ''signals''', @() diffaqua.Controller.callback (@act, [], 'signals', 1));
  s.set_current (@(time) [1, 2, 3]);
  throws (A, 'current: expected 2 real numbers', @() s.step (0));
  s.set_current ([]);
  t = diffaqua.Tape (s);
  s.rollout (diffaqua.Controller.callback (@(varargin) 0.5, @(varargin) deal (1:7, []), 'n_signals', 1, 'theta', 1), ...
             2, t);
  throws (A, 'pullback: by theta: expected 1 real numbers', @() t.gradient (travel (), c.WRT_CONTROL));
end

function gather (time, bar)
  global dqa_seen
  dqa_seen = [bar.'; dqa_seen];
end

function currents ()
  global dqa_seen
  dqa_seen = zeros (0, 2);
  c = diffaqua.constants ();
  s = swimmer ();
  s.set_current (@(time) [0.1 * time, 0.02], @gather);
  t = diffaqua.Tape (s);
  s.rollout (diffaqua.Controller.sinusoid (1), 3, t);
  assert (t.current (2), [0.2 / 30; 0.02], 1e-15);
  s.set_current ([]);
  same (t.gradient (travel (), c.WRT_CURRENT), dqa_seen, 'what the pullback got');
  s.set_current_table ([0, 1, 2], [0, 0; 0.1, 0; 0, 0]);
  t.clear ();
  s.set_state ();
  s.rollout (diffaqua.Controller.sinusoid (1), 2, t);
  assert (size (t.gradient (travel (), c.WRT_CURRENT_TABLE)), [3, 2]);
  throws ('DQA_ERROR_ARGUMENT', 'velocities: expected shape \[2, 2\], got \[2, 1\]', ...
          @() s.set_current_table ([0, 1], [0; 0]));
  s.set_current_table ([], []);
end

function keep_level (level, message)
  global dqa_seen
  assert (ischar (message));
  dqa_seen = [dqa_seen, level];
end

function logged ()
  global dqa_seen
  dqa_seen = [];
  c = diffaqua.constants ();
  diffaqua.set_log_handler (@keep_level, c.LOG_DEBUG);
  swimmer ().step (0);
  state = warning ('off', 'diffaqua:log');
  diffaqua.set_log_handler (@fail, c.LOG_DEBUG);
  swimmer ().step (0);  % what it throws stops nothing
  warning (state);
  diffaqua.set_log_handler ([]);
  assert (all (ismember ([c.LOG_INFO, c.LOG_DEBUG], dqa_seen)));
  throws ('DQA_ERROR_ARGUMENT', 'level', @() diffaqua.set_log_handler (@keep_level, 9));
end

function cancel_token ()
  token = diffaqua.CancelToken ();
  s = swimmer ('cancel', token);
  throws ('DQA_CANCELLED', '.', @() s.rollout (diffaqua.Controller.sinusoid (1), 9, [], @(d, n) token.set ()));
  token.reset ();
  s.step (0);
  token.close ();
  s.step (0);
end

% ------------------------------------------------------------------ each method once
function space ()
  s = small_space ();
  assert (s.names (), {'slim', 'stout'});
  h = 1e-5;
  bar = reshape (sin ((1:160) .^ 2), 20, 8);
  gradient = s.pullback ([0.3, 0.7], bar);
  difference = s.density ([0.3 + h, 0.7 - h]) - s.density ([0.3 - h, 0.7 + h]);
  assert ((gradient(1) - gradient(2)) * 2 * h / sum (bar(:) .* difference(:)), 1, 1e-6);
  c = diffaqua.constants ();
  assert (s.signal (0).kind, c.ACTUATOR_CAUDAL);
  assert (s.actuator (0, 0).kind, c.ACTUATOR_CAUDAL);
  assert (size (s.base (1)), [20, 8]);
  path = tempname ();
  s.save (path);
  same (diffaqua.ShapeSpace.load (path).density ([0.3, 0.7]), s.density ([0.3, 0.7]), 'loaded');
  delete (path);
  % Axes of three dimensions keep their places.
  solid = diffaqua.ShapeSpace ('cells_x', 12, 'cells_y', 8, 'cells_z', 10, 'cell_size', 0.1);
  cells = zeros (12, 8, 10);
  cells(3:10, 3:6, 3:8) = rand (8, 4, 6);
  solid.add_density (cells, 'noise');
  same (solid.base (0), cells, 'cells');
end

function bases ()
  flat = diffaqua.ShapeSpace ('dims', 2, 'cells_x', 20, 'cells_y', 8, 'cell_size', 0.05);
  pixels = zeros (16, 40);
  pixels(7:10, 5:36) = 1;
  assert (flat.add_image (pixels, 'bar'), 0);
  cells = zeros (20, 8);
  cells(4:17, 4:5) = 1;
  assert (flat.add_density (cells, 'block'), 1);
  for base = 0:1
    flat.add_actuator (base, 'mean', [-0.2, 0, 0], 'variance', [0.01, 0.002, 0.002]);
  end
  global dqa_seen
  dqa_seen = [];
  flat.build (@remember);
  assert (~isempty (dqa_seen));
  assert (flat.actuator (1, 0).mean, [-0.2, 0, 0]);
  assert (flat.info ().is_built, 1);
end

function simulator ()
  s = swimmer ();
  info = s.info ();
  s.step (0.5);
  assert (size (s.sensors ()), [5, 2]);
  assert (size (s.forces ()), [4, 2]);
  [vertices, elements] = s.surface ();
  assert ([columns(vertices), columns(elements)], [2, 2]);
  assert (max (elements(:)), rows (vertices) - 1);
  mesh = s.mesh ();
  assert (size (mesh.cell_nodes), [info.n_active_cells, 4]);
  assert (max (mesh.cell_nodes(:)), info.n_nodes - 1);
  % The corners of a cell lie as the header says: iz fastest, then iy, then ix.
  q = zeros (info.n_nodes, 2);
  s.set_state ();
  q = s.state ();
  corner = q(mesh.cell_nodes(1, :) + 1, :);
  assert (corner(2, 2) > corner(1, 2) && corner(3, 1) > corner(1, 1));
  muscles = s.muscles ();
  assert (unique (muscles.signs).', [-1, 1]);
  assert (sum (muscles.directions .^ 2, 2), ones (numel (muscles.cells), 1), 1e-12);
  assert (s.actuator (0).share, 1);
  index = s.node_box_index ();
  s.set_fixed_nodes (index(1:3));
  s.step (0.5);
  [q, v] = s.state ();
  s.set_state ();
  rest = s.state ();
  same (q(1:3, :), rest(1:3, :), 'fixed nodes');
  s.set_state (q, v);
  same (s.state (), q, 'state');
  throws ('DQA_ERROR_ARGUMENT', 'q: expected shape', @() s.set_state (q.'));
  s.set_fixed_nodes ([]);
  s.set_material (3e5 * ones (160, 1), []);
  s.set_material ();
  throws ('DQA_ERROR_ARGUMENT', 'young_modulus: expected shape \[160\], got \[1, 1\]', @() s.set_material (1));
  [threshold, estimate] = s.suggest_threshold ([0.5, 0.5], 0.1);
  assert (threshold >= 0 && threshold < 0.5 && estimate <= 0.1);
  assert (s.weights (), [0.5; 0.5]);
end

function tape ()
  c = diffaqua.constants ();
  A = 'DQA_ERROR_ARGUMENT';
  S = 'DQA_ERROR_STATE';
  s = swimmer ();
  t = diffaqua.Tape (s);
  throws (S, 'nothing is recorded', @() t.state (0));
  throws (S, 'nothing is recorded', @() diffaqua.Adjoint (t));
  s.rollout (diffaqua.Controller.sinusoid (1), 4, t);
  same (t.state (4), s.state (), 'state');
  same (t.surface (4), s.surface (), 'surface');
  assert ([t.n_steps(), t.statistics().steps, numel(t.actuation (1))], [4, 4, 1]);
  throws (A, 'step', @() t.actuation (4));
  effort = struct ('kind', c.OBJECTIVE_EFFORT, 'weight', 0.5);
  [loss, terms] = t.objective ({travel(), effort});
  assert (loss, terms(1) + 0.5 * terms(2), 1e-15);
  assert (t.objective (struct ('kind', {c.OBJECTIVE_TRAVEL, c.OBJECTIVE_EFFORT}, 'weight', {[], 0.5})), loss);
  path = struct ('kind', c.OBJECTIVE_PATH, 'path', [0, 0, 0; 1, 0.5, 0]);
  assert (t.objective (path) > 0);
  % A path that the swimmer stands on: rows are points.
  q0 = t.state (0);
  throws (A, 'unknown option ''wait''', @() t.objective (struct ('wait', 1)));
  throws (A, 'loss: expected a struct', @() t.objective (1));
  throws (A, 'loss: term 2: expected a struct', @() t.objective ({travel(), 3}));
  wrt = [c.WRT_WEIGHTS, c.WRT_CONTROL, c.WRT_ACTUATION, c.WRT_WATER, c.WRT_CURRENT, c.WRT_YOUNGS_MODULUS, ...
         c.WRT_MATERIAL, c.WRT_LAME];
  sizes = {[2, 1], [3, 1], [4, 1], [11, 1], [4, 2], [160, 1], [4, 1], [2, 1]};
  found = cell (size (wrt));
  [found{:}] = t.gradient (travel (), num2cell (wrt){:});
  assert (cellfun (@size, found, 'UniformOutput', false), sizes);
  adjoint = diffaqua.Adjoint (t);
  throws (S, '.', @() t.clear ());
  bar = ones (size (q0));
  adjoint.seed (2, c.SEED_POSITION, bar);
  adjoint.backward (2);
  throws (S, '.', @() adjoint.seed (3, c.SEED_POSITION, bar));
  throws (A, 'bar: expected shape', @() adjoint.seed (0, c.SEED_POSITION, 1));
  throws (A, 'wrt: expected one of', @() adjoint.gradient (99));
  adjoint.close ();
  t.clear ();
  s.step (0, t);
  throws (S, 'no controller', @() t.gradient (travel (), c.WRT_CONTROL));
  s.set_weights ([1, 0]);
  throws (S, 'another design', @() t.surface (1));
  throws ('DQA_ERROR_MEMORY', '.', @() s.step (0, diffaqua.Tape (s, 'memory_bytes', 8)));
end

function controllers ()
  sine = diffaqua.Controller.sinusoid (2);
  sine.set_parameters ([1, 2, pi / 2, 0.5, 2, pi / 2]);
  assert (sine.evaluate (0), [1; 0.5], 1e-15);
  throws ('DQA_ERROR_ARGUMENT', 'theta', @() sine.set_parameters (1));
  network = diffaqua.Controller.perceptron ('n_signals', 2, 'dims', 2, 'hidden', 4, 'seed', 3);
  assert (network.info ().n_parameters, (10 + 20 + 1) * 4 + (4 + 1) * 2);
  assert (numel (network.evaluate (1, zeros (10, 1))), 2);
  throws ('DQA_ERROR_ARGUMENT', 'sensors: expected shape \[10\]', @() network.evaluate (1, zeros (3, 1)));
  path = tempname ();
  network.save (path);
  same (diffaqua.Controller.load (path).parameters (), network.parameters (), 'loaded');
  delete (path);
end

function search ()
  target = [0.3, -2, 40];
  units = [1, 1, 20];
  found = diffaqua.CmaEs ([0, 0, 0], units, 'seed', 3);
  throws ('DQA_ERROR_STATE', '.', @() found.best ());
  path = tempname ();
  for generation = 1:90
    points = found.ask ();
    found.tell (sum (((points - target) ./ units) .^ 2, 2));
    if (generation == 30)
      found.save (path);
      found = diffaqua.CmaEs.load (path);
    end
  end
  delete (path);
  [x, value] = found.best ();
  assert (value < 1e-8);
  assert (x.', target, -1e-4);
  assert (found.mean ().', target, -1e-4);
  assert (found.info ().generation, 90);
  found.ask ();
  throws ('DQA_ERROR_ARGUMENT', 'values', @() found.tell (1));
  throws ('DQA_ERROR_ARGUMENT', 'scales: expected shape \[1\], got \[1, 2\]', @() diffaqua.CmaEs (0, [1, 2]));
end
