--[[ write_html.lua: what is particular to the page: the title is its only first-level heading,
tables and formulas scroll inside their own box. The build puts the figures into the file.       ]]

local pictures = require 'pictures'

local function escaped(text)
  return (text:gsub('[&<>"]', { ['&'] = '&amp;', ['<'] = '&lt;', ['>'] = '&gt;', ['"'] = '&quot;' }))
end

local function lower_heading(h)
  h.level = h.level + 1
  return h
end

-- A table that is wider than the screen scrolls; the box can be reached by the keyboard.
local function in_scroll_box(t)
  local name = pandoc.utils.stringify(t.caption.long):sub(1, 40):match '^[^.]+%.%d+'
  return pandoc.Div({ t }, pandoc.Attr('', { 'scroll' },
    { { 'role', 'region' }, { 'tabindex', '0' }, { 'aria-label', name or 'table' } }))   -- in this order
end

return function(doc)
  local root = pandoc.utils.stringify(doc.meta.figures)
  local function image(i)
    local width = pictures.width(root, i.src)
    return pandoc.RawInline('html', ('<img src="%s" alt="%s" style="width:%.4g%%">'):format(
      escaped(i.src), escaped(pandoc.utils.stringify(i.caption)),
      100 * math.min(1, width / pictures.text_width)))
  end
  doc.blocks = doc.blocks:walk { Image = image, Header = lower_heading, Table = in_scroll_box }
  return doc
end
