--[[ mathematics.lua: formulas that come out alike in MathML and in Typst.

Pandoc 3.9 writes some TeX wrongly, and silently. What can be put right is put right, in the TeX or
in the Typst that it becomes; what cannot is refused, with what to write instead.                ]]

local problems = require 'problems'

-- Lua patterns of TeX that one of the outputs would spoil, and the cure.
local REFUSED = {
  { '\\|', '\\lVert ... \\rVert' },
  { '\\hline', 'a matrix without lines' },
  { '\\&', 'the word and' },
  { '\\left%s*%.', '\\Big|' },
  { '\\tag', 'a label {#eq:name}' },
  { '\\label', 'a label {#eq:name} behind the formula' },
  { '\\begin{Vmatrix}', '\\lVert around a matrix' },
  { '\\left%s*\\lVert', '\\lVert, which grows by itself' },
  { '\\[bB]igg?[lrm]?%s*\\[lr]?Vert', '\\lVert, which grows by itself' },
  { '\\begin{array}', 'matrix, cases or aligned' },
}

-- Names that pandoc writes and Typst 0.15 no longer has (jgm/pandoc#11591), and other slips.
local REPAIRED = {
  { '%f[%w.]sect%f[^%w]', 'inter' },
  { '%.circle%f[^%w]', '.o' },
  { '(brac[ek]e?t?%.[lr])%.double', '%1.stroked' },
  { 'delim: "||"', 'delim: "|"' },
  { '"(arg ?m[ai][nx])"_', 'op("%1", limits: #true)_' },
  { '\\| (.-) \\|', 'lr(|%1|)' },                -- bars at their contents, and larger parentheses
  { '(#scale%b()%[\\[(%[]%]) ', '%1' },
  { ' (#scale%b()%[\\[)%]]%])', '%1' },
}

local function check(tex)
  for _, rule in ipairs(REFUSED) do
    local at = rule[2] and tex:find(rule[1])
    if at then
      problems.add(('the formula %s would be spoilt; instead of %s write %s'):format(
        tex:sub(1, 60), tex:match(rule[1]), rule[2]), tex:match '[^\n]+')
    end
  end
end

-- MathML sets \mathbf{B} in bold italics; the upright bold letters themselves it leaves alone.
local function upright_bold(tex)
  return (tex:gsub('\\mathbf%s*{(%a+)}', function(word)
    return '{' .. word:gsub('.', function(letter)
      local byte = letter:byte()
      return utf8.char(byte >= 97 and 0x1D41A + byte - 97 or 0x1D400 + byte - 65)
    end) .. '}'
  end))
end

-- Browsers set no space between a factor and a function's name, nor between that and its argument.
local function spaced_functions(tex)
  for _, name in ipairs { 'log', 'exp', 'sin', 'cos', 'dim', 'det', 'max', 'min' } do
    tex = tex:gsub('([%w}])%s*\\' .. name .. '%f[%A]', '%1\\,\\' .. name)
             :gsub('\\' .. name .. '%s+(%w)', '\\' .. name .. '\\,%1')
             :gsub('\\' .. name .. '(\\[lm]%a)', '\\' .. name .. '\\,%1')
  end
  return tex
end

-- As superscripts of MathML, primes would stand above the letters.
local PRIMES = { '′', '″', '‴' }
local function primes(tex)
  return (tex:gsub("'+", function(run) return '\\text{' .. (PRIMES[#run] or PRIMES[1]:rep(#run)) .. '}' end))
end

local function for_browsers(tex) return primes(spaced_functions(upright_bold(tex))) end

local function quoted(text)
  return '"' .. text:gsub('[\\"]', '\\%0'):gsub('%s+', ' ') .. '"'
end

local BETWEEN = '\n//between\n'

local written_as = {}     -- Typst of a formula, by its TeX, for those in the line and those displayed

-- One call writes all: each would prepare the writer anew, which takes longer than the formula.
local function write_all(doc)
  local formulas, blocks = {}, pandoc.Blocks {}
  doc:walk { Math = function(math)
    written_as[math.mathtype] = written_as[math.mathtype] or {}
    if written_as[math.mathtype][math.text] then return end
    written_as[math.mathtype][math.text] = true
    formulas[#formulas + 1] = math
    blocks:extend { pandoc.Plain { math }, pandoc.RawBlock('typst', BETWEEN) }
  end }
  local text, at = pandoc.write(pandoc.Pandoc(blocks), 'typst', { wrap_text = 'none' }) .. BETWEEN, 1
  for _, math in ipairs(formulas) do
    local first, last = text:find(BETWEEN, at, true)
    written_as[math.mathtype][math.text] = text:sub(at, first - 1)
    at = last + 1
  end
end

local function typst(math, id, number)
  local written = written_as[math.mathtype][math.text]
  written = written:gsub('^%s+', ''):gsub('%s+$', '')
  for _, rule in ipairs(REPAIRED) do written = written:gsub(rule[1], rule[2]) end
  for name in math.text:gmatch '\\operatorname{(%a+)}' do
    written = written:gsub('"' .. name .. '"', 'op("' .. name .. '")')
  end
  written = written:gsub('cases(%b())', function(c) return 'cases' .. c:gsub(' & ', ' &quad ') end)
  local options = 'alt: ' .. quoted(math.text) .. ', '
  if math.mathtype == 'DisplayMath' then options = 'block: true, ' .. options end
  if number then options = options .. 'numbering: (..n) => [(' .. number .. ')], ' end
  return pandoc.RawInline('typst',
    '#math.equation(' .. options .. written .. ')' .. ((id or '') ~= '' and '<' .. id .. '>' or ''))
end

-- the number stands beside the formula; without a number the formula stands alone
local function equation(span)
  if not span.classes:includes 'equation' then return nil end
  local number, id = span.attributes.number, span.identifier
  local math = span.content[1]
  if FORMAT:match 'typst' then return typst(math, id, number), false end
  math.text = for_browsers(math.text)
  span.attributes.number = nil
  span.content:insert(pandoc.Span({ pandoc.Str('(' .. number .. ')') }, { '', { 'eqno' } }))
  return span, false
end

local function formula(math)
  if FORMAT:match 'typst' then return typst(math) end
  math.text = for_browsers(math.text)
  return math
end

return function(doc)
  doc = doc:walk { Math = function(m) m.text = m.text:gsub('^%s+', ''):gsub('%s+$', ''); check(m.text); return m end }
  if FORMAT:match 'typst' then write_all(doc) end
  return doc:walk { traverse = 'topdown', Span = equation, Math = formula }
end
