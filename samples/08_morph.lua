-- Morph targets: a drop that becomes a tip, then a star, by its own clip; the one behind is driven by the script.
kandil.scene { size = {640, 360}, fps = 24, seconds = 4 }

kandil.spawn { mesh = { shape = "box", size = {6, 0.1, 5} }, material = { base_color = {0.7, 0.65, 0.6} },
               transform = { position = {0, -0.05, 0} } }
kandil.spawn { mesh = { shape = "box", size = {6, 2.5, 0.1} }, material = { base_color = {0.75, 0.5, 0.3} },
               transform = { position = {0, 1.25, -1.5} } }
kandil.spawn { model = "assets/drop.gltf", animation = { clip = "morph", loop = true },
               transform = { position = {-0.7, 0, 0.2} } }
local other = kandil.spawn { name = "other", model = "assets/drop.gltf", transform = { position = {0.9, 0, -0.4} },
                             material = { base_color = {0.85, 0.3, 0.15}, roughness = 0.5 } }
kandil.spawn { light = { type = "directional", intensity = 3 }, transform = { look_at = {-0.5, -1, -0.6} } }
kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 1.4, 3.4}, look_at = {0, 0.6, 0} } }

local drop = other:has("morph_weights") and other or other:child("drop")
function kandil.update(t)
    drop.morph_weights.weights = {0.5 + 0.5 * math.sin(3 * t), 0.5 - 0.5 * math.cos(2 * t)}
end
