--[[ output.lua: the passes that fit the document of report.lua to one output, HTML or PDF.

All that is wrong, also what the passes before found, is told at the end, in one go.              ]]

local here = pandoc.path.directory(PANDOC_SCRIPT_FILE)
package.path = pandoc.path.join { here, '?.lua' } .. ';' .. package.path

local problems = require 'problems'

local function finish()
  problems.stop_if_any()
end

return {
  { Pandoc = problems.take_over },
  { Pandoc = require 'online' },       -- without what only the site shows
  { Pandoc = require 'mathematics' },  -- formulas that both outputs set alike
  { Pandoc = require(FORMAT:match 'typst' and 'write_pdf' or 'write_html') },
  { Pandoc = finish },
}
