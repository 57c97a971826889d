-- SPDX-License-Identifier: MIT
-- The space of shapes between base meshes, outlines or images, and tokens that stop calls.
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local arrays = require "diffaqua.arrays"
local callbacks = require "diffaqua.callbacks"
local handle = require "diffaqua.handle"
local structs = require "diffaqua.structs"

local M = {}

-- ------------------------------------------------------------------ cancel token
local CancelToken = handle.class("cancel token", "dqa_cancel_token", "dqa_cancel_token_free")
M.CancelToken = CancelToken

-- Stops the calls of the objects that were made with it as `cancel`; they stay usable.
function M.cancel_token()
    return handle.create(CancelToken, {}, "dqa_cancel_token_create")
end

function CancelToken:set()
    self:call "dqa_cancel_token_set"
end

function CancelToken:reset()
    self:call "dqa_cancel_token_reset"
end

-- ------------------------------------------------------------------ space
local Space = handle.class("shape space", "dqa_shape_space", "dqa_shape_space_free")
M.Space = Space

-- Splits `cancel`, which is an object, from the numbers of an options table.
function M.split_cancel(options)
    if type(options) ~= "table" or options.cancel == nil then
        return options, nil
    end
    local numbers = {}
    for name, value in pairs(options) do
        if name ~= "cancel" then
            numbers[name] = value
        end
    end
    return numbers, handle.pointer("cancel", options.cancel, CancelToken)
end

-- An open space; options by the names of dqa_shape_space_options, such as {dims = 2, cells_x = 40}.
function M.shape_space(options)
    local numbers, token = M.split_cancel(options)
    local filled = structs.options("dqa_shape_space_options", "dqa_shape_space_options_init", numbers)
    filled[0].cancel = token
    return handle.create(Space, {}, "dqa_shape_space_create", filled)
end

-- The built space of a file that save wrote.
function M.load_shape_space(path)
    return handle.create(Space, {}, "dqa_shape_space_load", library.text("path", path))
end

-- Writes a built space, so that it is prepared only once.
function Space:save(path)
    self:call("dqa_shape_space_save", library.text("path", path))
end

local function add(self, name, ...)
    local base = ffi.new "int32_t[1]"
    local arguments = { n = select("#", ...) + 1, ... }
    arguments[arguments.n] = base
    self:change(name, unpack(arguments, 1, arguments.n))
    return base[0]
end

-- Each adds a base and returns its index, counted from 0.

-- A closed mesh: vertices [n][3] in any unit, triangles [m][3] of indices counted from 0.
function Space:add_mesh(vertices, triangles, name)
    local points = arrays.numbers("vertices", vertices, false, 3)
    local corners = arrays.indices("triangles", triangles, false, 3)
    return add(self, "dqa_shape_space_add_mesh", library.text("name", name or ""), points.data, points.rows,
        corners.data, corners.rows)
end

-- An STL, OBJ or PLY file; the base is named after it.
function Space:add_mesh_file(path)
    return add(self, "dqa_shape_space_add_mesh_file", library.text("path", path))
end

-- Covered fractions in [0, 1], shape [cells_x][cells_y][cells_z].
function Space:add_density(cells, name)
    local values = arrays.numbers("cells", cells, self:shape())
    return add(self, "dqa_shape_space_add_density", library.text("name", name or ""), values.data, values.n)
end

-- A closed simple polygon [n][2], for two dimensions.
function Space:add_polygon(corners, name)
    local points = arrays.numbers("corners", corners, false, 2)
    return add(self, "dqa_shape_space_add_polygon", library.text("name", name or ""), points.data, points.rows)
end

-- Grey values in [0, 1] (1: body) [rows][columns], the first row on top, for two dimensions.
function Space:add_image(pixels, name)
    local values = arrays.numbers("pixels", pixels, false, false)
    return add(self, "dqa_shape_space_add_image", library.text("name", name or ""), values.data, values.rows,
        values.columns)
end

-- Gives a base an actuator, options by the names of dqa_actuator_options. Needs the space's option cell_size.
function Space:add_actuator(base, options)
    local filled = structs.options("dqa_actuator_options", "dqa_actuator_options_init", options)
    self:change("dqa_shape_space_add_actuator", library.index("base", base), filled)
end

-- The actuator of a base; after build also an automatic one.
function Space:actuator(base, category, side)
    local filled = structs.options("dqa_actuator_options", "dqa_actuator_options_init")
    self:call("dqa_shape_space_get_actuator", library.index("base", base), library.index("category", category),
        library.index("side", side or 0), filled)
    return structs.record("dqa_actuator_options", filled)
end

-- Freezes the space and returns it. progress(done, total): a true result, or an error, stops the call.
function Space:build(progress)
    callbacks.with_progress(progress, function(callback, data)
        self:change("dqa_shape_space_build", callback, data)
    end)
    return self
end

-- Sizes, as dqa_shape_space_info.
function Space:info()
    local filled, size = structs.room "dqa_shape_space_info"
    self:call("dqa_shape_space_get_info", filled, size)
    return structs.record("dqa_shape_space_info", filled)
end

-- cells_x, cells_y, cells_z; cells_z is 1 in two dimensions.
function Space:shape()
    local info = self:info()
    return info.cells_x, info.cells_y, info.cells_z
end

-- Names of the bases, in order.
function Space:names()
    local names, pointer = {}, self:get()
    for base = 0, self:info().n_bases - 1 do
        names[base + 1] = ffi.string(library.lib.dqa_shape_space_base_name(pointer, base))
    end
    return names
end

-- What an actuation signal, counted from 0, drives: dqa_signal_info.
function Space:signal(signal)
    local filled, size = structs.room "dqa_signal_info"
    self:call("dqa_shape_space_signal", library.index("signal", signal), filled, size)
    return structs.record("dqa_signal_info", filled)
end

-- Covered fractions of a base [cells_x][cells_y][cells_z]. Here and below an array `out` is written to.
function Space:base(base, out)
    local cells = arrays.output("out", out, self:shape())
    self:call("dqa_shape_space_get_base", library.index("base", base), cells.data, cells.n)
    return cells
end

-- Density of the barycentre over its peak [cells_x][cells_y][cells_z]; weights [n_bases] on the simplex.
function Space:density(weights, out)
    local share = arrays.numbers("weights", weights, false)
    local cells = arrays.output("out", out, self:shape())
    self:call("dqa_shape_space_density", share.data, share.n, cells.data, cells.n)
    return cells
end

-- Gradient by the weights [n_bases], mean-free, of a loss whose gradient by the density is density_bar.
function Space:pullback(weights, density_bar)
    local share = arrays.numbers("weights", weights, false)
    local bar = arrays.numbers("density_bar", density_bar, self:shape())
    local result = arrays.new(share.n)
    self:call("dqa_shape_space_pullback", share.data, share.n, bar.data, bar.n, result.data)
    return result
end

return M
