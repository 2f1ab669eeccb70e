--[[ references.lua: references become links with numbers; what nobody refers to is told.

  @fig:a               Figure 2.1
  [@fig:a; @tbl:b]     Figure 2.1 and Table 2.3
  [-@eq:a]             (2.4), the number alone                                                   ]]

local labels = require 'labels'
local problems = require 'problems'

local OURS = { sec = true, app = true, fig = true, tbl = true, eq = true, lst = true, thm = true, lem = true,
  def = true, prop = true, cor = true, rem = true, exm = true, exr = true }

local function is_ours(citation)
  return OURS[citation.id:match '^(%a+):' or '']
end

-- The word before the number: none twice in a row, plural where more of its kind follow
local function word(label, before, after, suppressed)
  if suppressed or not label.number then return nil end
  if before and before.name == label.name then return nil end
  return after and after.name == label.name and label.plural or label.name
end

local function text(label, name)
  local number = label.number or label.name
  if label.kind == 'eq' then number = '(' .. number .. ')' end
  return name and name .. '\u{a0}' .. number or number
end

local function separator(i, n)
  if i == 1 then return {} end
  if i < n then return { pandoc.Str ',', pandoc.Space() } end
  return { pandoc.Str(n > 2 and ',' or ''), pandoc.Space(), pandoc.Str 'and', pandoc.Space() }
end

local function reference(cite)
  local ours = cite.citations:filter(is_ours)
  if #ours == 0 then return nil end
  if #ours < #cite.citations then
    problems.add('a reference and a citation in one bracket', '@' .. ours[1].id)
    return nil
  end
  local out = pandoc.Inlines {}
  for i, citation in ipairs(cite.citations) do
    local label = labels.known[citation.id]
    if not label then
      problems.add('reference to the unknown label @' .. citation.id, '@' .. citation.id)
      return nil
    end
    labels.used[citation.id] = true
    local before, after = cite.citations[i - 1], cite.citations[i + 1]
    local name = word(label, before and labels.known[before.id], after and labels.known[after.id],
      citation.mode == 'SuppressAuthor')
    out:extend(separator(i, #cite.citations))
    out:insert(pandoc.Link({ pandoc.Str(text(label, name)) }, '#' .. citation.id, '', { '', { 'xref' } }))
  end
  return out
end

return function(doc)
  doc.blocks = doc.blocks:walk { Cite = reference }
  local ids = {}
  for id, label in pairs(labels.known) do
    if (label.kind == 'fig' or label.kind == 'tbl') and not labels.used[id] then ids[#ids + 1] = id end
  end
  table.sort(ids)
  for _, id in ipairs(ids) do
    problems.add('the text never refers to @' .. id, '#' .. id)
  end
  return doc
end
