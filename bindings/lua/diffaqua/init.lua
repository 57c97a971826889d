-- SPDX-License-Identifier: MIT
-- Co-design of soft underwater swimmers for LuaJIT: shape space, simulator, controllers, tapes, gradients.
--
-- Thin over the C interface of libdiffaqua, whose header diffaqua.h explains every quantity. Lengths are SI units.
-- Constants are those of the header without DQA_, such as WRT_WEIGHTS. Indices of the library (bases, steps, signals,
-- nodes) count from 0 as in the header; elements of arrays count from 1 as in Lua.
assert(type(jit) == "table", "diffaqua needs LuaJIT")
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local arrays = require "diffaqua.arrays"
local callbacks = require "diffaqua.callbacks"

local M = {}

for name, value in pairs(library.constants) do
    M[name] = value
end

for _, part in ipairs { "shape_space", "controller", "simulator", "tape", "optimize" } do
    for name, value in pairs(require("diffaqua." .. part)) do
        if name:match "^%l" and name ~= "split_cancel" then -- functions; classes are for the other parts
            M[name] = value
        end
    end
end

-- array(3, 2): zeros of that shape; array{1, 2} or array{{1, 2}, {3, 4}}: the table's numbers.
M.array = arrays.array

-- handler(level, message) for messages of at most that level (default LOG_INFO); nil silences them. For the whole
-- process: only where no other thread of it uses the library, since LuaJIT cannot be called from a second thread.
M.set_log_handler = callbacks.set_log_handler

-- Of the loaded library, and where it was found.
M.version = ffi.string(library.lib.dqa_version())
M.library_path = library.path

-- What the library was built with, as a set: features().openmp.
function M.features()
    local set = {}
    for word in ffi.string(library.lib.dqa_features()):gmatch "%S+" do
        set[word] = true
    end
    return set
end

-- Whether a caught value is an error of this module: {status, name, message, position}.
function M.is_error(value)
    return getmetatable(value) == library.Error
end

-- One sentence on what a status means.
function M.status_text(status)
    return ffi.string(library.lib.dqa_status_text(library.index("status", status)))
end

return M
