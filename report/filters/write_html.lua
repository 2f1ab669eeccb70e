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

-- A line breaks neither between a bracket and a formula nor between a formula and its punctuation.
local function with_punctuation(inlines)
  local out = pandoc.Inlines {}
  local function is_text(x, pattern) return x and x.t == 'Str' and x.text:match(pattern) end
  local i = 1
  while i <= #inlines do
    local opens = is_text(inlines[i], '[(%[]$')
    local formula = inlines[opens and i + 1 or i]
    local whole = pandoc.Inlines {}
    if formula and formula.t == 'Math' and formula.mathtype == 'InlineMath' then
      local last = opens and i + 1 or i
      if is_text(inlines[last + 1], '^[.,;:!?)%]]') then last = last + 1 end
      for j = i, last do whole:insert(inlines[j]) end
    end
    if #whole > 1 then out:insert(pandoc.Span(whole, { '', { 'unbroken' } })) else out:insert(inlines[i]) end
    i = i + math.max(1, #whole)
  end
  return out
end

-- The parameters below a caption are folded. A link cannot stand in the summary, which is a button.
local function folded(s)
  if not s.classes:includes 'provenance' then return nil end
  local head, parameters = pandoc.Inlines {}, nil
  for _, x in ipairs(s.content) do
    if x.t == 'Span' and x.classes:includes 'parameters' then parameters = x.content
    elseif not parameters then head:insert(x) end
  end
  if not parameters then return nil end
  local out = pandoc.Inlines { pandoc.RawInline('html', '<details class="provenance"><summary>') }
  out:extend(head:walk { Link = function(l) return l.content end })
  local colon = pandoc.Span({ parameters:remove(1) }, { '', { 'colon' } })       -- not shown when folded
  out:extend { colon, pandoc.RawInline('html', '</summary>') }
  out:extend(parameters)
  out:extend { pandoc.Str '.', pandoc.RawInline('html', '</details>') }
  return out
end

-- A living figure: its script replaces the picture. The text after the figure says what to do.
local function widget(div)
  if not div.classes:includes 'widget' then return nil end
  local figure, lead = pandoc.Blocks {}, pandoc.Blocks {}
  for _, block in ipairs(div.content) do
    if block.t == 'Figure' then figure:insert(block) else lead:insert(block) end
  end
  figure:insert(pandoc.Div(lead, { '', { 'lead' }, { { 'hidden', '' } } }))      -- the script shows it
  return pandoc.Div(figure, { '', { 'widget' }, { { 'data-widget', div.attributes.name or '' } } })
end

return function(doc)
  local root = pandoc.utils.stringify(doc.meta.figures)
  local function image(i)
    local width = pictures.width(root, i.src)
    return pandoc.RawInline('html', ('<img class="picture" src="%s" alt="%s" style="width:%.4g%%">'):format(
      escaped(i.src), escaped(pandoc.utils.stringify(i.caption)),
      100 * math.min(1, width / pictures.text_width)))
  end
  doc.blocks = doc.blocks:walk { Image = image, Header = lower_heading, Table = in_scroll_box, Span = folded, Div = widget, Inlines = with_punctuation }
  return doc
end
