--[[ online.lua: appendices that only the site of the documentation shows.

  # Performance {#app:performance .appendix .online}

The one-file page and the PDF leave them out; a link into one of them becomes text. The document for
the site keeps them (metadata site: true).                                                       ]]

local function parted(blocks)
  local kept, online, within = pandoc.Blocks {}, pandoc.Blocks {}, false
  for _, block in ipairs(blocks) do
    if block.t == 'Header' and block.level == 1 then within = block.classes:includes 'online' end
    (within and online or kept):insert(block)
  end
  return kept, online
end

local function labels_in(blocks)
  local labels = {}
  local function note(x)
    if x.identifier and x.identifier ~= '' then labels['#' .. x.identifier] = true end
  end
  blocks:walk { Block = note, Inline = note }
  return labels
end

return function(doc)
  if doc.meta.site then return nil end
  local kept, online = parted(doc.blocks)
  local gone = labels_in(online)
  doc.blocks = kept:walk { Link = function(l) if gone[l.target] then return l.content end end }
  return doc
end
