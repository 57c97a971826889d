-- SPDX-License-Identifier: MIT
-- From the root of the repository: luarocks --lua-version 5.1 make bindings/lua/diffaqua-0.1.0-1.rockspec
rockspec_format = "3.0"
package = "diffaqua"
version = "0.1.0-1"
source = { url = "git+file://." } -- `make` builds what lies here
description = {
    summary = "Co-design of soft underwater swimmers, with gradients",
    detailed = "LuaJIT over the C interface of libdiffaqua, which must be installed (or named by DIFFAQUA_LIBRARY).",
    license = "MIT",
}
dependencies = { "lua == 5.1" } -- LuaJIT: ffi and jit are built in
build = {
    type = "builtin",
    modules = {
        diffaqua = "bindings/lua/diffaqua/init.lua",
        ["diffaqua.arrays"] = "bindings/lua/diffaqua/arrays.lua",
        ["diffaqua.callbacks"] = "bindings/lua/diffaqua/callbacks.lua",
        ["diffaqua.controller"] = "bindings/lua/diffaqua/controller.lua",
        ["diffaqua.handle"] = "bindings/lua/diffaqua/handle.lua",
        ["diffaqua.library"] = "bindings/lua/diffaqua/library.lua",
        ["diffaqua.optimize"] = "bindings/lua/diffaqua/optimize.lua",
        ["diffaqua.shape_space"] = "bindings/lua/diffaqua/shape_space.lua",
        ["diffaqua.simulator"] = "bindings/lua/diffaqua/simulator.lua",
        ["diffaqua.structs"] = "bindings/lua/diffaqua/structs.lua",
        ["diffaqua.tape"] = "bindings/lua/diffaqua/tape.lua",
    },
    install = { lua = { ["diffaqua.declarations"] = "bindings/diffaqua.cdef" } },
}
