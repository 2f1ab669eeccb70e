--[[ problems.lua: what is wrong with the text, collected and told together.

A problem may name a token of the source, such as a label; the build then looks up where it stands. ]]

local problems = {}
local found = {}

function problems.add(message, token)
  found[#found + 1] = 'PROBLEM\t' .. message:gsub('%s+', ' ') .. '\t' .. (token or '')
end

-- The document carries what is wrong, if anything, from the passes of report.lua to those of output.lua.
function problems.hand_on(doc)
  if #found == 0 then return nil end
  doc.meta.problems = pandoc.List.map(found, function(line) return pandoc.MetaString(line) end)
  return doc
end

function problems.take_over(doc)
  found = pandoc.List.map(doc.meta.problems or {}, tostring)
  doc.meta.problems = nil
  return doc
end

function problems.stop_if_any()
  if #found == 0 then return end
  io.stderr:write(table.concat(found, '\n'), '\n')
  os.exit(83)
end

return problems
