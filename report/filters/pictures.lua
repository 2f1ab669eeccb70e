--[[ pictures.lua: how wide a figure is printed. ]]

local problems = require 'problems'

local pictures = { text_width = 150 }     -- millimetres, as FULL_WIDTH of the figures' style

local POINT = 25.4 / 72
local HEAD = 2000         -- bytes, within which the size of a picture stands

function pictures.width(root, src)
  local path = pandoc.path.join { root, src }
  local file = io.open(path, 'rb')
  if not file then
    problems.add('the figure ' .. src .. ' has not been drawn', pandoc.path.filename(src))
    return pictures.text_width
  end
  local head = file:read(HEAD) or ''
  file:close()
  local points = head:match '<svg[^>]- width="([%d.]+)pt"'
  return points and tonumber(points) * POINT or pictures.text_width
end

return pictures
