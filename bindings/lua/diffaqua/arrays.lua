-- SPDX-License-Identifier: MIT
-- Arrays on their way in and out. Results are arrays of doubles (or of 32-bit integers) with a shape, row-major, whose
-- elements Lua counts from 1; C's own memory is their field `data`, counted from 0. What goes in may be such an array,
-- a C array of the right type (neither is copied), a flat table, or a table of rows.
--
-- Unlike the rest of the module this file is compiled: nothing here calls the library.
local ffi = require "ffi"
local library = require "diffaqua.library"
local refuse, kind = library.refuse, library.kind

local M = {}

local doubles = ffi.typeof "struct { int64_t n; int64_t shape[3]; int32_t rank; double data[?]; }"
local integers = ffi.typeof "struct { int64_t n; int64_t shape[3]; int32_t rank; int32_t data[?]; }"

-- ------------------------------------------------------------------ the array itself
local methods = {}

local function make(ctype, n, rank, first, second, third)
    local array = ctype(n)
    array.n, array.rank = n, rank
    array.shape[0], array.shape[1], array.shape[2] = first, second or 1, third or 1
    return array
end

local function within(array, index)
    if type(index) ~= "number" or index % 1 ~= 0 or index < 1 or index > tonumber(array.n) then
        error(("index %s of an array of %d elements"):format(tostring(index), tonumber(array.n)), 3)
    end
    return index - 1
end

local meta = {
    __index = function(array, key)
        if type(key) == "number" then
            return array.data[within(array, key)]
        end
        return methods[key]
    end,
    __newindex = function(array, key, value)
        array.data[within(array, key)] = value
    end,
    __len = function(array)
        return tonumber(array.n)
    end,
    __tostring = function(array)
        local words = {}
        for i = 1, math.min(#array, 6) do
            words[i] = ("%.6g"):format(array.data[i - 1])
        end
        return ("[%s]{%s%s}"):format(table.concat(array:sizes(), "]["), table.concat(words, ", "),
            #array > 6 and ", ..." or "")
    end,
}

-- Lengths of its axes, as a table.
function methods.sizes(array)
    local sizes = {}
    for axis = 1, array.rank do
        sizes[axis] = tonumber(array.shape[axis - 1])
    end
    return sizes
end

local function offset(array, i, j, k)
    local place = 0
    for axis, index in ipairs { i, j, k } do
        local length = tonumber(array.shape[axis - 1])
        if type(index) ~= "number" or index % 1 ~= 0 or index < 1 or index > length then
            error(("index %s of axis %d, which has %d"):format(tostring(index), axis, length), 3)
        end
        place = place * length + index - 1
    end
    return place
end

local function must_have(array, ...)
    if select("#", ...) ~= array.rank then
        error(("expected %d indices, got %d"):format(array.rank, select("#", ...)), 3)
    end
end

-- array:at(row, column) counts both from 1.
function methods.at(array, ...)
    must_have(array, ...)
    return array.data[offset(array, ...)]
end

-- Its elements as nested tables, one level for each axis.
function methods.totable(array)
    local function level(axis, start)
        local length, stride = tonumber(array.shape[axis - 1]), 1
        for later = axis, array.rank - 1 do
            stride = stride * tonumber(array.shape[later])
        end
        local out = {}
        for i = 0, length - 1 do
            out[i + 1] = axis == array.rank and array.data[start + i] or level(axis + 1, start + i * stride)
        end
        return out
    end
    return level(1, 0)
end

local function bytes(array, n)
    return n * (ffi.istype(doubles, array) and 8 or 4)
end

-- A copy of elements first ... last, both counted from 1, as one axis.
function methods.slice(array, first, last)
    last = last or #array
    if first % 1 ~= 0 or last % 1 ~= 0 or first < 1 or last > #array or last < first - 1 then
        error(("slice %s ... %s of an array of %d elements"):format(first, last, #array), 2)
    end
    local part = make(ffi.istype(doubles, array) and doubles or integers, last - first + 1, 1, last - first + 1)
    ffi.copy(part.data, array.data + (first - 1), bytes(array, last - first + 1))
    return part
end

function methods.copy(array)
    local twin = make(ffi.istype(doubles, array) and doubles or integers, tonumber(array.n), array.rank,
        array.shape[0], array.shape[1], array.shape[2])
    ffi.copy(twin.data, array.data, bytes(array, #array))
    return twin
end

ffi.metatype(doubles, meta)
ffi.metatype(integers, meta)

-- ------------------------------------------------------------------ out
local function shape_text(shape, rank)
    local words = {}
    for axis = 1, rank or #shape do
        words[axis] = shape[axis] and tostring(tonumber(shape[axis])) or "any"
    end
    return "[" .. table.concat(words, ", ") .. "]"
end

local function product(shape)
    local n = 1
    for axis = 1, #shape do
        n = n * shape[axis]
    end
    return n
end

function M.new(...)
    local shape = { ... }
    return make(doubles, product(shape), #shape, ...)
end

function M.new_integers(...)
    local shape = { ... }
    return make(integers, product(shape), #shape, ...)
end

local function has_shape(array, shape)
    if array.rank ~= #shape then
        return false
    end
    for axis = 1, #shape do
        if shape[axis] and tonumber(array.shape[axis - 1]) ~= shape[axis] then
            return false
        end
    end
    return true
end

-- Number of elements of an array that is to be written in place.
function M.length(name, array)
    if not ffi.istype(doubles, array) then
        refuse("%s: expected an array of diffaqua.array, got %s", name, kind(array))
    end
    return #array
end

-- `out` if it can be written as it is, or a new array.
function M.output(name, out, ...)
    if out == nil then
        return M.new(...)
    end
    if not ffi.istype(doubles, out) then
        refuse("%s: expected an array of diffaqua.array, got %s", name, kind(out))
    end
    if not has_shape(out, { ... }) then
        refuse("%s: expected shape %s, got %s", name, shape_text { ... }, shape_text(out:sizes()))
    end
    return out
end

-- ------------------------------------------------------------------ in
local function element(name, value, place, whole)
    if type(value) ~= "number" then
        refuse("%s: element %d: expected a number, got %s", name, place, kind(value))
    end
    if whole and (value % 1 ~= 0 or value < -2 ^ 31 or value >= 2 ^ 31) then
        refuse("%s: element %d: expected a whole number of 32 bits, got %.17g", name, place, value)
    end
    return value
end

local function from_rows(ctype, name, rows, columns, whole)
    local array = make(ctype, #rows * columns, 2, #rows, columns)
    for i = 1, #rows do
        local row = rows[i]
        if type(row) ~= "table" or #row ~= columns then
            refuse("%s: row %d: expected %d numbers, got %s", name, i, columns,
                type(row) == "table" and #row or kind(row))
        end
        for j = 1, columns do
            array.data[(i - 1) * columns + j - 1] = element(name, row[j], (i - 1) * columns + j, whole)
        end
    end
    return array
end

local function from_flat(ctype, name, values, whole)
    local array = make(ctype, #values, 1, #values)
    for i = 1, #values do
        array.data[i - 1] = element(name, values[i], i, whole)
    end
    return array
end

-- Gives a flat array of n elements the shape that is wanted, where its number of elements allows it.
local function flat_fits(n, shape)
    local open, known = 0, 1
    for axis = 1, #shape do
        if shape[axis] then
            known = known * shape[axis]
        else
            open = open + 1
        end
    end
    return open == 0 and n == known or open == 1 and known > 0 and n % known == 0
end

-- A view {data, n} of what the caller gave: `data` is what C takes, `n` the number of elements, `rows` the first
-- length. shape: lengths, false where any will do. `keep` holds what data points into: the view must outlive the call.
local function take(ctype, name, value, shape, whole)
    local array = value
    if type(value) == "table" then
        if type(value[1]) == "table" then
            local columns = shape[2] or #value[1]
            array = from_rows(ctype, name, value, columns, whole)
        else
            array = from_flat(ctype, name, value, whole)
        end
    elseif whole and ffi.istype(doubles, value) then
        array = make(integers, tonumber(value.n), value.rank, value.shape[0], value.shape[1], value.shape[2])
        for i = 0, tonumber(value.n) - 1 do
            array.data[i] = element(name, value.data[i], i + 1, true)
        end
    end
    if ffi.istype(ctype, array) then
        local n = tonumber(array.n)
        if not (has_shape(array, shape) or array.rank == 1 and flat_fits(n, shape)) then
            refuse("%s: expected shape %s, got %s", name, shape_text(shape), shape_text(array:sizes()))
        end
        local rows = array.rank == #shape and tonumber(array.shape[0]) or nil
        return { keep = array, data = array.data, n = n, rows = rows or n / (shape[2] or 1),
                 columns = array.rank == 2 and tonumber(array.shape[1]) or nil }
    end
    -- double[n]: its size is known, that of a pointer is not.
    local element_type = type(array) == "cdata" and tostring(ffi.typeof(array)):match "^ctype<(.-) %[[%d?]*%]>$"
    if element_type == (whole and "int" or "double") then
        local n = ffi.sizeof(array) / (whole and 4 or 8)
        if not flat_fits(n, shape) then
            refuse("%s: expected shape %s, got %d elements", name, shape_text(shape), n)
        end
        return { keep = array, data = array, n = n, rows = n / (shape[2] or 1) }
    end
    refuse("%s: expected numbers of shape %s (an array, a table or a C array of %s), got %s", name, shape_text(shape),
        whole and "int32_t" or "double", kind(value))
end

function M.numbers(name, value, ...)
    return take(doubles, name, value, { ... }, false)
end

function M.indices(name, value, ...)
    return take(integers, name, value, { ... }, true)
end

-- array(3, 2): zeros of that shape. array{1, 2} or array{{1, 2}, {3, 4}}: the table's numbers.
function M.array(first, ...)
    if type(first) == "table" then
        local shape = type(first[1]) == "table" and { false, #first[1] } or { false }
        return take(doubles, "array", first, shape, false).keep
    end
    local shape = { first, ... }
    if #shape < 1 or #shape > 3 then
        refuse("array: expected one to three lengths, got %d", #shape)
    end
    for axis, length in ipairs(shape) do
        if type(length) ~= "number" or length % 1 ~= 0 or length < 0 then
            refuse("array: length %d: expected a whole number >= 0, got %s", axis, tostring(length))
        end
    end
    return M.new(first, ...)
end

return M
