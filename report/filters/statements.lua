--[[ statements.lua: theorems, exercises and their like.

  ::: {.exercise #exr:name title="Weights far away"}
  ...
  :::
  ::: solution
  ...
  :::

Theorems, definitions and the rest share one counter; exercises have their own.                  ]]

local labels = require 'labels'

local NAMES = { theorem = 'Theorem', lemma = 'Lemma', definition = 'Definition', proposition = 'Proposition',
  corollary = 'Corollary', remark = 'Remark', example = 'Example', exercise = 'Exercise',
  proof = 'Proof', solution = 'Solution' }
local UNCOUNTED = { proof = true, solution = true }
local PLURAL = { lemma = 'Lemmas', corollary = 'Corollaries' }

local function statement_class(div)
  for _, class in ipairs(div.classes) do
    if NAMES[class] then return class end
  end
end

return function(div)
  local class = statement_class(div)
  if not class then return nil end
  local head = NAMES[class]
  if not UNCOUNTED[class] then
    local number = labels.next(class == 'exercise' and 'exercise' or 'statement')
    labels.define(div.identifier, class, number, NAMES[class], PLURAL[class])
    head = head .. '\u{a0}' .. number
  end
  local words = pandoc.Inlines { pandoc.Str(head) }
  if div.attributes.title then
    words:extend { pandoc.Space(), pandoc.Str '(' }
    words:extend(pandoc.utils.blocks_to_inlines(pandoc.read(div.attributes.title, 'markdown').blocks))
    words:insert(pandoc.Str ')')
    div.attributes.title = nil
  end
  words:insert(pandoc.Str '.')
  local lead = pandoc.Inlines { pandoc.Strong(words), pandoc.Space() }
  local first = div.content[1]
  if first and (first.t == 'Para' or first.t == 'Plain') then
    lead:extend(first.content)
    first.content = lead
    div.content[1] = first
  else
    div.content:insert(1, pandoc.Para(lead))
  end
  div.classes:insert(1, 'statement')
  return div
end
