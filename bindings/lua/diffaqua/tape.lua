-- SPDX-License-Identifier: MIT
-- The record of a rollout, losses of it, the backward sweep, and the proof of a gradient.
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local arrays = require "diffaqua.arrays"
local callbacks = require "diffaqua.callbacks"
local handle = require "diffaqua.handle"
local structs = require "diffaqua.structs"
local simulators = require "diffaqua.simulator"
local controllers = require "diffaqua.controller"
local refuse, constants = library.refuse, library.constants

local M = {}

local Tape = simulators.Tape

-- ------------------------------------------------------------------ losses
-- A loss is a term, such as {kind = OBJECTIVE_TRAVEL, weight = 1}, or a list of terms, of which it is the weighted sum.
-- Fields by the names of dqa_objective_term; a path is [n][1 + dims], rows of (time in s, coordinates in m).
local function terms_of(loss)
    if type(loss) ~= "table" then
        refuse("loss: expected a table, got %s", library.kind(loss))
    end
    local list = type(loss[1]) == "table" and loss or { loss }
    local terms, keep = ffi.new("dqa_objective_term[?]", #list), {}
    for i = 1, #list do
        if type(list[i]) ~= "table" then
            refuse("loss: term %d: expected a table, got %s", i, library.kind(list[i]))
        end
        local numbers, path = {}, nil
        for name, value in pairs(list[i]) do
            if name == "path" then
                path = arrays.numbers("path", value, false, false)
            else
                numbers[name] = value
            end
        end
        if numbers.n_path ~= nil then
            refuse "unknown option 'n_path': it is that of `path`"
        end
        library.check(library.lib.dqa_objective_term_init(terms + (i - 1), ffi.sizeof "dqa_objective_term"))
        structs.fill("dqa_objective_term", terms[i - 1], numbers)
        if path then
            terms[i - 1].path, terms[i - 1].n_path = path.data, path.n
            keep[#keep + 1] = path
        end
    end
    return { pointer = terms, n = #list, keep = keep }
end

-- ------------------------------------------------------------------ tape
-- An empty tape for the simulator's rollouts; options by the names of dqa_tape_options: memory_bytes, a budget.
function M.tape(simulator, options)
    local parent = handle.pointer("simulator", simulator, simulators.Simulator)
    local filled = structs.options("dqa_tape_options", "dqa_tape_options_init", options)
    local tape = handle.create(Tape, { simulator }, "dqa_tape_create", parent, filled)
    local info = simulator:info()
    tape.simulator, tape.entries, tape.table_rows = simulator, {}, 1
    tape.dims, tape.n_bases, tape.n_signals, tape.n_cells = info.dims, info.n_bases, info.n_signals, simulator.n_cells
    return tape
end

-- What the library calls for these steps must outlive the tape, even if recording fails half-way.
function Tape:will_record(simulator, controller)
    if simulator.current then
        self.entries[simulator.current] = true
    end
    if controller and controller.entry then
        self.entries[controller.entry] = true
    end
    if self.design == nil or self:n_steps() == 0 then
        self.design = simulator.design
    end
    self.table_rows = simulator.table_rows
    if controller then
        self.n_parameters = controller:info().n_parameters
    end
end

-- Empties the tape for another rollout; throws while an adjoint of it lives.
function Tape:clear()
    self:change "dqa_tape_clear"
    self.design, self.entries, self.n_parameters = nil, {}, nil
end

-- Steps recorded so far.
function Tape:n_steps()
    local count = ffi.new "int64_t[1]"
    self:call("dqa_tape_n_steps", count)
    return tonumber(count[0])
end

local function design_of(tape)
    if tape.design == nil then
        library.fail(constants.ERROR_STATE, "nothing is recorded on this tape")
    end
    return tape.design
end

-- Positions and velocities after `step` steps, each [n_nodes][dims]; cheapest in order under a budget.
function Tape:state(step, q, v)
    local design = design_of(self)
    local positions = arrays.output("q", q, design.n_nodes, design.dims)
    local velocities = arrays.output("v", v, design.n_nodes, design.dims)
    self:call("dqa_tape_get_state", library.whole("step", step), positions.data, positions.n, velocities.data,
        velocities.n)
    return positions, velocities
end

-- Actuation [n_signals] used in a step, counted from 0.
function Tape:actuation(step)
    local values = arrays.new(self.n_signals)
    self:call("dqa_tape_get_actuation", library.whole("step", step), values.data, values.n)
    return values
end

-- Velocity of the water [dims] (m/s) during a step, counted from 0.
function Tape:current(step)
    local values = arrays.new(self.dims)
    self:call("dqa_tape_get_current", library.whole("step", step), values.data, values.n)
    return values
end

-- Vertices [n_vertices][dims] of the surface after `step` steps; its elements are those of simulator:surface() for the
-- same design. Their number must be given once the simulator has another design.
function Tape:surface(step, n_vertices)
    if n_vertices == nil then
        if self.simulator.design ~= self.design then
            library.fail(constants.ERROR_STATE,
                "the simulator has another design now: give n_vertices of that of the tape")
        end
        n_vertices = self.simulator:surface_size()
    end
    local vertices = arrays.new(library.index("n_vertices", n_vertices), self.dims)
    self:call("dqa_tape_get_surface", library.whole("step", step), vertices.data, vertices.n)
    return vertices
end

-- Memory, iterations and residuals, as dqa_tape_statistics.
function Tape:statistics()
    local filled, size = structs.room "dqa_tape_statistics"
    self:call("dqa_tape_stats", filled, size)
    return structs.record("dqa_tape_statistics", filled)
end

-- The loss of the recorded rollout, and its unweighted terms [n_terms].
function Tape:objective(loss)
    local terms = terms_of(loss)
    local value, each = ffi.new "double[1]", arrays.new(terms.n)
    self:call("dqa_tape_objective", terms.pointer, terms.n, value, each.data)
    return value[0], each
end

-- Gradients of a loss, one result for each of WRT_WEIGHTS, ...: a whole backward sweep.
function Tape:gradient(loss, ...)
    local adjoint, wanted = M.adjoint(self), { ... }
    local ok, problem = pcall(function()
        adjoint:seed_objective(loss)
        adjoint:backward()
        for i = 1, #wanted do
            wanted[i] = adjoint:gradient(wanted[i])
        end
    end)
    adjoint:close()
    if not ok then
        error(problem, 0)
    end
    return unpack(wanted)
end

-- ------------------------------------------------------------------ adjoint
local Adjoint = handle.class("adjoint", "dqa_adjoint", "dqa_adjoint_free")

-- A cursor over a finished tape that walks back from its last step. Seeds add up.
function M.adjoint(tape)
    local parent = handle.pointer("tape", tape, Tape)
    local design = design_of(tape)
    local adjoint = handle.create(Adjoint, { tape }, "dqa_adjoint_create", parent)
    adjoint.entries, adjoint.design = tape.entries, design
    local steps, dims = tape:n_steps(), design.dims
    adjoint.shapes = {
        [constants.WRT_WEIGHTS] = { tape.n_bases },
        [constants.WRT_CONTROL] = { tape.n_parameters },
        [constants.WRT_ACTUATION] = { steps, tape.n_signals },
        [constants.WRT_INITIAL_POSITION] = { design.n_nodes, dims },
        [constants.WRT_INITIAL_VELOCITY] = { design.n_nodes, dims },
        [constants.WRT_WATER] = { dims + 9 },
        [constants.WRT_CURRENT] = { steps, dims },
        [constants.WRT_CURRENT_TABLE] = { tape.table_rows, dims },
        [constants.WRT_YOUNGS_MODULUS] = { tape.n_cells },
        [constants.WRT_MUSCLE_STIFFNESS] = { tape.n_cells },
        [constants.WRT_MATERIAL] = { 4 },
        [constants.WRT_LAME] = { 2 },
    }
    return adjoint
end

-- Adds bar [n_nodes][dims] to dL/dq or dL/dv (SEED_POSITION, SEED_VELOCITY) of the state after `step` steps.
function Adjoint:seed(step, quantity, bar)
    local values = arrays.numbers("bar", bar, self.design.n_nodes, self.design.dims)
    self:change("dqa_adjoint_seed", library.whole("step", step), library.index("quantity", quantity), values.data,
        values.n)
end

-- Adds the seeds of a loss; only before the sweep has begun.
function Adjoint:seed_objective(loss)
    local terms = terms_of(loss)
    self:change("dqa_adjoint_seed_objective", terms.pointer, terms.n)
end

-- Runs the sweep back to the state after `to_step` steps (default 0); goes on where it was stopped.
function Adjoint:backward(to_step, progress)
    local target = library.whole("to_step", to_step or 0)
    callbacks.with_progress(progress, function(callback, data)
        self:change("dqa_adjoint_backward", target, callback, data)
    end)
end

-- A gradient, in the shape that the header gives. All but ACTUATION and CURRENT need the whole sweep.
function Adjoint:gradient(wrt, out)
    local shape = self.shapes[wrt]
    if not shape then
        refuse("wrt: expected one of WRT_WEIGHTS, ..., got %s", tostring(wrt))
    end
    if #shape == 0 then
        library.fail(constants.ERROR_STATE,
            "wrt: no controller drove this tape; its steps have the gradient WRT_ACTUATION")
    end
    local values = arrays.output("out", out, unpack(shape))
    self:call("dqa_adjoint_get", wrt, values.data, values.n)
    return values
end

-- ------------------------------------------------------------------ proof of the gradient
-- Proves (or refutes) a gradient by finite differences along a random direction: dqa_gradient_check_report. options by
-- the names of dqa_gradient_check_options; controller may be nil. The simulator is unchanged.
function M.check_gradient(simulator, loss, options, controller)
    local scene = handle.pointer("simulator", simulator, simulators.Simulator)
    local driver = controller ~= nil and handle.pointer("controller", controller, controllers.Controller) or nil
    local terms = terms_of(loss)
    local filled = structs.options("dqa_gradient_check_options", "dqa_gradient_check_options_init", options)
    local report, size = structs.room "dqa_gradient_check_report"
    handle.call({ simulator, controller }, "dqa_check_gradient", scene, driver, terms.pointer, terms.n, filled, report,
        size)
    return structs.record("dqa_gradient_check_report", report)
end

return M
