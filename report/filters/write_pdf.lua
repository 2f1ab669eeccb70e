--[[ write_pdf.lua: what pandoc's Typst writer leaves out or does its own way.

It drops alternative texts (jgm/pandoc#11394), so images are written here; boxes, captions' small
print and the size of wide tables are calls into template.typ.                                   ]]

local parts = require 'parts'
local pictures = require 'pictures'

local WIDE = 7            -- from so many columns on a table is set smaller
local LONG = 30           -- from so many rows on it may run over several pages,
local LONG_OF_TEXT = 8    -- and from so many if its cells are of several lines

local function raw(text) return pandoc.RawInline('typst', text) end
local function raw_block(text) return pandoc.RawBlock('typst', text) end

local function quoted(text)
  return '"' .. text:gsub('[\\"]', '\\%0'):gsub('%s+', ' ') .. '"'
end

local function wrapped(before, inlines, after)
  local out = pandoc.Inlines { raw(before) }
  out:extend(inlines)
  out:insert(raw(after))
  return out
end

local function with_pages(inlines)
  return inlines:walk { Link = function(l) return { l, raw('#page-of(<' .. l.target:sub(2) .. '>)') } end }
end

local function span(s)
  if s.classes:includes 'label' then return pandoc.Strong(s.content) end
  if s.classes:includes 'parameters' then return {} end     -- the appendix lists them
  if s.classes:includes 'provenance' then return wrapped('#provenance[', with_pages(s.content), ']') end
  if s.classes:includes 'with-page' then return with_pages(s.content) end
end

-- Paragraphs, lists and listings at the top level stay whole; what announces the next block stays with it.
local WHOLE = 2000        -- characters up to which a block stays whole, about half a page

local function last_character(block)
  return pandoc.utils.stringify(block):sub(-1)
end

local function kept_whole(block)
  local is_list = block.t == 'BulletList' or block.t == 'OrderedList'
  local is_listing = block.t == 'Div' and block.classes:includes 'listing'
  if not (block.t == 'Para' or is_list or is_listing) then return { block } end
  if #pandoc.utils.stringify(block) > WHOLE then return { block } end
  local keep = last_character(block) == ':' and '(keep: true)' or ''
  return { raw_block('#whole' .. keep .. '['), block, raw_block ']' }
end

local function is_displayed(x)
  return x and x.t == 'RawInline' and x.text:match '^#math%.equation%(block: true' ~= nil
end

local function begins_sentence(x)
  return x and x.t == 'Str' and x.text:match '^%u' ~= nil
end

-- A formula that ends a sentence also ends a paragraph: below it there may be a new page.
local function parts_of(block)
  if block.t ~= 'Para' then return { block } end
  local out, part = pandoc.Blocks {}, pandoc.Inlines {}
  for i, x in ipairs(block.content) do
    part:insert(x)
    if is_displayed(x) and begins_sentence(block.content[i + 2]) then
      out:insert(pandoc.Para(part))
      part = pandoc.Inlines {}
    end
  end
  out:insert(pandoc.Para(part))
  return out
end

local function unsplit(blocks)
  local out = pandoc.Blocks {}
  for _, block in ipairs(blocks) do
    for _, part in ipairs(parts_of(block)) do out:extend(kept_whole(part)) end
  end
  return out
end

-- In print only the figure of a living figure is left.
local function figures_of(div)
  return div.content:filter(function(block) return block.t == 'Figure' end)
end

local function box(div)
  if div.classes:includes 'widget' then return figures_of(div) end
  local kind
  for _, class in ipairs(div.classes) do
    if class ~= 'statement' then kind = kind or class end
  end
  if not div.classes:includes 'statement' then return nil end
  if kind == 'solution' then div.content = unsplit(div.content) end
  div.content:insert(1, raw_block('#statement("' .. kind .. '")['))
  div.content:insert(raw_block ']')
  return div
end

local function row_count(t)
  local count = 0
  for _, body in ipairs(t.bodies) do count = count + #body.body end
  return count
end

-- pandoc gives widths to the columns of a table whose lines are longer than a line of text
local function has_widths(t)
  return t.colspecs[1][2] ~= nil
end

local function within(call, blocks)
  blocks:insert(1, raw_block('#' .. call .. '['))
  blocks:insert(raw_block ']')
end

local function sized(t)
  local out = pandoc.Blocks { t }
  if #t.colspecs >= WIDE then within('wide-table', out) end
  if row_count(t) >= (has_widths(t) and LONG_OF_TEXT or LONG) then within('long-table', out) end
  return out
end

return function(doc)
  local root = pandoc.utils.stringify(doc.meta.figures)
  local function image(i)
    local width = pictures.width(root, i.src)
    return raw(('#image("/experiments/%s", width: %.2fmm, alt: %s)'):format(i.src, width,
      quoted(pandoc.utils.stringify(i.caption))))
  end
  doc.blocks = doc.blocks:walk { Image = image, Span = span, Div = box, Table = sized }
  doc.blocks = parts(unsplit(doc.blocks))
  return doc
end
