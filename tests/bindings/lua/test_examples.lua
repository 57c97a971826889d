-- SPDX-License-Identifier: MIT
-- The module as it is installed: the lines of its README, and the example, which must gain.
local support = require "support"
local test = support.test
local root, build = os.getenv "DQA_ROOT", os.getenv "DQA_BUILD"

local here = io.popen("pwd"):read()
support.installed = here .. "/prefix/share/lua/5.1"

local function read(path)
    local file = assert(io.open(path, "rb"))
    local text = file:read "*a"
    file:close()
    return text
end

-- Runs a command of the shell with the installed module alone; returns what it printed.
local function shell(command)
    local status = os.execute(("export LUA_PATH='%s/?.lua;%s/?/init.lua'; exec >'%s/out' 2>&1; %s"):format(
        support.installed, support.installed, here, command))
    local text = read(here .. "/out")
    assert(status == 0, command .. "\n" .. text)
    return text
end

test("install", function()
    shell(("'%s' --install '%s' --component lua --prefix prefix"):format(os.getenv "CMAKE", build))
    shell "test -f prefix/share/lua/5.1/diffaqua/diffaqua.cdef -a -f prefix/share/lua/5.1/diffaqua/init.lua"
    assert(shell "find prefix -type f | wc -l":match "%d+" == "12", "nothing else is installed")
end)

test("the lines of the README", function()
    local lines = assert(read(root .. "/bindings/lua/README.md"):match "```lua\n(.-)```")
    local file = assert(io.open("readme.lua", "w"))
    file:write(lines)
    file:close()
    local found = {}
    for number in shell(("cd '%s' && luajit '%s/readme.lua'"):format(root, here)):gmatch "-?%d[%d.e-]*" do
        found[#found + 1] = tonumber(number)
    end
    support.equal(#found, 1 + 2 + 3 + 4, "numbers that it prints, lengths of arrays included")
    support.close(found[5], -found[6], 1e-12, "the gradient by the weights is mean-free")
    assert(found[1] ~= 0)
end)

test("the example gains", function()
    local printed = shell(("luajit '%s/bindings/lua/examples/swim.lua' 6 20"):format(root))
    local travels = {}
    for way in printed:gmatch "travels +([-%d.]+) mm" do
        travels[#travels + 1] = tonumber(way)
    end
    support.equal(#travels, 6)
    assert(travels[6] > 1.5 * travels[1], printed)
end)

support.run()
