-- SPDX-License-Identifier: MIT
-- Stateless helpers for optimisers, and a search without gradients (CMA-ES).
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local arrays = require "diffaqua.arrays"
local handle = require "diffaqua.handle"
local structs = require "diffaqua.structs"

local M = {}

-- One step of Adam (Kingma & Ba 2015), all [n]; the arrays x and moments are updated in place; iterations count from 1.
function M.adam_step(x, gradient, rates, first_moment, second_moment, iteration)
    local n = arrays.length("x", x)
    arrays.output("first_moment", first_moment or false, n)
    arrays.output("second_moment", second_moment or false, n)
    local slope, rate = arrays.numbers("gradient", gradient, n), arrays.numbers("rates", rates, n)
    library.check(library.lib.dqa_adam_step(x.data, slope.data, rate.data, first_moment.data, second_moment.data, n,
        library.whole("iteration", iteration)))
end

-- The point of the simplex (>= 0, sum 1) that is nearest to x [n], as a new array.
function M.project_simplex(x)
    local given = arrays.numbers("x", x, false)
    local point = arrays.new(given.n)
    ffi.copy(point.data, given.data, 8 * given.n)
    library.check(library.lib.dqa_project_simplex(point.data, point.n))
    return point
end

-- ------------------------------------------------------------------ search
local Search = handle.class("search", "dqa_cma_es", "dqa_cma_es_free")

-- CMA-ES from mean [n] in units of scales [n] (nil: 1); options by the names of dqa_cma_es_options. Minimises a
-- function from its values alone: ask for candidates, tell their values, and so on.
function M.cma_es(mean, scales, options)
    local start = arrays.numbers("mean", mean, false)
    local units = scales ~= nil and arrays.numbers("scales", scales, start.n) or {}
    local filled = structs.options("dqa_cma_es_options", "dqa_cma_es_options_init", options)
    return handle.create(Search, {}, "dqa_cma_es_create", filled, start.data, units.data, start.n)
end

-- The search of a file that save wrote.
function M.load_cma_es(path)
    return handle.create(Search, {}, "dqa_cma_es_load", library.text("path", path))
end

-- Writes the state, which goes on with the same bits.
function Search:save(path)
    self:call("dqa_cma_es_save", library.text("path", path))
end

-- Sizes, generation, and how wide the search still is: dqa_cma_es_info.
function Search:info()
    local filled, size = structs.room "dqa_cma_es_info"
    self:call("dqa_cma_es_get_info", filled, size)
    return structs.record("dqa_cma_es_info", filled)
end

-- Candidates [population][n] of this generation.
function Search:ask(out)
    local info = self:info()
    local candidates = arrays.output("out", out, info.population, info.n)
    self:change("dqa_cma_es_ask", candidates.data, candidates.n)
    return candidates
end

-- Values [population] of the candidates in their order, math.huge for what could not be evaluated.
function Search:tell(values)
    local found = arrays.numbers("values", values, false)
    self:change("dqa_cma_es_tell", found.data, found.n)
end

-- The candidate [n] of the lowest value so far, and that value.
function Search:best()
    local x, value = arrays.new(self:info().n), ffi.new "double[1]"
    self:call("dqa_cma_es_best", x.data, x.n, value)
    return x, value[0]
end

-- Centre of the distribution [n]: often better than any candidate.
function Search:mean()
    local x = arrays.new(self:info().n)
    self:call("dqa_cma_es_mean", x.data, x.n)
    return x
end

return M
