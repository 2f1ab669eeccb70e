--[[ quoted_facts.lua: {{experiment.fact:format}} and {{experiment.params.field}} become numbers,
in prose, captions, cells, headings, mathematics and attributes (alternative texts).

Code is left alone, so that this syntax can be shown. A table remembers whose facts it quotes.   ]]

local problems = require 'problems'
local values = require 'values'

local QUOTATION = '{{([^{}]*)}}'

local seen                -- the experiments quoted in the table at hand

local function text_of(inside)
  local token = '{{' .. inside .. '}}'
  local key, format = inside:match '^([%w_.]+):?(.*)$'
  if not key then
    problems.add('not of the form {{experiment.fact:format}}: ' .. token, token)
    return '?'
  end
  local value, kind, name = values.find(key, token)
  if value == nil then return '?' end
  if kind == 'facts' and format == '' and math.type(value) == 'float' and not math.tointeger(value) then
    problems.add('a number with decimals needs a format, such as {{' .. key .. ':.2f}}', token)
  end
  if seen then seen[name] = true end
  return values.text(value, format, token) or '?'
end

local function in_text(str)
  if not str.text:find(QUOTATION) then
    if str.text:find '{{' or str.text:find '}}' then
      problems.add('not of the form {{experiment.fact:format}}: ' .. str.text, str.text)
    end
    return nil
  end
  local out, at = pandoc.Inlines {}, 1
  for before, inside, after in str.text:gmatch('()' .. QUOTATION .. '()') do
    if before > at then out:insert(pandoc.Str(str.text:sub(at, before - 1))) end
    out:extend(values.inlines(text_of(inside)))
    at = after
  end
  if at <= #str.text then out:insert(pandoc.Str(str.text:sub(at))) end
  return out
end

local function in_mathematics(math)
  math.text = math.text:gsub(QUOTATION, function(inside) return values.tex(text_of(inside)) end)
  return math
end

local function in_attributes(element)
  for name, value in pairs(element.attributes) do
    if value:find(QUOTATION) then
      element.attributes[name] =
        value:gsub(QUOTATION, function(inside) return values.plain(text_of(inside)) end)
    end
  end
  return element
end

local fill = { Str = in_text, Math = in_mathematics, Image = in_attributes, Div = in_attributes,
  CodeBlock = in_attributes, Inlines = values.with_units }

-- Alternative texts are inlines of the image, but plain text in the outputs.
local plain = { Str = function(str)
  return pandoc.Str((str.text:gsub(QUOTATION, function(i) return values.plain(text_of(i)) end)))
end }

local function in_table(t)
  seen = {}
  t = t:walk(fill)
  local names = {}
  for name in pairs(seen) do names[#names + 1] = name end
  seen = nil
  if #names > 0 and not t.attributes.experiment then
    table.sort(names)
    t.attributes.experiment = table.concat(names, ' ')
  end
  return t
end

-- Most blocks quote nothing. The text of a whole block tells that sooner than a walk through its words.
local function with_numbers(block)
  local text = tostring(block)
  if not text:find '{{' and not text:find '}}' then return { block } end
  return pandoc.Blocks { block }
    :walk { Image = function(i) i.caption = i.caption:walk(plain); return i end }
    :walk { Table = in_table }:walk(fill)
end

return function(doc)
  local filled = pandoc.Blocks {}
  for _, block in ipairs(doc.blocks) do filled:extend(with_numbers(block)) end
  doc.blocks = filled
  for key, value in pairs(doc.meta) do
    if pandoc.utils.type(value) == 'Inlines' or pandoc.utils.type(value) == 'Blocks' then
      doc.meta[key] = value:walk(fill)
    end
  end
  return doc
end
