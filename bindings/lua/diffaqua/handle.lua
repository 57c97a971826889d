-- SPDX-License-Identifier: MIT
-- Objects of the library as Lua objects: closed by close() or when nothing refers to them any more, in any order.
jit.off(true, true)

local ffi = require "ffi"
local library = require "diffaqua.library"
local lib, check, refuse = library.lib, library.check, library.refuse

local M = {}

local Handle = {}

-- A class of objects of one C type; `what` is for messages. Closing them calls the function `free` of the library.
function M.class(what, type_name, free)
    local class = setmetatable({}, { __index = Handle })
    class.__index, class.what, class.type_name, class.free = class, what, type_name, free
    class.__tostring = function(self)
        return ("diffaqua %s%s"):format(self.what, self:is_closed() and " (closed)" or "")
    end
    return class
end

-- A new object of the class from the last output of create(..., out).
function M.create(class, users, create, ...)
    local out = ffi.new(class.type_name .. " *[1]")
    local arguments = { n = select("#", ...) + 1, ... }
    arguments[arguments.n] = out
    M.call(users, create, unpack(arguments, 1, arguments.n))
    return setmetatable({ pointer = ffi.gc(out[0], lib[class.free]), users = 0 }, class)
end

-- The pointer of an object of that class which is not closed.
function M.pointer(name, object, class)
    if getmetatable(object) ~= class then
        refuse("%s: expected a %s, got %s", name, class.what, library.kind(object))
    end
    return object:get()
end

-- Calls a function of the library while `users` (objects) are in use, and throws what went wrong.
function M.call(users, name, ...)
    for i = 1, #users do
        users[i].users = users[i].users + 1
    end
    local ok, status = pcall(lib[name], ...)
    for i = 1, #users do
        users[i].users = users[i].users - 1
    end
    if not ok then
        error(status, 0) -- an argument of a type that C does not take: a defect of this module
    end
    check(status)
end

function Handle:get()
    if self.pointer == nil then
        library.fail(library.constants.ERROR_STATE, ("this %s is closed"):format(self.what))
    end
    return self.pointer
end

-- Calls name(pointer, ...) of the library.
function Handle:call(name, ...)
    M.call({ self }, name, self:get(), ...)
end

-- Refuses what changes an object while a call that uses it waits for a callback: what that call goes on to compute
-- would be neither of the two.
function M.must_be_free(object)
    if object.users > 0 then
        library.fail(library.constants.ERROR_STATE,
            ("this %s cannot be changed while a call uses it"):format(object.what))
    end
end

-- The same for what changes the object.
function Handle:change(name, ...)
    local pointer = self:get()
    M.must_be_free(self)
    M.call({ self }, name, pointer, ...)
end

-- Gives its memory back; further use throws. Again: nothing happens. What was made from it stays.
function Handle:close()
    if self.pointer == nil then
        return
    end
    if self.users > 0 then
        library.fail(library.constants.ERROR_STATE, ("this %s cannot be closed while a call uses it"):format(self.what))
    end
    local pointer = ffi.gc(self.pointer, nil)
    self.pointer = nil
    lib[self.free](pointer)
end

function Handle:is_closed()
    return self.pointer == nil
end

return M
