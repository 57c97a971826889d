-- SPDX-License-Identifier: MIT
-- The structs of the header as Lua tables: options go in by the names of their fields, records come out the same way.
-- Names and types of the fields are those of diffaqua.cdef.
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local lib, check, refuse, kind = library.lib, library.check, library.refuse, library.kind

local M = {}

local HIDDEN = { struct_size = true, flags = true, padding = true }
local RANGE = {
    int32_t = { -2 ^ 31, 2 ^ 31 - 1 },
    uint32_t = { 0, 2 ^ 32 - 1 },
    int64_t = { -2 ^ 53, 2 ^ 53 }, -- what a Lua number holds exactly; beyond it give an int64_t
    uint64_t = { 0, 2 ^ 53 },
}

-- fields[struct]: a list of {name, type, length or nil}, in the struct's order, without what means nothing to a caller.
local fields = {}
for struct, body in library.declarations:gmatch "typedef struct ([%w_]+) (%b{})" do
    local list = {}
    for declaration in body:sub(2, -2):gmatch "[^;]*[^;%s][^;]*" do
        local ctype, name, length = declaration:match "^%s*(.-)%s*([%w_]+)%[?(%d*)%]?%s*$"
        if not HIDDEN[name] then
            list[#list + 1] = { name = name, type = ctype, length = tonumber(length) }
        end
    end
    fields[struct] = list
end
M.fields = fields

local function is_number(field)
    return field.type == "double" or RANGE[field.type] ~= nil
end

local function value_of(path, field, value)
    local range = RANGE[field.type]
    if not range then
        return library.number(path, value)
    end
    local whole = library.whole(path, value)
    if type(whole) == "number" and (whole < range[1] or whole > range[2]) then
        refuse("%s: expected a number in [%.0f, %.0f], got %.0f", path, range[1], range[2], whole)
    end
    return whole
end

local function assign(filled, field, value)
    if not field.length then
        filled[field.name] = value_of(field.name, field, value)
        return
    end
    if type(value) ~= "table" and type(value) ~= "cdata" then
        refuse("%s: expected %d numbers, got %s", field.name, field.length, kind(value))
    end
    if type(value) == "cdata" then -- an array of this module's
        value = value:totable()
    end
    if #value ~= field.length then
        refuse("%s: expected %d numbers, got %d", field.name, field.length, #value)
    end
    for i = 1, field.length do
        filled[field.name][i - 1] = value_of(("%s[%d]"):format(field.name, i), field, value[i])
    end
end

-- Writes `values` (nil: none) by name into a struct.
function M.fill(struct, filled, values)
    if values == nil then
        return
    end
    if type(values) ~= "table" then
        refuse("options: expected a table, got %s", kind(values))
    end
    local known, names = {}, {}
    for _, field in ipairs(fields[struct]) do
        if is_number(field) then
            known[field.name] = field
            names[#names + 1] = field.name
        end
    end
    for name in pairs(values) do
        if not known[name] then
            table.sort(names)
            refuse("unknown option '%s', expected one of %s", tostring(name), table.concat(names, ", "))
        end
    end
    for _, field in ipairs(fields[struct]) do -- in order: the same error for the same table
        local value = values[field.name]
        if value ~= nil then
            assign(filled, field, value)
        end
    end
end

-- A struct filled by its _init function, then with `values` by name.
function M.options(struct, init, values)
    local filled = ffi.new(struct .. "[1]")
    check(lib[init](filled, ffi.sizeof(struct)))
    M.fill(struct, filled[0], values)
    return filled
end

-- A struct for the library to fill, and its size.
function M.room(struct)
    return ffi.new(struct .. "[1]"), ffi.sizeof(struct)
end

-- The Lua table of a filled struct.
function M.record(struct, filled)
    local out = {}
    for _, field in ipairs(fields[struct]) do
        if is_number(field) then
            local value = filled[0][field.name]
            if field.length then
                local list = {}
                for i = 1, field.length do
                    list[i] = tonumber(value[i - 1])
                end
                out[field.name] = list
            else
                out[field.name] = tonumber(value)
            end
        end
    end
    return out
end

return M
