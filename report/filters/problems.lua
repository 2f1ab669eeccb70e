--[[ problems.lua: what is wrong with the text, collected and told together.

A problem may name a token of the source, such as a label; the build then looks up where it stands. ]]

local problems = {}
local found = {}

function problems.add(message, token)
  found[#found + 1] = 'PROBLEM\t' .. message:gsub('%s+', ' ') .. '\t' .. (token or '')
end

function problems.stop_if_any()
  if #found == 0 then return end
  io.stderr:write(table.concat(found, '\n'), '\n')
  os.exit(83)
end

return problems
