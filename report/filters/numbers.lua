--[[ numbers.lua: one walk in reading order that numbers sections, equations, figures, tables,
listings and statements.

  # Title {#sec:a}       # Title {#app:a .appendix}       # Title {.unnumbered}
  # Title {#sec:a .part} has chapters below it, whose numbers run on
  $$ .. $$ {#eq:a}       an equation without a label has no number
  ```{.python #lst:a caption="..."}                                                              ]]

local captions = require 'captions'
local labels = require 'labels'
local problems = require 'problems'
local statements = require 'statements'

-- headings --------------------------------------------------------------------------------------
local level, in_appendix, unnumbered_level = {}, false, nil
local parts, ROMAN = 0, { 'I', 'II', 'III', 'IV' }

local function section_number(depth)
  level[depth] = (level[depth] or 0) + 1
  for below = depth + 1, 6 do level[below] = nil end
  local parts = {}
  for k = 1, depth do parts[k] = tostring(level[k] or 0) end
  if in_appendix then parts[1] = string.char(string.byte 'A' + level[1] - 1) end
  return table.concat(parts, '.')
end

local function part(h)
  parts, unnumbered_level = parts + 1, nil
  labels.begin_chapter(nil)
  labels.define(h.identifier, 'Part', ROMAN[parts], 'Part')
  h.content:insert(1, pandoc.Span({ pandoc.Str('Part\u{a0}' .. ROMAN[parts]) }, { '', { 'secno' } }))
  h.content:insert(2, pandoc.Str '\u{2002}')
  return h
end

local function heading(h)
  if h.classes:includes 'part' then return part(h) end
  if h.classes:includes 'appendix' and not in_appendix then in_appendix, level = true, {} end
  if unnumbered_level and h.level <= unnumbered_level then unnumbered_level = nil end
  if unnumbered_level or h.classes:includes 'unnumbered' then
    -- what lies below an unnumbered heading would otherwise count on as 0.1
    unnumbered_level = unnumbered_level or h.level
    if not h.classes:includes 'unnumbered' then h.classes:insert 'unnumbered' end
    if h.level == 1 then labels.begin_chapter(nil) end
    labels.define(h.identifier, 'sec', nil, '“' .. pandoc.utils.stringify(h.content) .. '”')
    return h
  end
  local number = section_number(h.level)
  if h.level == 1 then labels.begin_chapter(number) end
  local name = in_appendix and (h.level == 1 and 'Appendix' or 'Section') or h.level == 1 and 'Chapter' or 'Section'
  labels.define(h.identifier, name, number, name, name == 'Appendix' and 'Appendices' or nil)
  h.content:insert(1, pandoc.Span({ pandoc.Str(number) }, { '', { 'secno' } }))
  h.content:insert(2, pandoc.Str '\u{2002}')
  return h
end

-- equations -------------------------------------------------------------------------------------
-- A display with its label becomes a span that holds formula, label and number.
local function equations(inlines)
  local out, i = pandoc.Inlines {}, 1
  while inlines[i] do
    local x, rest = inlines[i], nil
    if x.t == 'Math' and x.mathtype == 'DisplayMath' then
      local j = i + 1
      while inlines[j] and (inlines[j].t == 'Space' or inlines[j].t == 'SoftBreak') do j = j + 1 end
      local id, after = nil, nil
      if inlines[j] and inlines[j].t == 'Str' then id, after = inlines[j].text:match '^{#(eq:[^}]+)}(.*)$' end
      if id then
        local number = labels.next 'eq'
        labels.define(id, 'eq', number, 'Equation')
        x = pandoc.Span({ x }, pandoc.Attr(id, { 'equation' }, { number = number }))
        rest, i = after, j
      end
    end
    out:insert(x)
    if rest and rest ~= '' then out:insert(pandoc.Str(rest)) end
    i = i + 1
  end
  return out
end

-- The text of a whole paragraph tells sooner than its inlines do that it has no equation.
local function paragraph(block)
  if not tostring(block):find 'DisplayMath' then return nil end
  return block:walk { traverse = 'topdown', Inlines = equations }
end

local function raw_tex(x)
  if x.format:match 'tex' then
    problems.add('raw TeX would vanish; write $$ ... $$ {#eq:name}: ' .. x.text:sub(1, 50), x.text:match '[^\n]+')
  end
end

-- listings --------------------------------------------------------------------------------------
local function listing(code)
  if not code.attributes.caption then return nil end
  local number, id = labels.next 'lst', code.identifier
  labels.define(id, 'lst', number, 'Listing')
  local caption = captions.head('Listing', number)
  caption:extend(pandoc.utils.blocks_to_inlines(pandoc.read(code.attributes.caption, 'markdown').blocks))
  code.identifier, code.attributes.caption = '', nil
  local box = pandoc.Div({ pandoc.Div({ pandoc.Plain(caption) }, { '', { 'caption' } }), code }, { id, { 'listing' } })
  return box, false
end

return function(doc)
  captions.prepare(doc)
  doc.blocks = doc.blocks:walk {
    traverse = 'topdown',
    Header = heading, Para = paragraph, Plain = paragraph, RawInline = raw_tex, RawBlock = raw_tex,
    CodeBlock = listing, Figure = captions.figure, Table = captions.table, Div = statements,
  }
  return doc
end
