--[[ undated.lua: a work without a date, such as slides, is cited by its author and the page.

  @erleben [p. 39]     Erleben (p. 39), where other works have the year
  [@erleben, p. 39]    (Erleben, p. 39)                                                          ]]

local function authors(work)
  local names = {}
  for i, who in ipairs(work.author) do names[i] = pandoc.utils.stringify(who.family) end
  return table.concat(names, ' and ')
end

-- The page as it is written, with a dash between numbers, and no line break after "p."
local function page(citation)
  local text = pandoc.utils.stringify(citation.suffix):gsub('^[%s,]+', '')
  return (text:gsub('(%d)-(%d)', '%1–%2'):gsub('^(pp?%.)%s', '%1\u{a0}'))
end

return function(doc)
  local undated = {}
  for _, work in ipairs(pandoc.utils.references(doc)) do
    if not work.issued then undated[work.id] = authors(work) end
  end
  local function cited(cite)
    local citation = cite.citations[1]
    local author = #cite.citations == 1 and undated[citation.id]
    if not author then return nil end
    local where = page(citation)
    local function link(text)
      return pandoc.Link({ pandoc.Str(text) }, '#ref-' .. citation.id)
    end
    if citation.mode ~= 'AuthorInText' then
      cite.content = { pandoc.Str '(', link(where == '' and author or author .. ', ' .. where), pandoc.Str ')' }
    elseif where == '' then
      cite.content = { link(author) }
    else
      cite.content = { pandoc.Str(author), pandoc.Space(), pandoc.Str '(', link(where), pandoc.Str ')' }
    end
    return cite
  end
  doc.blocks = doc.blocks:walk { Cite = cited }
  return doc
end
