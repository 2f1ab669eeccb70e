--[[ values.lua: the numbers of the experiments, and how a number is written.

One number has three spellings: inlines in prose, TeX inside mathematics, plain text inside an
alternative text. All start from the same digits.                                               ]]

local problems = require 'problems'

local values = { experiments = {} }

function values.load(path)
  local file = assert(io.open(path))
  values.experiments = pandoc.json.decode(file:read 'a', false)
  file:close()
end

function values.experiment(name)
  local experiment = values.experiments[name]
  if not experiment then
    local known = {}
    for k in pairs(values.experiments) do known[#known + 1] = k end
    table.sort(known)
    problems.add('there is no experiment ' .. name .. '; there are ' .. table.concat(known, ', '), name)
  end
  return experiment
end

-- A format is what Python's format() knows of numbers: [+][.digits][d e f g %]
local function parse(format)
  local sign, precision, kind = format:match '^(%+?)(%.?%d*)([defg%%]?)$'
  if not kind or precision == '.' or precision:match '^%d' then return nil end
  return sign, precision, kind
end

-- All numbers have separators from 1,000 on, in text and tables alike.
local function group(digits)
  local whole, rest = digits:match '^([-+]?%d+)(.*)$'
  if not whole then return digits end
  local grouped = whole:reverse():gsub('(%d%d%d)', '%1,'):reverse()
  return grouped:gsub('^([-+]?),', '%1') .. rest
end

-- An order of magnitude arrives as the text ~1e-16. It has no digits.
function values.order(value)
  return type(value) == 'string' and value:match '^~(1e[-+]%d+)$' or nil
end

local WITHOUT_DIGITS = { [''] = true, e = true, g = true, ['.0e'] = true }

local function order_text(order, format, token)
  if WITHOUT_DIGITS[format] then return order end
  problems.add(('an order of magnitude has no digits: write .0e, not %q, in %s'):format(format, token), token)
  return nil
end

local function digits(x, format)
  x = math.tointeger(x) or x             -- JSON numbers arrive as floats
  local sign, precision, kind = parse(format)
  if not kind then return nil end
  if kind == '' and precision == '' then
    kind = math.type(x) == 'integer' and 'd' or '.9g'
  end
  if kind == 'd' and math.type(x) ~= 'integer' then return nil end
  local text
  if kind == '%' then
    text = ('%' .. sign .. (precision == '' and '.6' or precision) .. 'f'):format(100 * x) .. '%'
  elseif kind == 'e' and precision == '.0' and ('%.15e'):format(x):match '^%-?1%.0*e' == nil then
    text = ('%#' .. sign .. '.0e'):format(x)     -- one digit, 1.e-05, is not a power of ten, 1e-05
  else
    text = ('%' .. sign .. precision .. (kind == '' and 'g' or kind)):format(x)
  end
  return group(text)
end

-- A value as text with the digits that are told; nil and a problem where the format does not fit.
function values.text(value, format, token)
  if type(value) == 'table' then
    local parts = {}
    for i, part in ipairs(value) do parts[i] = values.text(part, format, token) or '?' end
    return table.concat(parts, ', ')
  end
  local order = values.order(value)
  if order then return order_text(order, format, token) end
  if type(value) ~= 'number' then
    if format ~= '' then problems.add('a text has no number format: ' .. token, token) end
    return tostring(value)
  end
  local text = digits(value, format)
  if not text then
    problems.add(('the format %q does not fit %s in %s'):format(format, tostring(value), token), token)
  end
  return text
end

-- The value of "experiment.fact" or "experiment.params.field".
function values.find(key, token)
  local name, field = key:match '^([%w_]+)%.params%.([%w_]+)$'
  local kind = 'params'
  if not name then name, field, kind = key:match '^([%w_]+)' , key:match '%.([%w_]+)$', 'facts' end
  local experiment = name and values.experiments[name]
  if not experiment then
    problems.add('there is no experiment for ' .. token, token)
    return nil
  end
  local value = experiment[kind][field or '']
  if value == nil then
    local what = kind == 'facts' and 'fact' or 'parameter'
    problems.add(('%s has no %s %s'):format(name, what, field or key), token)
  end
  return value, kind, name
end

-- Mantissa and exponent of 1.20e-03; a bare power of ten, 1e-16, has no mantissa, 1.e-16 has the mantissa 1.
local function scientific(text)
  local mantissa, exponent = text:match '^([-+]?[%d.,]+)e([-+]%d+)$'
  if not mantissa then return nil end
  local sign = mantissa:match '^[-+]?'
  if mantissa:match '^[-+]?1$' then return sign, nil, math.tointeger(tonumber(exponent)) end
  return sign, mantissa:sub(#sign + 1):gsub('%.$', ''), math.tointeger(tonumber(exponent))
end

-- 2 × 10⁻³, 10⁻³, and without a power where that is shorter: 2 for 2 × 10⁰, 1 and 10 for 10⁰ and 10¹.
local function product(mantissa, times, exponent, power)
  if exponent == 0 then return mantissa or '1' end
  if exponent == 1 and not mantissa then return '10' end
  return (mantissa and mantissa .. times or '') .. power
end

function values.tex(text)
  if not text:match '^[-+%d]' then return '\\text{' .. text .. '}' end
  local sign, mantissa, exponent = scientific(text)
  if exponent then
    return sign .. product(mantissa, ' \\times ', exponent, '10^{' .. exponent .. '}')
  end
  -- as text, since Typst sets a space behind a comma of mathematics
  return (text:gsub('%d+,[%d,]*%d', '\\text{%0}'):gsub('%%', '\\,\\%%'))
end

local RAISED = { ['-'] = '⁻', ['0'] = '⁰', ['1'] = '¹', ['2'] = '²', ['3'] = '³', ['4'] = '⁴',
  ['5'] = '⁵', ['6'] = '⁶', ['7'] = '⁷', ['8'] = '⁸', ['9'] = '⁹' }

local MINUS = '−'
local NO_BREAK = '\u{a0}'

function values.plain(text)
  if not text:match '^[-+%d]' then return text end
  local sign, mantissa, exponent = scientific(text)
  if exponent then
    text = sign .. product(mantissa, ' × ', exponent, '10' .. tostring(exponent):gsub('.', RAISED))
  end
  return (text:gsub('^%-', MINUS):gsub('(%d)%%', '%1' .. NO_BREAK .. '%%'))
end

function values.inlines(text)
  if not text:match ', ' and scientific(text) then
    return pandoc.Inlines { pandoc.Math('InlineMath', values.tex(text)) }
  end
  local out = pandoc.Inlines {}
  for word in text:gmatch '%S+' do
    if #out > 0 then out:insert(pandoc.Space()) end
    local number, comma = word:match '^(.-)(,?)$'
    if scientific(number) then
      out:insert(pandoc.Math('InlineMath', values.tex(number)))
      if comma ~= '' then out:insert(pandoc.Str(comma)) end
    else
      out:insert(pandoc.Str((word:gsub('^%-(%d)', MINUS .. '%1'):gsub('(%d)%%', '%1' .. NO_BREAK .. '%%'))))
    end
  end
  return out
end

-- A line does not end between a number and its unit.
local UNITS = { ['%'] = true, ['°'] = true, m = true, mm = true, km = true, s = true, K = true, t = true,
  ['m/s'] = true, ['kg/m³'] = true, kPa = true, MB = true }

function values.with_units(inlines)
  for i = 2, #inlines - 1 do
    local number, unit = inlines[i - 1], inlines[i + 1]
    if inlines[i].t == 'Space' and number.t == 'Str' and number.text:match '%d$' and unit.t == 'Str'
        and UNITS[unit.text:match '^(.-)[.,;:)]*$'] then
      inlines[i] = pandoc.Str(NO_BREAK)
    end
  end
  return inlines
end

return values
