-- SPDX-License-Identifier: MIT
-- Controllers: a sine per signal, a perceptron that sees the sensors, and Lua functions.
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local arrays = require "diffaqua.arrays"
local callbacks = require "diffaqua.callbacks"
local handle = require "diffaqua.handle"
local structs = require "diffaqua.structs"
local refuse = library.refuse

local M = {}

local Controller = handle.class("controller", "dqa_controller", "dqa_controller_free")
M.Controller = Controller

-- Open loop: a sin(omega t + phi) per signal; theta [n_signals][3] = (a in [0, 1], omega in rad/s, phi in rad).
function M.sinusoid(n_signals, time_step)
    return handle.create(Controller, {}, "dqa_controller_create_sinusoid", library.index("n_signals", n_signals),
        library.number("time_step", time_step or 1 / 30))
end

-- Closed loop: a perceptron with tanh; options by the names of dqa_mlp_options, where `hidden` is a table of the
-- neurons of each hidden layer, such as {n_signals = 1, dims = 2, hidden = {64, 64}}.
function M.perceptron(options)
    local values = {}
    if options ~= nil and type(options) ~= "table" then
        refuse("options: expected a table, got %s", library.kind(options))
    end
    for name, value in pairs(options or {}) do
        values[name] = value
    end
    if values.n_hidden ~= nil then
        refuse "unknown option 'n_hidden': give `hidden`, the neurons of each hidden layer"
    end
    if values.hidden ~= nil then
        if type(values.hidden) ~= "table" or #values.hidden > 5 then
            refuse("hidden: expected a table of at most 5 numbers, got %s",
                type(values.hidden) == "table" and #values.hidden or library.kind(values.hidden))
        end
        values.n_hidden = #values.hidden
        values.hidden = { unpack(values.hidden) }
        for i = values.n_hidden + 1, 5 do
            values.hidden[i] = 1 -- of no meaning, but must be in range
        end
    end
    return handle.create(Controller, {}, "dqa_controller_create_mlp",
        structs.options("dqa_mlp_options", "dqa_mlp_options_init", values))
end

-- A controller of Lua functions, which must depend on their arguments alone (step counted from 0, time in s):
--   evaluate(step, time, sensors [n_sensors], theta [n_parameters]) -> actuation [n_signals], each in [-1, 1];
--   pullback(step, time, sensors, theta, actuation_bar [n_signals]) -> theta_bar [n_parameters], sensors_bar
--   [n_sensors].
-- Fields: evaluate, pullback (nil: none), n_signals, n_sensors (0, or 5 dims), theta, time_step.
function M.callback_controller(fields)
    if type(fields) ~= "table" then
        refuse("fields: expected a table, got %s", library.kind(fields))
    end
    local numbers, own = {}, { evaluate = true, pullback = true, theta = true }
    for name, value in pairs(fields) do
        numbers[name] = not own[name] and value or nil
    end
    local entry, data = callbacks.register {
        evaluate = library.callable("evaluate", fields.evaluate),
        pullback = fields.pullback ~= nil and library.callable("pullback", fields.pullback) or nil,
    }
    local filled = structs.options("dqa_callback_controller_options", "dqa_callback_controller_options_init", numbers)
    filled[0].evaluate = callbacks.evaluate
    filled[0].pullback = entry.pullback and callbacks.pullback or nil
    filled[0].user_data = data
    local theta = arrays.numbers("theta", fields.theta or {}, false)
    local controller = handle.create(Controller, {}, "dqa_controller_create_callback", filled,
        theta.n > 0 and theta.data or nil, theta.n)
    controller.entry = entry
    return controller
end

-- The controller of a file that save wrote.
function M.load_controller(path)
    return handle.create(Controller, {}, "dqa_controller_load", library.text("path", path))
end

-- Writes settings and parameters.
function Controller:save(path)
    self:call("dqa_controller_save", library.text("path", path))
end

-- Kind and sizes, as dqa_controller_info.
function Controller:info()
    local filled, size = structs.room "dqa_controller_info"
    self:call("dqa_controller_get_info", filled, size)
    return structs.record("dqa_controller_info", filled)
end

-- A copy of theta [n_parameters].
function Controller:parameters(out)
    local count = ffi.new "int64_t[1]"
    self:call("dqa_controller_n_parameters", count)
    local theta = arrays.output("out", out, tonumber(count[0]))
    self:call("dqa_controller_get_parameters", theta.data, theta.n)
    return theta
end

-- Replaces theta [n_parameters].
function Controller:set_parameters(theta)
    local values = arrays.numbers("theta", theta, false)
    self:change("dqa_controller_set_parameters", values.data, values.n)
end

-- Actuation [n_signals] at a step, counted from 0, from sensors [n_sensors] where it reads them.
function Controller:evaluate(step, sensors, out)
    local actuation = arrays.output("out", out, self:info().n_signals)
    local seen = sensors ~= nil and arrays.numbers("sensors", sensors, self:info().n_sensors) or { n = 0 }
    self:call("dqa_controller_evaluate", library.whole("step", step), seen.data, seen.n, actuation.data, actuation.n)
    return actuation
end

return M
