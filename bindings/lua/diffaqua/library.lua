-- SPDX-License-Identifier: MIT
-- Finds and loads the shared library, reads its declarations (diffaqua.cdef), and turns a status into a Lua error.
--
-- The library is looked for at the environment variable DIFFAQUA_LIBRARY, then where the system keeps libraries.
jit.off(true, true) -- C functions may call back, which compiled code does not allow

local ffi = require "ffi"

local M = {}

-- ------------------------------------------------------------------ declarations
local here = debug.getinfo(1, "S").source:match "^@(.*)library%.lua$" or "./"

local function read_declarations()
    -- Installed beside this file; in a checkout where the other languages have it too.
    for _, path in ipairs { here .. "diffaqua.cdef", here .. "../../diffaqua.cdef" } do
        local file = io.open(path, "rb")
        if file then
            local text = file:read "*a"
            file:close()
            return text
        end
    end
    error("diffaqua: diffaqua.cdef is missing beside " .. here .. "library.lua: the installation is incomplete", 0)
end

M.declarations = read_declarations()
if not pcall(ffi.typeof, "dqa_shape_space_options") then -- the module may be loaded again
    ffi.cdef(M.declarations)
end

local function load_library()
    local named, tried = os.getenv "DIFFAQUA_LIBRARY", {}
    for _, name in ipairs(named and { named } or { "libdiffaqua.so.0", "diffaqua" }) do
        local ok, found = pcall(ffi.load, name)
        if ok then
            return found, name
        end
        tried[#tried + 1] = tostring(found)
    end
    error("diffaqua: cannot load the shared library: " .. table.concat(tried, "; ")
        .. ". Install it, or set DIFFAQUA_LIBRARY to its path", 0)
end

M.lib, M.path = load_library()
local lib = M.lib

-- Constants by their names without DQA_, such as WRT_WEIGHTS.
M.constants = {}
for name, value in M.declarations:gmatch "DQA_([%u%d_]+) = (-?%d+)" do
    M.constants[name] = tonumber(value)
end

if lib.dqa_abi_version() ~= M.constants.ABI_VERSION then
    error(("diffaqua: %s has ABI %d; this module was made for %d"):format(M.path, lib.dqa_abi_version(),
        M.constants.ABI_VERSION), 0)
end

-- ------------------------------------------------------------------ errors
-- What is thrown: a table with status (the code), name (such as "DQA_ERROR_MESH"), message (the library's), and
-- position ("file:line:" of the caller outside this module, or "").
local Error = {}
Error.__index = Error
M.Error = Error

function Error:__tostring()
    return self.position .. self.name .. ": " .. self.message
end

local function caller()
    for level = 3, 30 do
        local frame = debug.getinfo(level, "Sl")
        if not frame then
            break
        end
        if frame.currentline > 0 and frame.source:sub(2, 1 + #here) ~= here then
            return ("%s:%d: "):format(frame.short_src, frame.currentline)
        end
    end
    return ""
end

function M.fail(status, message)
    error(setmetatable({
        status = status,
        name = ffi.string(lib.dqa_status_name(status)),
        message = message,
        position = caller(),
    }, Error), 0)
end

-- An argument that Lua refuses before the library sees it.
function M.refuse(pattern, ...)
    M.fail(M.constants.ERROR_ARGUMENT, pattern:format(...))
end

-- ------------------------------------------------------------------ errors that callbacks threw
-- They never cross the C frames: kept here, thrown again where the call returns to Lua. The first one counts.
local thrown = nil

function M.keep_thrown(value)
    thrown = thrown or { value = value }
end

-- A callback starts with a clean slate, so that calls inside it do not throw what is another call's to throw.
function M.enter_callback()
    local outer = thrown
    thrown = nil
    return outer
end

function M.leave_callback(outer)
    thrown = outer or thrown
end

function M.check(status)
    if thrown then
        local value = thrown.value
        thrown = nil
        error(value, 0)
    end
    if status == 0 then
        return
    end
    local message = ffi.string(lib.dqa_last_error())
    if status == M.constants.ERROR_INTERNAL and message == "unknown exception" then
        -- Ctrl-C makes the interpreter throw before a callback's first line, where nothing can keep it: the library
        -- stops as if cancelled, but cannot know why.
        M.fail(M.constants.CANCELLED, "interrupted in a callback")
    end
    M.fail(status, message)
end

-- ------------------------------------------------------------------ single arguments
local function kind(value)
    return type(value) == "cdata" and tostring(ffi.typeof(value)) or type(value)
end
M.kind = kind

-- A whole number of 64 bits that Lua's doubles hold exactly, or an int64_t or uint64_t.
function M.whole(name, value)
    if ffi.istype("int64_t", value) or ffi.istype("uint64_t", value) then
        return value
    end
    if type(value) ~= "number" then
        M.refuse("%s: expected a whole number, got %s", name, kind(value))
    end
    if value % 1 ~= 0 or math.abs(value) > 2 ^ 53 then
        M.refuse("%s: expected a whole number, got %.17g", name, value)
    end
    return value
end

-- One of 32 bits.
function M.index(name, value)
    local whole = tonumber(M.whole(name, value))
    if whole < -2 ^ 31 or whole >= 2 ^ 31 then
        M.refuse("%s: expected a number of 32 bits, got %.0f", name, whole)
    end
    return whole
end

function M.number(name, value)
    if type(value) ~= "number" then
        M.refuse("%s: expected a number, got %s", name, kind(value))
    end
    return value
end

function M.text(name, value)
    if type(value) ~= "string" then
        M.refuse("%s: expected a string, got %s", name, kind(value))
    end
    if value:find("\0", 1, true) then
        M.refuse("%s: expected a string without zero bytes", name)
    end
    return value
end

function M.callable(name, value)
    local meta = getmetatable(value)
    if type(value) ~= "function" and not (type(meta) == "table" and meta.__call) then
        M.refuse("%s: expected a function, got %s", name, kind(value))
    end
    return value
end

return M
