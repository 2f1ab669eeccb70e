--[[ report.lua: the passes that turn the chapters into a report.

Every number of a section, figure, table, equation or statement is worked out in these passes, once
for both outputs; so the HTML and the PDF cannot disagree. What is particular to one of them is left
to output.lua. Each other file beside this one is one pass.                                      ]]

local here = pandoc.path.directory(PANDOC_SCRIPT_FILE)
package.path = pandoc.path.join { here, '?.lua' } .. ';' .. package.path

local problems = require 'problems'

local function load(doc)
  require('values').load(pandoc.utils.stringify(doc.meta.values))
end

-- Citations that are not found stop pandoc at once, so all other problems go before them.
local function finish(doc)
  return problems.hand_on(doc) or require 'undated' (pandoc.utils.citeproc(doc))
end

return {
  { Pandoc = load },
  { Pandoc = require 'tables' },       -- results become tables
  { Pandoc = require 'quoted_facts' },   -- {{experiment.fact:format}} becomes the number
  { Pandoc = require 'numbers' },      -- everything that is counted gets its number
  { Pandoc = require 'references' },   -- @fig:name becomes Figure 2.1
  { Pandoc = finish },               -- @lancaster1981 becomes a citation
}
