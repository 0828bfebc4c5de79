-- Debugs a rack with nvim-dap: a breakpoint, steps forwards and backwards, a value; prints where it stood.
local dap = require("dap")
local stops = 0

dap.adapters.scanrack = { type = "executable", command = vim.env.DEBUG_PYTHON, args = { "-m", "scanrack", "debug" } }
dap.listeners.after.event_stopped.count = function() stops = stops + 1 end

--- Waits for a stop, and prints its frame.
local function stand(count)
  local frame
  assert(vim.wait(60000, function()
    frame = dap.session() and dap.session().current_frame
    return stops >= count and frame ~= nil
  end, 20), "no stop " .. count)
  vim.wait(500, function() return dap.session().current_frame ~= frame end, 20)
  frame = dap.session().current_frame
  io.stdout:write(frame.name .. "|" .. frame.line .. "\n")
end

vim.cmd("edit " .. vim.env.DEBUG_FILE)
vim.api.nvim_win_set_cursor(0, { tonumber(vim.env.DEBUG_LINE), 0 })
dap.set_breakpoint()
dap.run({ type = "scanrack", request = "launch", name = "rack", program = vim.env.DEBUG_RACK, speed = "max" })
stand(1)
for count, move in ipairs({ dap.continue, dap.step_over, dap.step_back, dap.continue, dap.reverse_continue }) do
  move()
  stand(count + 1)
end
local value
dap.session():request("evaluate", { expression = "Feeding", context = "watch" }, function(_, answer) value = answer.result end)
assert(vim.wait(20000, function() return value end), "no value")
io.stdout:write(value .. "\n")
dap.terminate()
vim.wait(10000, function() return dap.session() == nil end)
vim.cmd("qa!")
