-- SPDX-License-Identifier: MIT
-- Two fish seen from above and the sine that bends a mix of them, optimised for the distance travelled:
--   luajit examples/swim.lua [iterations [steps]]
local dq = require "diffaqua"

local iterations, steps = tonumber(arg[1] or 20), tonumber(arg[2] or 30)

local function outline(width)
    local n, corners = 40, {}
    for i = 1, n do
        local s = (i - 0.5) / n
        local half = 0.02 + width * math.sin(math.pi * s ^ 0.7) + math.max(0, 0.25 * (s - 0.75))
        corners[i], corners[2 * n + 1 - i] = { 0.5 - s, half }, { 0.5 - s, -half }
    end
    return corners
end

local space = dq.shape_space { dims = 2, cells_x = 32, cells_y = 12, sigma = 0.7 }
space:add_polygon(outline(0.05), "slim")
space:add_polygon(outline(0.12), "stout")
local simulator = dq.simulator(space:build(), { young_modulus = 5e5, muscle_stiffness = 1e6 })
local sine, tape = dq.sinusoid(1), dq.tape(simulator)
local travel = { kind = dq.OBJECTIVE_TRAVEL }

-- x: two weights on the simplex, then amplitude in [0, 1], frequency (rad/s) and phase of the sine.
local x, rates = dq.array { 0.5, 0.5, 0.6, 15, 0 }, { 0.05, 0.05, 0.05, 0.5, 0.1 }
local first, second = dq.array(5), dq.array(5)
local gradient = dq.array(5)

for iteration = 1, iterations do
    tape:clear()
    simulator:set_weights(x:slice(1, 2))
    sine:set_parameters(x:slice(3))
    simulator:rollout(sine, steps, tape)
    local loss = tape:objective(travel)
    print(("%3d: travels %7.2f mm with %2.0f %% slim, amplitude %.2f, %.1f rad/s"):format(iteration, -1e3 * loss,
        100 * x[1], x[3], x[4]))

    local by_weights, by_control = tape:gradient(travel, dq.WRT_WEIGHTS, dq.WRT_CONTROL)
    for i = 1, 5 do
        gradient[i] = i <= 2 and by_weights[i] or by_control[i - 2]
    end
    dq.adam_step(x, gradient, rates, first, second, iteration)
    local weights = dq.project_simplex(x:slice(1, 2))
    x[1], x[2], x[3] = weights[1], weights[2], math.min(math.max(x[3], 0), 1)
end
