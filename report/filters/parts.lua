--[[ parts.lua: parts in print.

  # Applications {#sec:applications .part pages=50}

A part begins on a new page and ends before the next part, appendix or unnumbered heading. The
template counts its pages and refuses more than `pages`.                                         ]]

local function raw(text) return pandoc.RawInline('typst', text) end

local function heading(h)
  local out = pandoc.Inlines { raw '#heading(level: 1, supplement: [Part])[' }
  out:extend(h.content)
  out:insert(raw('] <' .. h.identifier .. '>'))
  return pandoc.Plain(out)
end

local function ends_part(h)
  return h.classes:includes 'part' or h.classes:includes 'appendix' or h.classes:includes 'unnumbered'
end

return function(blocks)
  local out, part = pandoc.Blocks {}, nil
  for _, block in ipairs(blocks) do
    local opens = block.t == 'Header' and block.level == 1
    if opens and part and ends_part(block) then
      out:insert(pandoc.RawBlock('typst', ('#part-ends(<%s>, %s)'):format(part.identifier,
        part.attributes.pages or 'none')))
      part = nil
    end
    if opens and block.classes:includes 'part' then
      part = block
      out:insert(pandoc.RawBlock('typst', '#pagebreak(weak: true)'))
      block = heading(block)
    end
    out:insert(block)
  end
  return out
end
