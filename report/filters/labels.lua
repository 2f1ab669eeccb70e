--[[ labels.lua: what can be referred to, and the counters.

Numbers start again in every chapter and carry its number: Figure 2.1, (3.4), Exercise A.1.      ]]

local problems = require 'problems'

local labels = { known = {}, used = {} }

local counts = {}
local chapter = nil

function labels.begin_chapter(number)
  chapter, counts = number, {}
end

function labels.next(kind)
  counts[kind] = (counts[kind] or 0) + 1
  return (chapter and chapter .. '.' or '') .. counts[kind]
end

-- kind: sec, fig, tbl, eq, lst or a statement; name: what a reference calls it
function labels.define(id, kind, number, name, plural)
  if id == '' then return end
  if labels.known[id] then problems.add('the label ' .. id .. ' is given twice', id) end
  labels.known[id] = { kind = kind, number = number, name = name, plural = plural or name .. 's' }
end

return labels
