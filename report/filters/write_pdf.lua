--[[ write_pdf.lua: what pandoc's Typst writer leaves out or does its own way.

It drops alternative texts (jgm/pandoc#11394), so images are written here; boxes, captions' small
print and the size of wide tables are calls into template.typ.                                   ]]

local parts = require 'parts'
local pictures = require 'pictures'

local WIDE = 7            -- from so many columns on a table is set smaller
local LONG = 30           -- from so many rows on it may run over several pages,
local LONG_OF_TEXT = 19   -- and from so many if its cells are of several lines

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

local function within(call, blocks)
  blocks:insert(1, raw_block('#' .. call .. '['))
  blocks:insert(raw_block ']')
end

local function with_pages(inlines)
  return inlines:walk { Link = function(l) return { l, raw('#page-of(<' .. l.target:sub(2) .. '>)') } end }
end

-- Typst would end a line behind the slash of a unit.
local function unit(str)
  if str.text:match '^k?[gm]/[ms]' then return raw('#box[' .. str.text .. ']') end
end

local function span(s)
  if s.classes:includes 'label' then return pandoc.Strong(s.content) end
  if s.classes:includes 'parameters' then return {} end     -- the appendix lists them
  if s.classes:includes 'provenance' then return wrapped('#provenance[', with_pages(s.content), ']') end
  if s.classes:includes 'with-page' then return with_pages(s.content) end
end

-- Paragraphs, short lists, items of long ones, and listings at the top level stay whole; what announces
-- the next block stays with it.
local WHOLE = 2000        -- characters up to which a block stays whole, about half a page,
local WHOLE_LIST = 800    -- and a list

local function last_character(block)
  return pandoc.utils.stringify(block):sub(-1)
end

local function whole(blocks, keep)
  within('whole' .. (keep and '(keep: true)' or ''), blocks)
  return blocks
end

-- An item of one paragraph remains one, for the sake of the spaces between items.
local function whole_item(item)
  if #item > 1 or item[1].t ~= 'Plain' then return whole(item) end
  return { pandoc.Plain(wrapped('#whole[', item[1].content, ']')) }
end

local function kept_whole(block)
  local length = #pandoc.utils.stringify(block)
  local is_list = block.t == 'BulletList' or block.t == 'OrderedList'
  local is_listing = block.t == 'Div' and block.classes:includes 'listing'
  if is_list and length > WHOLE_LIST then
    for i, item in ipairs(block.content) do block.content[i] = whole_item(item) end
    return { block }
  end
  if not (block.t == 'Para' or is_list or is_listing) or length > WHOLE then return { block } end
  return whole(pandoc.Blocks { block }, last_character(block) == ':')
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

local last_statement = nil      -- the one with a label that a proof is below

local function box(div)
  if div.classes:includes 'widget' then return figures_of(div) end
  local kind
  for _, class in ipairs(div.classes) do
    if class ~= 'statement' then kind = kind or class end
  end
  if not div.classes:includes 'statement' then return nil end
  if kind == 'solution' or kind == 'proof' then div.content = unsplit(div.content) end
  if kind ~= 'proof' and div.identifier ~= '' then last_statement = div.identifier end
  local of = kind == 'proof' and last_statement and (', of: "%s"'):format(last_statement) or ''
  div.content:insert(1, raw_block(('#statement("%s"%s)['):format(kind, of)))
  div.content:insert(raw_block ']')
  return kind == 'proof' and { raw_block '#before-proof', div } or div
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

local function is_long(t)
  return row_count(t) >= (has_widths(t) and LONG_OF_TEXT or LONG)
end

local function sized(t)
  local out = pandoc.Blocks { t }
  if #t.colspecs >= WIDE then within('wide-table', out) end
  if is_long(t) then within('long-table', out) end
  return out
end

-- All figures and short tables float; the template asks on which page their chapter begins.
local function floating(blocks)
  local chapter
  local function float(block)
    if block.t == 'Table' and is_long(block) then return nil end
    local out = pandoc.Blocks { block }
    within(('floating(<%s>)'):format(chapter), out)
    return out
  end
  local out = pandoc.Blocks {}
  for _, block in ipairs(blocks) do
    if block.t == 'Header' and block.level == 1 then chapter = block.identifier end
    out:extend(pandoc.Blocks { block }:walk { Figure = float, Table = float })
  end
  return out
end

return function(doc)
  local root = pandoc.utils.stringify(doc.meta.figures)
  local function image(i)
    local width = pictures.width(root, i.src)
    return raw(('#image("/experiments/%s", width: %.2fmm, alt: %s)'):format(i.src, width,
      quoted(pandoc.utils.stringify(i.caption))))
  end
  doc.blocks = doc.blocks:walk { Image = image, Str = unit, Span = span, Div = box, Table = sized }
  doc.blocks = parts(unsplit(floating(doc.blocks)))
  return doc
end
