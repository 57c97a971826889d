-- SPDX-License-Identifier: MIT
-- The test vectors of tests/bindings/vectors, to the last bit of what the C program wrote in this run.
local dq = require "diffaqua"
local support = require "support"
local test, same, equal = support.test, support.same, support.equal

local vectors = support.read_json(os.getenv "DQA_VECTORS")
local spaces = {}

local function without(options, name)
    local out = {}
    for key, value in pairs(options) do
        out[key] = key ~= name and value or nil
    end
    return out
end

test("helpers", function()
    local entry = vectors.project_simplex
    same(dq.project_simplex(entry.x), entry.result, "project_simplex")
    entry = vectors.adam_step
    local x, first, second = dq.array(entry.x), dq.array(entry.first_moment), dq.array(entry.second_moment)
    dq.adam_step(x, entry.gradient, entry.rates, first, second, entry.iteration)
    same(x, entry.x_after, "x_after")
    same(first, entry.first_moment_after, "first_moment_after")
    same(second, entry.second_moment_after, "second_moment_after")
end)

test("spaces", function()
    for index, entry in ipairs(vectors.spaces) do
        local space = dq.shape_space(entry.options)
        for _, base in ipairs(entry.polygons or {}) do
            space:add_polygon(base.corners, base.name)
        end
        for _, base in ipairs(entry.meshes or {}) do
            space:add_mesh(base.vertices, base.triangles, base.name)
        end
        spaces[index] = space:build()
        same(space:density(entry.weights), entry.density, "density")
        same(space:pullback(entry.weights, entry.density_bar), entry.weights_bar, "weights_bar")
    end
    equal(#spaces, 2, "spaces")
end)

local function controller_of(described, simulator)
    if described.kind == "sinusoid" then
        local sine = dq.sinusoid(1, simulator.time_step)
        sine:set_parameters(described.theta)
        return sine
    end
    equal(described.options.n_hidden, 1, "n_hidden")
    local options = without(described.options, "n_hidden")
    options.hidden = { options.hidden }
    local perceptron = dq.perceptron(options)
    same(perceptron:parameters(), described.theta, "theta")
    return perceptron
end

test("rollouts", function()
    for _, entry in ipairs(vectors.rollouts) do
        local simulator = dq.simulator(spaces[entry.space + 1], entry.options)
        simulator:set_weights(entry.weights)
        local controller, tape = controller_of(entry.controller, simulator), dq.tape(simulator)
        simulator:rollout(controller, entry.n_steps, tape)
        local loss, per_term = tape:objective(entry.terms)
        local q, v = simulator:state()
        same(loss, entry.loss, "loss")
        same(per_term, entry.per_term, "per_term")
        same(q, entry.q, "q")
        same(v, entry.v, "v")
        same(simulator:sensors(), entry.sensors, "sensors")
        same(simulator:forces(), entry.forces, "forces")
        for _, name in ipairs { "weights", "control", "actuation", "initial_position", "material" } do
            local gradient = tape:gradient(entry.terms, dq["WRT_" .. name:upper()])
            same(gradient, entry["gradient_" .. name], "gradient_" .. name)
        end
    end
    equal(#vectors.rollouts, 3, "rollouts")
end)

test("optimisation", function()
    local entry = vectors.optimisation
    local simulator = dq.simulator(spaces[entry.space + 1], entry.options)
    local sine, tape, travel = dq.sinusoid(1, simulator.time_step), dq.tape(simulator), { kind = dq.OBJECTIVE_TRAVEL }
    local n, x, losses, points = entry.n_bases, dq.array(entry.x), {}, {}
    local first, second = dq.array(#x), dq.array(#x)
    for iteration = 1, entry.iterations do
        tape:clear()
        simulator:set_weights(x:slice(1, n))
        sine:set_parameters(x:slice(n + 1))
        simulator:rollout(sine, entry.n_steps, tape)
        losses[iteration] = tape:objective(travel)
        local by_weights, by_control = tape:gradient(travel, dq.WRT_WEIGHTS, dq.WRT_CONTROL)
        dq.adam_step(x, support.flat({ by_weights, by_control }, {}), entry.rates, first, second, iteration)
        local share = dq.project_simplex(x:slice(1, n))
        for i = 1, n do
            x[i] = share[i]
        end
        x[n + 1] = math.min(math.max(x[n + 1], 0), 1)
        points[iteration] = x:copy()
    end
    same(losses, entry.losses, "losses")
    same(points, entry.x_after, "x_after")
    assert(losses[#losses] < 2 * losses[1], "the optimisation gains")
end)

test("errors", function()
    local simulator = dq.simulator(spaces[1], vectors.optimisation.options)
    for _, entry in ipairs(vectors.errors) do
        if entry.call == "step" then
            simulator:set_weights { 0.5, 0.5 }
        end
        local ok, problem = pcall(simulator[entry.call], simulator, entry.argument)
        equal(ok, false, entry.call)
        equal(problem.status, entry.status, "status")
        equal(problem.name, entry.name, "name")
        equal(problem.message, entry.message, "message")
    end
    equal(#vectors.errors, 2, "errors")
end)

support.run()
