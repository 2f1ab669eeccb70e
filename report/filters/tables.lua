--[[ tables.lua: a table out of the results of an experiment.

  ::: {.result #tbl:name experiment=power_sampling table=errors
       columns="n; LS rms; MLS rms" heads="$n$; least squares; moving least squares" formats="; .2e; .2e"}
  The caption, with $math$ and {{power_sampling.params.points}}.
  :::

`columns` chooses and orders the columns of the result; `heads` are Markdown and default to the
columns; `formats` default to whole numbers as they are and three digits of others.
`rows="1, 4-6"` keeps some rows.                                                                   ]]

local problems = require 'problems'
local values = require 'values'

-- "a; b; c" as a list
local function split(text)
  local parts = pandoc.List {}
  for part in ((text or '') .. ';'):gmatch '%s*(.-)%s*;' do parts:insert(part) end
  return parts
end

-- a text of its own could begin with a title ("% …"); a head of a column has none
local function markdown(text)
  return pandoc.utils.blocks_to_inlines(pandoc.read(text, 'markdown-pandoc_title_block').blocks)
end

local function found_columns(result, columns, id)
  local indices = {}
  for _, column in ipairs(columns) do
    local _, index = pandoc.List(result.columns):find(column)
    if not index then
      problems.add(('%s: no column %q; the table has %s'):format(id, column,
        table.concat(result.columns, '; ')), column)
    end
    indices[#indices + 1] = index or 1
  end
  return indices
end

local function cell(value, format, id)
  if type(value) == 'number' and format == '' and not math.tointeger(value) then format = '.3g' end
  if type(value) ~= 'number' then format = '' end   -- a text, or an order of magnitude
  return pandoc.Cell { pandoc.Plain(values.inlines(values.text(value, format, id) or '?')) }
end

local function is_numeric(rows, index)
  for _, row in ipairs(rows) do
    if type(row[index]) == 'number' or values.order(row[index]) then return true end
  end
end

-- rows="1, 4-6": the first, and the fourth to the sixth
local function chosen_rows(result, wanted, id)
  if not wanted then return result.rows end
  local rows = {}
  for part in wanted:gmatch '[^,]+' do
    local first, last = part:match '^%s*(%d+)%-?(%d*)%s*$'
    first, last = tonumber(first), tonumber(last) or tonumber(first)
    if not first or first < 1 or last < first or last > #result.rows then
      problems.add(('%s: rows="%s" must lie within 1-%d'):format(id, wanted, #result.rows), id)
      return result.rows
    end
    table.move(result.rows, first, last, #rows + 1, rows)
  end
  return rows
end

local function result_table(div)
  local id, a = div.identifier, div.attributes
  local experiment = values.experiment(a.experiment or '(none named)')
  local result = experiment and experiment.tables[a.table or '']
  if not result then
    problems.add(('%s: %s has no table %s'):format(id, a.experiment or '?', a.table or '?'), id)
    return div
  end
  local columns = a.columns and split(a.columns) or pandoc.List(result.columns)
  local heads = a.heads and split(a.heads) or columns
  local formats = split(a.formats)
  if #heads ~= #columns or (a.formats and #formats ~= #columns) then
    problems.add(id .. ': as many heads and formats as columns are wanted', id)
  end
  local indices, all = found_columns(result, columns, id), chosen_rows(result, a.rows, id)
  local specs, head, rows = {}, {}, {}
  for k, index in ipairs(indices) do
    specs[k] = { is_numeric(all, index) and 'AlignRight' or 'AlignLeft', nil }
    head[k] = pandoc.Cell { pandoc.Plain(markdown(heads[k] or '?')) }
  end
  for r, row in ipairs(all) do
    local cells = {}
    for k, index in ipairs(indices) do cells[k] = cell(row[index], formats[k] or '', id) end
    rows[r] = pandoc.Row(cells)
  end
  local caption = { long = { pandoc.Plain(pandoc.utils.blocks_to_inlines(div.content)) } }
  local body = { attr = pandoc.Attr(), body = rows, head = {}, row_head_columns = 0 }
  return pandoc.Table(caption, specs, pandoc.TableHead { pandoc.Row(head) }, { body },
    pandoc.TableFoot {}, pandoc.Attr(id, { 'result' }, { experiment = a.experiment }))
end

-- ::: parameters ::: lists all experiments with their parameters and what each is
local function parameter_list()
  local names, items = {}, {}
  for name in pairs(values.experiments) do names[#names + 1] = name end
  table.sort(names)
  for _, name in ipairs(names) do
    local experiment, lines = values.experiments[name], {}
    for _, field in ipairs(experiment.fields) do
      local line = pandoc.Inlines { pandoc.Code(field.name), pandoc.Str ' = ' }
      line:extend(values.inlines(values.text(experiment.params[field.name], '', name)))
      if field.meaning ~= '' then
        line:insert(pandoc.Str ': ')
        line:extend(markdown(field.meaning))
      end
      lines[#lines + 1] = { pandoc.Plain(line) }
    end
    local term = pandoc.Inlines {
      pandoc.Span({ pandoc.Code(name) }, pandoc.Attr('experiment-' .. name)), pandoc.Str ': ' }
    term:extend(markdown(experiment.title))
    items[#items + 1] = { term, { { pandoc.BulletList(lines) } } }
  end
  return pandoc.DefinitionList(items)
end

return function(doc)
  doc.blocks = doc.blocks:walk { Div = function(div)
    if div.classes:includes 'result' then return result_table(div) end
    if div.classes:includes 'parameters' then return parameter_list() end
  end }
  return doc
end
