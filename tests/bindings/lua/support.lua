-- SPDX-License-Identifier: MIT
-- What the tests of the Lua module share: a runner, comparisons, a reader of JSON, and a plane scene so small that a
-- rollout takes milliseconds.
local M = {}

-- ------------------------------------------------------------------ runner
local tests = {}

function M.test(name, run)
    tests[#tests + 1] = { name = name, run = run }
end

function M.run()
    local failures = 0
    for _, test in ipairs(tests) do
        local ok, problem = xpcall(test.run, function(value)
            return debug.traceback(tostring(value), 2)
        end)
        print(("%s %s"):format(ok and "ok    " or "FAILED", test.name))
        if not ok then
            failures = failures + 1
            print(problem)
        end
    end
    print(("%d tests, %d failed"):format(#tests, failures))
    os.exit(failures == 0 and #tests > 0 and 0 or 1, true)
end

-- ------------------------------------------------------------------ comparisons
function M.equal(found, expected, what)
    if found ~= expected then
        error(("%s: found %s, expected %s"):format(what or "value", tostring(found), tostring(expected)), 2)
    end
end

-- The same numbers to the last bit; either may be a number, a table (nested or not) or an array.
local function flat(value, out)
    if type(value) == "cdata" then
        for i = 1, #value do
            out[#out + 1] = value[i]
        end
    elseif type(value) == "table" then
        for i = 1, #value do
            flat(value[i], out)
        end
    else
        out[#out + 1] = value
    end
    return out
end
M.flat = flat

function M.same(found, expected, what)
    local left, right = flat(found, {}), flat(expected, {})
    M.equal(#left, #right, what .. ": length")
    for i = 1, #right do
        if left[i] ~= right[i] then
            error(("%s[%d]: found %.17g, expected %.17g"):format(what, i, left[i], right[i]), 2)
        end
    end
end

function M.close(found, expected, tolerance, what)
    if not (math.abs(found - expected) <= tolerance) then
        error(("%s: found %.17g, expected %.17g"):format(what or "value", found, expected), 2)
    end
end

-- run() must throw an error of the module with that name whose message has the pattern; returns it.
function M.throws(name, pattern, run)
    local ok, problem = pcall(run)
    if ok then
        error(("nothing was thrown, expected %s: %s"):format(name, pattern), 2)
    end
    if type(problem) ~= "table" or problem.name ~= name or not problem.message:find(pattern) then
        error(("thrown: %s; expected %s: %s"):format(tostring(problem), name, pattern), 2)
    end
    return problem
end

-- ------------------------------------------------------------------ JSON
-- Reads what write_vectors writes: objects, lists, numbers, strings with \" and \\.
function M.read_json(path)
    local file = assert(io.open(path, "rb"))
    local text = file:read "*a"
    file:close()
    local at = 1
    local function expect(pattern)
        local first, last, found = text:find("^%s*" .. pattern, at)
        if first then
            at = last + 1
            return found or true
        end
    end
    local value
    local function list(close, item)
        local out = {}
        if expect(close) then
            return out
        end
        repeat
            item(out)
        until not expect ","
        assert(expect(close), "JSON: a list does not end at byte " .. at)
        return out
    end
    local function string()
        local found = expect '"((.-))"'
        while found and found:match "\\*$" and #found:match "\\*$" % 2 == 1 do -- the quote was escaped
            local last = text:find('"', at, true)
            found = found .. '"' .. text:sub(at, last - 1)
            at = last + 1
        end
        return found and (found:gsub("\\(.)", "%1"))
    end
    function value()
        if expect "{" then
            return list("}", function(out)
                local key = assert(string(), "JSON: a name is missing")
                assert(expect ":", "JSON: a colon is missing")
                out[key] = value()
            end)
        elseif expect "%[" then
            return list("%]", function(out)
                out[#out + 1] = value()
            end)
        end
        local number = expect "(-?%d[%d.eE+-]*)"
        return number and tonumber(number) or assert(string(), "JSON: no value at byte " .. at)
    end
    return value()
end

-- ------------------------------------------------------------------ scene
local function outline(width)
    local n, corners = 32, {}
    for i = 1, n do
        local s = (i - 0.5) / n
        local half = 0.02 + width * math.sin(math.pi * s ^ 0.75) + math.max(0, 0.25 * (s - 0.75))
        corners[i], corners[2 * n + 1 - i] = { 0.5 - s, half }, { 0.5 - s, -half }
    end
    return corners
end

function M.space(dq, options)
    local settings = { dims = 2, cells_x = 20, cells_y = 8, sigma = 0.75 }
    for name, value in pairs(options or {}) do
        settings[name] = value
    end
    local space = dq.shape_space(settings)
    space:add_polygon(outline(0.0625), "slim")
    space:add_polygon(outline(0.125), "stout")
    return space:build()
end

-- Tight solves: finite differences see their noise.
M.SETTINGS = { young_modulus = 2e5, muscle_stiffness = 1e6, tolerance = 1e-12, adjoint_tolerance = 1e-12 }

function M.swimmer(dq, options)
    local settings = {}
    for name, value in pairs(M.SETTINGS) do
        settings[name] = value
    end
    for name, value in pairs(options or {}) do
        settings[name] = value
    end
    local simulator = dq.simulator(M.space(dq), settings)
    simulator:set_weights { 0.5, 0.5 }
    return simulator
end

return M
