--[[ captions.lua: number, caption, words and origin of figures and tables.

  ![The caption, with $math$.](power_sampling.svg){#fig:name alt="What is to be seen."}

The experiment is known from the file's name; its parameters are put below the caption, where the
page folds them; in print the appendix lists them.                                               ]]

local labels = require 'labels'
local problems = require 'problems'
local values = require 'values'

local captions = {}

local LONG = 6            -- a longer tuple is told by its ends
local explained = false   -- whether the document lists all parameters
local silent = false      -- whether captions leave the experiment out: without-provenance

function captions.prepare(doc)
  silent = doc.meta['without-provenance'] == true
  doc.blocks:walk { Span = function(s)
    if s.identifier:match '^experiment%-' then explained = true end
  end }
end

function captions.head(name, number)
  return pandoc.Inlines {
    pandoc.Span({ pandoc.Str(name .. '\u{a0}' .. number .. '.') }, { '', { 'label' } }), pandoc.Space() }
end

local function name_of(experiment)
  local code = pandoc.Code(experiment)
  return explained and pandoc.Link({ code }, '#experiment-' .. experiment, '', { '', { 'origin' } }) or code
end

local function parameter(field, value)
  if type(value) == 'table' and #value > LONG then
    value = { value[1], value[2], '…', value[#value] }
  end
  local out = pandoc.Inlines { pandoc.Str(field:gsub('_', ' ') .. ' = ') }
  out:extend(values.inlines(values.text(value, '', field)))
  return out
end

-- "Experiment power_sampling: points = 100, seed = 0."; of several experiments only the names
local function provenance(names)
  local out = pandoc.Inlines { pandoc.Str(#names == 1 and 'Experiment' or 'Experiments'), pandoc.Space() }
  for i, name in ipairs(names) do
    if i > 1 then out:extend { pandoc.Str(i == #names and ' and' or ','), pandoc.Space() } end
    out:insert(name_of(name))
  end
  local only = #names == 1 and values.experiment(names[1])
  local with = pandoc.Inlines {}
  for i, field in ipairs(only and only.fields or {}) do
    with:extend { pandoc.Str(i == 1 and ':' or ';'), pandoc.Space() }
    with:extend(parameter(field.name, only.params[field.name]))
  end
  if #with > 0 then out:insert(pandoc.Span(with, { '', { 'parameters' } })) end
  out:insert(pandoc.Str '.')
  return pandoc.Span(out, { '', { 'provenance' } })
end

local function names_in(text)
  local names = {}
  for name in (text or ''):gmatch '[%w_]+' do names[#names + 1] = name end
  return names
end

local function captioned(x, kind, name, origin)
  if not x.identifier:match('^' .. kind .. ':') then
    problems.add(('every %s needs a label {#%s:...}: %s'):format(name:lower(), kind,
      pandoc.utils.stringify(x.caption.long):sub(1, 60)), x.identifier)
  end
  if #x.caption.long == 0 then
    problems.add(x.identifier .. ' has no caption', x.identifier)
    return x
  end
  local number = labels.next(kind)
  labels.define(x.identifier, kind, number, name)
  local caption = captions.head(name, number)
  caption:extend(pandoc.utils.blocks_to_inlines(x.caption.long))
  if #origin > 0 and not silent then caption:extend { pandoc.Space(), provenance(origin) } end
  x.caption.long = { pandoc.Plain(caption) }
  x.attributes.experiment = nil
  return x
end

-- The experiment that draws a figure is the longest name with which the figure's begins.
local function drawn_by(stem)
  local best
  for name, experiment in pairs(values.experiments) do
    if pandoc.List(experiment.figures):includes(stem) then best = name end
  end
  return best
end

local function check_words(image, id)
  local alt = pandoc.utils.stringify(image.caption)
  if #alt < 20 then problems.add(id .. ' needs an alternative text that says what is to be seen: alt="..."', id) end
  return alt
end

function captions.figure(figure)
  local id, origin = figure.identifier, {}
  figure = figure:walk { Image = function(image)
    local alt = check_words(image, id)
    if alt == pandoc.utils.stringify(figure.caption.long) then
      problems.add(id .. ': the alternative text only repeats the caption', id)
    end
    local stem = pandoc.path.split_extension(image.src)
    local name = drawn_by(stem)
    if not name then problems.add('no experiment draws the figure ' .. image.src, image.src) end
    origin[#origin + 1] = name
    image.src = (name or '') .. '/' .. image.src
    return image
  end }
  if #origin == 0 then problems.add(id .. ' shows no figure of an experiment', id) end
  return captioned(figure, 'fig', 'Figure', origin)
end

function captions.table(t)
  return captioned(t, 'tbl', 'Table', names_in(t.attributes.experiment))
end

return captions
