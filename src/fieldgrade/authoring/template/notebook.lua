--[[ notebook.lua: a notebook's Markdown for Pandoc. A formula's \tag becomes its number, on the page
and on paper; the rest is that of the report, in whose folder Pandoc runs. ]]

package.path = 'filters/?.lua;' .. package.path
local problems, mathematics = require 'problems', require 'mathematics'

-- $$ … \tag{2.1} $$ is the numbered formula of the report.
local function numbered(math)
  local number = math.text:match '\\tag%s*{([^}]*)}'
  if math.mathtype ~= 'DisplayMath' or not number then return nil end
  math.text = math.text:gsub('%s*\\tag%s*{[^}]*}', '')
  return pandoc.Span({ math }, { '', { 'equation' }, { number = number } }), false
end

-- In print nothing unfolds: a hint is printed below its summary.
local function unfolded(raw)
  if not FORMAT:match 'typst' then return nil end
  local summary = raw.text:match '<summary>(.-)</summary>'
  if summary then return pandoc.Para { pandoc.Strong { pandoc.Str(summary .. '.') } } end
  return {}
end

local function picture(image)
  local alt = image.attributes.alt
  if FORMAT:match 'typst' then
    return pandoc.RawInline('typst', ('#image("/%s", alt: "%s", width: 85%%)'):format(image.src, alt))
  end
  return image
end

-- The first heading repeats the title, which the template prints.
local function untitled(doc)
  if doc.blocks[1] and doc.blocks[1].t == 'Header' then doc.blocks:remove(1) end
  return doc
end

return {
  { Pandoc = untitled },
  { traverse = 'topdown', Math = numbered },
  { Pandoc = function(doc) return mathematics(doc) end },
  { RawBlock = unfolded, Image = picture },
  { Pandoc = function() problems.stop_if_any() end },
}
