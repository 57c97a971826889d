-- SPDX-License-Identifier: MIT
-- The Lua module over the C interface: declarations, arrays, options, errors, lives of objects, callbacks.
local ffi = require "ffi"
local dq = require "diffaqua"
local library = require "diffaqua.library"
local structs = require "diffaqua.structs"
local support = require "support"
local test, equal, same, close, throws = support.test, support.equal, support.same, support.close, support.throws

local TRAVEL = { kind = dq.OBJECTIVE_TRAVEL }
local ARGUMENT, STATE, CANCELLED = "DQA_ERROR_ARGUMENT", "DQA_ERROR_STATE", "DQA_CANCELLED"

local function temporary()
    local path = os.tmpname()
    return path, function()
        os.remove(path)
    end
end

-- ------------------------------------------------------------------ declarations
test("every function of the header is used", function()
    local text = ""
    for _, name in ipairs { "arrays", "callbacks", "controller", "handle", "init", "library", "optimize", "shape_space",
        "simulator", "structs", "tape" } do
        local file = assert(io.open(os.getenv "DQA_ROOT" .. "/bindings/lua/diffaqua/" .. name .. ".lua"))
        text = text .. file:read "*a"
        file:close()
    end
    local n = 0
    for name in library.declarations:gmatch "(dqa_[%w_]+)%([%w_ *,]*%);" do
        n = n + 1
        assert(text:find(name .. "%f[^%w_]"), name .. " cannot be reached")
    end
    assert(n >= 90, "the declarations were not read: " .. n)
end)

test("constants and structs", function()
    equal(dq.WRT_LAME, 11)
    equal(dq.DIVERGED, -9)
    local n = 0
    for struct, fields in pairs(structs.fields) do
        n = n + 1
        local zero = ffi.new(struct)
        for _, field in ipairs(fields) do
            local value = zero[field.name] -- throws where C has no such field
            equal(type(value) == "cdata" and tostring(ffi.typeof(value)):match "%[(%d+)%]" or nil,
                field.length and tostring(field.length), struct .. "." .. field.name)
        end
    end
    assert(n >= 17, "the structs were not read: " .. n)
    local file = assert(io.open(os.getenv "DQA_ROOT" .. "/capi/diffaqua.h"))
    local header = file:read "*a"
    file:close()
    equal(dq.version, ("%s.%s.%s"):format(header:match "VERSION_MAJOR (%d+)", header:match "VERSION_MINOR (%d+)",
        header:match "VERSION_PATCH (%d+)"))
    assert(dq.status_text(dq.ERROR_MESH):find "mesh")
    equal(type(next(dq.features())), "string")
end)

test("the rockspec lists every file", function()
    local root, rock = os.getenv "DQA_ROOT", {}
    setfenv(assert(loadfile(root .. "/bindings/lua/diffaqua-0.1.0-1.rockspec")), rock)()
    equal(rock.version, dq.version .. "-1", "version")
    local listed, n = {}, 0
    for _, path in pairs(rock.build.modules) do
        listed[path] = true
    end
    for path in io.popen("cd '" .. root .. "' && ls bindings/lua/diffaqua/*.lua"):lines() do
        assert(listed[path], path .. " is not in the rockspec")
        listed[path], n = nil, n + 1
    end
    equal(next(listed), nil, "listed, but not there")
    assert(n > 5)
end)

-- ------------------------------------------------------------------ arrays and options
test("arrays", function()
    local array = dq.array { { 1, 2, 3 }, { 4, 5, 6 } }
    equal(#array, 6)
    equal(array:at(2, 1), 4)
    equal(array[6], 6)
    same(array:slice(2, 4), { 2, 3, 4 }, "slice")
    same(array:totable()[2], { 4, 5, 6 }, "totable")
    array[1] = 7
    equal(array:copy()[1], 7)
    equal(tostring(array), "[2][3]{7, 2, 3, 4, 5, 6}")
    for _, wrong in ipairs { 0, 7, 1.5 } do
        equal(pcall(function() return array[wrong] end), false, "index " .. wrong)
        equal(pcall(function() array[wrong] = 1 end), false, "index " .. wrong)
    end
    equal(pcall(array.at, array, 3, 1), false, "row 3 of 2")
    equal(pcall(array.at, array, 1), false, "one index of two")
    equal(pcall(array.slice, array, 3, 9), false, "slice beyond the end")
    throws(ARGUMENT, "length 2: expected a whole number", function() dq.array(2, 0.5) end)
end)

test("what goes in", function()
    local space = support.space(dq)
    local expected = space:density { 0.25, 0.75 }
    same(space:density(dq.array { 0.25, 0.75 }), expected, "array")
    same(space:density(ffi.new("double[2]", 0.25, 0.75)), expected, "C array")
    same(space:density(ffi.new("double[?]", 2, 0.25, 0.75)), expected, "C array of variable length")
    local out = dq.array(20, 8, 1)
    equal(space:density({ 0.25, 0.75 }, out), out, "the same array")
    same(out, expected, "out")
    same(space:pullback({ 0.25, 0.75 }, expected), space:pullback({ 0.25, 0.75 }, support.flat(expected, {})), "flat")

    throws(ARGUMENT, "weights: element 2: expected a number, got string", function() space:density { 0.5, "a" } end)
    throws(ARGUMENT, "weights: expected shape %[any%], got %[1, 2%]", function() space:density { { 0.5, 0.5 } } end)
    throws(ARGUMENT, "weights: expected numbers of shape %[any%].*got nil", function() space:density() end)
    throws(ARGUMENT, "weights: expected numbers.*got ctype<double %*>", function()
        space:density(ffi.cast("double *", out.data))
    end)
    throws(ARGUMENT, "weights: expected numbers.*got ctype<float %[2%]>", function()
        space:density(ffi.new "float[2]")
    end)
    throws(ARGUMENT, "weights", function() space:density { 1 } end)
    throws(ARGUMENT, "weights", function() space:density { 0.3, 0.3 } end)
    throws(ARGUMENT, "weights", function() space:density { 0 / 0, 1 } end)
    throws(ARGUMENT, "density_bar: expected shape %[20, 8, 1%], got %[3%]", function()
        space:pullback({ 0.5, 0.5 }, { 1, 2, 3 })
    end)
    throws(ARGUMENT, "out: expected shape %[20, 8, 1%], got %[160%]", function()
        space:density({ 0.5, 0.5 }, dq.array(160))
    end)
    throws(ARGUMENT, "out: expected an array", function() space:density({ 0.5, 0.5 }, {}) end)

    local open = dq.shape_space { dims = 2, cells_x = 20, cells_y = 8 }
    throws(ARGUMENT, "corners: row 2: expected 2 numbers, got 1", function() open:add_polygon { { 0, 0 }, { 1 } } end)
    throws(ARGUMENT, "corners: expected shape %[any, 2%], got %[3%]", function() open:add_polygon { 0, 0, 1 } end)
    throws(ARGUMENT, "name: expected a string, got number", function() open:add_polygon({ { 0, 0 } }, 7) end)
    local solid = dq.shape_space()
    throws(ARGUMENT, "triangles: element 3: expected a whole number of 32 bits, got 1.5", function()
        solid:add_mesh({ { 0, 0, 0 } }, { { 0, 0, 1.5 } })
    end)
    throws("DQA_ERROR_MESH", ".", function() solid:add_mesh({ 0, 0, 0, 1, 0, 0, 0, 1, 0 }, { 0, 1, 2 }) end)
end)

test("options", function()
    throws(ARGUMENT, "unknown option 'sigmoid', expected one of .*sigma", function() dq.shape_space { sigmoid = 1 } end)
    throws(ARGUMENT, "unknown option 'struct_size'", function() dq.shape_space { struct_size = 1 } end)
    throws(ARGUMENT, "cells_x: expected a whole number, got string", function() dq.shape_space { cells_x = "20" } end)
    throws(ARGUMENT, "cells_x: expected a whole number, got 20.5", function() dq.shape_space { cells_x = 20.5 } end)
    throws(ARGUMENT, "cells_x: expected a number in %[%-2147483648", function()
        dq.shape_space { cells_x = 2 ^ 31 }
    end)
    throws(ARGUMENT, "seed: expected a number in %[0", function() dq.perceptron { seed = -1 } end)
    throws(ARGUMENT, "sigma", function() dq.shape_space { sigma = -1 } end)
    throws(ARGUMENT, "options: expected a table, got number", function() dq.shape_space(3) end)
    throws(ARGUMENT, "cancel: expected a cancel token, got table", function() dq.shape_space { cancel = {} } end)
    local space = support.space(dq)
    throws(ARGUMENT, "current: expected 3 numbers, got 1", function() dq.simulator(space, { current = { 1 } }) end)
    throws(ARGUMENT, "current%[2%]: expected a number, got string", function()
        dq.simulator(space, { current = { 1, "x", 3 } })
    end)
    throws(ARGUMENT, "hidden: expected a table of at most 5 numbers, got 6", function()
        dq.perceptron { hidden = { 1, 1, 1, 1, 1, 1 } }
    end)
    throws(ARGUMENT, "give `hidden`", function() dq.perceptron { n_hidden = 2 } end)
    close(dq.simulator(space, { time_step = 0.25 }).time_step, 0.25, 0)
    local large = dq.perceptron { seed = 2 ^ 53, hidden = { 2 } }:parameters()
    same(dq.perceptron { seed = 9007199254740992ULL, hidden = { 2 } }:parameters(), large, "seed of 64 bits")
end)

-- ------------------------------------------------------------------ errors and lives
test("errors", function()
    local caught = throws("DQA_ERROR_IO", "fish%.stl", function()
        dq.shape_space():add_mesh_file "/nowhere/fish.stl"
    end)
    equal(caught.status, dq.ERROR_IO)
    equal(dq.is_error(caught), true)
    equal(dq.is_error "text", false)
    assert(tostring(caught):match "^.*test_core%.lua:%d+: DQA_ERROR_IO: .*fish%.stl", tostring(caught))
    local path, remove = temporary()
    throws("DQA_ERROR_FILE", ".", function() dq.load_shape_space(path) end)
    remove()
    throws(STATE, ".", function() dq.simulator(dq.shape_space()) end)
    throws(ARGUMENT, "space: expected a shape space, got nil", function() dq.simulator() end)
    throws(ARGUMENT, "space: expected a shape space, got table", function() dq.simulator(dq.sinusoid(1)) end)
    throws(ARGUMENT, "n_signals", function() dq.sinusoid(0) end)
    throws(ARGUMENT, "n_steps: expected a whole number, got 1.5", function()
        support.swimmer(dq):rollout(dq.sinusoid(1), 1.5)
    end)
end)

test("objects close in any order", function()
    for _, order in ipairs { "space simulator sine tape adjoint", "adjoint tape sine simulator space" } do
        local objects = { space = support.space(dq), sine = dq.sinusoid(1) }
        objects.simulator = dq.simulator(objects.space, support.SETTINGS)
        objects.simulator:set_weights { 0.5, 0.5 }
        objects.tape = dq.tape(objects.simulator)
        objects.simulator:rollout(objects.sine, 3, objects.tape)
        objects.adjoint = dq.adjoint(objects.tape)
        for name in order:gmatch "%w+" do
            equal(objects[name]:is_closed(), false)
            objects[name]:close()
            objects[name]:close()
            assert(tostring(objects[name]):find "closed")
        end
        throws(STATE, "this shape space is closed", function() objects.space:info() end)
        throws(STATE, "this simulator is closed", function() objects.simulator:rollout(dq.sinusoid(1), 1) end)
        throws(STATE, "this controller is closed", function() objects.sine:parameters() end)
        throws(STATE, "this tape is closed", function() objects.tape:n_steps() end)
        throws(STATE, "this adjoint is closed", function() objects.adjoint:backward() end)
        throws(STATE, "this shape space is closed", function() dq.simulator(objects.space) end)
    end
end)

test("a child outlives its parents", function()
    local swimmer = support.swimmer(dq)
    local tape = dq.tape(swimmer)
    swimmer:rollout(dq.sinusoid(1), 3, tape)
    swimmer:close()
    collectgarbage()
    assert(tape:gradient(TRAVEL, dq.WRT_WEIGHTS)[1] ~= 0)
end)

test("objects are collected", function()
    local weak = setmetatable({}, { __mode = "v" })
    local finalised = 0
    for i = 1, 20 do
        weak[i] = dq.sinusoid(1)
        local pointer = weak[i].pointer
        weak[i].pointer = ffi.gc(pointer, function(p)
            finalised = finalised + 1
            library.lib.dqa_controller_free(p)
        end)
    end
    collectgarbage()
    collectgarbage()
    equal(next(weak), nil, "still there")
    equal(finalised, 20, "freed")
end)

test("not closed while a call uses it", function()
    local swimmer, sine = support.swimmer(dq), dq.sinusoid(1)
    throws(STATE, "simulator cannot be closed while", function()
        swimmer:rollout(sine, 3, nil, function() swimmer:close() end)
    end)
    throws(STATE, "controller cannot be closed while", function()
        swimmer:rollout(sine, 3, nil, function() sine:close() end)
    end)
    local tape = dq.tape(swimmer)
    for name, change in pairs {
        simulator = function() swimmer:set_weights { 1, 0 } end,
        tape = function() tape:clear() end,
        controller = function() sine:set_parameters { 1, 1, 1 } end,
    } do
        throws(STATE, "this " .. name .. " cannot be changed while", function()
            swimmer:rollout(sine, 3, tape, change)
        end)
    end
    throws(STATE, "this simulator cannot be changed", function()
        swimmer:rollout(sine, 3, nil, function() swimmer:step { 0 } end)
    end)
    tape:clear()
    swimmer:rollout(sine, 3, tape, function() -- questions are welcome
        swimmer:state()
        sine:parameters()
        tape:n_steps()
    end)
    swimmer:set_weights { 1, 0 } -- the counts are right again
    swimmer:close()
    sine:close()
end)

-- ------------------------------------------------------------------ callbacks
test("progress", function()
    local swimmer, seen = support.swimmer(dq), {}
    swimmer:rollout(dq.sinusoid(1), 4, nil, function(done, total) seen[#seen + 1] = done .. "/" .. total end)
    equal(table.concat(seen, " "), "1/4 2/4 3/4 4/4")
    throws(CANCELLED, ".", function() swimmer:rollout(dq.sinusoid(1), 9, nil, function(done) return done == 2 end) end)
    equal(swimmer:info().steps, 6)
    throws(ARGUMENT, "progress: expected a function, got number", function()
        swimmer:rollout(dq.sinusoid(1), 1, nil, 7)
    end)
    local callable = setmetatable({}, { __call = function() return true end })
    throws(CANCELLED, ".", function() swimmer:rollout(dq.sinusoid(1), 2, nil, callable) end)
end)

test("errors come out of callbacks unchanged", function()
    local swimmer, mine = support.swimmer(dq), { "mine" }
    local function fail()
        error(mine)
    end
    local function failing(run)
        local ok, problem = pcall(run)
        equal(ok, false)
        equal(rawequal(problem, mine), true, tostring(problem))
    end
    failing(function() swimmer:rollout(dq.sinusoid(1), 3, nil, fail) end)
    failing(function() swimmer:set_weights({ 1, 0 }, fail) end)
    failing(function() swimmer:rollout(dq.callback_controller { evaluate = fail, n_signals = 1 }, 3) end)
    swimmer:set_weights { 0.5, 0.5 }
    swimmer:set_current(fail)
    failing(function() swimmer:step { 0 } end)
    swimmer:set_current(function() return { 0, 0 } end, fail)
    local tape = dq.tape(swimmer)
    swimmer:step({ 0 }, tape)
    failing(function() tape:gradient(TRAVEL, dq.WRT_WEIGHTS) end)
    swimmer:set_current(nil)
    tape:clear()
    local controller = dq.callback_controller {
        evaluate = function() return { 0.5 } end, pullback = fail, n_signals = 1, theta = { 1 },
    }
    swimmer:rollout(controller, 2, tape)
    failing(function() tape:gradient(TRAVEL, dq.WRT_CONTROL) end)
    swimmer:step { 0 } -- nothing is left over

    local ok, problem = pcall(swimmer.rollout, swimmer, dq.sinusoid(1), 1, nil, function() error() end)
    equal(ok, false)
    equal(problem, nil, "an error without a value")
    -- A call inside a callback throws its own error, there; the outer one carries on.
    local inner
    swimmer:rollout(dq.sinusoid(1), 2, nil, function()
        inner = throws(ARGUMENT, "n_signals", function() dq.sinusoid(0) end)
    end)
    equal(inner.status, dq.ERROR_ARGUMENT)
    -- Neither a yield nor deep recursion crosses the library.
    ok = coroutine.wrap(function()
        return pcall(swimmer.rollout, swimmer, dq.sinusoid(1), 1, nil, function() coroutine.yield() end)
    end)()
    equal(ok, false, "yield")
    local function deep() return 1 + deep() end
    ok, problem = pcall(swimmer.rollout, swimmer, dq.sinusoid(1), 1, nil, deep)
    equal(ok, false, "recursion")
    assert(tostring(problem):find "stack overflow", problem)
    -- Ctrl-C makes the interpreter throw before a callback's first line.
    local steps = swimmer:info().steps
    throws(CANCELLED, "interrupted in a callback", function()
        swimmer:rollout(dq.sinusoid(1), 9, nil, function(done)
            debug.sethook(done == 2 and function()
                local frame = debug.getinfo(2, "Su")
                if frame.source:find "callbacks.lua" and frame.nparams == 3 then -- what C calls
                    debug.sethook()
                    error "interrupted!"
                end
            end or nil, "c")
        end)
    end)
    equal(swimmer:info().steps, steps + 3)
    swimmer:step { 0 }
end)

local function reactive()
    return dq.callback_controller {
        n_signals = 1,
        n_sensors = 10,
        theta = { 0.7, 0.4 },
        evaluate = function(_, time, sensors, theta)
            local e = math.exp(2 * (theta[1] * math.sin(12 * time) + theta[2] * sensors[4]))
            return { (e - 1) / (e + 1) }
        end,
        pullback = function(_, time, sensors, theta, bar)
            local z = theta[1] * math.sin(12 * time) + theta[2] * sensors[4]
            local slope = bar[1] / ((math.exp(z) + math.exp(-z)) / 2) ^ 2
            return { slope * math.sin(12 * time), slope * sensors[4] }, { 0, 0, 0, slope * theta[2], 0, 0, 0, 0, 0, 0 }
        end,
    }
end

test("a controller of Lua functions and its pullback", function()
    local swimmer = support.swimmer(dq)
    for _, wrt in ipairs { dq.WRT_CONTROL, dq.WRT_WEIGHTS } do
        local report = dq.check_gradient(swimmer, TRAVEL, { with_respect_to = wrt, n_steps = 5 }, reactive())
        assert(report.relative_error < 1e-6, report.relative_error)
        close(report.taylor_slope, 2, 0.1, "slope")
    end
    local tape = dq.tape(swimmer)
    swimmer:rollout(reactive(), 5, tape)
    collectgarbage() -- the tape keeps what it calls
    collectgarbage()
    local adjoint = dq.adjoint(tape)
    tape:close()
    tape.entries = nil
    collectgarbage() -- and so does its adjoint
    collectgarbage()
    adjoint:seed_objective(TRAVEL)
    adjoint:backward()
    equal(#adjoint:gradient(dq.WRT_CONTROL), 2)
    local blind = dq.callback_controller { n_signals = 1, n_sensors = 10, evaluate = function() return { 0 } end }
    tape = dq.tape(swimmer)
    swimmer:rollout(blind, 2, tape)
    throws(STATE, ".", function() dq.adjoint(tape) end)
    equal(blind:info().has_pullback, 0)
    throws("DQA_ERROR_UNSUPPORTED", ".", function() blind:save "nowhere" end)
end)

test("what callbacks return", function()
    local swimmer = support.swimmer(dq)
    local function driven(evaluate)
        swimmer:rollout(dq.callback_controller { evaluate = evaluate, n_signals = 1 }, 1)
    end
    throws(ARGUMENT, "evaluate: expected shape %[1%], got %[2%]", function() driven(function() return { 0, 0 } end) end)
    throws(ARGUMENT, "evaluate: expected numbers.*got nil", function() driven(function() end) end)
    throws(ARGUMENT, "%[%-1, 1%]", function() driven(function() return { 3 } end) end)
    throws(ARGUMENT, "evaluate: expected a function, got nil", function() driven() end)
    throws(ARGUMENT, "unknown option 'signals'", function()
        dq.callback_controller { evaluate = print, signals = 1 }
    end)
    swimmer:set_current(function() return { 1, 2, 3 } end)
    throws(ARGUMENT, "current: expected shape %[2%], got %[3%]", function() swimmer:step { 0 } end)
    swimmer:set_current()
    local tape = dq.tape(swimmer)
    swimmer:rollout(dq.callback_controller {
        evaluate = function() return { 0.5 } end, n_signals = 1, theta = { 1 }, pullback = function() return 7 end,
    }, 2, tape)
    throws(ARGUMENT, "pullback: by theta: expected numbers", function() tape:gradient(TRAVEL, dq.WRT_CONTROL) end)
end)

test("currents", function()
    local swimmer, times, bars = support.swimmer(dq), {}, {}
    swimmer:set_current(function(time) return { 0.1 * time, 0.02 } end, function(time, bar)
        table.insert(times, 1, time)
        table.insert(bars, 1, bar:totable())
    end)
    local tape = dq.tape(swimmer)
    swimmer:rollout(dq.sinusoid(1), 3, tape)
    close(tape:current(2)[1], 0.2 / 30, 1e-15)
    swimmer:set_current(nil)
    collectgarbage()
    same(tape:gradient(TRAVEL, dq.WRT_CURRENT), bars, "what the pullback got")
    close(times[3], 2 / 30, 1e-15)
    swimmer:set_current_table({ 0, 1, 2 }, { { 0, 0 }, { 0.1, 0 }, { 0, 0 } })
    tape:clear()
    swimmer:set_state()
    swimmer:rollout(dq.sinusoid(1), 2, tape)
    same(tape:gradient(TRAVEL, dq.WRT_CURRENT_TABLE):sizes(), { 3, 2 }, "shape")
    swimmer:set_current_table({}, {})
    throws(ARGUMENT, "velocities: expected shape %[2, 2%]", function() swimmer:set_current_table({ 0, 1 }, { 1 }) end)
end)

test("any number of callbacks, also from compiled code", function()
    local swimmer, calls = support.swimmer(dq, { tolerance = 1e-6 }), 0
    for _ = 1, 2000 do
        dq.callback_controller { n_signals = 1, evaluate = function()
            calls = calls + 1
            return { 0 }
        end }:evaluate(0)
    end
    local constant = dq.callback_controller { n_signals = 1, evaluate = function()
        calls = calls + 1
        return { 0.1 }
    end }
    for _ = 1, 300 do
        swimmer:rollout(constant, 1, nil, function() end)
        constant:evaluate(0)
    end
    equal(calls, 2600)
end)

test("log", function()
    local seen = {}
    dq.set_log_handler(function(level, message) seen[level] = message end, dq.LOG_DEBUG)
    support.swimmer(dq):step { 0 }
    dq.set_log_handler(nil)
    equal(type(seen[dq.LOG_INFO]), "string")
    equal(type(seen[dq.LOG_DEBUG]), "string")
    throws(ARGUMENT, "level", function() dq.set_log_handler(print, 9) end)
    throws(ARGUMENT, "handler: expected a function", function() dq.set_log_handler(3) end)
end)

test("cancel token", function()
    local token = dq.cancel_token()
    local swimmer = support.swimmer(dq, { cancel = token })
    throws(CANCELLED, ".", function() swimmer:rollout(dq.sinusoid(1), 9, nil, function() token:set() end) end)
    token:reset()
    swimmer:step { 0 }
    token:close()
    swimmer:step { 0 }
end)

-- ------------------------------------------------------------------ each method once
test("space", function()
    local space = support.space(dq)
    equal(table.concat(space:names(), " "), "slim stout")
    same({ space:shape() }, { 20, 8, 1 }, "shape")
    local h, bar = 1e-5, dq.array(20, 8, 1)
    for i = 1, 160 do
        bar[i] = math.sin(i * i)
    end
    local gradient, slope = space:pullback({ 0.3, 0.7 }, bar), 0
    local ahead, behind = space:density { 0.3 + h, 0.7 - h }, space:density { 0.3 - h, 0.7 + h }
    for i = 1, 160 do
        slope = slope + bar[i] * (ahead[i] - behind[i]) / (2 * h)
    end
    close((gradient[1] - gradient[2]) / slope, 1, 1e-6, "pullback")
    equal(space:signal(0).kind, dq.ACTUATOR_CAUDAL)
    equal(space:actuator(0, 0).kind, dq.ACTUATOR_CAUDAL)
    equal(#space:base(1), 160)
    local path, remove = temporary()
    space:save(path)
    same(dq.load_shape_space(path):density { 0.3, 0.7 }, space:density { 0.3, 0.7 }, "loaded")
    remove()
end)

test("bases", function()
    local flat = dq.shape_space { dims = 2, cells_x = 20, cells_y = 8, cell_size = 0.05 }
    local pixels, cells = dq.array(16, 40), dq.array(20, 8, 1)
    for row = 6, 9 do
        for column = 4, 35 do
            pixels[row * 40 + column + 1] = 1
        end
    end
    for i = 3, 16 do
        cells[i * 8 + 4], cells[i * 8 + 5] = 1, 1
    end
    equal(flat:add_image(pixels, "bar"), 0)
    equal(flat:add_density(cells, "block"), 1)
    for base = 0, 1 do
        flat:add_actuator(base, { mean = { -0.2, 0, 0 }, variance = { 0.01, 0.002, 0.002 } })
    end
    local reports = 0
    flat:build(function() reports = reports + 1 end)
    assert(reports > 0)
    same(flat:actuator(1, 0).mean, { -0.2, 0, 0 }, "mean")
    equal(flat:info().is_built, 1)
end)

test("simulator", function()
    local swimmer = support.swimmer(dq)
    local info = swimmer:info()
    swimmer:step { 0.5 }
    same(swimmer:sensors():sizes(), { 5, 2 }, "sensors")
    same(swimmer:forces():sizes(), { 4, 2 }, "forces")
    local vertices, elements = swimmer:surface()
    equal(vertices:sizes()[2], 2)
    equal(elements:sizes()[2], 2)
    local mesh, muscles, largest = swimmer:mesh(), swimmer:muscles(), 0
    for i = 1, #mesh.cell_nodes do
        largest = math.max(largest, mesh.cell_nodes[i])
    end
    equal(largest, info.n_nodes - 1)
    equal(#mesh.box_index, info.n_active_cells)
    equal(math.abs(muscles.signs[1]), 1)
    equal(#muscles.directions, 2 * #muscles.stiffness)
    equal(swimmer:actuator(0).share, 1)
    local index = swimmer:node_box_index()
    swimmer:set_fixed_nodes(index:slice(1, 3))
    swimmer:step { 0.5 }
    local q, v = swimmer:state()
    local again = dq.array(info.n_nodes, 2)
    equal(swimmer:state(again), again)
    same(again, q, "out")
    swimmer:set_state()
    local rest = swimmer:state()
    same(q:slice(1, 6), rest:slice(1, 6), "fixed nodes")
    swimmer:set_state(q, v)
    same(swimmer:state(), q, "state")
    swimmer:set_fixed_nodes {}
    local moduli = dq.array(160)
    for i = 1, 160 do
        moduli[i] = 3e5
    end
    swimmer:set_material(moduli, nil)
    swimmer:set_material()
    throws(ARGUMENT, "young_modulus: expected shape %[160%], got %[1%]", function() swimmer:set_material { 1 } end)
    local threshold, estimate = swimmer:suggest_threshold({ 0.5, 0.5 }, 0.1)
    assert(threshold >= 0 and threshold < 0.5 and estimate <= 0.1)
    same(swimmer:weights(), { 0.5, 0.5 }, "weights")
end)

test("tape", function()
    local swimmer = support.swimmer(dq)
    local tape = dq.tape(swimmer)
    throws(STATE, "nothing is recorded", function() tape:state(0) end)
    throws(STATE, "nothing is recorded", function() dq.adjoint(tape) end)
    swimmer:rollout(dq.sinusoid(1), 4, tape)
    same(tape:state(4), swimmer:state(), "state")
    same(tape:surface(4), (swimmer:surface()), "surface")
    equal(tape:n_steps(), 4)
    equal(tape:statistics().steps, 4)
    equal(#tape:actuation(1), 1)
    throws(ARGUMENT, "step", function() tape:actuation(4) end)
    local loss, terms = tape:objective { TRAVEL, { kind = dq.OBJECTIVE_EFFORT, weight = 0.5 } }
    close(loss, terms[1] + 0.5 * terms[2], 1e-15)
    assert(tape:objective { kind = dq.OBJECTIVE_PATH, path = { { 0, 0, 0 }, { 1, 0.5, 0 } } } > 0)
    throws(ARGUMENT, "unknown option 'wait'", function() tape:objective { wait = 1 } end)
    throws(ARGUMENT, "loss: expected a table", function() tape:objective(1) end)
    local wanted = { { dq.WRT_WEIGHTS, 2 }, { dq.WRT_CONTROL, 3 }, { dq.WRT_ACTUATION, 4 }, { dq.WRT_WATER, 11 },
        { dq.WRT_CURRENT, 8 }, { dq.WRT_YOUNGS_MODULUS, 160 }, { dq.WRT_MATERIAL, 4 }, { dq.WRT_LAME, 2 } }
    local which = {}
    for i, pair in ipairs(wanted) do
        which[i] = pair[1]
    end
    for i, gradient in ipairs { tape:gradient(TRAVEL, unpack(which)) } do
        equal(#gradient, wanted[i][2], "gradient " .. i)
    end
    local adjoint = dq.adjoint(tape)
    local bar = dq.array(swimmer:info().n_nodes, 2)
    throws(STATE, ".", function() tape:clear() end)
    adjoint:seed(2, dq.SEED_POSITION, bar)
    adjoint:backward(2)
    throws(STATE, ".", function() adjoint:seed(3, dq.SEED_POSITION, bar) end)
    throws(ARGUMENT, "wrt", function() adjoint:gradient(99) end)
    throws(ARGUMENT, "bar: expected shape", function() adjoint:seed(0, dq.SEED_POSITION, { 1 }) end)
    adjoint:close()
    tape:clear()
    swimmer:step({ 0 }, tape)
    throws(STATE, "no controller", function() tape:gradient(TRAVEL, dq.WRT_CONTROL) end)
    swimmer:set_weights { 1, 0 }
    throws(STATE, "another design", function() tape:surface(1) end)
    throws("DQA_ERROR_MEMORY", ".", function() swimmer:step({ 0 }, dq.tape(swimmer, { memory_bytes = 8 })) end)
end)

test("controllers", function()
    local sine = dq.sinusoid(2)
    sine:set_parameters { 1, 2, math.pi / 2, 0.5, 2, math.pi / 2 }
    close(sine:evaluate(0)[2], 0.5, 1e-15)
    throws(ARGUMENT, "theta", function() sine:set_parameters { 1 } end)
    local network = dq.perceptron { n_signals = 2, dims = 2, hidden = { 4 }, seed = 3 }
    equal(network:info().n_parameters, (10 + 20 + 1) * 4 + (4 + 1) * 2)
    equal(#network:evaluate(1, dq.array(5, 2):slice(1)), 2)
    local path, remove = temporary()
    network:save(path)
    same(dq.load_controller(path):parameters(), network:parameters(), "loaded")
    remove()
end)

test("search", function()
    local target, units = { 0.3, -2, 40 }, { 1, 1, 20 }
    local search = dq.cma_es({ 0, 0, 0 }, units, { seed = 3 })
    throws(STATE, ".", function() search:best() end)
    local path, remove = temporary()
    for generation = 1, 90 do
        local points, values = search:ask(), {}
        for k = 1, points:sizes()[1] do
            values[k] = 0
            for j = 1, 3 do
                values[k] = values[k] + ((points:at(k, j) - target[j]) / units[j]) ^ 2
            end
        end
        search:tell(values)
        if generation == 30 then
            search:save(path)
            search = dq.load_cma_es(path)
        end
    end
    remove()
    local x, value = search:best()
    assert(value < 1e-8, value)
    close(x[3], 40, 4e-3)
    close(search:mean()[2], -2, 2e-4)
    equal(search:info().generation, 90)
    search:ask()
    throws(ARGUMENT, "values", function() search:tell { 1 } end)
    throws(ARGUMENT, "scales: expected shape %[1%], got %[2%]", function() dq.cma_es({ 0 }, { 1, 2 }) end)
    throws(ARGUMENT, "x: expected an array", function() dq.adam_step({ 1 }, { 1 }, { 1 }, { 0 }, { 0 }, 1) end)
end)

support.run()
