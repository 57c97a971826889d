-- SPDX-License-Identifier: MIT
-- One scene: shape space, material, water, solver; its present design and state.
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local arrays = require "diffaqua.arrays"
local callbacks = require "diffaqua.callbacks"
local handle = require "diffaqua.handle"
local structs = require "diffaqua.structs"
local shape_space = require "diffaqua.shape_space"
local controllers = require "diffaqua.controller"

local M = {}

local Simulator = handle.class("simulator", "dqa_simulator", "dqa_simulator_free")
M.Simulator = Simulator
local Tape = handle.class("tape", "dqa_tape", "dqa_tape_free")
M.Tape = Tape -- its methods are in tape.lua

-- A scene in a built space; options by the names of dqa_simulator_options, such as {time_step = 1 / 60}. Call
-- set_weights before anything that needs a body.
function M.simulator(space, options)
    local parent = handle.pointer("space", space, shape_space.Space)
    local numbers, token = shape_space.split_cancel(options)
    local filled = structs.options("dqa_simulator_options", "dqa_simulator_options_init", numbers)
    filled[0].cancel = token
    local simulator = handle.create(Simulator, { space }, "dqa_simulator_create", parent, filled)
    simulator.time_step = filled[0].time_step -- s, as the scene was made
    simulator.n_cells = space:info().n_cells
    simulator.table_rows = 1
    return simulator
end

-- Sizes, totals and the clock, as dqa_simulator_info.
function Simulator:info()
    local filled, size = structs.room "dqa_simulator_info"
    self:call("dqa_simulator_get_info", filled, size)
    return structs.record("dqa_simulator_info", filled)
end

-- ------------------------------------------------------------------ design
local function new_design(self)
    local info = self:info()
    self.design = info.has_design == 1 and { n_nodes = info.n_nodes, dims = info.dims } or nil -- tapes remember it
end

-- New design from weights [n_bases] on the simplex; the state goes back to rest and the clock to 0. progress(done,
-- total): a true result, or an error, stops the call.
function Simulator:set_weights(weights, progress)
    local share = arrays.numbers("weights", weights, false)
    callbacks.with_progress(progress, function(callback, data)
        self:change("dqa_simulator_set_weights", share.data, share.n, callback, data)
    end)
    new_design(self)
end

-- Weights of the present design [n_bases].
function Simulator:weights()
    local share = arrays.new(self:info().n_bases)
    self:call("dqa_simulator_get_weights", share.data, share.n)
    return share
end

-- Moduli (Pa) by cell of the full box [n_cells], or nil for the uniform one of the options; state to rest.
function Simulator:set_material(young_modulus, muscle_stiffness)
    local solid = young_modulus ~= nil and arrays.numbers("young_modulus", young_modulus, self.n_cells) or {}
    local muscle = muscle_stiffness ~= nil and arrays.numbers("muscle_stiffness", muscle_stiffness, self.n_cells) or {}
    self:change("dqa_simulator_set_material", solid.data, muscle.data, self.n_cells)
    new_design(self)
end

-- Nodes of the full box that keep their place, by index counted from 0; {} frees all. State to rest.
function Simulator:set_fixed_nodes(nodes)
    local held = arrays.indices("nodes", nodes, false)
    self:change("dqa_simulator_set_fixed_nodes", held.n > 0 and held.data or nil, held.n)
    new_design(self)
end

-- Index in the full box of each node [n_nodes].
function Simulator:node_box_index()
    local nodes = arrays.new_integers(self:info().n_nodes)
    self:call("dqa_simulator_node_box_index", nodes.data, nodes.n)
    return nodes
end

-- threshold, estimate: the option `threshold` that keeps the estimated error at or below `tolerance`.
function Simulator:suggest_threshold(weights, tolerance)
    local share, found = arrays.numbers("weights", weights, false), ffi.new "double[2]"
    self:call("dqa_simulator_suggest_threshold", share.data, share.n, library.number("tolerance", tolerance), found,
        found + 1)
    return found[0], found[1]
end

-- ------------------------------------------------------------------ water
-- Velocity of the water, linear between velocities [n_times][dims] (m/s) at times [n_times] (s); {}, {}: back to the
-- option `current`.
function Simulator:set_current_table(times, velocities)
    local at = arrays.numbers("times", times, false)
    local values = arrays.numbers("velocities", velocities, at.n, self:info().dims)
    self:change("dqa_simulator_set_current_table", at.data, at.n, values.data, values.n)
    self.current, self.table_rows = nil, math.max(1, at.n)
end

-- Velocity of the water current(time) -> [dims] (m/s), asked once a step; backward sweeps give pullback(time,
-- current_bar [dims]) the gradient of each step, last step first. nil: back to the options.
function Simulator:set_current(current, pullback)
    if current == nil then
        self:change("dqa_simulator_set_current_callback", nil, nil, nil)
        self.current, self.table_rows = nil, 1
        return
    end
    local entry, data = callbacks.register {
        current = library.callable("current", current),
        pullback = pullback ~= nil and library.callable("pullback", pullback) or nil,
        dims = self:info().dims,
    }
    self:change("dqa_simulator_set_current_callback", callbacks.current, pullback and callbacks.current_pullback or nil,
        data)
    self.current, self.table_rows = entry, 1
end

-- ------------------------------------------------------------------ motion
local function record_to(self, tape, controller)
    handle.must_be_free(self)
    if tape == nil then
        return nil, { self, controller }
    end
    local pointer = handle.pointer("tape", tape, Tape)
    handle.must_be_free(tape)
    tape:will_record(self, controller)
    return pointer, { self, tape, controller } -- without one, the list is shorter
end

-- One step with actuation [n_signals], each in [-1, 1]. On failure the state is that before the call.
function Simulator:step(actuation, tape)
    local signals = arrays.numbers("actuation", actuation, false)
    local pointer = self:get()
    local record, users = record_to(self, tape)
    handle.call(users, "dqa_simulator_step", pointer, signals.data, signals.n, record)
end

-- n_steps steps driven by a controller. On failure or when stopped, the state is that after the last whole one, and the
-- tape holds the whole ones.
function Simulator:rollout(controller, n_steps, tape, progress)
    local pointer, driver = self:get(), handle.pointer("controller", controller, controllers.Controller)
    local steps = library.whole("n_steps", n_steps)
    local record, users = record_to(self, tape, controller)
    callbacks.with_progress(progress, function(callback, data)
        handle.call(users, "dqa_simulator_rollout", pointer, driver, steps, record, callback, data)
    end)
end

-- Positions (m) and velocities (m/s), each [n_nodes][dims]; given arrays are written to.
function Simulator:state(q, v)
    local info = self:info()
    local positions = arrays.output("q", q, info.n_nodes, info.dims)
    local velocities = arrays.output("v", v, info.n_nodes, info.dims)
    self:call("dqa_simulator_get_state", positions.data, positions.n, velocities.data, velocities.n)
    return positions, velocities
end

-- Sets the state, each [n_nodes][dims], and the clock to step 0. nil: rest positions, zero velocities.
function Simulator:set_state(q, v)
    local info = self:info()
    local positions = q ~= nil and arrays.numbers("q", q, info.n_nodes, info.dims) or { n = 0 }
    local velocities = v ~= nil and arrays.numbers("v", v, info.n_nodes, info.dims) or { n = 0 }
    self:change("dqa_simulator_set_state", positions.data, positions.n, velocities.data, velocities.n)
end

-- [5][dims]: velocities of head, centre and tail (m/s), offsets of head and tail from the centre (m).
function Simulator:sensors(out)
    local seen = arrays.output("out", out, 5, self:info().dims)
    self:call("dqa_simulator_sensors", seen.data, seen.n)
    return seen
end

-- [4][dims]: drag and thrust of the last step (N), then their means over the wet surface (N/m^2).
function Simulator:forces(out)
    local total = arrays.output("out", out, 4, self:info().dims)
    self:call("dqa_simulator_forces", total.data, total.n)
    return total
end

-- ------------------------------------------------------------------ geometry
-- Numbers of vertices and elements of the surface.
function Simulator:surface_size()
    local rows = ffi.new "int64_t[2]"
    self:call("dqa_simulator_surface", nil, 0, nil, 0, rows, rows + 1)
    return tonumber(rows[0]), tonumber(rows[1])
end

-- The isosurface of the body, carried by the present state: vertices [n][dims] (m), elements [m][dims] of indices
-- counted from 0 (triangles, or segments in two dimensions).
function Simulator:surface()
    local dims = self:info().dims
    local n_vertices, n_elements = self:surface_size()
    local vertices, elements = arrays.new(n_vertices, dims), arrays.new_integers(n_elements, dims)
    self:call("dqa_simulator_surface", vertices.data, vertices.n, elements.data, elements.n, nil, nil)
    return vertices, elements
end

-- The simulated cells: {cell_nodes [n][2^dims], box_index [n], occupancy [n]}.
function Simulator:mesh()
    local info = self:info()
    local n = info.n_active_cells
    local nodes, index, occupancy = arrays.new_integers(n, 2 ^ info.dims), arrays.new_integers(n), arrays.new(n)
    self:call("dqa_simulator_mesh", nodes.data, nodes.n, index.data, index.n, occupancy.data, occupancy.n)
    return { cell_nodes = nodes, box_index = index, occupancy = occupancy }
end

-- What the interpolation made of an actuator: dqa_actuator_info. side: SIDE_BOTH (default) for caudal ones.
function Simulator:actuator(category, side)
    local filled, size = structs.room "dqa_actuator_info"
    self:call("dqa_simulator_actuator", library.index("category", category), library.index("side", side or 0), filled,
        size)
    return structs.record("dqa_actuator_info", filled)
end

-- The fibres of the present design, one row per cell and fibre group: {cells, signals, signs [n], directions [n][dims],
-- stiffness [n] (Pa)}.
function Simulator:muscles()
    local count = ffi.new "int64_t[1]"
    self:call("dqa_simulator_muscles", nil, nil, nil, 0, nil, 0, nil, 0, count)
    local n = tonumber(count[0])
    local cells, signals, signs = arrays.new_integers(n), arrays.new_integers(n), arrays.new_integers(n)
    local directions, stiffness = arrays.new(n, self:info().dims), arrays.new(n)
    self:call("dqa_simulator_muscles", cells.data, signals.data, signs.data, n, directions.data, directions.n,
        stiffness.data, stiffness.n, nil)
    return { cells = cells, signals = signals, signs = signs, directions = directions, stiffness = stiffness }
end

return M
