-- SPDX-License-Identifier: MIT
-- Lua functions that the library calls. What they throw never crosses the C frames: it is kept, the call is asked to
-- stop, and the error is thrown again where the call returns to Lua (library.check).
--
-- LuaJIT has room for some hundreds of C callbacks, so there is one for each type of function; user_data is the number
-- of the Lua functions it stands for. They are held weakly here, and strongly by the objects that may call them.
--
-- The library runs all of these on the thread of the call, where LuaJIT can take them.
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local arrays = require "diffaqua.arrays"

local M = {}

local entries = setmetatable({}, { __mode = "v" })
local last = 0

local function number_of(data)
    return tonumber(ffi.cast("intptr_t", data))
end

-- Remembers a table of functions; returns it and its user_data.
function M.register(entry)
    last = last + 1
    entries[last] = entry
    return entry, ffi.cast("void *", ffi.cast("intptr_t", last))
end

-- Calls run(entry, ...) for C: 0, or 1 where it returns something true or throws.
local function guarded(run, data, ...)
    local outer = library.enter_callback()
    local entry = entries[number_of(data)]
    local ok, result
    if entry then
        ok, result = pcall(run, entry, ...)
    else
        ok, result = false, "diffaqua: a callback was called after all that refers to it was gone"
    end
    if not ok then
        library.keep_thrown(result)
    end
    library.leave_callback(outer)
    return (not ok or result) and 1 or 0
end

local function view(pointer, n)
    local copy = arrays.new(tonumber(n))
    if n > 0 and pointer ~= nil then
        ffi.copy(copy.data, pointer, 8 * tonumber(n))
    end
    return copy
end

-- What a function returned, as n numbers at `to`.
local function deliver(name, value, to, n)
    local numbers = arrays.numbers(name, value, tonumber(n))
    ffi.copy(to, numbers.data, 8 * numbers.n)
end

M.progress = ffi.cast("dqa_progress", function(done, total, data)
    return guarded(function(entry)
        return entry.progress(tonumber(done), tonumber(total))
    end, data)
end)

M.current = ffi.cast("dqa_current", function(time, out, data)
    return guarded(function(entry)
        deliver("current", entry.current(time), out, entry.dims)
    end, data)
end)

M.current_pullback = ffi.cast("dqa_current_pullback", function(time, bar, data)
    return guarded(function(entry)
        return entry.pullback(time, view(bar, entry.dims))
    end, data)
end)

M.evaluate = ffi.cast("dqa_control_evaluate", function(step, time, sensors, n_sensors, theta, n_parameters, actuation,
                                                       n_signals, data)
    return guarded(function(entry)
        local value = entry.evaluate(tonumber(step), time, view(sensors, n_sensors), view(theta, n_parameters))
        deliver("evaluate", value, actuation, n_signals)
    end, data)
end)

M.pullback = ffi.cast("dqa_control_pullback", function(step, time, sensors, n_sensors, theta, n_parameters, bar,
                                                       n_signals, theta_bar, sensors_bar, data)
    return guarded(function(entry)
        local by_theta, by_sensors = entry.pullback(tonumber(step), time, view(sensors, n_sensors),
            view(theta, n_parameters), view(bar, n_signals))
        if n_parameters > 0 then
            deliver("pullback: by theta", by_theta, theta_bar, n_parameters)
        end
        if n_sensors > 0 then
            deliver("pullback: by sensors", by_sensors, sensors_bar, n_sensors)
        end
    end, data)
end)

-- Calls run(function, user_data) for one call with a progress function; nil: none.
function M.with_progress(progress, run)
    if progress == nil then
        return run(nil, nil)
    end
    local entry, data = M.register { progress = library.callable("progress", progress) }
    run(M.progress, data)
    entry.progress = nil -- held until here
end

-- ------------------------------------------------------------------ log
local log_handler = nil

local log_callback = ffi.cast("dqa_log_handler", function(level, message, _)
    local outer = library.enter_callback()
    local ok, problem = pcall(function()
        if log_handler then
            log_handler(level, ffi.string(message))
        end
    end)
    if not ok then -- there is no call that it could come out of
        io.stderr:write("diffaqua: the log handler failed: ", tostring(problem), "\n")
    end
    library.leave_callback(outer)
end)

-- handler(level, message) for messages of at most that level (default LOG_INFO); nil silences them. For the whole
-- process: only where no other thread of it uses the library, since LuaJIT cannot be called from a second thread.
function M.set_log_handler(handler, level)
    level = library.index("level", level == nil and library.constants.LOG_INFO or level)
    if handler ~= nil then
        library.callable("handler", handler)
    end
    library.check(library.lib.dqa_set_log_handler(handler and log_callback or nil, level, nil))
    log_handler = handler
end

-- The state that these callbacks enter is about to close: the library must not call them any more.
M.at_exit = newproxy(true)
getmetatable(M.at_exit).__gc = function()
    if log_handler then
        library.lib.dqa_set_log_handler(nil, 0, nil)
    end
end

return M
