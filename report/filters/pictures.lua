--[[ pictures.lua: where a figure lies and how wide it is printed. ]]

local problems = require 'problems'

local pictures = { text_width = 150 }     -- millimetres, as FULL_WIDTH of the figures' style

local POINT = 25.4 / 72

function pictures.read(root, src)
  local path = pandoc.path.join { root, src }
  local file = io.open(path, 'rb')
  if not file then
    problems.add('the figure ' .. src .. ' has not been drawn', pandoc.path.filename(src))
    return '', pictures.text_width
  end
  local svg = file:read 'a'
  file:close()
  local points = svg:match '<svg[^>]- width="([%d.]+)pt"'
  return svg, points and tonumber(points) * POINT or pictures.text_width
end

return pictures
